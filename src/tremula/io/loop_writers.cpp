#include "tremula/io/loop_writers.hpp"

#include "tremula/io/contact_sheet.hpp"
#include "tremula/io/gltf.hpp"
#include "tremula/io/html.hpp"
#include "tremula/io/pose_table.hpp"

namespace tremula {
namespace {

// A target moves every vertex and turns its normal: six floats, or 8 and 4 bytes quantised, about a third of
// which meshopt leaves. Every sample has its weight.
double targets_size(const LoopSize& size, double target_count, MeshCompression compression) {
  const double bytes = compression == MeshCompression::none        ? 24
                       : compression == MeshCompression::quantised ? 12
                                                                   : 4;
  return size.vertex_count * (40 + bytes * target_count) +
         4 * size.instance_count * size.sample_count * (1 + target_count);
}

// Some hundred keys of a thousand joints an instance.
double rig_size(const LoopSize& size) { return 2e6 * size.instance_count; }

constexpr double bytes_per_pose = 150;  // nine numbers of 15 to 20 digits
constexpr double most_static_shapes = 3;

constexpr LoopWriter writers[] = {
    {"glb", "Blender, engines",
     [](const Loop& loop, const LoopWriteOptions& options) {
       if (loop.rig) return encode_glb(loop, *loop.rig, {.compression = options.compression});
       return encode_glb(*loop.rest, make_morph_targets(loop, options.morphs), loop.facts,
                         {.compression = options.compression});
     },
     [](const LoopSize& size, const LoopWriteOptions& options) {
       if (options.on_bones) return 60 * size.vertex_count + rig_size(size);
       const double sides = options.morphs == MorphForm::paired ? 2 : 1;
       return targets_size(size, sides * (size.mode_count + most_static_shapes), options.compression);
     }},
    {"html", "plays in a browser",
     [](const Loop& loop, const LoopWriteOptions&) {
       if (loop.rig) return encode_html(loop, *loop.rig);
       return encode_html(*loop.rest, make_morph_targets(loop, MorphForm::signed_weights), loop.facts);
     },
     [](const LoopSize& size, const LoopWriteOptions& options) {
       if (options.on_bones) return 1e6 + 4.0 / 3 * (20 * size.vertex_count + rig_size(size));
       return 1e6 +
              4.0 / 3 * targets_size(size, size.mode_count + most_static_shapes, MeshCompression::meshopt);
     }},
    {"csv", "node poses per frame",
     [](const Loop& loop, const LoopWriteOptions& options) {
       return encode_pose_table(loop, options.frames);
     },
     [](const LoopSize& size, const LoopWriteOptions&) {
       return bytes_per_pose * size.frame_count * size.node_count * size.instance_count;
     }},
    {"png", "contact sheet",
     [](const Loop& loop, const LoopWriteOptions&) { return encode_contact_sheet(loop); },
     [](const LoopSize&, const LoopWriteOptions&) { return 2e6; }},
};

}  // namespace

std::span<const LoopWriter> loop_writers() { return writers; }

// Samples in double precision, and the complex half spectra that they are made from.
double motion_size(const LoopSize& size) {
  return 16 * size.sample_count * (size.mode_count + most_static_shapes);
}

}  // namespace tremula
