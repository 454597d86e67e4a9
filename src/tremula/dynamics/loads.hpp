// What the wind does to a structure: forces on its sites from the velocity at their points.
#pragma once

#include "tremula/dynamics/foliage.hpp"
#include "tremula/dynamics/gust_average.hpp"
#include "tremula/structure/sheet.hpp"
#include "tremula/structure/sites.hpp"
#include "tremula/wind/gust_statistics.hpp"

#include <vector>

#include <Eigen/Core>

namespace tremula {

enum class LoadModel {
  stochastic,  // of 1/2 rho C_D A |v_n| v_n: its mean over the gusts and the best linear fit
               // (gust_average.hpp)
  linearised,  // of the same about the mean wind (errata S6): right for small gusts
  paper,       // rho C_D r P v as S eq. 3 prints it: no mean wind in it, no leaves
};

struct LoadOptions {
  LoadModel model = LoadModel::stochastic;
  double fluid_density = 1.2;            // of air [kg/m^3] (S section 2)
  double branch_drag_coefficient = 1.2;  // of a cylinder across the flow, on its diameter
  double leaf_drag_coefficient = 0.25;   // of foliage that folds in the wind, on one side of its area
  FoliageLaw foliage = {};               // how it folds further
  // Of a flat blade: a force C_L |u| (u . n) n along its normal n, whose part across the wind is lift. Blades
  // of foliage that folds and flutters have none on the average.
  double leaf_lift_coefficient = 0;
  // Of a ribbon, which is as flat as a plate and far longer than wide: a force C_N |u| (u . n) n on one side
  // of its area, and C_f |u| u for the friction of both (Luhar & Nepf 2011 and Zhu et al. 2021 take 1.95 and
  // 0.02 for blades in water).
  double ribbon_normal_coefficient = 1.95;
  double ribbon_friction_coefficient = 0.02;
  // C_M of the force rho C_M V dv/dt across a cylinder of volume V in a fluid that speeds up (Morison's
  // second term). 2 is the potential flow's, 1 for the pressure and 1 for the added mass; in air it is
  // nothing. Blades have the first of these on their own volume and the second, C_M - 1, on the fluid that
  // they carry, along their normal.
  double inertia_coefficient = 0;
  // Of a sheet: a force C_N |u| (u . n) n on one side of its area. C_N of a plate square to the flow is 1.1
  // to 1.2 for sides of 1:1 to 1:5 (Hoerner 1965, Fluid-Dynamic Drag, section 3-4).
  double plate_normal_coefficient = 1.2;
};

// Throws InputError for densities or coefficients below 0, and as check_foliage does.
void check_loads(const LoadOptions& options);

// With the gust v at the site's point, the force on it is mean + gust_share * per_velocity * v +
// per_acceleration * dv/dt [N].
struct SiteLoad {
  Mat3 per_velocity = Mat3::Zero();      // of the wind at the site, or against it of the site itself [N s/m]
  Vec3 mean = Vec3::Zero();              // [N]
  Mat3 turning = Mat3::Zero();           // how the mean grows when the site turns [N/rad]
  Mat3 per_acceleration = Mat3::Zero();  // of the fluid [kg]
  double gust_share = 1;                 // what shelter leaves of a gust (shelter.hpp)
};
struct Loads {
  std::vector<SiteLoad> sites;  // (S)
  bool has_inertia = false;     // whether any has a per_acceleration
  bool damp = true;             // what moves meets the wind, too; LoadModel::paper knows nothing of it
};

// What options say of every site, prepared once.
struct LoadLaw {
  LoadOptions options;
  FoldingMixture folding;
};
LoadLaw load_law(const LoadOptions& options);  // throws as check_loads does

// The load of one site whose free wind is this and of which shelter leaves a share.
SiteLoad load_on(const Site& site, const GustStatistics& wind, double share, const LoadLaw& law);

// On all of them. wind (P) of their points, free of shelter; share (S), empty: 1. Throws InputError for sizes
// that do not agree.
Loads find_loads(const Sites& sites, const std::vector<GustStatistics>& wind, const LoadLaw& law,
                 const Eigen::VectorXd& share = {});
// The same in a mean wind without gusts (3 x P) [m/s].
Loads linearise_loads(const Sites& sites, const Eigen::Matrix3Xd& mean_wind, const LoadOptions& options = {});

// The drag coefficient times the area that a site turns towards the wind [m^2]: what shelters others.
double drag_area(const Site& site, const Vec3& wind, const LoadLaw& law);

// Throws InputError unless the loads are of as many sites.
void check_loads(const Sites& sites, const Loads& loads);

// How the mean wind drags at every area of a sheet along itself, both sides together [N/m^2]: 1/2 rho C U |U|
// of the part in its plane, C = 0.1. Flags that flap have 0.06 to 0.2 on one side of their area (Hoerner
// 1965, section 3-25).
Vec3 drag_along(const Sheet& sheet, const Vec3& wind, double fluid_density);

// The sum of all means [N].
Vec3 mean_drag(const Loads& loads);

// Forces on the rows of the structure: of all loads under the mean wind, and of a fluctuation v (3 x P).
Eigen::VectorXd mean_force(const Sites& sites, const Loads& loads);
Eigen::VectorXd fluctuating_force(const Sites& sites, const Loads& loads, const Eigen::Matrix3Xd& velocity);

// Of a fluid that speeds up by so much (3 x P) [m/s^2].
Eigen::VectorXd inertia_force(const Sites& sites, const Loads& loads, const Eigen::Matrix3Xd& acceleration);

// Modal forces are participation^T * (v_x, v_y, v_z of point 0, 1, …): (3P x c), real, the same for every
// frequency. shapes (rows x c).
Eigen::MatrixXd modal_participation(const Sites& sites, const Loads& loads,
                                    Eigen::Ref<const Eigen::MatrixXd> shapes);
// The same of dv/dt; empty where there is none.
Eigen::MatrixXd modal_inertia(const Sites& sites, const Loads& loads,
                              Eigen::Ref<const Eigen::MatrixXd> shapes);

}  // namespace tremula
