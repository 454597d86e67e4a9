#include "tremula/deformation/bent_pose.hpp"

#include "tremula/base/check.hpp"
#include "tremula/deformation/carry_surface.hpp"
#include "tremula/numerics/rotation.hpp"

#include <algorithm>

namespace tremula {
namespace {

void check_tree(const Structure& structure) {
  if (structure.tree == nullptr) throw InputError("structure that bends far", "a frame", "a tree");
}

void check_bent(const Structure& structure, const std::vector<BentBranch>& bent) {
  check_tree(structure);
  check_equal("bent branches", static_cast<std::ptrdiff_t>(bent.size()), structure.tree->branch_count());
}

// A cross section that carries what hangs on it by position + turn (arm).
struct Carrier {
  Vec3 shift;
  Mat3 turn;
  Vec3 position(const Vec3& arm) const { return shift + turn * arm; }
  Vec3 normal(const Vec3& n) const { return turn * n; }
};

// The largest angle [rad] by which a displacement turns an end in space or a chord on what carries it.
double largest_angle(const BeamTree& tree, const Eigen::VectorXd& displacement,
                     const Eigen::VectorXd& strains) {
  double largest = 0;
  for (int k = 0; k < tree.branch_count(); ++k) {
    largest = std::max({largest, displacement.segment<3>(6 * k + 3).norm(),
                        strains.segment<3>(6 * k).norm() / tree.members[index_of(k)].beam.length});
  }
  return largest;
}

}  // namespace

BentLean bend_lean(const Structure& structure, const Motion& motion) {
  check_tree(structure);
  const Eigen::VectorXd& strains = motion.lean_strains;
  check_equal("strains of the lean", strains.size(), structure.size());
  if (!strains.allFinite())
    throw InputError("strains of the lean", "a number that is not finite", "finite numbers");
  BentLean lean{structure.tree, strains, bend(*structure.tree, strains), {}};
  lean.maps = strain_maps(*structure.tree, strains, lean.bent);
  return lean;
}

Eigen::VectorXd displacement_about_lean(const Motion& motion, double time) {
  Eigen::VectorXd coordinates = coordinates_at(motion, time);
  for (std::size_t c = 0; c < motion.basis.kind.size(); ++c) {
    if (motion.basis.kind[c] == ShapeKind::lean) coordinates[static_cast<Eigen::Index>(c)] = 0;
  }
  return superpose(motion.basis, coordinates);
}

std::vector<BentBranch> bent_at(const BentLean& lean, const Motion& motion, double time) {
  return bend(*lean.tree,
              lean.strains + strains_about(*lean.tree, lean.maps, displacement_about_lean(motion, time)));
}

std::vector<BentBranch> bent_at(const Structure& structure, const Motion& motion, double time) {
  return bent_at(bend_lean(structure, motion), motion, time);
}

SurfaceDelta bend_surface(const Structure& structure, const Surface& surface,
                          const std::vector<BentBranch>& bent) {
  check_bent(structure, bent);
  return carry_surface(structure, surface, [&](std::size_t branch, double s) {
    const Member& member = structure.members[branch];
    const BentPoint point = point_on(member, bent[branch], s);
    return Carrier{point.position - member.point(s), point.frame - Mat3::Identity()};
  });
}

BentPoint bent_node(const Structure& structure, const std::vector<BentBranch>& bent, std::size_t node) {
  check_bent(structure, bent);
  const Node& self = structure.nodes[node];
  if (self.row >= 0) {
    const BentBranch& branch = bent[index_of(self.row / 6)];
    return {branch.end, branch.end_frame};
  }
  if (self.foot_of < 0) return {self.position, Mat3::Identity()};
  const Member& member = structure.members[index_of(self.foot_of)];
  const BentPoint foot = point_on(member, bent[index_of(self.foot_of)], 0);
  return {self.position + foot.position - member.start, foot.frame};
}

BentChange change_about(const BentLean& lean, const Eigen::VectorXd& displacement) {
  // Small enough for the third derivative, large enough for the digits of a difference.
  constexpr double angle = 1e-4;
  const Eigen::VectorXd more = strains_about(*lean.tree, lean.maps, displacement);
  const double step = angle / std::max(largest_angle(*lean.tree, displacement, more), 1e-100);
  return {bend(*lean.tree, lean.strains + step * more), bend(*lean.tree, lean.strains - step * more), step};
}

SurfaceDelta change_of_surface(const Structure& structure, const Surface& surface, const BentChange& change) {
  check_bent(structure, change.after);
  check_bent(structure, change.before);
  return carry_surface(structure, surface, [&](std::size_t branch, double s) {
    const Member& member = structure.members[branch];
    const BentPoint after = point_on(member, change.after[branch], s),
                    before = point_on(member, change.before[branch], s);
    const double half = 0.5 / change.step;
    return Carrier{half * (after.position - before.position), half * (after.frame - before.frame)};
  });
}

Vec6 change_of_node(const Structure& structure, const BentChange& change, std::size_t node) {
  const BentPoint after = bent_node(structure, change.after, node),
                  before = bent_node(structure, change.before, node);
  Vec6 moved;
  moved << after.position - before.position, rotation_vector(after.frame * before.frame.transpose());
  return 0.5 / change.step * moved;
}

}  // namespace tremula
