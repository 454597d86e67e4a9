// What a loop can be written as: one table, a line each. To add a format, add a line.
#pragma once

#include "tremula/deformation/loop.hpp"
#include "tremula/deformation/morph_targets.hpp"
#include "tremula/io/mesh_compression.hpp"

#include <span>
#include <string>
#include <string_view>

namespace tremula {

struct LoopWriteOptions {
  std::span<const int> frames = {};                          // of a table of poses
  MorphForm morphs = MorphForm::biased;                      // of .glb
  MeshCompression compression = MeshCompression::quantised;  // of .glb
  bool on_bones = false;  // of .glb: for the size, before there is a Loop::rig, which decides
};

// What decides how large things get.
struct LoopSize {
  double node_count = 0, vertex_count = 0, mode_count = 0, sample_count = 0, frame_count = 0,
         instance_count = 1;
};

struct LoopWriter {
  std::string_view extension;  // "glb", and the name of the format
  std::string_view purpose;    // "Blender, engines"
  // The bytes of the file. The same arguments give the same. Throws Error and InputError as the writer of the
  // format does (gltf.hpp, html.hpp, pose_table.hpp, contact_sheet.hpp).
  std::string (*encode)(const Loop& loop, const LoopWriteOptions& options);
  double (*size)(const LoopSize& size, const LoopWriteOptions& options);  // of the file [bytes], about
};
std::span<const LoopWriter> loop_writers();

// A loop's own table and what it is made from [bytes], about.
double motion_size(const LoopSize& size);

}  // namespace tremula
