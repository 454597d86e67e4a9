#include "tremula/deformation/grass_pose.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/memory.hpp"
#include "tremula/deformation/posed_blades.hpp"
#include "tremula/deformation/principal_shapes.hpp"
#include "tremula/wind/profile.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string>
#include <utility>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

namespace tremula {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3f;

void pose_all(const GrassInWind& grass, double time, bool still, std::span<Vector3f> positions,
              std::span<Vector3f> normals) {
  check_equal("positions of the grass", static_cast<std::ptrdiff_t>(positions.size()), grass.all_vertices);
  if (!normals.empty())
    check_equal("normals of the grass", static_cast<std::ptrdiff_t>(normals.size()), grass.all_vertices);
  if (!std::isfinite(time)) throw InputError("time of the pose", number_text(time) + " s", "a finite one");
  const PoseOfGrass pose = pose_of(grass, time, still);
  const std::vector<float>& attached = grass.meadow.attached;
  // A plant stays in one piece of work.
  const auto whole = [&](std::size_t i) {
    while (i < attached.size() && attached[i] >= 0) ++i;
    return i;
  };
  constexpr std::size_t grain = 2048;
  tbb::parallel_for(std::size_t{0}, (attached.size() + grain - 1) / grain, [&](std::size_t part) {
    const std::size_t first = whole(part * grain), end = whole(std::min((part + 1) * grain, attached.size()));
    pose_plants(pose, first, end, positions.data(), normals.empty() ? nullptr : normals.data());
  });
}

void check_in_time(const GrassInWind& grass) {
  const double bytes = 8.0 * static_cast<double>(grass.blade_count()) * grass.loop.sample_count;
  if (bytes < 0.8 * static_cast<double>(available_memory())) return;
  throw InputError(
      "blades in time",
      std::to_string(grass.blade_count()) + " for " + std::to_string(grass.loop.sample_count) + " samples",
      "fewer, or blades that look their motion up");
}

std::vector<std::array<float, 2>> at_height(const TravellingField& field, double height) {
  const FieldPlane& plane = field.plane;
  const Vec3 along = heading_direction(field.heading), across(-along.y(), along.x(), 0);
  std::vector<std::array<float, 2>> values;
  values.reserve(index_of(plane.columns) * index_of(field.loop.sample_count));
  for (int p = 0; p < field.loop.sample_count; ++p) {
    for (int c = 0; c < plane.columns; ++c) {
      const Vec3 place =
          (plane.first_column + c * plane.spacing) * across + (field.ground + height) * Vec3::UnitZ();
      const Vector3f value = local_value_at(field, place, field.loop.period * p / field.loop.sample_count);
      values.push_back({value.x(), value.y()});
    }
  }
  return values;
}

// One layer, at the height of the tips.
TravellingField layer_at(const TravellingField& gusts, double height) {
  TravellingField layer{.loop = gusts.loop,
                        .heading = gusts.heading,
                        .speed = gusts.speed,
                        .plane = gusts.plane,
                        .ground = gusts.ground,
                        .mean = {mean_at(gusts, gusts.ground + height)},
                        .values = {}};
  layer.plane.heights = {height};
  for (const auto& [along, across] : at_height(gusts, height)) layer.values.push_back({along, across, 0, 0});
  return layer;
}

void follow_in_time(GrassInWind& grass, const std::vector<BladeResponse>& blades,
                    const TravellingField& gusts) {
  check_in_time(grass);
  grass.of_blade.resize(grass.blade_count());
  tbb::parallel_for(std::size_t{0}, grass.blade_count(), [&](std::size_t i) {
    const Meadow& meadow = grass.meadow;
    const std::size_t make = std::size_t{meadow.kind[i]} * frequency_classes + meadow.frequency_class[i];
    if (blades[make].frequency == 0) return;
    const Vec3 place(static_cast<double>(meadow.x[i]), static_cast<double>(meadow.y[i]),
                     gusts.ground + gusts.plane.heights[0]);
    const Eigen::Matrix2Xd sway = sway_in_time(blades[make], gusts, place);
    for (Eigen::Index p = 0; p < sway.cols(); ++p)
      grass.of_blade[i].push_back({static_cast<float>(sway(0, p)), static_cast<float>(sway(1, p))});
  });
}

void lay_out_vertices(GrassInWind& grass) {
  const Meadow& meadow = grass.meadow;
  std::vector<std::uint64_t> blades(meadow.species.kinds.size(), 0), next(meadow.species.kinds.size(), 0);
  for (const std::uint8_t kind : meadow.kind) ++blades[kind];
  std::uint64_t all = 0;
  for (std::size_t k = 0; k < blades.size(); ++k) {
    grass.vertex_count.push_back(
        static_cast<std::uint32_t>(skin_of(meadow.species.kinds[k]).vertices.size()));
    next[k] = all;
    all += blades[k] * grass.vertex_count[k];
  }
  if (all >= (1ULL << 31U)) throw InputError("vertices of the grass", std::to_string(all), "fewer than 2^31");
  grass.all_vertices = static_cast<std::uint32_t>(all);
  for (const std::uint8_t kind : meadow.kind) {
    grass.first_vertex.push_back(static_cast<std::uint32_t>(next[kind]));
    next[kind] += grass.vertex_count[kind];
  }
}

}  // namespace

GrassInWind put_in_wind(Meadow meadow, const TravellingField& gusts, GrassMotion way) {
  check_species(meadow.species);
  check_at_least("blades of the meadow", static_cast<std::ptrdiff_t>(meadow.size()), 1);
  check_plane(gusts.plane, gusts.loop);
  GrassInWind grass;
  grass.meadow = std::move(meadow);
  grass.loop = gusts.loop;
  grass.heading = gusts.heading;
  grass.speed = gusts.speed;
  grass.plane = gusts.plane;
  grass.way = way;
  lay_out_vertices(grass);
  const GrassSpecies& species = grass.meadow.species;
  const double height = grass.meadow.height;
  const TravellingField layer = layer_at(gusts, height);
  const GustStatistics wind = statistics_at(layer, height);
  std::vector<BladeResponse> blades;
  for (std::size_t k = 0; k < species.kinds.size(); ++k) {
    const BladeKind& kind = species.kinds[k];
    for (int number = 0; number < frequency_classes; ++number) {
      blades.emplace_back();
      grass.follows.emplace_back();
      if (kind.frequency == 0) continue;
      BladeResponse& blade = blades.back();
      blade = blade_response(species, static_cast<int>(k), number, height, wind);
      GrassInWind::Follows& follows = grass.follows.back();
      follows.lean = static_cast<float>(blade.lean);
      follows.per_length = static_cast<float>(1 / blade.rod.length);
      if (way == GrassMotion::looked_up)
        follows.angle = at_height(respond(layer, field_response(blade)), height);
    }
    grass.bends.push_back(kind.frequency == 0 ? tabulate_rest(kind)
                                              : tabulate_bends(kind, blades[blades.size() - 2]));
  }
  if (way == GrassMotion::in_time) follow_in_time(grass, blades, layer);
  for (std::size_t i = 0; i < grass.blade_count(); ++i) {
    grass.cos_azimuth.push_back(std::cos(grass.meadow.azimuth[i]));
    grass.sin_azimuth.push_back(std::sin(grass.meadow.azimuth[i]));
    grass.cos_facing.push_back(std::cos(grass.meadow.facing[i]));
    grass.sin_facing.push_back(std::sin(grass.meadow.facing[i]));
  }
  return grass;
}

Eigen::Vector2d angles_of(const GrassInWind& grass, std::size_t blade, double time) {
  if (grass.bends[grass.meadow.kind[blade]].in_plane == 1) return Vector2d::Zero();
  return driven_angles(pose_of(grass, time, false), blade).cast<double>();
}

void pose_grass(const GrassInWind& grass, double time, std::span<Vector3f> positions,
                std::span<Vector3f> normals) {
  pose_all(grass, time, false, positions, normals);
}

Surface grass_surface(const GrassInWind& grass) {
  Surface surface;
  const std::size_t vertices = grass.all_vertices;
  surface.position.resize(vertices);
  surface.normal.resize(vertices);
  surface.texture.resize(vertices);
  surface.branch.assign(vertices, 0);
  surface.along.resize(vertices);
  pose_all(grass, 0, true, surface.position, surface.normal);
  const std::vector<BladeKind>& kinds = grass.meadow.species.kinds;
  std::vector<BladeSkin> skins;
  for (const BladeKind& kind : kinds) {
    skins.push_back(skin_of(kind));
    surface.parts.push_back({.material = {.name = kind.material,
                                          .color = kind.color,
                                          .roughness = 0.6F,
                                          .two_sided = skins.back().two_sided},
                             .triangles = {},
                             .pieces = {.first_vertex = 0,
                                        .size = static_cast<std::uint32_t>(skins.back().vertices.size()),
                                        .count = 0}});
  }
  for (std::size_t i = 0; i < grass.blade_count(); ++i) {
    const std::size_t k = grass.meadow.kind[i];
    const BladeSkin& skin = skins[k];
    SurfacePart& part = surface.parts[k];
    const std::uint32_t first = grass.first_vertex[i];
    if (part.pieces.count++ == 0) part.pieces.first_vertex = first;
    const std::vector<double> joints = joints_of(kinds[k]);
    for (std::size_t v = 0; v < skin.vertices.size(); ++v) {
      const auto along = static_cast<float>(joints[index_of(skin.vertices[v].joint)]);
      surface.texture[first + v] = {skin.vertices[v].u, along};
      surface.along[first + v] = along;
      surface.branch[first + v] = static_cast<std::int32_t>(i);
    }
    for (const std::uint32_t corner : skin.triangles) part.triangles.push_back(first + corner);
  }
  std::erase_if(surface.parts, [](const SurfacePart& part) { return part.triangles.empty(); });
  return surface;
}

Loop make_grass_loop(Meadow meadow, const TravellingField& gusts, const LoopFacts& facts, GrassMotion way) {
  const auto grass = std::make_shared<const GrassInWind>(put_in_wind(std::move(meadow), gusts, way));
  const auto rest = std::make_shared<const Surface>(grass_surface(*grass));
  Loop loop;
  loop.facts = facts;
  loop.period = gusts.loop.period;
  loop.rest = rest;
  loop.skin_at = [grass, rest](double time) {
    SurfaceDelta delta;
    delta.position.resize(rest->vertex_count());
    delta.normal.resize(rest->vertex_count());
    pose_grass(*grass, time, delta.position, delta.normal);
    for (std::size_t i = 0; i < delta.position.size(); ++i) {
      delta.position[i] -= rest->position[i];
      delta.normal[i] -= rest->normal[i];
    }
    return delta;
  };
  const int samples = gusts.loop.sample_count;
  loop.coordinates.resize(samples, 0);
  if (rest->vertex_count() > most_morphed_vertices) return loop;
  const double height = grass->meadow.height;
  const auto principal = std::make_shared<const PrincipalShapes>(principal_shapes(
      samples, [&](int sample) { return loop.skin_at(loop.period * sample / samples); }, 0.005 * height));
  loop.kind.assign(principal->shapes.size(), ShapeKind::static_shape);
  loop.kind.front() = ShapeKind::lean;
  loop.frequency = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(principal->shapes.size()));
  loop.coordinates = principal->weights;
  loop.shape_of_skin = [principal](Eigen::Index shape, double weight) {
    SurfaceDelta delta = principal->shapes[index_of(shape)];
    for (Vector3f& position : delta.position) position *= static_cast<float>(weight);
    for (Vector3f& normal : delta.normal) normal *= static_cast<float>(weight);
    return delta;
  };
  return loop;
}

}  // namespace tremula
