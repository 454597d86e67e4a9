#include "tremula/structure/independent_parts.hpp"

#include <algorithm>

namespace tremula {

std::vector<std::vector<int>> independent_parts(const BeamTree& tree) {
  std::vector<std::vector<int>> parts;
  std::vector<std::size_t> part_of_branch;
  for (int k = 0; k < tree.branch_count(); ++k) {
    const int parent = tree.parent[static_cast<std::size_t>(k)];
    part_of_branch.push_back(parent < 0 ? parts.size() : part_of_branch[static_cast<std::size_t>(parent)]);
    if (parent < 0) parts.emplace_back();
    parts[part_of_branch.back()].push_back(k);
  }
  return parts;
}

BeamTree part_of(const BeamTree& tree, std::span<const int> branches) {
  BeamTree part;
  for (const int branch : branches) {
    const auto k = static_cast<std::size_t>(branch);
    const int parent = tree.parent[k];
    const auto place = std::ranges::lower_bound(branches, parent) - branches.begin();
    part.parent.push_back(parent < 0 ? -1 : static_cast<int>(place));
    part.reach.push_back(tree.reach[k]);
    part.members.push_back(tree.members[k]);
    part.members.back().start_row = parent < 0 ? -1 : 6 * place;
    part.members.back().end_row = Eigen::Index{6} * (part.branch_count() - 1);
    part.compliances.push_back(tree.compliances[k]);
    part.masses.push_back(tree.masses[k]);
    if (!tree.blade_water.empty()) part.blade_water.push_back(tree.blade_water[k]);
    if (tree.is_loaded()) {
      part.geometric.push_back(tree.geometric[k]);
      part.loaded.push_back(tree.loaded[k]);
    }
  }
  return part;
}

}  // namespace tremula
