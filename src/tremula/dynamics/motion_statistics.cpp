#include "tremula/dynamics/motion_statistics.hpp"

#include "tremula/base/error.hpp"
#include "tremula/dynamics/basis.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <tbb/parallel_for.h>
#include <Eigen/Eigenvalues>

namespace tremula {
namespace {

// A root of the covariance, R R^T: mean squares are then sums of squares and cannot come out below zero.
Eigen::MatrixXd covariance_root(const Eigen::MatrixXd& coordinates) {
  const Eigen::MatrixXd covariance =
      coordinates.transpose() * coordinates / static_cast<double>(coordinates.rows());
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(covariance);
  return solver.eigenvectors() * solver.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal();
}

Sway sway_of(const Modes& modes, const StaticShapes& more, const Eigen::MatrixXd& coordinates) {
  Sway sway{.coordinates = coordinates.colwise().norm().transpose() /
                           std::sqrt(static_cast<double>(coordinates.rows()))};
  const Eigen::MatrixXd root = covariance_root(coordinates);
  const auto rms = [&](Eigen::Index row) {
    Eigen::MatrixXd moved = modes.shapes.middleRows(row, 3) * root.topRows(modes.count());
    if (more.count() > 0) moved += more.shapes.middleRows(row, 3) * root.bottomRows(more.count());
    return moved.norm();
  };
  for (Eigen::Index k = 0; k < modes.shapes.rows() / 6; ++k) {
    sway.rotation = std::max(sway.rotation, rms(6 * k + 3));
    const double displacement = rms(6 * k);
    if (displacement > sway.displacement) {
      sway.displacement = displacement;
      sway.branch = static_cast<int>(k);
    }
  }
  return sway;
}

struct Stretch {
  double share = 0;
  int branch = 0;
};

// How the ends of a branch move apart.
Vec3 separation(const Structure& structure, Eigen::Ref<const Eigen::VectorXd> displacement, int branch) {
  const EndDisplacements ends = end_displacements(structure, displacement, branch);
  Vec3 start = ends.start_translation;
  if (structure.parent[static_cast<std::size_t>(branch)] < 0)
    start = foot_displacement(structure, displacement, branch).head<3>();
  return ends.end_translation - start;
}

// Of a few branches, at some samples.
Stretch stretch_of(const Structure& structure, const Modes& modes, const Motion& motion,
                   const Eigen::MatrixXd& weights, int first, int last) {
  constexpr Eigen::Index frames_together = 256;
  Eigen::MatrixXd apart(3 * (last - first), weights.cols());
  for (Eigen::Index c = 0; c < weights.cols(); ++c) {
    const Eigen::Ref<const Eigen::VectorXd> shape = shape_of(modes, motion, c);
    for (int k = first; k < last; ++k)
      apart.block<3, 1>(3 * (k - first), c) = separation(structure, shape, k);
  }
  Stretch most;
  for (Eigen::Index begin = 0; begin < weights.rows(); begin += frames_together) {
    const Eigen::Index frames = std::min(frames_together, weights.rows() - begin);
    const Eigen::MatrixXd moved = apart * weights.middleRows(begin, frames).transpose();
    for (int k = first; k < last; ++k) {
      const auto index = static_cast<std::size_t>(k);
      const double length = structure.beams[index].length;
      const Vec3 chord = length * structure.direction[index];
      const double longest =
          (moved.middleRows<3>(3 * (k - first)).colwise() + chord).colwise().norm().maxCoeff();
      if (longest / length - 1 > most.share) most = {longest / length - 1, k};
    }
  }
  return most;
}

Stretch largest_stretch(const Structure& structure, const Modes& modes, const Motion& motion) {
  constexpr double operations = 4e8;
  constexpr int fewest_frames = 32, branches_together = 512;
  const Eigen::Index samples = motion.sample_count(), columns = 1 + motion.coordinates.cols();
  const int count = structure.branch_count();
  const double affordable = operations / (6.0 * count * static_cast<double>(columns));
  const Eigen::Index frames =
      std::min(samples, std::max<Eigen::Index>(fewest_frames, static_cast<Eigen::Index>(affordable)));
  Eigen::MatrixXd weights(frames, columns);
  for (Eigen::Index frame = 0; frame < frames; ++frame)
    weights.row(frame) << 1, motion.coordinates.row(frame * samples / frames);

  std::vector<Stretch> parts(static_cast<std::size_t>((count + branches_together - 1) / branches_together));
  tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t part) {
    const int first = static_cast<int>(part) * branches_together;
    parts[part] =
        stretch_of(structure, modes, motion, weights, first, std::min(count, first + branches_together));
  });
  return *std::max_element(parts.begin(), parts.end(),
                           [](const Stretch& a, const Stretch& b) { return a.share < b.share; });
}

}  // namespace

MotionStatistics motion_statistics(const Structure& structure, const Modes& modes, const Motion& motion) {
  check_belong_together(modes, motion);
  if (motion.lean.size() != structure.size()) {
    throw InputError("rows of the motion", std::to_string(motion.lean.size()),
                     std::to_string(structure.size()) + " for this structure");
  }
  if (motion.sample_count() == 0) throw InputError("motion", "no sample", "one or more");
  if (!motion.lean.allFinite() || !motion.coordinates.allFinite())
    throw InputError("motion", "a displacement that is no number", "numbers");

  MotionStatistics statistics;
  for (Eigen::Index k = 0; k < motion.lean.size() / 6; ++k) {
    statistics.largest_lean = std::max(statistics.largest_lean, motion.lean.segment<3>(6 * k).norm());
    statistics.largest_lean_rotation =
        std::max(statistics.largest_lean_rotation, motion.lean.segment<3>(6 * k + 3).norm());
  }
  const Eigen::RowVectorXd mean = motion.coordinates.colwise().mean();
  statistics.about_lean = sway_of(modes, motion.static_shapes, motion.coordinates);
  statistics.about_mean = sway_of(modes, motion.static_shapes, motion.coordinates.rowwise() - mean);
  const Stretch stretch = largest_stretch(structure, modes, motion);
  statistics.largest_stretch = stretch.share;
  statistics.most_stretched_branch = stretch.branch;
  return statistics;
}

}  // namespace tremula
