// What the wind does to a structure: nodal forces from the velocity at one point of each branch.
#pragma once

#include "tremula/geometry/skeleton.hpp"
#include "tremula/structure/structure.hpp"

#include <vector>

#include <Eigen/Core>

namespace tremula {

enum class LoadModel {
  linearised,  // of 1/2 rho C_D D |v_n| v_n about the mean wind (errata S6); leaves likewise
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

// Per branch k, with the wind v_k at its middle: force on the ends (start translation, start rotation, end
// translation, end rotation; world axes) = mean + per_velocity * v_k. One wind per branch, as S eq. 4 has it.
struct BranchLoad {
  Eigen::Matrix<double, 12, 3> per_velocity = Eigen::Matrix<double, 12, 3>::Zero();  // [N s/m, N s]
  Eigen::Matrix<double, 12, 1> mean = Eigen::Matrix<double, 12, 1>::Zero();          // [N, N m]
  // For aerodynamic damping: force per velocity, length and diameter of the branch, which per_velocity is
  // made of before lean_and_reconfigure takes a part of it. Zero for LoadModel::paper.
  Mat3 drag_per_diameter = Mat3::Zero();  // [N s/m^3]
};
struct Loads {
  Eigen::Matrix3Xd points;           // (3 x N) middles of the branches at rest [m]
  std::vector<BranchLoad> branches;  // (N)
  // Of every leaf, for damping too, in the order of the skeleton; none for LoadModel::paper.
  std::vector<Mat3> leaf_per_velocity = {};  // [N s/m]
  std::vector<int> leaf_branch = {};
};

// The translation of the point of a branch at s (0 start … 1 end) is the transpose of this times the
// displacements of its ends, stacked as above (S eq. 1). Also: the forces on the ends that a force there
// makes.
using PointShape = Eigen::Matrix<double, 12, 3>;
PointShape point_shape(const Beam& beam, const Vec3& direction, double s);

// The middles of the branches: where the loads want to know the wind. (3 x N) [m]
Eigen::Matrix3Xd load_points(const Skeleton& skeleton);

// mean_wind (3 x N) [m/s] at load_points. Throws InputError for densities or coefficients below 0. These
// functions throw it, too, for sizes that do not agree.
Loads linearise_loads(const Skeleton& skeleton, const Structure& structure, const Eigen::Matrix3Xd& mean_wind,
                      const LoadOptions& options = {});

// Throws InputError unless the loads are of a structure of as many branches.
void check_loads(const Structure& structure, const Loads& loads);

// Nodal forces (6N) of the loads on all branches under the mean wind, and of a fluctuation v (3 x N).
Eigen::VectorXd mean_force(const Structure& structure, const Loads& loads);
Eigen::VectorXd fluctuating_force(const Structure& structure, const Loads& loads,
                                  const Eigen::Matrix3Xd& velocity);

// Modal forces are participation^T * (v_x, v_y, v_z of branch 0, 1, …): (3N x m), real, the same for every
// frequency. shapes (6N x m).
Eigen::MatrixXd modal_participation(const Structure& structure, const Loads& loads,
                                    const Eigen::MatrixXd& shapes);

}  // namespace tremula
