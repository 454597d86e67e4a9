#include "tremula/dynamics/basis.hpp"

#include "tremula/base/error.hpp"

#include <string>

namespace tremula {
namespace {

using Column = Eigen::Ref<const Eigen::VectorXd>;

template <class Columns>
Eigen::VectorXd add_up(const Eigen::VectorXd& weights, Columns column) {
  Eigen::VectorXd sum = weights[0] * column(0);
  for (Eigen::Index c = 1; c < weights.size(); ++c) sum += weights[c] * column(c);
  return sum;
}

void check_count(const Eigen::VectorXd& weights, Eigen::Index columns) {
  if (weights.size() != columns)
    throw InputError("number of weights", std::to_string(weights.size()), std::to_string(columns));
}

}  // namespace

void check_belong_together(const Modes& modes, const Motion& motion) {
  const auto check = [](const char* what, Eigen::Index found, Eigen::Index wanted) {
    if (found != wanted)
      throw InputError(what, std::to_string(found), std::to_string(wanted) + ", as the motion was made with");
  };
  check("number of modes", modes.count(), motion.mode_count());
  check("rows of the modes", modes.shapes.rows(), motion.lean.size());
  check("columns of the modes", modes.shapes.cols(), modes.count());
  const StaticShapes& more = motion.static_shapes;
  check("columns of the static shapes", more.shapes.cols(), more.count());
  if (more.count() > 0) check("rows of the static shapes", more.shapes.rows(), motion.lean.size());
}

Eigen::Ref<const Eigen::VectorXd> shape_of(const Modes& modes, const Motion& motion, Eigen::Index column) {
  if (column == 0) return motion.lean;
  if (column <= modes.count()) return modes.shapes.col(column - 1);
  return motion.static_shapes.shapes.col(column - 1 - modes.count());
}

Basis all_shapes(const Modes& modes, const Motion& motion) {
  check_belong_together(modes, motion);
  const Eigen::Index mode_count = modes.count(), more = motion.static_shapes.count();
  Basis basis{{}, Eigen::VectorXd(1 + mode_count + more), {motion.lean.size(), 1 + mode_count + more}};
  for (Eigen::Index c = 0; c < basis.count(); ++c) {
    basis.kind.push_back(c == 0            ? ShapeKind::lean
                         : c <= mode_count ? ShapeKind::mode
                                           : ShapeKind::static_shape);
    basis.columns.col(c) = shape_of(modes, motion, c);
  }
  basis.frequency << 0, modes.frequency, motion.static_shapes.frequency;
  return basis;
}

Eigen::VectorXd weights_at(const Motion& motion, double time, Interpolation interpolation) {
  const Eigen::VectorXd coordinates = coordinates_at(motion, time, interpolation);
  Eigen::VectorXd weights(1 + coordinates.size());
  weights << 1, coordinates;
  return weights;
}

Eigen::MatrixXd weights(const Motion& motion) {
  Eigen::MatrixXd weights(motion.coordinates.rows(), 1 + motion.coordinates.cols());
  weights << Eigen::VectorXd::Ones(motion.coordinates.rows()), motion.coordinates;
  return weights;
}

Eigen::VectorXd superpose(const Basis& basis, const Eigen::VectorXd& weights) {
  check_count(weights, basis.count());
  return add_up(weights, [&](Eigen::Index c) -> Column { return basis.columns.col(c); });
}

Eigen::VectorXd superpose(const Modes& modes, const Motion& motion, const Eigen::VectorXd& weights) {
  check_belong_together(modes, motion);
  check_count(weights, 1 + motion.coordinates.cols());
  return add_up(weights, [&](Eigen::Index c) { return shape_of(modes, motion, c); });
}

}  // namespace tremula
