#include "tremula/dynamics/damping.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/error.hpp"

#include <cmath>
#include <string>
#include <vector>

#include <tbb/parallel_for.h>

namespace tremula {
namespace {

double above_zero(const char* what, double value) {
  if (!std::isfinite(value) || value <= 0) throw InputError(what, std::to_string(value), "a number above 0");
  return value;
}

}  // namespace

Eigen::VectorXd structural_damping(const Damping& damping, const Eigen::VectorXd& omega) {
  if (damping.mass_proportional && damping.stiffness_proportional) {
    throw InputError("damping", "both mass-proportional and stiffness-proportional", "one of them");
  }
  if (damping.mass_proportional) {
    return Eigen::VectorXd::Constant(omega.size(),
                                     above_zero("mass-proportional damping", *damping.mass_proportional));
  }
  if (damping.stiffness_proportional) {
    return above_zero("stiffness-proportional damping", *damping.stiffness_proportional) * omega.cwiseAbs2();
  }
  return 2 * above_zero("damping ratio", damping.ratio) * omega;
}

Eigen::MatrixXd aerodynamic_damping(const Sites& sites, const Loads& loads,
                                    Eigen::Ref<const Eigen::MatrixXd> shapes) {
  check_loads(sites, loads);
  Eigen::MatrixXd damping = Eigen::MatrixXd::Zero(shapes.cols(), shapes.cols());
  if (!loads.damp) return damping;
  const std::vector<SiteBlock> blocks = cut_between_points(sites);
  std::vector<Eigen::MatrixXd> parts(blocks.size());
  tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t block) {
    const auto [first, last] = blocks[block];
    const Eigen::MatrixXd motion = sites.motion(first, last, shapes);
    Eigen::MatrixXd force(motion.rows(), motion.cols());
    for (std::size_t s = first; s < last; ++s) {
      const Eigen::Index row = 3 * static_cast<Eigen::Index>(s - first);
      force.middleRows<3>(row).noalias() = loads.sites[s].per_velocity * motion.middleRows<3>(row);
    }
    parts[block].noalias() = motion.transpose() * force;
  });
  // In the order of the blocks, whichever thread was first.
  for (const Eigen::MatrixXd& part : parts) damping += part;
  return damping;
}

}  // namespace tremula
