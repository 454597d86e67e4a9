// How the numbers of a mesh are packed.
#pragma once

namespace tremula {

enum class MeshCompression {
  none,       // floats, and no extension of glTF: what reads glTF reads this (Godot 4 reads nothing else)
  quantised,  // 16 and 8 bits, KHR_mesh_quantization: less than half the size; Blender, three.js and others
  meshopt,    // those packed by EXT_meshopt_compression: a fifth of them; three.js, not Blender 3.4
};

}  // namespace tremula
