// All the shapes a motion is made of, side by side: what a viewer or an engine uploads once.
#pragma once

#include "tremula/dynamics/static_correction.hpp"
#include "tremula/modes/modes.hpp"

#include <string_view>
#include <vector>

#include <Eigen/Core>

namespace tremula {

enum class ShapeKind {
  lean,          // under the mean wind; its coordinate is 1 at all times
  mode,          // of Modes
  static_shape,  // what the modes left out follow the wind by (static_correction.hpp)
};
std::string_view name_of(ShapeKind kind);  // "lean", "mode", "static"

// The displacement of the structure at any time is columns * coordinates at that time. The lean comes first,
// then the modes in their order, then the static shapes.
struct Basis {
  std::vector<ShapeKind> kind;  // (c)
  Eigen::VectorXd frequency;    // (c) [Hz]; 0 for the lean, Rayleigh quotients for static shapes
  Eigen::MatrixXd columns;      // (rows x c), rows as in Modes::shapes; the lean in m and rad

  int count() const { return static_cast<int>(frequency.size()); }
  int count(ShapeKind of) const;
};

// Throws InputError where lean, modes and static shapes are not of one structure.
Basis join(const Eigen::VectorXd& lean, Modes modes, const StaticShapes& static_shapes);

// The sum of the columns that are leans; 0 where there is none. (rows)
Eigen::VectorXd lean_of(const Basis& basis);

// Throws InputError unless kinds, frequencies and columns are equally many and all are finite.
void check_basis(const Basis& basis);

// The sum of the weighted columns, always added in this order, so that a frame alone has the bytes it has in
// a sequence. (rows)
Eigen::VectorXd superpose(const Basis& basis, const Eigen::VectorXd& coordinates);

}  // namespace tremula
