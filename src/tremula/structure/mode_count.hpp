// How many modes a structure has below a frequency, counted rather than searched: what proves that none is
// missing.
#pragma once

#include "tremula/structure/beam_tree.hpp"

#include <vector>

namespace tremula {

// The number of eigenvalues of K q = omega^2 M q below omega^2 (omega [rad/s] >= 0).
//
// It is the number of negative pivots of K - omega^2 M (Sylvester's law of inertia). Written in the
// displacements e of each branch relative to its rigidly carried start, elimination from the tips to the
// roots meets one 6 x 6 pivot a branch, C^-1 + N with N the dynamic stiffness of what it carries, and never
// the differences of large stiffnesses in which an assembled K - omega^2 M loses its digits: with C = S S^T
// the pivot has as many negative eigenvalues as I + S^T N S. Cost O(N).
int count_modes_below(const BeamTree& tree, double omega);

// The same sum, branch by branch: what its pivot counts. Added up over what stands on a root by itself
// (independent_parts), it is the number of modes of that. (N)
std::vector<int> negative_pivots(const BeamTree& tree, double omega);

}  // namespace tremula
