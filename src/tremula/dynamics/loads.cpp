#include "tremula/dynamics/loads.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/error.hpp"
#include "tremula/numerics/quadrature.hpp"

#include <cmath>
#include <string>

namespace tremula {
namespace {

// Drag of 1/2 rho C A |u| u on the part u of the wind that counts, linearised about its mean: A C rho/2 |U|
// (P + n n^T).
struct Drag {
  Mat3 per_velocity = Mat3::Zero();
  Vec3 mean = Vec3::Zero();
};

Drag linearise(double half_rho_c_area, const Mat3& projection, const Vec3& mean_wind) {
  const Vec3 normal_wind = projection * mean_wind;
  const double speed = normal_wind.norm();
  if (speed == 0) return {};
  const Vec3 n = normal_wind / speed;
  return {half_rho_c_area * speed * (projection + n * n.transpose()), half_rho_c_area * speed * normal_wind};
}

// The force c |u| (u . n) n along the normal of a blade, linearised likewise.
void add_lift(double half_rho_c_area, const Vec3& normal, const Vec3& mean_wind, Drag& drag) {
  const double speed = mean_wind.norm();
  if (speed == 0 || half_rho_c_area == 0) return;
  const double through = mean_wind.dot(normal);
  drag.mean += half_rho_c_area * speed * through * normal;
  drag.per_velocity += half_rho_c_area * normal * (speed * normal + through / speed * mean_wind).transpose();
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

template <class Scalar>
void add_end_forces(const Structure& structure, int k, const Eigen::Matrix<Scalar, 12, 1>& ends,
                    Eigen::Matrix<Scalar, Eigen::Dynamic, 1>& force) {
  force.template segment<6>(6 * k) += ends.template tail<6>();
  const int parent = structure.parent[static_cast<std::size_t>(k)];
  if (parent < 0) return;
  const Eigen::Matrix<Scalar, 3, 1> at_start = ends.template head<3>();
  force.template segment<3>(6 * parent) += at_start;
  force.template segment<3>(6 * parent + 3) +=
      ends.template segment<3>(3) + structure.start_arm[static_cast<std::size_t>(k)].cross(at_start);
}

}  // namespace

// A force at s on the axis as forces on the two ends: the transpose of S eq. 1, B before it is integrated (S
// eq. 4). A force across the branch makes moments d x f on the slopes.
PointShape point_shape(const Beam& beam, const Vec3& direction, double s) {
  const Shape shape = shape_at(beam, s);
  const Mat3 along = direction * direction.transpose();
  const Mat3 across = Mat3::Identity() - along;
  Mat3 cross;
  cross << 0, -direction[2], direction[1], direction[2], 0, -direction[0], -direction[1], direction[0], 0;
  PointShape forces;
  forces << shape.axial[0] * along + shape.deflection[0] * across, shape.deflection[1] * cross,
      shape.axial[1] * along + shape.deflection[2] * across, shape.deflection[3] * cross;
  return forces;
}

Eigen::Matrix3Xd load_points(const Skeleton& skeleton) {
  Eigen::Matrix3Xd points(3, skeleton.branch_count());
  for (int k = 0; k < skeleton.branch_count(); ++k) {
    const Branch& branch = skeleton.branches[static_cast<std::size_t>(k)];
    points.col(k) = 0.5 * (branch.start + branch.end);
  }
  return points;
}

Loads linearise_loads(const Skeleton& skeleton, const Structure& structure, const Eigen::Matrix3Xd& mean_wind,
                      const LoadOptions& options) {
  check_options(options);
  check_equal("branches of the structure", structure.branch_count(), skeleton.branch_count());
  check_equal("columns of the mean wind", mean_wind.cols(), skeleton.branch_count());
  static const std::vector<QuadraturePoint> quadrature = gauss_legendre(4);
  Loads loads{.points = load_points(skeleton), .branches = {}};
  loads.branches.reserve(static_cast<std::size_t>(skeleton.branch_count()));
  for (int k = 0; k < skeleton.branch_count(); ++k) {
    const auto index = static_cast<std::size_t>(k);
    const Beam& beam = structure.beams[index];
    const Vec3& direction = structure.direction[index];
    const Mat3 projection = Mat3::Identity() - direction * direction.transpose();
    BranchLoad load;
    const double mean_radius = 0.5 * (beam.start_radius + beam.end_radius);
    const Drag per_diameter = linearise(0.5 * options.fluid_density * options.branch_drag_coefficient,
                                        projection, mean_wind.col(k));
    if (options.model == LoadModel::linearised) load.drag_per_diameter = per_diameter.per_velocity;
    for (const QuadraturePoint& point : quadrature) {
      const PointShape forces = beam.length * point.weight * point_shape(beam, direction, point.position);
      if (options.model == LoadModel::paper) {
        load.per_velocity +=
            options.fluid_density * options.branch_drag_coefficient * mean_radius * forces * projection;
        continue;
      }
      const double diameter =
          2 * (beam.start_radius + point.position * (beam.end_radius - beam.start_radius));
      load.per_velocity += diameter * forces * per_diameter.per_velocity;
      load.mean += diameter * forces * per_diameter.mean;
    }
    loads.branches.push_back(load);
  }
  if (options.model == LoadModel::paper) return loads;
  for (const Leaf& leaf : skeleton.leaves) {
    const auto index = static_cast<std::size_t>(leaf.branch);
    const double half_rho_area = 0.5 * options.fluid_density * leaf.area;
    Drag drag = linearise(half_rho_area * options.leaf_drag_coefficient, Mat3::Identity(),
                          mean_wind.col(leaf.branch));
    add_lift(half_rho_area * options.leaf_lift_coefficient, leaf.normal, mean_wind.col(leaf.branch), drag);
    loads.leaf_per_velocity.push_back(drag.per_velocity);
    loads.leaf_branch.push_back(leaf.branch);
    const PointShape forces = point_shape(structure.beams[index], structure.direction[index], leaf.position);
    loads.branches[index].per_velocity += forces * drag.per_velocity;
    loads.branches[index].mean += forces * drag.mean;
  }
  return loads;
}

void check_loads(const Structure& structure, const Loads& loads) {
  check_equal("branches of the loads", static_cast<std::ptrdiff_t>(loads.branches.size()),
              structure.branch_count());
  check_equal("branches of the leaves in the loads", static_cast<std::ptrdiff_t>(loads.leaf_branch.size()),
              static_cast<std::ptrdiff_t>(loads.leaf_per_velocity.size()));
  for (const int branch : loads.leaf_branch) {
    if (branch < 0 || branch >= structure.branch_count()) {
      throw InputError("branch of a leaf in the loads", std::to_string(branch),
                       "0 to " + std::to_string(structure.branch_count() - 1));
    }
  }
}

Eigen::VectorXd mean_force(const Structure& structure, const Loads& loads) {
  check_loads(structure, loads);
  Eigen::VectorXd force = Eigen::VectorXd::Zero(structure.size());
  for (int k = 0; k < structure.branch_count(); ++k) {
    add_end_forces<double>(structure, k, loads.branches[static_cast<std::size_t>(k)].mean, force);
  }
  return force;
}

Eigen::VectorXd fluctuating_force(const Structure& structure, const Loads& loads,
                                  const Eigen::Matrix3Xd& velocity) {
  check_loads(structure, loads);
  check_equal("columns of the velocity", velocity.cols(), structure.branch_count());
  Eigen::VectorXd force = Eigen::VectorXd::Zero(structure.size());
  for (int k = 0; k < structure.branch_count(); ++k) {
    add_end_forces<double>(structure, k,
                           loads.branches[static_cast<std::size_t>(k)].per_velocity * velocity.col(k), force);
  }
  return force;
}

Eigen::MatrixXd modal_participation(const Structure& structure, const Loads& loads,
                                    const Eigen::MatrixXd& shapes) {
  check_loads(structure, loads);
  check_equal("rows of the shapes", shapes.rows(), structure.size());
  Eigen::MatrixXd participation(3 * structure.branch_count(), shapes.cols());
  for (Eigen::Index r = 0; r < shapes.cols(); ++r) {
    const Eigen::VectorXd shape = shapes.col(r);
    for (int k = 0; k < structure.branch_count(); ++k) {
      const EndDisplacements ends = end_displacements(structure, shape, k);
      Eigen::Matrix<double, 12, 1> stacked;
      stacked << ends.start_translation, ends.start_rotation, ends.end_translation, ends.end_rotation;
      participation.block<3, 1>(3 * k, r) =
          loads.branches[static_cast<std::size_t>(k)].per_velocity.transpose() * stacked;
    }
  }
  return participation;
}

}  // namespace tremula
