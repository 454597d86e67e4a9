#include "loop_formats.hpp"

#include "tremula/io/finite.hpp"
#include "tremula/io/html.hpp"
#include "tremula/io/pose_table.hpp"
#include "tremula/render/render.hpp"

#include <cstdio>
#include <numbers>

namespace tremula::cli {
namespace {

MorphTargets morph_targets(const Loop& loop, MorphForm form) {
  return make_morph_targets(loop.subject.skeleton, loop.subject.structure, loop.surface, loop.subject.modes,
                            loop.motion, form);
}

std::string encode_glb_of(const Loop& loop) {
  return encode_glb(loop.surface, morph_targets(loop, loop.morphs), loop.info,
                    {.compression = loop.compression});
}

std::string encode_html_of(const Loop& loop) {
  return encode_html(loop.surface, morph_targets(loop, MorphForm::signed_weights), loop.info);
}

std::string encode_poses(const Loop& loop) {
  return encode_pose_table(loop.subject.skeleton, loop.subject.structure, loop.subject.modes, loop.motion,
                           loop.frames);
}

std::string encode_contact_sheet(const Loop& loop) {
  constexpr int columns = 4, rows = 3, cells = columns * rows;
  std::vector<std::vector<Eigen::Vector3f>> positions, normals;
  std::vector<Eigen::Vector3f> everywhere;
  std::vector<std::string> labels;
  for (int i = 0; i < cells; ++i) {
    const double time = loop.motion.period * i / cells;
    const SurfaceDelta delta = deform_surface(loop.subject.skeleton, loop.subject.structure, loop.surface,
                                              displacement_at(loop.subject.modes, loop.motion, time));
    check_finite("picture: positions", delta.position);
    check_finite("picture: normals", delta.normal);
    positions.push_back(loop.surface.position);
    normals.push_back(loop.surface.normal);
    for (std::size_t v = 0; v < loop.surface.vertex_count(); ++v) {
      positions.back()[v] += delta.position[v];
      normals.back()[v] = (normals.back()[v] + delta.normal[v]).normalized();
    }
    everywhere.insert(everywhere.end(), positions.back().begin(), positions.back().end());
    char label[32];
    std::snprintf(label, sizeof label, "t = %.2f s", time);
    labels.emplace_back(label);
  }
  // Seen across the wind, so that lean and sway show.
  const double azimuth = (loop.info.heading - 105) * std::numbers::pi / 180;
  const Camera camera = frame_points(everywhere, azimuth, 0.12, 1);
  std::vector<Image> images;
  for (int i = 0; i < cells; ++i) {
    const auto cell = static_cast<std::size_t>(i);
    images.push_back(
        render_surface(loop.surface, positions[cell], normals[cell], camera, {.width = 400, .height = 400}));
  }
  return encode_png(contact_sheet(images, columns, labels));
}

// A target moves every vertex and turns its normal: six floats, or 8 and 4 bytes quantised, about a third of
// which meshopt leaves. Every sample has its weight.
double targets_size(const LoopSize& size, double target_count, MeshCompression compression) {
  const double bytes = compression == MeshCompression::none        ? 24
                       : compression == MeshCompression::quantised ? 12
                                                                   : 4;
  return size.vertex_count * (40 + bytes * target_count) + 4 * size.sample_count * (1 + target_count);
}

constexpr double bytes_per_pose = 150;  // nine numbers of 15 to 20 digits
constexpr double static_shapes = 3;

constexpr LoopFormat formats[] = {
    {{"glb", "Blender, engines"},
     encode_glb_of,
     [](const LoopSize& size) {
       const double sides = size.morphs == MorphForm::paired ? 2 : 1;
       return targets_size(size, sides * (size.mode_count + static_shapes), size.compression);
     }},
    {{"html", "plays in a browser"},
     encode_html_of,
     [](const LoopSize& size) {
       return 1e6 + 4.0 / 3 * targets_size(size, size.mode_count + static_shapes, MeshCompression::meshopt);
     }},
    {{"csv", "node poses per frame"},
     encode_poses,
     [](const LoopSize& size) { return bytes_per_pose * size.frame_count * size.node_count; }},
    {{"png", "contact sheet"}, encode_contact_sheet, [](const LoopSize&) { return 2e6; }},
};

}  // namespace

std::span<const LoopFormat> loop_formats() { return formats; }

// Samples in double precision, and the complex half spectra that they are made from.
double motion_size(const LoopSize& size) {
  return 16 * size.sample_count * (size.mode_count + static_shapes);
}

}  // namespace tremula::cli
