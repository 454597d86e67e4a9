// How a blade of grass stands under a load.
#pragma once

#include "tremula/dynamics/grass_response.hpp"
#include "tremula/geometry/meadow.hpp"

#include <array>
#include <vector>

namespace tremula {

inline constexpr int bends_in_plane = 17, bends_across = 9;

// Directions of the pieces of blades by the angles b in the blade's plane and across. They are known over
// m = b / (1 + |b|), where the shape goes nearly straight with m; across counts from 0, the other side is its
// mirror image.
struct BendTable {
  int in_plane = 1, across = 1;  // how many m, from -1 to 1 and from 0 to 1; 1: stiff
  // (trajectories x across x in_plane) of x, y and z of up to four pieces.
  std::vector<std::array<float, 12>> directions;
};
BendTable tabulate_bends(const BladeKind& kind, const BladeResponse& blade);
BendTable tabulate_rest(const BladeKind& kind);

}  // namespace tremula
