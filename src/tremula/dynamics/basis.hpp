// All the shapes a motion is made of, side by side: what a viewer or an engine uploads once.
#pragma once

#include "tremula/dynamics/motion.hpp"
#include "tremula/modes/modes.hpp"

#include <vector>

#include <Eigen/Core>

namespace tremula {

enum class ShapeKind {
  lean,          // under the mean wind, its weight is 1 at all times
  mode,          // of Modes
  static_shape,  // what the modes left out follow the wind by (static_correction.hpp)
};

// The displacement at any time is columns * weights: of weights_at() at that time, or of a row of weights()
// at a sample. Column 0 is the lean, then come the modes in their order, then the static shapes.
struct Basis {
  std::vector<ShapeKind> kind;  // (c)
  Eigen::VectorXd frequency;    // (c) [Hz]; 0 for the lean, Rayleigh quotients for static shapes
  Eigen::MatrixXd columns;      // (6N x c) rows as in Modes::shapes; the lean in m and rad

  int count() const { return static_cast<int>(frequency.size()); }
};

// Throws InputError unless the modes are as many and as long as those that the motion was made with.
void check_belong_together(const Modes& modes, const Motion& motion);

// Throws as that does.
Basis all_shapes(const Modes& modes, const Motion& motion);

// One column, without a copy of all; `column` below 1 + the number of coordinates.
Eigen::Ref<const Eigen::VectorXd> shape_of(const Modes& modes, const Motion& motion, Eigen::Index column);

// What multiplies each column: 1, then the coordinates. At any time [s] (c), and at all samples (M x c).
Eigen::VectorXd weights_at(const Motion& motion, double time, Interpolation interpolation);
Eigen::MatrixXd weights(const Motion& motion);

// The sum of the weighted columns, always added in this order, so that a frame alone has the bytes it has in
// a sequence; the second form spares the copy of the shapes. (6N)
Eigen::VectorXd superpose(const Basis& basis, const Eigen::VectorXd& weights);
Eigen::VectorXd superpose(const Modes& modes, const Motion& motion, const Eigen::VectorXd& weights);

}  // namespace tremula
