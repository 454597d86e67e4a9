#include "tremula/io/gltf.hpp"

#include "tremula/base/error.hpp"
#include "tremula/io/atomic_file.hpp"
#include "tremula/io/finite.hpp"
#include "tremula/io/glb_builder.hpp"
#include "tremula/io/gltf_parts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <type_traits>
#include <vector>

namespace tremula {
namespace {

using namespace gltf;

const SurfaceDelta& shape_of(const MorphTargets& morphs, const MorphTarget& target) {
  return morphs.shapes[static_cast<std::size_t>(target.shape)];
}

// The surface as it is where all weights are zero. Normals get unit length by a scale of each vertex, which
// its targets must share: then the sum points where it should.
struct Base {
  std::vector<Vec3f> position, normal;
  std::vector<float> normal_scale;
};

Base base_of(const Surface& surface, const MorphTargets& morphs) {
  Base base{surface.position, surface.normal, {}};
  base.normal_scale.resize(surface.vertex_count());
  for_all(surface.vertex_count(), [&](std::size_t i) {
    for (const MorphTarget& target : morphs.targets) {
      if (target.rest == 0) continue;
      base.position[i] -= target.rest * target.sign * shape_of(morphs, target).position[i];
      base.normal[i] -= target.rest * target.sign * shape_of(morphs, target).normal[i];
    }
    const float length = base.normal[i].norm();
    base.normal_scale[i] = length > 0 ? 1 / length : 1;
    base.normal[i] *= base.normal_scale[i];
  });
  return base;
}

// Every coordinate of the base and of a target fits into 16 bits. Some room is left, since rounding the
// targets moves the base.
double step_of(const Base& base, const MorphTargets& morphs) {
  float largest = std::numeric_limits<float>::min();
  const auto include = [&](const std::vector<Vec3f>& values) {
    for (const Vec3f& value : values) largest = std::max(largest, value.lpNorm<Eigen::Infinity>());
  };
  include(base.position);
  for (const SurfaceDelta& shape : morphs.shapes) include(shape.position);
  return static_cast<double>(largest) /
         (32767 - std::min<double>(static_cast<double>(morphs.target_count()), 16383));
}

// A target's share of one part, as the file has it.
template <class Storage>
struct StoredTarget {
  Vectors<typename Storage::Position> moved;
  Vectors<typename Storage::Normal> turned;
};

template <class Storage>
StoredTarget<Storage> store_target(const MorphTarget& target, const SurfaceDelta& shape, const Part& part,
                                   const Base& base, const Storage& storage) {
  using Position = typename Storage::Position;
  using Normal = typename Storage::Normal;
  const std::size_t count = part.vertices.size();
  StoredTarget<Storage> result{Vectors<Position>(count), Vectors<Normal>(count)};
  for_all(count, [&](std::size_t i) {
    const std::uint32_t v = part.vertices[i];
    result.moved[i] = stored<Position>(y_up(target.sign * shape.position[v]), storage.position_unit,
                                       storage.negligible_position);
    result.turned[i] = stored<Normal>(y_up(target.sign * base.normal_scale[v] * shape.normal[v]),
                                      storage.normal_unit, storage.negligible_normal);
  });
  return result;
}

// So that the plant stands at rest to half a step, what rounding did to the targets is taken off the base.
template <class Storage>
Vectors<typename Storage::Position> store_base(const Surface& surface, const MorphTargets& morphs,
                                               const Part& part,
                                               const std::vector<StoredTarget<Storage>>& targets,
                                               const Storage& storage) {
  Vectors<typename Storage::Position> result(part.vertices.size());
  for_all(part.vertices.size(), [&](std::size_t i) {
    Vec3f position = y_up(surface.position[part.vertices[i]]);
    for (std::size_t t = 0; t < targets.size(); ++t)
      position -= morphs.targets[t].rest * read_back(targets[t].moved[i], storage.position_unit);
    result[i] = stored<typename Storage::Position>(position, storage.position_unit, 0);
  });
  return result;
}

int add_change(GlbBuilder& builder, const Vectors<float>& moved) { return builder.add_change(moved); }

// In 8 bits where all of it fits: the unit is that of the node.
int add_change(GlbBuilder& builder, const Vectors<std::int16_t>& moved) {
  const bool small = std::all_of(moved.begin(), moved.end(), [](const auto& value) {
    return std::all_of(value.begin(), value.end(), [](int steps) { return std::abs(steps) <= 127; });
  });
  if (!small) return builder.add_change(moved);
  Vectors<std::int8_t> few(moved.size());
  for_all(moved.size(), [&](std::size_t i) {
    for (std::size_t k = 0; k < 3; ++k) few[i][k] = static_cast<std::int8_t>(moved[i][k]);
  });
  return builder.add_change(few);
}

// Positions and normals of one part, and what the targets do to them.
template <class Storage>
void add_vectors(GlbBuilder& builder, const Surface& surface, const MorphTargets& morphs, const Part& part,
                 const Base& base, const Storage& storage, Json& primitive) {
  constexpr bool normalized = std::is_integral_v<typename Storage::Normal>;
  std::vector<StoredTarget<Storage>> targets;
  for (const MorphTarget& target : morphs.targets)
    targets.push_back(store_target(target, shape_of(morphs, target), part, base, storage));

  const auto position = store_base(surface, morphs, part, targets, storage);
  Vectors<typename Storage::Normal> normal(part.vertices.size());
  for_all(part.vertices.size(), [&](std::size_t i) {
    normal[i] = stored<typename Storage::Normal>(y_up(base.normal[part.vertices[i]]), storage.normal_unit, 0);
  });
  const int id = builder.add_attribute(position);
  add_bounds(builder.accessor(id), position);
  primitive["attributes"] = {{"POSITION", id}, {"NORMAL", builder.add_attribute(normal, normalized)}};

  for (const StoredTarget<Storage>& target : targets) {
    const int moved = add_change(builder, target.moved);
    add_bounds(builder.accessor(moved), target.moved);
    primitive["targets"].push_back(
        {{"POSITION", moved}, {"NORMAL", builder.add_change(target.turned, normalized)}});
  }
}

Json make_primitive(GlbBuilder& builder, const Surface& surface, const Triangles& triangles,
                    const MorphTargets& morphs, const Base& base, double step, bool quantised, int material) {
  const Part part = lay_out(triangles, surface.vertex_count());
  Json primitive = Json::object();
  const auto unit = static_cast<float>(step);
  if (quantised) {
    add_vectors(builder, surface, morphs, part, base, Whole{unit, 1.0F / 127}, primitive);
  } else {
    add_vectors(builder, surface, morphs, part, base, Floats{1, 1, unit / 2, 0.5F / 127}, primitive);
  }
  add_rest_of_primitive(builder, surface, part, material, primitive);
  return primitive;
}

// A channel for every instance; those that move at the same time share their keys.
Json make_animation(GlbBuilder& builder, const MorphTargets& morphs) {
  std::map<double, std::size_t> sampler_of_shift;
  Json channels = Json::array(), samplers = Json::array();
  for (std::size_t i = 0; i < morphs.instances.size(); ++i) {
    const Instance& instance = morphs.instances[i];
    const auto [sampler, is_new] = sampler_of_shift.try_emplace(instance.time_shift, samplers.size());
    if (is_new) {
      const WeightTable table = weights_of(morphs, instance);
      const int input = builder.add_numbers(table.times);
      builder.accessor(input)["min"] = {table.times.front()};
      builder.accessor(input)["max"] = {table.times.back()};
      const int output = builder.add_numbers(table.weights);
      samplers.push_back({{"input", input}, {"output", output}, {"interpolation", "LINEAR"}});
    }
    channels.push_back({{"sampler", sampler->second}, {"target", {{"node", i}, {"path", "weights"}}}});
  }
  return {{"name", morphs.repeats ? "wind loop" : "clip"},
          {"channels", std::move(channels)},
          {"samplers", std::move(samplers)}};
}

// One for every instance, all of one mesh. `step`: what the mesh's numbers are in [m].
Json make_nodes(const MorphTargets& morphs, const std::string& name, double step) {
  Json nodes = Json::array();
  for (std::size_t i = 0; i < morphs.instances.size(); ++i) {
    const Instance& instance = morphs.instances[i];
    Json node = {{"name", i == 0 ? name : name + " " + std::to_string(i + 1)}, {"mesh", 0}};
    if (!instance.position.isZero(0))
      node["translation"] = {instance.position.x(), instance.position.z(), 0 - instance.position.y()};
    if (instance.turn != 0)
      node["rotation"] = {0, std::sin(instance.turn / 2), 0, std::cos(instance.turn / 2)};
    const double scale = step * instance.scale;
    if (scale != 1) node["scale"] = {scale, scale, scale};
    if (instance.time_shift != 0) node["extras"] = {{"tremula", {{"time_shift_s", instance.time_shift}}}};
    nodes.push_back(std::move(node));
  }
  return nodes;
}

void check_fit(const Surface& surface, const MorphTargets& morphs) {
  const std::size_t count = surface.vertex_count();
  if (std::all_of(surface.parts.begin(), surface.parts.end(),
                  [](const SurfacePart& part) { return part.triangles.empty(); }))
    throw Error("glTF: the surface has no triangles");
  check_finite("glTF: positions of the surface", surface.position);
  check_finite("glTF: normals of the surface", surface.normal);
  check_finite("glTF: times of the loop", morphs.times);
  check_finite("glTF: weights of the loop", morphs.weights);
  check_instances(morphs.instances, morphs.repeats);
  if (morphs.weights.size() != morphs.key_count() * morphs.target_count()) {
    throw Error("glTF: " + std::to_string(morphs.weights.size()) +
                " weights, wanted one for each key and target");
  }
  for (const SurfaceDelta& shape : morphs.shapes) {
    if (shape.position.size() != count || shape.normal.size() != count) {
      throw Error("glTF: a morph target has " + std::to_string(shape.position.size()) + " vertices, wanted " +
                  std::to_string(count));
    }
    check_finite("glTF: positions of a morph target", shape.position);
    check_finite("glTF: normals of a morph target", shape.normal);
  }
}

Json make_mesh(const MorphTargets& morphs, const std::string& name, Json primitives) {
  Json mesh = {{"name", name}, {"primitives", std::move(primitives)}};
  if (morphs.targets.empty()) return mesh;
  Json rest = Json::array(), names = Json::array(), kinds = Json::array(), modes = Json::array();
  for (const MorphTarget& target : morphs.targets) {
    rest.push_back(target.rest);
    names.push_back(target.name);
    kinds.push_back(name_of(target.kind));
    modes.push_back(target.kind == ShapeKind::mode ? target.number + 1 : 0);
  }
  // A viewer that does not play shows the plant at rest.
  mesh["weights"] = std::move(rest);
  mesh["extras"] = {{"targetNames", std::move(names)},
                    {"targetKinds", std::move(kinds)},
                    {"targetModes", std::move(modes)}};
  return mesh;
}

}  // namespace

std::string encode_glb(const Surface& surface, const MorphTargets& morphs, const LoopFacts& facts,
                       const GltfOptions& options) {
  check_fit(surface, morphs);
  const Base base = base_of(surface, morphs);
  const double step = step_of(base, morphs);
  const bool quantised = options.compression != MeshCompression::none;

  GlbBuilder builder(options.compression);
  Json primitives = Json::array(), materials = Json::array();
  for (const SurfacePart& part : surface.parts) {
    if (part.triangles.empty()) continue;
    primitives.push_back(make_primitive(builder, surface, part.triangles, morphs, base, step, quantised,
                                        static_cast<int>(materials.size())));
    materials.push_back(make_material(part.material));
  }

  Json extras = {{"period_s", morphs.period},
                 {"repeats", morphs.repeats},
                 {"frames_per_second", facts.frames_per_second},
                 {"wind_speed_m_s", facts.wind_speed},
                 {"heading_deg", facts.heading},
                 {"seed", facts.seed},
                 {"frequencies_hz", morphs.frequencies},
                 {"static_shapes", morphs.static_shape_count}};
  if (!facts.scales) extras["scales"] = false;
  Json nodes = make_nodes(morphs, facts.name, quantised ? step : 1);
  Json roots = Json::array();
  for (std::size_t i = 0; i < nodes.size(); ++i) roots.push_back(i);
  Json document = {
      {"asset", {{"version", "2.0"}, {"generator", "tremula " TREMULA_VERSION}}},
      {"scene", 0},
      {"scenes",
       Json::array({{{"name", facts.name}, {"nodes", std::move(roots)}, {"extras", {{"tremula", extras}}}}})},
      {"nodes", std::move(nodes)},
      {"meshes", Json::array({make_mesh(morphs, facts.name, std::move(primitives))})},
      {"materials", std::move(materials)}};
  if (quantised) {
    Json extensions = Json::array({"KHR_mesh_quantization"});
    if (options.compression == MeshCompression::meshopt) extensions.push_back("EXT_meshopt_compression");
    document["extensionsUsed"] = document["extensionsRequired"] = extensions;
  }
  if (!morphs.targets.empty()) document["animations"] = Json::array({make_animation(builder, morphs)});
  return std::move(builder).pack(document);
}

void write_glb(const std::string& path, const Surface& surface, const MorphTargets& morphs,
               const LoopFacts& facts, const GltfOptions& options) {
  write_file_atomically(path, encode_glb(surface, morphs, facts, options));
}

}  // namespace tremula
