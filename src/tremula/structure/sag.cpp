#include "tremula/structure/sag.hpp"

#include "tremula/structure/equilibrium.hpp"

namespace tremula {

Skeleton sagged(const Skeleton& unloaded, const StructureOptions& options) {
  const BeamTree tree = assemble_tree(unloaded, options);
  const DeadLoadsOnBranches weight_of(tree, weight(unloaded, options));
  const std::vector<BentBranch> bent = find_equilibrium(tree, [&](int k, const BentBranch& branch) {
                                         EndLoads loads;
                                         weight_of.add_to(k, branch, loads);
                                         return loads;
                                       }).bent;
  Skeleton skeleton = unloaded;
  for (int k = 0; k < skeleton.branch_count(); ++k) {
    skeleton.branches[index_of(k)].start = bent[index_of(k)].start;
    skeleton.branches[index_of(k)].end = bent[index_of(k)].end;
  }
  for (Leaf& leaf : skeleton.leaves) {
    const Member& member = tree.members[index_of(leaf.branch)];
    const BentPoint place = point_on(member, bent[index_of(leaf.branch)], leaf.position);
    leaf.base = place.position + place.frame * (leaf.base - member.point(leaf.position));
    leaf.axis = place.frame * leaf.axis;
    leaf.normal = place.frame * leaf.normal;
  }
  return skeleton;
}

}  // namespace tremula
