#include "tremula/dynamics/reconfiguration.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include <Eigen/QR>

#include "tremula/base/error.hpp"

namespace tremula {
namespace {

Eigen::ArrayXd rotation_angles(const Eigen::VectorXd& displacement) {
  Eigen::ArrayXd angles(displacement.size() / 6);
  for (Eigen::Index k = 0; k < angles.size(); ++k) angles[k] = displacement.segment<3>(6 * k + 3).norm();
  return angles;
}

}  // namespace

Eigen::VectorXd lean_and_reconfigure(const Structure& structure, const Reconfiguration& reconfiguration,
                                     Loads& loads) {
  constexpr double smallest_angle = 1e-6;
  const double angle = reconfiguration.angle;
  if (!std::isfinite(angle) || (angle != 0 && angle < smallest_angle)) {
    char found[32];
    std::snprintf(found, sizeof found, "%g rad", angle);
    throw InputError("reconfiguration angle", found, "0, or 1e-6 rad or more");
  }
  Eigen::VectorXd lean = solve_static(structure, mean_force(structure, loads));
  if (reconfiguration.angle == 0) return lean;
  const auto x_squared = [&] { return (rotation_angles(lean) / reconfiguration.angle).square().eval(); };

  // Fixed-point iteration on the logarithm of lambda. Undamped it would overshoot by up to four times the
  // error; a fifth of the step makes the error shrink to 0.8 or less of itself each time. What the last steps
  // did to it tells where it would vanish (Anderson 1965, J. ACM 12), which is ten times sooner.
  constexpr double step = 0.2, tolerance = 1e-10, good_enough = 1e-3;
  constexpr int most_iterations = 200, memory = 4;
  const std::vector<BranchLoad> whole = loads.branches;
  const Eigen::Index count = structure.branch_count();
  Eigen::VectorXd logarithm = Eigen::VectorXd::Zero(count), last_error, last_logarithm;
  Eigen::MatrixXd errors(count, memory), logarithms(count, memory);  // what they changed by
  for (int iteration = 0;; ++iteration) {
    const Eigen::VectorXd error = (-2 * (1 + x_squared()).log()).matrix() - logarithm;
    const double largest = error.cwiseAbs().maxCoeff();
    if (largest < tolerance) break;
    if (iteration == most_iterations) {
      if (largest < good_enough) break;
      throw Error(
          "reconfiguration: the lean does not settle under this wind; choose less wind or stiffer wood");
    }
    // An error that grows says that the past misleads: a plain step then.
    const bool grew = iteration > 0 && error.norm() > last_error.norm();
    const Eigen::Index known = grew ? 0 : std::min(iteration, memory);
    if (iteration > 0) {
      errors.col((iteration - 1) % memory) = error - last_error;
      logarithms.col((iteration - 1) % memory) = logarithm - last_logarithm;
    }
    last_error = error;
    last_logarithm = logarithm;
    logarithm += step * error;
    if (known > 0) {
      const auto past = errors.leftCols(known);
      const Eigen::VectorXd share =
          (past.transpose() * past).completeOrthogonalDecomposition().solve(past.transpose() * error);
      logarithm -= (logarithms.leftCols(known) + step * past) * share;
    }
    logarithm = logarithm.cwiseMin(0);
    for (std::size_t k = 0; k < whole.size(); ++k) {
      loads.branches[k].mean = std::exp(logarithm[static_cast<Eigen::Index>(k)]) * whole[k].mean;
    }
    lean = solve_static(structure, mean_force(structure, loads));
  }
  // F ~ U^2 lambda(theta) with theta ~ F: d ln F/d ln U = 2 / (1 - d ln lambda/d ln theta), instead of 2.
  // That is so because the drag falls as the branch turns, which is a stiffness; what a branch meets that
  // moves at an angle, the damping, is the drag at that angle.
  const Eigen::ArrayXd x2 = x_squared(), lambda = logarithm.array().exp();
  for (std::size_t k = 0; k < whole.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    loads.branches[k].per_velocity *= lambda[row] / (1 + 4 * x2[row] / (1 + x2[row]));
    loads.branches[k].drag_per_diameter *= lambda[row];
  }
  for (std::size_t i = 0; i < loads.leaf_per_velocity.size(); ++i)
    loads.leaf_per_velocity[i] *= lambda[loads.leaf_branch[i]];
  return lean;
}

}  // namespace tremula
