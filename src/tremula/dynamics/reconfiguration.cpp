#include "tremula/dynamics/reconfiguration.hpp"

#include <cmath>
#include <string>
#include <vector>

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
  if (!std::isfinite(reconfiguration.angle) || reconfiguration.angle < 0) {
    throw InputError("reconfiguration angle", std::to_string(reconfiguration.angle), "0 rad or more");
  }
  Eigen::VectorXd lean = solve_static(structure, mean_force(structure, loads));
  if (reconfiguration.angle == 0) return lean;
  const auto x_squared = [&] { return (rotation_angles(lean) / reconfiguration.angle).square().eval(); };

  // Fixed-point iteration on the logarithm of lambda. Undamped it would overshoot by up to four times the
  // error; a fifth of the step makes the error shrink to 0.8 or less of itself each time.
  constexpr double step = 0.2, tolerance = 1e-10;
  constexpr int most_iterations = 200;
  const std::vector<BranchLoad> whole = loads.branches;
  Eigen::ArrayXd logarithm = Eigen::ArrayXd::Zero(structure.branch_count());
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    const Eigen::ArrayXd wanted = -2 * (1 + x_squared()).log();
    if ((wanted - logarithm).abs().maxCoeff() < tolerance) break;
    logarithm += step * (wanted - logarithm);
    for (std::size_t k = 0; k < whole.size(); ++k) {
      loads.branches[k].mean = std::exp(logarithm[static_cast<Eigen::Index>(k)]) * whole[k].mean;
    }
    lean = solve_static(structure, mean_force(structure, loads));
  }
  // F ~ U^2 lambda(theta) with theta ~ F: d ln F/d ln U = 2 / (1 - d ln lambda/d ln theta), instead of 2.
  const Eigen::ArrayXd x2 = x_squared(), factor = logarithm.exp() / (1 + 4 * x2 / (1 + x2));
  for (std::size_t k = 0; k < whole.size(); ++k) {
    loads.branches[k].per_velocity *= factor[static_cast<Eigen::Index>(k)];
    loads.branches[k].drag_per_diameter *= factor[static_cast<Eigen::Index>(k)];
  }
  for (std::size_t i = 0; i < loads.leaf_per_velocity.size(); ++i)
    loads.leaf_per_velocity[i] *= factor[loads.leaf_branch[i]];
  return lean;
}

}  // namespace tremula
