// How many times its load a plant could stand under.
#pragma once

#include "tremula/structure/beam_tree.hpp"

#include <limits>
#include <vector>

namespace tremula {

// The factor on the loads at which the plant buckles: the smallest c > 0 for which K + c K_G is singular.
struct LoadMargin {
  // Relative error 1e-8; infinite where no factor does it.
  double factor = std::numeric_limits<double>::infinity();
  int branch = -1;  // that takes the most strain energy in the shape it buckles into; -1 for none
};

// `geometric` (N): of the loads (geometric_stiffness); the tree's own counts for nothing. The largest
// eigenvalue of -S^T B^-T K_G B^-1 S is 1/c; it is iterated by Lanczos, in some thirty sweeps.
LoadMargin load_margin(const BeamTree& tree, const std::vector<GeometricStiffness>& geometric);

}  // namespace tremula
