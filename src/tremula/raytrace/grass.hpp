// Blades of grass near the eye, where the pattern of the ground alone would look painted.
#pragma once

#include "tremula/raytrace/posed_scene.hpp"
#include "tremula/raytrace/raytrace.hpp"

#include <memory>
#include <vector>

namespace tremula {

// Square pieces of meadow, the first with all its blades and each next one with fewer and wider ones; still.
std::vector<std::shared_ptr<const Surface>> grass_tiles(double height);

// The tiles laid side by side in front of the camera, thinner with distance. Where a tile lies and how it is
// turned depends on its place in the world alone, so that nothing creeps when the camera moves.
std::vector<LoopShape> grass_before(const Camera& camera, const GroundLook& ground,
                                    const std::vector<std::shared_ptr<const Surface>>& tiles);

}  // namespace tremula
