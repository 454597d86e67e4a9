// Binary glTF 2.0 (.glb): the skin, its morph targets and one animation of their weights, "wind loop". Turned
// to glTF's axes (y up) only here: x, y, z become x, z, -y.
//
// Bark and leaves are two primitives of one mesh; both carry the same targets, positions and normals. Every
// vertex says in _BRANCH and _ALONG (floats) which branch carries it and where (Surface::branch,
// Surface::along). The scene's extras repeat LoopInfo, the period and the frequencies; the mesh's extras name
// the targets (targetNames) and tell for each the mode it belongs to (targetModes, from 1; 0 is the mean
// lean).
#pragma once

#include "tremula/deformation/morph_targets.hpp"
#include "tremula/geometry/surface.hpp"

#include <cstdint>
#include <string>

namespace tremula {

// What a file says about the loop in it.
struct LoopInfo {
  std::string name = "tree";      // of the scene, node and mesh
  double frames_per_second = 30;  // what the loop was made for; the keys stand at its samples
  double wind_speed = 0;          // mean, at its reference height [m/s]
  double heading = 0;             // of the mean wind, from x towards y [degrees]
  std::uint64_t seed = 0;
};

struct GltfOptions {
  // A target is stored sparsely where that is smaller; then changes below these bounds are left out.
  double position_tolerance = 1e-4;  // of the largest movement that any target gives any vertex
  double normal_tolerance = 5e-3;    // length of the change of the unit normal, about radians
};

// The same arguments give the same bytes. Throws Error when the surface has no triangles, when a number is
// not finite, when surface and targets do not fit together, or when the file would pass 4 GiB, which .glb
// cannot.
std::string encode_glb(const Surface& surface, const MorphTargets& morphs, const LoopInfo& info,
                       const GltfOptions& options = {});

// Throws Error, also when the file cannot be written, and then leaves none behind.
void write_glb(const std::string& path, const Surface& surface, const MorphTargets& morphs,
               const LoopInfo& info, const GltfOptions& options = {});

}  // namespace tremula
