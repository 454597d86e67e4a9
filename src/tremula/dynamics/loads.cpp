#include "tremula/dynamics/loads.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/error.hpp"

#include <cmath>
#include <string>

#include <tbb/parallel_for.h>

namespace tremula {
namespace {

// Drag of 1/2 rho C A |u| u on the part u of the wind that counts, linearised about its mean: A C rho/2 |U|
// (P + n n^T).
SiteLoad linearise(double half_rho_c_area, const Mat3& projection, const Vec3& mean_wind) {
  const Vec3 normal_wind = projection * mean_wind;
  const double speed = normal_wind.norm();
  if (speed == 0) return {};
  const Vec3 n = normal_wind / speed;
  return {half_rho_c_area * speed * (projection + n * n.transpose()), half_rho_c_area * speed * normal_wind};
}

// The force c |u| (u . n) n along the normal of a blade, linearised likewise.
void add_lift(double half_rho_c_area, const Vec3& normal, const Vec3& mean_wind, SiteLoad& load) {
  const double speed = mean_wind.norm();
  if (speed == 0 || half_rho_c_area == 0) return;
  const double through = mean_wind.dot(normal);
  load.mean += half_rho_c_area * speed * through * normal;
  load.per_velocity += half_rho_c_area * normal * (speed * normal + through / speed * mean_wind).transpose();
}

void check_options(const LoadOptions& options) {
  const auto check = [](const char* what, double value) {
    if (!std::isfinite(value) || value < 0) throw InputError(what, std::to_string(value), "0 or more");
  };
  check("fluid density", options.fluid_density);
  check("branch drag coefficient", options.branch_drag_coefficient);
  check("leaf drag coefficient", options.leaf_drag_coefficient);
  check("leaf lift coefficient", options.leaf_lift_coefficient);
}

SiteLoad load_on(const Site& site, const Vec3& wind, const LoadOptions& options) {
  const double half_rho_area = 0.5 * options.fluid_density * site.area;
  if (site.kind == SiteKind::blade) {
    SiteLoad load = linearise(half_rho_area * options.leaf_drag_coefficient, Mat3::Identity(), wind);
    add_lift(half_rho_area * options.leaf_lift_coefficient, site.axis, wind, load);
    return load;
  }
  const Mat3 across = Mat3::Identity() - site.axis * site.axis.transpose();
  return linearise(half_rho_area * options.branch_drag_coefficient, across, wind);
}

SiteLoad printed_load_on(const Site& site, const LoadOptions& options) {
  if (site.kind == SiteKind::blade) return {};
  const Mat3 across = Mat3::Identity() - site.axis * site.axis.transpose();
  return {0.5 * options.fluid_density * options.branch_drag_coefficient * site.mean_area * across};
}

}  // namespace

Loads linearise_loads(const Sites& sites, const Eigen::Matrix3Xd& mean_wind, const LoadOptions& options) {
  check_options(options);
  check_equal("columns of the mean wind", mean_wind.cols(), sites.point_count());
  Loads loads{.sites = std::vector<SiteLoad>(sites.sites.size()),
              .gust_share = Eigen::VectorXd::Ones(sites.point_count()),
              .damp = options.model == LoadModel::linearised};
  tbb::parallel_for(std::size_t{0}, sites.sites.size(), [&](std::size_t s) {
    const Site& site = sites.sites[s];
    loads.sites[s] = options.model == LoadModel::paper ? printed_load_on(site, options)
                                                       : load_on(site, mean_wind.col(site.point), options);
  });
  return loads;
}

void check_loads(const Sites& sites, const Loads& loads) {
  check_equal("sites of the loads", static_cast<std::ptrdiff_t>(loads.sites.size()),
              static_cast<std::ptrdiff_t>(sites.sites.size()));
  check_equal("points of the loads", loads.gust_share.size(), sites.point_count());
}

Eigen::VectorXd mean_force(const Sites& sites, const Loads& loads) {
  check_loads(sites, loads);
  Eigen::Matrix3Xd forces(3, static_cast<Eigen::Index>(loads.sites.size()));
  for (std::size_t s = 0; s < loads.sites.size(); ++s)
    forces.col(static_cast<Eigen::Index>(s)) = loads.sites[s].mean;
  return sites.gather(forces);
}

Eigen::VectorXd fluctuating_force(const Sites& sites, const Loads& loads, const Eigen::Matrix3Xd& velocity) {
  check_loads(sites, loads);
  check_equal("columns of the velocity", velocity.cols(), sites.point_count());
  Eigen::Matrix3Xd forces(3, static_cast<Eigen::Index>(loads.sites.size()));
  for (std::size_t s = 0; s < loads.sites.size(); ++s) {
    const int point = sites.sites[s].point;
    forces.col(static_cast<Eigen::Index>(s)) =
        loads.gust_share[point] * (loads.sites[s].per_velocity * velocity.col(point));
  }
  return sites.gather(forces);
}

Eigen::MatrixXd modal_participation(const Sites& sites, const Loads& loads,
                                    Eigen::Ref<const Eigen::MatrixXd> shapes) {
  check_loads(sites, loads);
  Eigen::MatrixXd participation = Eigen::MatrixXd::Zero(3 * sites.point_count(), shapes.cols());
  const std::vector<SiteBlock> blocks = cut_between_points(sites);
  tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t block) {
    const auto [first, last] = blocks[block];
    const Eigen::MatrixXd motion = sites.motion(first, last, shapes);
    for (std::size_t s = first; s < last; ++s) {
      const int point = sites.sites[s].point;
      participation.middleRows<3>(3 * point).noalias() +=
          loads.gust_share[point] * loads.sites[s].per_velocity.transpose() *
          motion.middleRows<3>(3 * static_cast<Eigen::Index>(s - first));
    }
  });
  return participation;
}

}  // namespace tremula
