#include "tremula/dynamics/loads.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/error.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include <tbb/parallel_for.h>

namespace tremula {
namespace {

SiteLoad scaled(const AverageForce& force, double half_rho_c_area) {
  return {half_rho_c_area * force.per_velocity, half_rho_c_area * force.mean};
}

// Of a cylinder along d whose axis turns by theta: v_n grows by -(theta x d) (d . v) across the axis, and the
// force stays across it.
Mat3 turning_of_cylinder(const SiteLoad& load, const Vec3& axis, const Vec3& wind) {
  return axis.dot(wind) * load.per_velocity * cross_matrix(axis) - axis * axis.cross(load.mean).transpose();
}

// Of a plate whose drag is so much along its normal n, of the speed through its plane and of all of it.
// Turned by theta, its normal is n + theta x n.
Mat3 turning_of_plate(const Vec3& normal, const Vec3& drag) {
  return normal * normal.cross(drag).transpose() - drag.dot(normal) * cross_matrix(normal);
}

// The pressure that speeds the fluid up speeds what displaces it up, and the fluid that a blade carries
// follows the rest across the blade.
Mat3 inertia_of_blade(const Site& site, const LoadOptions& options) {
  if (!(options.inertia_coefficient > 0)) return Mat3::Zero();
  return options.fluid_density *
         (std::min(options.inertia_coefficient, 1.0) * site.volume * Mat3::Identity() +
          std::max(options.inertia_coefficient - 1, 0.0) * site.carried * site.axis * site.axis.transpose());
}

SiteLoad load_on_ribbon(const Site& site, const GustStatistics& wind, const LoadLaw& law) {
  const LoadOptions& options = law.options;
  const double half_rho_area = 0.5 * options.fluid_density * site.area;
  const AverageForce all = average_drag(wind);
  SiteLoad load = scaled(along_normal(all, site.axis), half_rho_area * options.ribbon_normal_coefficient);
  load.turning = half_rho_area * options.ribbon_normal_coefficient * turning_of_plate(site.axis, all.mean);
  const SiteLoad friction = scaled(all, half_rho_area * options.ribbon_friction_coefficient);
  load.mean += friction.mean;
  load.per_velocity += friction.per_velocity;
  load.per_acceleration = inertia_of_blade(site, options);
  return load;
}

SiteLoad load_on_blade(const Site& site, const GustStatistics& wind, const LoadLaw& law) {
  const LoadOptions& options = law.options;
  const double half_rho_area = 0.5 * options.fluid_density * site.area;
  const bool folds = options.foliage.vogel_exponent != 0;
  SiteLoad load = scaled(folds ? average_folding_drag(law.folding, wind) : average_drag(wind),
                         half_rho_area * options.leaf_drag_coefficient);
  load.per_acceleration = inertia_of_blade(site, options);
  if (options.leaf_lift_coefficient == 0) return load;
  const SiteLoad lift =
      scaled(along_normal(average_drag(wind), site.axis), half_rho_area * options.leaf_lift_coefficient);
  load.mean += lift.mean;
  load.per_velocity += lift.per_velocity;
  return load;
}

SiteLoad load_on_cylinder(const Site& site, const GustStatistics& wind, const LoadLaw& law) {
  const LoadOptions& options = law.options;
  SiteLoad load = scaled(average_drag_across(site.axis, wind),
                         0.5 * options.fluid_density * site.area * options.branch_drag_coefficient);
  load.turning = turning_of_cylinder(load, site.axis, wind.mean);
  if (options.inertia_coefficient > 0) {
    const Mat3 across = Mat3::Identity() - site.axis * site.axis.transpose();
    load.per_acceleration = options.fluid_density * options.inertia_coefficient * site.volume * across;
  }
  return load;
}

// What shapes make of the forces that the fluid has on all sites, by what each site's is proportional to.
template <class PerFluid>
Eigen::MatrixXd sum_at_points(const Sites& sites, const Loads& loads,
                              Eigen::Ref<const Eigen::MatrixXd> shapes, const PerFluid& per_fluid) {
  check_loads(sites, loads);
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(3 * sites.point_count(), shapes.cols());
  const std::vector<SiteBlock> blocks = cut_between_points(sites);
  tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t block) {
    const auto [first, last] = blocks[block];
    const Eigen::MatrixXd motion = sites.motion(first, last, shapes);
    for (std::size_t s = first; s < last; ++s) {
      sum.middleRows<3>(3 * sites.sites[s].point).noalias() +=
          per_fluid(loads.sites[s]).transpose() *
          motion.middleRows<3>(3 * static_cast<Eigen::Index>(s - first));
    }
  });
  return sum;
}

// What a velocity or an acceleration of the fluid at the points (3 x P) does to the rows of the structure.
template <class PerFluid>
Eigen::VectorXd force_of_fluid(const Sites& sites, const Loads& loads, const Eigen::Matrix3Xd& fluid,
                               const PerFluid& per_fluid) {
  check_loads(sites, loads);
  check_equal("columns of the velocity", fluid.cols(), sites.point_count());
  Eigen::Matrix3Xd forces(3, static_cast<Eigen::Index>(loads.sites.size()));
  for (std::size_t s = 0; s < loads.sites.size(); ++s)
    forces.col(static_cast<Eigen::Index>(s)) = per_fluid(loads.sites[s]) * fluid.col(sites.sites[s].point);
  return sites.gather(forces);
}

SiteLoad load_on_plate(const Site& site, const GustStatistics& wind, const LoadLaw& law) {
  const double half_rho_c_area =
      0.5 * law.options.fluid_density * site.area * law.options.plate_normal_coefficient;
  const AverageForce all = average_drag(wind);
  SiteLoad load = scaled(along_normal(all, site.axis), half_rho_c_area);
  load.turning = half_rho_c_area * turning_of_plate(site.axis, all.mean);
  return load;
}

SiteLoad load_on_any(const Site& site, const GustStatistics& wind, const LoadLaw& law) {
  switch (site.kind) {
    case SiteKind::blade:
      return load_on_blade(site, wind, law);
    case SiteKind::ribbon:
      return load_on_ribbon(site, wind, law);
    case SiteKind::plate:
      return load_on_plate(site, wind, law);
    case SiteKind::cylinder:
      break;
  }
  return load_on_cylinder(site, wind, law);
}

SiteLoad printed_load_on(const Site& site, const LoadOptions& options) {
  if (site.kind != SiteKind::cylinder) return {};
  const Mat3 across = Mat3::Identity() - site.axis * site.axis.transpose();
  return {0.5 * options.fluid_density * options.branch_drag_coefficient * site.mean_area * across};
}

}  // namespace

void check_loads(const LoadOptions& options) {
  const auto check = [](const char* what, double value) {
    if (!std::isfinite(value) || value < 0) throw InputError(what, std::to_string(value), "0 or more");
  };
  check("fluid density", options.fluid_density);
  check("branch drag coefficient", options.branch_drag_coefficient);
  check("leaf drag coefficient", options.leaf_drag_coefficient);
  check("leaf lift coefficient", options.leaf_lift_coefficient);
  check("ribbon normal coefficient", options.ribbon_normal_coefficient);
  check("ribbon friction coefficient", options.ribbon_friction_coefficient);
  check("inertia coefficient", options.inertia_coefficient);
  check("plate normal coefficient", options.plate_normal_coefficient);
  check_foliage(options.foliage);
}

LoadLaw load_law(const LoadOptions& options) {
  check_loads(options);
  return {options, mix_folding(options.foliage)};
}

SiteLoad load_on(const Site& site, const GustStatistics& wind, double share, const LoadLaw& law) {
  if (law.options.model == LoadModel::paper) return printed_load_on(site, law.options);
  GustStatistics reaching{share * wind.mean, Mat3::Zero()};
  if (law.options.model == LoadModel::stochastic) reaching.covariance = share * share * wind.covariance;
  SiteLoad load = load_on_any(site, reaching, law);
  load.gust_share = share;
  return load;
}

Loads find_loads(const Sites& sites, const std::vector<GustStatistics>& wind, const LoadLaw& law,
                 const Eigen::VectorXd& share) {
  check_equal("points of the wind", static_cast<std::ptrdiff_t>(wind.size()), sites.point_count());
  const auto count = static_cast<std::ptrdiff_t>(sites.sites.size());
  if (share.size() > 0) check_equal("shares of the wind", share.size(), count);
  Loads loads{.sites = std::vector<SiteLoad>(sites.sites.size()),
              .has_inertia = law.options.inertia_coefficient > 0 && law.options.model != LoadModel::paper,
              .damp = law.options.model != LoadModel::paper};
  tbb::parallel_for(std::ptrdiff_t{0}, count, [&](std::ptrdiff_t s) {
    const Site& site = sites.sites[index_of(s)];
    loads.sites[index_of(s)] =
        load_on(site, wind[index_of(site.point)], share.size() > 0 ? share[s] : 1, law);
  });
  return loads;
}

Loads linearise_loads(const Sites& sites, const Eigen::Matrix3Xd& mean_wind, const LoadOptions& options) {
  check_equal("columns of the mean wind", mean_wind.cols(), sites.point_count());
  std::vector<GustStatistics> wind(index_of(mean_wind.cols()));
  for (Eigen::Index p = 0; p < mean_wind.cols(); ++p) wind[index_of(p)].mean = mean_wind.col(p);
  return find_loads(sites, wind, load_law(options));
}

double drag_area(const Site& site, const Vec3& wind, const LoadLaw& law) {
  const double speed = wind.norm();
  if (law.options.model == LoadModel::paper || speed == 0) return 0;
  if (site.kind == SiteKind::blade)
    return law.options.leaf_drag_coefficient * site.area * folding_factor(law.options.foliage, speed);
  if (site.kind == SiteKind::plate || site.kind == SiteKind::ribbon) {
    const double through = site.axis.dot(wind) / speed;
    const bool ribbon = site.kind == SiteKind::ribbon;
    return site.area *
           ((ribbon ? law.options.ribbon_normal_coefficient : law.options.plate_normal_coefficient) *
                through * through +
            (ribbon ? law.options.ribbon_friction_coefficient : 0));
  }
  return law.options.branch_drag_coefficient * site.area * site.axis.cross(wind).norm() / speed;
}

void check_loads(const Sites& sites, const Loads& loads) {
  check_equal("sites of the loads", static_cast<std::ptrdiff_t>(loads.sites.size()),
              static_cast<std::ptrdiff_t>(sites.sites.size()));
}

Vec3 drag_along(const Sheet& sheet, const Vec3& wind, double fluid_density) {
  constexpr double coefficient = 0.1;
  const Vec3 normal = sheet.normal();
  const Vec3 along = wind - wind.dot(normal) * normal;
  return 0.5 * fluid_density * coefficient * along.norm() * along;
}

Vec3 mean_drag(const Loads& loads) {
  Vec3 sum = Vec3::Zero();
  for (const SiteLoad& load : loads.sites) sum += load.mean;
  return sum;
}

Eigen::VectorXd mean_force(const Sites& sites, const Loads& loads) {
  check_loads(sites, loads);
  Eigen::Matrix3Xd forces(3, static_cast<Eigen::Index>(loads.sites.size()));
  for (std::size_t s = 0; s < loads.sites.size(); ++s)
    forces.col(static_cast<Eigen::Index>(s)) = loads.sites[s].mean;
  return sites.gather(forces);
}

Eigen::VectorXd fluctuating_force(const Sites& sites, const Loads& loads, const Eigen::Matrix3Xd& velocity) {
  return force_of_fluid(sites, loads, velocity,
                        [](const SiteLoad& load) -> Mat3 { return load.gust_share * load.per_velocity; });
}

Eigen::VectorXd inertia_force(const Sites& sites, const Loads& loads, const Eigen::Matrix3Xd& acceleration) {
  return force_of_fluid(sites, loads, acceleration,
                        [](const SiteLoad& load) { return load.per_acceleration; });
}

Eigen::MatrixXd modal_participation(const Sites& sites, const Loads& loads,
                                    Eigen::Ref<const Eigen::MatrixXd> shapes) {
  return sum_at_points(sites, loads, shapes,
                       [](const SiteLoad& load) -> Mat3 { return load.gust_share * load.per_velocity; });
}

Eigen::MatrixXd modal_inertia(const Sites& sites, const Loads& loads,
                              Eigen::Ref<const Eigen::MatrixXd> shapes) {
  if (!loads.has_inertia) return {};
  return sum_at_points(sites, loads, shapes, [](const SiteLoad& load) { return load.per_acceleration; });
}

}  // namespace tremula
