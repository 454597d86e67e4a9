// What the wind does to a structure: forces on its sites from the velocity at their points.
#pragma once

#include "tremula/structure/sites.hpp"

#include <vector>

#include <Eigen/Core>

namespace tremula {

enum class LoadModel {
  linearised,  // of 1/2 rho C_D A |v_n| v_n about the mean wind (errata S6); leaves likewise
  paper,       // rho C_D r P v as S eq. 3 prints it: no mean wind in it, no leaves
};

struct LoadOptions {
  LoadModel model = LoadModel::linearised;
  double fluid_density = 1.2;            // of air [kg/m^3] (S section 2)
  double branch_drag_coefficient = 1.2;  // of a cylinder across the flow, on its diameter
  double leaf_drag_coefficient = 0.25;   // of foliage that folds in the wind, on one side of its area
  // Of a flat blade: a force C_L |u| (u . n) n along its normal n, whose part across the wind is lift. Blades
  // of foliage that folds and flutters have none on the average.
  double leaf_lift_coefficient = 0;
};

// With the wind v at the site's point, the force on it is mean + gust_share * per_velocity * v [N].
struct SiteLoad {
  Mat3 per_velocity = Mat3::Zero();  // of the wind, or against it of the site itself [N s/m]
  Vec3 mean = Vec3::Zero();          // [N]
};
struct Loads {
  std::vector<SiteLoad> sites;  // (S)
  // (P) What is left of a gust's force where the structure turns out of the wind with it
  // (reconfiguration.hpp).
  Eigen::VectorXd gust_share;
  bool damp = true;  // what moves meets the wind, too; LoadModel::paper knows nothing of it
};

// mean_wind (3 x P) [m/s] at the points of the sites. Throws InputError for densities or coefficients below
// 0. These functions throw it, too, for sizes that do not agree.
Loads linearise_loads(const Sites& sites, const Eigen::Matrix3Xd& mean_wind, const LoadOptions& options = {});

// Throws InputError unless the loads are of as many sites and points.
void check_loads(const Sites& sites, const Loads& loads);

// Forces on the rows of the structure: of all loads under the mean wind, and of a fluctuation v (3 x P).
Eigen::VectorXd mean_force(const Sites& sites, const Loads& loads);
Eigen::VectorXd fluctuating_force(const Sites& sites, const Loads& loads, const Eigen::Matrix3Xd& velocity);

// Modal forces are participation^T * (v_x, v_y, v_z of point 0, 1, …): (3P x c), real, the same for every
// frequency. shapes (rows x c).
Eigen::MatrixXd modal_participation(const Sites& sites, const Loads& loads,
                                    Eigen::Ref<const Eigen::MatrixXd> shapes);

}  // namespace tremula
