// The parts of a plant that share nothing but the ground.
#pragma once

#include "tremula/structure/beam_tree.hpp"

#include <span>
#include <vector>

namespace tremula {

// The ground does not move, so what stands on it by itself moves by itself: K and M have no entry between two
// branches that stand on roots, nor between what these carry. One list of branches for each branch that
// stands on a root, in the order of the structure.
std::vector<std::vector<int>> independent_parts(const BeamTree& tree);

// The structure of these branches alone, in ascending order and each with its parent: branch i of it is
// branches[i].
BeamTree part_of(const BeamTree& tree, std::span<const int> branches);

}  // namespace tremula
