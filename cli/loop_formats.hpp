// What a loop can be written as: one table, a line each.
#pragma once

#include "tremula/geometry/surface.hpp"
#include "tremula/io/gltf.hpp"
#include "tremula/pipeline.hpp"

#include <span>
#include <string>

#include "outputs.hpp"

namespace tremula::cli {

// Everything the writers draw from.
struct Loop {
  const Subject& subject;
  const Motion& motion;
  const Surface& surface;
  std::span<const int> frames;  // for tables of poses
  LoopInfo info;
  MorphForm morphs;             // of .glb
  MeshCompression compression;  // of .glb
};

// What decides how large things get.
struct LoopSize {
  double node_count, vertex_count, mode_count, sample_count, frame_count;
  MorphForm morphs;
  MeshCompression compression;
};

// Of Format, `name` is the extension too.
struct LoopFormat : Format {
  std::string (*encode)(const Loop& loop);
  double (*size)(const LoopSize& size);  // of the file [bytes], about
};
std::span<const LoopFormat> loop_formats();

// A loop's own table and what it is made from [bytes], about.
double motion_size(const LoopSize& size);

}  // namespace tremula::cli
