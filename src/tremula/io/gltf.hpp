// Binary glTF 2.0 (.glb): the skin, its morph targets and one animation of their weights, "wind loop". Turned
// to glTF's axes (y up) only here: x, y, z become x, z, -y.
//
// The parts of the surface, as bark and leaves, are primitives of one mesh, each with its material; all carry
// the same targets, positions and normals. Every instance is a node with that mesh and its own weights in the
// animation; a time shift stands in the node's extras too.
// Quantised (KHR_mesh_quantization), positions and their changes are whole numbers of one step, in 16 bits or
// 8, and the node's scale is the step, about the height/32767; normals are whole numbers of 1/127, and a
// change of more than 1 is cut. A vertex that a target moves by less than half a step stands still in it.
// mesh.weights are those at which the plant stands at rest (MorphTarget::rest). Every vertex says in _BRANCH
// and _ALONG (floats) which branch carries it and where (Surface::branch, Surface::along to 1/4096). The
// scene's extras repeat LoopFacts, the period, the frequencies of the modes and the number of static shapes;
// the mesh's extras give of each target the name (targetNames), the kind (targetKinds: "lean", "mode" or
// "static") and the mode it belongs to (targetModes, from 1; 0 for what is no mode).
#pragma once

#include "tremula/deformation/loop.hpp"
#include "tremula/deformation/morph_targets.hpp"
#include "tremula/deformation/rig.hpp"
#include "tremula/geometry/surface.hpp"
#include "tremula/io/mesh_compression.hpp"

#include <string>

namespace tremula {

struct GltfOptions {
  MeshCompression compression = MeshCompression::quantised;
  bool shapes = false;  // of the file on bones: also Rig::shapes, for the page
};

// The same arguments give the same bytes. Throws Error when the surface has no triangles, when a number is
// not finite, when surface and targets do not fit together, or when the file would pass 4 GiB, which .glb
// cannot.
std::string encode_glb(const Surface& surface, const MorphTargets& morphs, const LoopFacts& facts,
                       const GltfOptions& options = {});

// The same loop on bones: the rig's joints as nodes, one skin, and an animation for every clip, with keys of
// turns in 16 bits. The root joint carries the place of the instance; every instance has joints and channels
// of its own. Vertices have at most four weights, in 8 bits. A player that does not play shows the plant at
// rest. Quantised, the scale stands in the inverse bind matrices. The scene's extras say besides what of the
// morphed file they say, without shapes, the wind speed of every clip ("clips"), the bounds of the skin in
// motion ("bounds_m", y up) and the error ("largest_error_m"). The mesh's own bounds are those at rest, as
// the format has it. With shapes, "shapes" in the extras says of which clip they are, their kinds, and the
// accessors of their numbers, each shape's turns in steps of its own.
std::string encode_glb(const Loop& loop, const Rig& rig, const GltfOptions& options = {});

// Throws Error, also when the file cannot be written, and then leaves none behind.
void write_glb(const std::string& path, const Surface& surface, const MorphTargets& morphs,
               const LoopFacts& facts, const GltfOptions& options = {});

}  // namespace tremula
