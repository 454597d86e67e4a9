#include "tremula/dynamics/reconfiguration.hpp"

#include <cmath>
#include <string>

#include "tremula/base/error.hpp"

namespace tremula {
namespace {

Loads reduced(const Loads& loads, const Eigen::ArrayXd& factor) {
  Loads result = loads;
  for (Eigen::Index k = 0; k < factor.size(); ++k) {
    BranchLoad& load = result.branches[static_cast<std::size_t>(k)];
    load.per_velocity *= factor[k];
    load.mean *= factor[k];
  }
  return result;
}

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

  // Fixed-point iteration on the logarithm of the factors. Undamped it would overshoot by up to four times
  // the error; a fifth of the step makes the error shrink to 0.8 or less of itself each time.
  constexpr double step = 0.2, tolerance = 1e-10;
  constexpr int most_iterations = 200;
  Eigen::ArrayXd logarithm = Eigen::ArrayXd::Zero(structure.branch_count());
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    const Eigen::ArrayXd wanted = -2 * (1 + (rotation_angles(lean) / reconfiguration.angle).square()).log();
    const double error = (wanted - logarithm).abs().maxCoeff();
    if (error < tolerance) break;
    logarithm += step * (wanted - logarithm);
    lean = solve_static(structure, mean_force(structure, reduced(loads, logarithm.exp())));
  }
  loads = reduced(loads, logarithm.exp());
  return lean;
}

}  // namespace tremula
