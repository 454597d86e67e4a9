#include "tremula/structure/independent_parts.hpp"

#include <algorithm>

namespace tremula {

std::vector<std::vector<int>> independent_parts(const Structure& structure) {
  std::vector<std::vector<int>> parts;
  std::vector<std::size_t> part_of_branch;
  for (int k = 0; k < structure.branch_count(); ++k) {
    const int parent = structure.parent[static_cast<std::size_t>(k)];
    part_of_branch.push_back(parent < 0 ? parts.size() : part_of_branch[static_cast<std::size_t>(parent)]);
    if (parent < 0) parts.emplace_back();
    parts[part_of_branch.back()].push_back(k);
  }
  return parts;
}

Structure part_of(const Structure& structure, std::span<const int> branches) {
  Structure part;
  for (const int branch : branches) {
    const auto k = static_cast<std::size_t>(branch);
    const int parent = structure.parent[k];
    const auto place = std::ranges::lower_bound(branches, parent) - branches.begin();
    part.parent.push_back(parent < 0 ? -1 : static_cast<int>(place));
    part.direction.push_back(structure.direction[k]);
    part.start_arm.push_back(structure.start_arm[k]);
    part.reach.push_back(structure.reach[k]);
    part.beams.push_back(structure.beams[k]);
    part.compliances.push_back(structure.compliances[k]);
    part.masses.push_back(structure.masses[k]);
  }
  return part;
}

}  // namespace tremula
