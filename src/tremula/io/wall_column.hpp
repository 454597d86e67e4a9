// The wall of hollow stems in tables of other programs: a column of thicknesses, in the unit of the radius.
#pragma once

#include "tremula/io/table_header.hpp"

#include <cstddef>
#include <optional>

namespace tremula {

inline std::optional<std::size_t> wall_column(const TableHeader& header) {
  return header.find({"wall", "wallthickness", "thickness"});
}

// Branch::wall of a row: the thickness over the radius; solid where it is 0, empty or NA. Throws InputError
// for one that is no thickness or more than the radius.
inline double wall_of(const TableRow& row, std::size_t column, double radius) {
  const std::string_view field = row.fields.at[column];
  if (field.empty() || field == "NA") return 1;
  const double thickness = row.finite(column, "wall");
  if (thickness == 0) return 1;
  if (thickness < smallest_size || thickness > radius)
    row.reject(column, "wall",
               "a thickness of 1e-12 to the radius, " + shown(radius) + ", or 0 for a solid stem");
  return thickness / radius;
}

}  // namespace tremula
