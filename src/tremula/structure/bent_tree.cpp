#include "tremula/structure/bent_tree.hpp"

#include "tremula/base/check.hpp"
#include "tremula/numerics/rotation.hpp"

#include <cmath>
#include <optional>

#include <Eigen/LU>

namespace tremula {
namespace {

// By how much the chord turns in the frame of the start.
Vec3 chord_turn(const Member& member, const Vec3& translation) {
  return member.direction.cross(translation) / member.beam.length;
}

// Where a beam on a spring of the ground stands on it, in the axes at rest; zero on rigid ground.
struct Foot {
  Vec3 translation = Vec3::Zero(), rotation = Vec3::Zero();
};
Foot foot_of(const Member& member, const BentBranch& branch) {
  if (member.beam.base.translation == 0 && member.beam.base.rotation == 0) return {};
  const double length = member.beam.length;
  const Vec3 turned = rotation_vector(branch.start_frame.transpose() * branch.chord_frame);
  const Vec3 chord = branch.start_frame.transpose() * (branch.end - branch.start);
  const double elongation = chord.norm() - length;
  const Vec3& d = member.direction;
  const Split end(elongation * d + length * turned.cross(d),
                  rotation_vector(branch.start_frame.transpose() * branch.end_frame), d);
  const Shape shape = shape_at(member.beam, 0);
  const Split moved(shape.axial[1] * end.along, shape.torsion[1] * end.twist,
                    shape.deflection[2] * end.across + shape.deflection[3] * end.bend,
                    shape.slope[2] * end.across + shape.slope[3] * end.bend);
  return {moved.translation(d), moved.rotation(d)};
}

}  // namespace

std::vector<BentBranch> bend(const BeamTree& tree, const Eigen::VectorXd& strains) {
  check_equal("rows of the strains", strains.size(), tree.size());
  std::vector<BentBranch> bent(tree.parent.size());
  for (int k = 0; k < tree.branch_count(); ++k) {
    const Member& member = tree.members[index_of(k)];
    BentBranch& branch = bent[index_of(k)];
    const int parent = tree.parent[index_of(k)];
    if (parent < 0) {
      branch.start = member.start;
    } else {
      const BentBranch& carrier = bent[index_of(parent)];
      branch.start_frame = carrier.end_frame;
      branch.start = carrier.end + carrier.end_frame * member.start_arm;
    }
    const Vec3 translation = strains.segment<3>(6 * k);
    branch.chord_frame.noalias() = branch.start_frame * rotation_matrix(chord_turn(member, translation));
    branch.end_frame.noalias() = branch.start_frame * rotation_matrix(strains.segment<3>(6 * k + 3));
    branch.end = branch.start + (member.beam.length + translation.dot(member.direction)) *
                                    (branch.chord_frame * member.direction);
  }
  return bent;
}

Eigen::VectorXd strains_about(const BeamTree& tree, const Eigen::VectorXd& strains,
                              const std::vector<BentBranch>& bent, const Eigen::VectorXd& displacement) {
  return strains_about(tree, strain_maps(tree, strains, bent), displacement);
}

StrainMaps strain_maps(const BeamTree& tree, const Eigen::VectorXd& strains,
                       const std::vector<BentBranch>& bent) {
  check_equal("rows of the strains", strains.size(), tree.size());
  check_equal("bent branches", static_cast<std::ptrdiff_t>(bent.size()), tree.branch_count());
  StrainMaps maps;
  for (int k = 0; k < tree.branch_count(); ++k) {
    const Member& member = tree.members[index_of(k)];
    const BentBranch& branch = bent[index_of(k)];
    const Mat3 to_start = branch.start_frame.transpose(), to_chord = branch.chord_frame.transpose();
    // The chord turns by T(psi) d psi in the frame of the start, psi = d x v / length. psi and its growth
    // stay across d, where T has an inverse; what it would turn about the chord itself does not move the end.
    const Vec3& d = member.direction;
    const Mat3 along = d * d.transpose(), cross = cross_matrix(d);
    const Mat3 tangent = rotation_tangent(chord_turn(member, strains.segment<3>(6 * k)));
    const Vec3 chord = to_start * (branch.chord_frame * d);
    const Mat3 system = tangent * (Mat3::Identity() - along) + chord * d.transpose();
    const double length = (branch.end - branch.start).norm();
    const Mat3 turn = to_start * branch.chord_frame * cross * to_chord / length;
    maps.translation.emplace_back(along * to_chord -
                                  member.beam.length * (cross * system.partialPivLu().solve(turn)));
    maps.rotation.emplace_back(
        rotation_tangent(strains.segment<3>(6 * k + 3)).partialPivLu().solve(to_start));
    const int parent = tree.parent[index_of(k)];
    const Vec3 carrier = parent < 0 ? branch.start - member.start_arm : bent[index_of(parent)].end;
    maps.reach.emplace_back(branch.end - carrier);
  }
  return maps;
}

Eigen::VectorXd strains_about(const BeamTree& tree, const StrainMaps& maps,
                              const Eigen::VectorXd& displacement) {
  check_equal("rows of the displacement", displacement.size(), tree.size());
  for (const std::size_t count : {maps.translation.size(), maps.rotation.size(), maps.reach.size()})
    check_equal("maps of strains", static_cast<std::ptrdiff_t>(count), tree.branch_count());
  Eigen::VectorXd more(tree.size());
  for (int k = 0; k < tree.branch_count(); ++k) {
    const int parent = tree.parent[index_of(k)];
    Vec3 translation = displacement.segment<3>(6 * k), rotation = displacement.segment<3>(6 * k + 3);
    if (parent >= 0) {
      const Vec3 carried = displacement.segment<3>(6 * parent + 3);
      translation -= displacement.segment<3>(6 * parent) + carried.cross(maps.reach[index_of(k)]);
      rotation -= carried;
    }
    more.segment<3>(6 * k).noalias() = maps.translation[index_of(k)] * translation;
    more.segment<3>(6 * k + 3).noalias() = maps.rotation[index_of(k)] * rotation;
  }
  return more;
}

Eigen::VectorXd displacement_of(const BeamTree& tree, const std::vector<BentBranch>& bent) {
  check_equal("bent branches", static_cast<std::ptrdiff_t>(bent.size()), tree.branch_count());
  Eigen::VectorXd displacement(tree.size());
  for (int k = 0; k < tree.branch_count(); ++k) {
    displacement.segment<3>(6 * k) = bent[index_of(k)].end - tree.members[index_of(k)].point(1);
    displacement.segment<3>(6 * k + 3) = rotation_vector(bent[index_of(k)].end_frame);
  }
  return displacement;
}

BeamTree tree_at(const BeamTree& tree, const std::vector<BentBranch>& bent) {
  check_equal("bent branches", static_cast<std::ptrdiff_t>(bent.size()), tree.branch_count());
  BeamTree standing = tree;
  for (int k = 0; k < tree.branch_count(); ++k) {
    const BentBranch& branch = bent[index_of(k)];
    Member& member = standing.members[index_of(k)];
    member.direction = (branch.end - branch.start).normalized();
    member.start = branch.end - member.beam.length * member.direction;
    const int parent = tree.parent[index_of(k)];
    const Vec3 carrier =
        parent < 0 ? branch.start - tree.members[index_of(k)].start_arm : bent[index_of(parent)].end;
    member.start_arm = member.start - carrier;
    standing.reach[index_of(k)] = branch.end - carrier;
  }
  return standing;
}

BentCurve curve_of(const Member& member, const BentBranch& branch) {
  const Vec3& d = member.direction;
  const Foot foot = foot_of(member, branch);
  const bool rigid = foot.rotation.isZero(0);
  BentCurve curve{.start = branch.start + branch.start_frame * foot.translation,
                  .end = branch.end,
                  .start_frame = branch.start_frame,
                  .direction = d};
  if (!rigid) curve.start_frame *= rotation_matrix(foot.rotation);
  const double length = (curve.end - curve.start).norm();
  curve.start_slope = length * (curve.start_frame * d);
  curve.end_slope = length * (branch.end_frame * d);
  curve.turn = rotation_vector(curve.start_frame.transpose() * branch.end_frame);
  return curve;
}

Vec3 position_on(const BentCurve& curve, double s) {
  const double s2 = s * s, s3 = s2 * s;
  return (1 - 3 * s2 + 2 * s3) * curve.start + (s - 2 * s2 + s3) * curve.start_slope +
         (3 * s2 - 2 * s3) * curve.end + (s3 - s2) * curve.end_slope;
}

namespace {

// Along the axis by s, or nothing where the curve has a cusp.
std::optional<Vec3> slope_on(const BentCurve& curve, double s) {
  const double s2 = s * s;
  const Vec3 along = (6 * s2 - 6 * s) * (curve.start - curve.end) + (1 - 4 * s + 3 * s2) * curve.start_slope +
                     (3 * s2 - 2 * s) * curve.end_slope;
  const double size = along.norm();
  if (!(size > 1e-9 * curve.end_slope.norm())) return {};
  return along / size;
}

// Between the frames of the ends by even turning.
Mat3 frame_between(const BentCurve& curve, double s) {
  return curve.start_frame * rotation_matrix(s * curve.turn);
}

}  // namespace

Vec3 direction_on(const BentCurve& curve, double s) {
  if (const std::optional<Vec3> slope = slope_on(curve, s)) return *slope;
  return frame_between(curve, s) * curve.direction;
}

// The frame between those of the ends, and from there the shortest way into the curve.
BentPoint point_on(const BentCurve& curve, double s) {
  const Mat3 between = frame_between(curve, s);
  const std::optional<Vec3> slope = slope_on(curve, s);
  const Vec3 position = position_on(curve, s);
  if (!slope) return {position, between};
  return {position, shortest_turn(between * curve.direction, *slope) * between};
}

BentPoint point_on(const Member& member, const BentBranch& branch, double s) {
  return point_on(curve_of(member, branch), s);
}

}  // namespace tremula
