#include "tremula/dynamics/reconfiguration.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/QR>

#include "tremula/base/error.hpp"

namespace tremula {
namespace {

// (P) By how much what is at each point has turned.
Eigen::ArrayXd rotation_angles(const Sites& sites, const Eigen::VectorXd& displacement) {
  Eigen::ArrayXd angles(sites.point_count());
  for (Eigen::Index p = 0; p < angles.size(); ++p) {
    const Eigen::Index row = sites.turning_row[static_cast<std::size_t>(p)];
    angles[p] = row < 0 ? 0 : displacement.segment<3>(row + 3).norm();
  }
  return angles;
}

Eigen::Matrix3Xd mean_forces(const Loads& loads) {
  Eigen::Matrix3Xd forces(3, static_cast<Eigen::Index>(loads.sites.size()));
  for (std::size_t s = 0; s < loads.sites.size(); ++s)
    forces.col(static_cast<Eigen::Index>(s)) = loads.sites[s].mean;
  return forces;
}

void reduce(const Sites& sites, const Eigen::ArrayXd& lambda, Loads& loads) {
  for (std::size_t s = 0; s < sites.sites.size(); ++s) {
    const double factor = lambda[sites.sites[s].point];
    loads.sites[s].mean *= factor;
    loads.sites[s].per_velocity *= factor;
  }
}

}  // namespace

Lean find_lean(const Structure& structure, const Sites& sites, Loads loads,
               const Reconfiguration& reconfiguration) {
  constexpr double smallest_angle = 1e-6;
  const double angle = reconfiguration.angle;
  if (!std::isfinite(angle) || (angle != 0 && angle < smallest_angle)) {
    char found[32];
    std::snprintf(found, sizeof found, "%g rad", angle);
    throw InputError("reconfiguration angle", found, "0, or 1e-6 rad or more");
  }
  Eigen::VectorXd lean = structure.flexibility(mean_force(sites, loads));
  if (angle == 0) return {lean, std::move(loads)};
  const Eigen::SparseMatrix<double> by_point = sites.gather_by_point(mean_forces(loads));
  const auto x_squared = [&] { return (rotation_angles(sites, lean) / angle).square().eval(); };

  // Fixed-point iteration on the logarithm of lambda. Undamped it would overshoot by up to four times the
  // error; a fifth of the step makes the error shrink to 0.8 or less of itself each time. What the last steps
  // did to it tells where it would vanish (Anderson 1965, J. ACM 12), which is ten times sooner.
  constexpr double step = 0.2, tolerance = 1e-10, good_enough = 1e-3;
  constexpr int most_iterations = 200, memory = 4;
  const Eigen::Index count = sites.point_count();
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
    lean = structure.flexibility(by_point * logarithm.array().exp().matrix());
  }
  // F ~ U^2 lambda(theta) with theta ~ F: d ln F/d ln U = 2 / (1 - d ln lambda/d ln theta), instead of 2.
  // That is so because the drag falls as the branch turns, which is a stiffness; what a branch meets that
  // moves at an angle, the damping, is the drag at that angle.
  const Eigen::ArrayXd x2 = x_squared();
  reduce(sites, logarithm.array().exp(), loads);
  loads.gust_share.array() /= 1 + 4 * x2 / (1 + x2);
  return {lean, std::move(loads)};
}

}  // namespace tremula
