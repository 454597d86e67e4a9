#include "tremula/dynamics/motion_statistics.hpp"

#include "tremula/base/check.hpp"
#include "tremula/structure/bent_tree.hpp"

#include <algorithm>
#include <array>
#include <cmath>
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

// The rows of the nodes at the ends of the members, in their order, and of all nodes of what is flat; -1
// where that is held.
std::vector<Eigen::Index> end_rows(const Structure& structure) {
  std::vector<Eigen::Index> rows;
  for (const Member& member : structure.members) rows.push_back(member.end_row);
  for (std::size_t i = 0; structure.sheet && i < structure.nodes.size(); ++i)
    rows.push_back(structure.nodes[i].row);
  for (const PlacedPanel& panel : structure.panels) {
    for (const PanelNode& node : panel.nodes) rows.push_back(node.row);
  }
  return rows;
}

// The columns that move, side by side.
std::vector<Eigen::Index> moving_columns(const Basis& basis) {
  std::vector<Eigen::Index> columns;
  for (std::size_t c = 0; c < basis.kind.size(); ++c) {
    if (basis.kind[c] != ShapeKind::lean) columns.push_back(static_cast<Eigen::Index>(c));
  }
  return columns;
}

Sway sway_of(const std::vector<Eigen::Index>& rows, const Basis& basis, const Eigen::MatrixXd& coordinates) {
  const std::vector<Eigen::Index> columns = moving_columns(basis);
  const Eigen::MatrixXd moving = coordinates(Eigen::all, columns);
  Sway sway{.coordinates =
                moving.colwise().norm().transpose() / std::sqrt(static_cast<double>(moving.rows()))};
  const Eigen::MatrixXd root = covariance_root(moving);
  const auto rms = [&](Eigen::Index row) {
    return (basis.columns(Eigen::seqN(row, 3), columns) * root).norm();
  };
  std::vector<std::array<double, 2>> moved(rows.size());
  tbb::parallel_for(std::size_t{0}, rows.size(), [&](std::size_t k) {
    if (rows[k] >= 0) moved[k] = {rms(rows[k]), rms(rows[k] + 3)};
  });
  for (std::size_t k = 0; k < moved.size(); ++k) {
    sway.rotation = std::max(sway.rotation, moved[k][1]);
    if (moved[k][0] > sway.displacement) {
      sway.displacement = moved[k][0];
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
Vec3 separation(const Member& member, Eigen::Ref<const Eigen::VectorXd> displacement) {
  const EndDisplacements ends = end_displacements(member, displacement);
  const Vec3 foot = foot_displacement(member, displacement).head<3>();
  return ends.end_translation - (ends.start_translation + foot);
}

// What small displacements superpose on: the structure at rest, the lean one of them; or, where the lean
// bends far, the tree as it stands in it.
struct Ground {
  std::vector<Member> members;
  std::vector<Vec3> chords;  // from the start to the end of every member there
};

Ground ground_of(const Structure& structure, const Eigen::VectorXd& lean_strains) {
  Ground ground{{structure.members.begin(), structure.members.end()}, {}};
  for (const Member& member : ground.members) ground.chords.push_back(member.beam.length * member.direction);
  if (lean_strains.size() == 0) return ground;
  if (structure.tree == nullptr) throw InputError("structure that bends far", "a frame", "a tree");
  const std::vector<BentBranch> bent = bend(*structure.tree, lean_strains);
  ground.members = tree_at(*structure.tree, bent).members;
  for (std::size_t k = 0; k < bent.size(); ++k)
    ground.chords[k] = bent[k].end - point_on(structure.members[k], bent[k], 0).position;
  return ground;
}

// Of a few branches, at some samples. weights: 0 for a lean that is part of the ground.
Stretch stretch_of(const Ground& ground, const Basis& basis, const Eigen::MatrixXd& weights, int first,
                   int last) {
  constexpr Eigen::Index frames_together = 256;
  Eigen::MatrixXd apart(3 * (last - first), weights.cols());
  for (Eigen::Index c = 0; c < weights.cols(); ++c) {
    for (int k = first; k < last; ++k)
      apart.block<3, 1>(3 * (k - first), c) =
          separation(ground.members[static_cast<std::size_t>(k)], basis.columns.col(c));
  }
  Stretch most;
  for (Eigen::Index begin = 0; begin < weights.rows(); begin += frames_together) {
    const Eigen::Index frames = std::min(frames_together, weights.rows() - begin);
    const Eigen::MatrixXd moved = apart * weights.middleRows(begin, frames).transpose();
    for (int k = first; k < last; ++k) {
      const double length = ground.members[static_cast<std::size_t>(k)].beam.length;
      const Vec3& chord = ground.chords[static_cast<std::size_t>(k)];
      const double longest =
          (moved.middleRows<3>(3 * (k - first)).colwise() + chord).colwise().norm().maxCoeff();
      if (longest / length - 1 > most.share) most = {longest / length - 1, k};
    }
  }
  return most;
}

Stretch largest_stretch(const Structure& structure, const Motion& motion) {
  if (structure.members.empty()) return {};
  constexpr double operations = 4e8;
  constexpr int fewest_frames = 32, branches_together = 512;
  const Eigen::Index samples = motion.sample_count(), columns = motion.coordinates.cols();
  const int count = static_cast<int>(structure.members.size());
  const double affordable = operations / (6.0 * count * static_cast<double>(columns));
  const Eigen::Index frames =
      std::min(samples, std::max<Eigen::Index>(fewest_frames, static_cast<Eigen::Index>(affordable)));
  Eigen::MatrixXd weights(frames, columns);
  for (Eigen::Index frame = 0; frame < frames; ++frame)
    weights.row(frame) = motion.coordinates.row(frame * samples / frames);
  const Ground ground = ground_of(structure, motion.lean_strains);
  for (Eigen::Index c = 0; c < columns && motion.lean_strains.size() > 0; ++c) {
    if (motion.basis.kind[static_cast<std::size_t>(c)] == ShapeKind::lean) weights.col(c).setZero();
  }

  std::vector<Stretch> parts(static_cast<std::size_t>((count + branches_together - 1) / branches_together));
  tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t part) {
    const int first = static_cast<int>(part) * branches_together;
    parts[part] =
        stretch_of(ground, motion.basis, weights, first, std::min(count, first + branches_together));
  });
  return *std::max_element(parts.begin(), parts.end(),
                           [](const Stretch& a, const Stretch& b) { return a.share < b.share; });
}

}  // namespace

MotionStatistics motion_statistics(const Structure& structure, const Motion& motion) {
  check_motion(motion);
  check_equal("rows of the motion", motion.basis.columns.rows(), structure.size());

  MotionStatistics statistics;
  const std::vector<Eigen::Index> rows = end_rows(structure);
  const Eigen::VectorXd lean = lean_of(motion.basis);
  for (const Eigen::Index row : rows) {
    if (row < 0) continue;
    statistics.largest_lean = std::max(statistics.largest_lean, lean.segment<3>(row).norm());
    statistics.largest_lean_rotation =
        std::max(statistics.largest_lean_rotation, lean.segment<3>(row + 3).norm());
  }
  const Eigen::RowVectorXd mean = motion.coordinates.colwise().mean();
  statistics.about_lean = sway_of(rows, motion.basis, motion.coordinates);
  statistics.about_mean = sway_of(rows, motion.basis, motion.coordinates.rowwise() - mean);
  const Stretch stretch = largest_stretch(structure, motion);
  statistics.largest_stretch = stretch.share;
  statistics.most_stretched_branch = stretch.branch;
  return statistics;
}

}  // namespace tremula
