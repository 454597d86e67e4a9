#include "tremula/dynamics/damping.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/error.hpp"

#include <algorithm>
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

Eigen::VectorXd ratios_of(const Eigen::VectorXd& given, Eigen::Index count) {
  Eigen::VectorXd ratios(count);
  for (Eigen::Index r = 0; r < count; ++r) ratios[r] = given[std::min(r, given.size() - 1)];
  for (Eigen::Index r = 0; r < given.size(); ++r)
    above_zero(("damping ratio of mode " + std::to_string(r + 1)).c_str(), given[r]);
  return ratios;
}

// Of phi_r^T (force of the site per what cause says of it) (cause of phi_s).
template <class Cause, class Matrix>
Eigen::MatrixXd sum_over_sites(const Sites& sites, Eigen::Ref<const Eigen::MatrixXd> shapes,
                               const Cause& cause, const Matrix& matrix) {
  const std::vector<SiteBlock> blocks = cut_between_points(sites);
  std::vector<Eigen::MatrixXd> parts(blocks.size());
  tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t block) {
    const auto [first, last] = blocks[block];
    Eigen::MatrixXd force = cause(first, last, shapes);
    for (std::size_t s = first; s < last; ++s) {
      const Eigen::Index row = 3 * static_cast<Eigen::Index>(s - first);
      force.middleRows<3>(row) = (matrix(s) * force.middleRows<3>(row)).eval();
    }
    parts[block].noalias() = sites.motion(first, last, shapes).transpose() * force;
  });
  // In the order of the blocks, whichever thread was first.
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(shapes.cols(), shapes.cols());
  for (const Eigen::MatrixXd& part : parts) sum += part;
  return sum;
}

}  // namespace

Eigen::VectorXd structural_damping(const Damping& damping, const Eigen::VectorXd& omega) {
  const int given = static_cast<int>(damping.ratios.size() > 0) + damping.mass_proportional.has_value() +
                    damping.stiffness_proportional.has_value() + damping.decay_time.has_value();
  if (given > 1) {
    throw InputError("damping",
                     std::to_string(given) + " of ratios, mass- and stiffness-proportional and a decay time",
                     "one of them");
  }
  if (damping.mass_proportional) {
    return Eigen::VectorXd::Constant(omega.size(),
                                     above_zero("mass-proportional damping", *damping.mass_proportional));
  }
  if (damping.stiffness_proportional) {
    return above_zero("stiffness-proportional damping", *damping.stiffness_proportional) * omega.cwiseAbs2();
  }
  if (damping.decay_time) {
    const double rate = 2 / above_zero("decay time of the first mode", *damping.decay_time);
    if (omega.size() == 0) return omega;
    return rate * (omega / omega[0]).cwiseAbs2();
  }
  if (damping.ratios.size() > 0) return 2 * ratios_of(damping.ratios, omega.size()).cwiseProduct(omega);
  return 2 * above_zero("damping ratio", damping.ratio) * omega;
}

Eigen::MatrixXd aerodynamic_damping(const Sites& sites, const Loads& loads,
                                    Eigen::Ref<const Eigen::MatrixXd> shapes) {
  check_loads(sites, loads);
  if (!loads.damp) return Eigen::MatrixXd::Zero(shapes.cols(), shapes.cols());
  return sum_over_sites(sites, shapes, sites.motion,
                        [&](std::size_t s) { return loads.sites[s].per_velocity; });
}

Eigen::MatrixXd aerodynamic_stiffness(const Sites& sites, const Loads& loads,
                                      Eigen::Ref<const Eigen::MatrixXd> shapes) {
  check_loads(sites, loads);
  return -sum_over_sites(sites, shapes, sites.turning, [&](std::size_t s) { return loads.sites[s].turning; });
}

}  // namespace tremula
