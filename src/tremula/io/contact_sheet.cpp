#include "tremula/io/contact_sheet.hpp"

#include "tremula/io/finite.hpp"
#include "tremula/render/render.hpp"

#include <cstdio>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace tremula {

namespace {

using Vectors = std::vector<Eigen::Vector3f>;

struct Placement {
  Eigen::Vector3f position;
  Eigen::Matrix3f rotation;
  float scale;

  explicit Placement(const Instance& instance)
      : position(instance.position.cast<float>()),
        rotation(instance.rotation().cast<float>()),
        scale(static_cast<float>(instance.scale)) {}
  Eigen::Vector3f point(const Eigen::Vector3f& p) const { return position + scale * (rotation * p); }
};

// All instances as one surface at rest.
Surface gather(const Loop& loop) {
  const Surface& one = *loop.rest;
  Surface all;
  for (const Instance& instance : loop.instances) {
    const Placement place(instance);
    const auto first = static_cast<std::uint32_t>(all.vertex_count());
    for (std::size_t v = 0; v < one.vertex_count(); ++v) {
      all.position.push_back(place.point(one.position[v]));
      all.normal.push_back(place.rotation * one.normal[v]);
    }
    all.texture.insert(all.texture.end(), one.texture.begin(), one.texture.end());
    all.branch.insert(all.branch.end(), one.branch.begin(), one.branch.end());
    all.along.insert(all.along.end(), one.along.begin(), one.along.end());
    for (SurfacePart part : one.parts) {
      for (std::uint32_t& corner : part.triangles) corner += first;
      part.pieces.first_vertex += first;
      all.parts.push_back(std::move(part));
    }
  }
  return all;
}

void append_pose(const Loop& loop, const Instance& instance, double time, Vectors& positions,
                 Vectors& normals) {
  const SurfaceDelta delta = loop.skin_at(time + instance.time_shift);
  const Placement place(instance);
  check_finite("picture: positions", delta.position);
  check_finite("picture: normals", delta.normal);
  for (std::size_t v = 0; v < loop.rest->vertex_count(); ++v) {
    positions.push_back(place.point(loop.rest->position[v] + delta.position[v]));
    normals.push_back(place.rotation * (loop.rest->normal[v] + delta.normal[v]).normalized());
  }
}

}  // namespace

std::string encode_contact_sheet(const Loop& loop) {
  check_instances(loop.instances, loop.repeats);
  constexpr int columns = 4, rows = 3, cells = columns * rows;
  const Surface surface = gather(loop);
  std::vector<Vectors> positions(cells), normals(cells);
  Vectors everywhere;
  std::vector<std::string> labels;
  for (std::size_t i = 0; i < cells; ++i) {
    const double time = loop.period * static_cast<double>(i) / cells;
    for (const Instance& instance : loop.instances)
      append_pose(loop, instance, time, positions[i], normals[i]);
    everywhere.insert(everywhere.end(), positions[i].begin(), positions[i].end());
    char label[32];
    std::snprintf(label, sizeof label, "t = %.2f s", time);
    labels.emplace_back(label);
  }
  const Camera camera =
      frame_points(everywhere, azimuth_across(normals, loop.facts.heading * std::numbers::pi / 180), 0.12, 1);
  std::vector<Image> images;
  for (std::size_t i = 0; i < cells; ++i)
    images.push_back(render_surface(surface, positions[i], normals[i], camera,
                                    {.width = 400, .height = 400, .under_water = loop.facts.under_water}));
  return encode_png(contact_sheet(images, columns, labels));
}

}  // namespace tremula
