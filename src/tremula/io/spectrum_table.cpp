#include "tremula/io/spectrum_table.hpp"

#include "tremula/base/error.hpp"
#include "tremula/io/atomic_file.hpp"
#include "tremula/io/text_table.hpp"

#include <algorithm>
#include <array>

namespace tremula {
namespace {

constexpr std::size_t most_rows = 1'000'000;
constexpr std::array<std::array<const char*, 4>, 2> layouts = {
    {{"frequency", "S_u", "S_v", "S_w"}, {"k1_rad_per_m", "Fu", "Fv", "Fw"}}};

std::size_t column_of(const Fields& header, std::string_view name) {
  const std::size_t count = std::min(header.count, header.at.size());
  return static_cast<std::size_t>(
      std::find(header.at.begin(), header.at.begin() + static_cast<std::ptrdiff_t>(count), name) -
      header.at.begin());
}

}  // namespace

SpectrumTable read_spectrum_table(const std::string& path) {
  return read_spectrum_table(read_file(path), path);
}

SpectrumTable read_spectrum_table(std::string_view text, const std::string& path) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);  // UTF-8 says so itself
  TextLines lines{text};
  std::string_view line;
  SpectrumTable table;
  Fields header{};
  const std::array<const char*, 4>* names = nullptr;
  std::array<std::size_t, 4> at{};
  while (lines.next(line)) {
    if (line.empty() || line[0] == '#') continue;
    const Fields fields = split_at_blanks(line);
    const TableRow row{path, lines.number, fields};
    if (names == nullptr) {
      for (const auto& layout : layouts) {
        std::transform(layout.begin(), layout.end(), at.begin(),
                       [&](const char* name) { return column_of(fields, name); });
        const std::size_t end = std::min(fields.count, fields.at.size());
        if (std::all_of(at.begin(), at.end(), [&](std::size_t c) { return c < end; })) {
          names = &layout;
          break;
        }
      }
      if (names == nullptr) {
        throw InputError(row.place(),
                         counted(fields.count, "column") + " beginning with " + shown(fields.at[0]),
                         "a header with frequency S_u S_v S_w, or with k1_rad_per_m Fu Fv Fw");
      }
      table.by_wave_number = names == &layouts[1];
      header = fields;
      continue;
    }
    if (fields.count != header.count) {
      throw InputError(row.place(), counted(fields.count, "column"),
                       std::to_string(header.count) + " as in the header");
    }
    if (table.at.size() == most_rows) {
      throw InputError(row.place(), "yet another row", "at most " + std::to_string(most_rows));
    }
    const double place = row.positive(at[0], (*names)[0]);
    if (!table.at.empty() && place <= table.at.back()) {
      row.reject(at[0], (*names)[0], "more than the " + shown(table.at.back()) + " of the row before");
    }
    table.at.push_back(place);
    table.values.emplace_back(row.positive(at[1], (*names)[1]), row.positive(at[2], (*names)[2]),
                              row.positive(at[3], (*names)[3]));
  }
  if (table.at.size() < 2) {
    throw InputError(path, counted(table.at.size(), "row") + " of a spectrum",
                     "a header and two rows or more");
  }
  return table;
}

}  // namespace tremula
