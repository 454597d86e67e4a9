// Binary glTF 2.0 (.glb): the skin, its morph targets and one animation of their weights, "wind loop". Turned
// to glTF's axes (y up) only here: x, y, z become x, z, -y.
//
// Bark and leaves are two primitives of one mesh; both carry the same targets, positions and normals.
// Quantised (KHR_mesh_quantization), positions and their changes are whole numbers of one step, in 16 bits or
// 8, and the node's scale is the step, about the height/32767; normals are whole numbers of 1/127, and a
// change of more than 1 is cut. A vertex that a target moves by less than half a step stands still in it.
// mesh.weights are those at which the plant stands at rest (MorphTarget::rest). Every vertex says in _BRANCH
// and _ALONG (floats) which branch carries it and where (Surface::branch, Surface::along to 1/4096). The
// scene's extras repeat LoopInfo, the period, the frequencies of the modes and the number of static shapes;
// the mesh's extras give of each target the name (targetNames), the kind (targetKinds: "lean", "mode" or
// "static") and the mode it belongs to (targetModes, from 1; 0 for what is no mode).
#pragma once

#include "tremula/deformation/morph_targets.hpp"
#include "tremula/geometry/surface.hpp"
#include "tremula/io/mesh_compression.hpp"

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
  MeshCompression compression = MeshCompression::quantised;
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
