// Axes of a skeleton: chains of branches that a tube can follow (see split_into_axes in surface.hpp).
#pragma once

#include "tremula/geometry/skeleton.hpp"

#include <vector>

namespace tremula {

// Unit vector from start to end of every branch; a branch of no length takes that of the branch below it, or
// up.
std::vector<Vec3> branch_directions(const Skeleton& skeleton);

// The child that goes on best at the end of each branch, or -1. (N)
std::vector<int> branch_continuations(const Skeleton& skeleton);

}  // namespace tremula
