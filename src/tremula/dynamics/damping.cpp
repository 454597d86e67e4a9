#include "tremula/dynamics/damping.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/error.hpp"
#include "tremula/numerics/quadrature.hpp"

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

constexpr int chunk_branches = 512;  // whose points make one matrix product

// Velocities of points of a chunk of branches, and the forces on them, point by point.
struct PointRows {
  Eigen::MatrixXd motion, force;
  Eigen::Index used = 0;

  PointRows(Eigen::Index rows, Eigen::Index modes) : motion(rows, modes), force(rows, modes) {}
  void add(const PointShape& shape, const Eigen::MatrixXd& ends, const Mat3& drag) {
    motion.middleRows<3>(used).noalias() = shape.transpose() * ends;
    force.middleRows<3>(used).noalias() = drag * motion.middleRows<3>(used);
    used += 3;
  }
};

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

Eigen::MatrixXd aerodynamic_damping(const Skeleton& skeleton, const Structure& structure, const Loads& loads,
                                    const Eigen::MatrixXd& shapes) {
  check_loads(structure, loads);
  check_equal("rows of the shapes", shapes.rows(), structure.size());
  check_equal("branches of the skeleton", skeleton.branch_count(), structure.branch_count());
  static const std::vector<QuadraturePoint> quadrature = gauss_legendre(4);
  const Eigen::Index modes = shapes.cols();
  const int count = structure.branch_count();
  std::vector<std::vector<std::size_t>> leaves(static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < loads.leaf_per_velocity.size(); ++i) {
    leaves[static_cast<std::size_t>(loads.leaf_branch[i])].push_back(i);
  }
  const int chunks = (count + chunk_branches - 1) / chunk_branches;
  std::vector<Eigen::MatrixXd> parts(static_cast<std::size_t>(chunks));
  tbb::parallel_for(0, chunks, [&](int chunk) {
    const int first = chunk * chunk_branches, last = std::min(count, first + chunk_branches);
    Eigen::Index points = 0;
    for (int k = first; k < last; ++k) {
      points += static_cast<Eigen::Index>(quadrature.size() + leaves[static_cast<std::size_t>(k)].size());
    }
    PointRows rows(3 * points, modes);
    Eigen::MatrixXd ends(12, modes);
    for (int k = first; k < last; ++k) {
      const auto index = static_cast<std::size_t>(k);
      for (Eigen::Index r = 0; r < modes; ++r) {
        const EndDisplacements moved = end_displacements(structure, shapes.col(r), k);
        ends.col(r) << moved.start_translation, moved.start_rotation, moved.end_translation,
            moved.end_rotation;
      }
      const Beam& beam = structure.beams[index];
      for (const QuadraturePoint& point : quadrature) {
        const double diameter =
            2 * (beam.start_radius + point.position * (beam.end_radius - beam.start_radius));
        rows.add(point_shape(beam, structure.direction[index], point.position), ends,
                 beam.length * point.weight * diameter * loads.branches[index].drag_per_diameter);
      }
      for (const std::size_t leaf : leaves[index]) {
        rows.add(point_shape(beam, structure.direction[index], skeleton.leaves[leaf].position), ends,
                 loads.leaf_per_velocity[leaf]);
      }
    }
    parts[static_cast<std::size_t>(chunk)].noalias() = rows.motion.transpose() * rows.force;
  });
  Eigen::MatrixXd damping = Eigen::MatrixXd::Zero(modes, modes);
  for (const Eigen::MatrixXd& part : parts) damping += part;
  return damping;
}

}  // namespace tremula
