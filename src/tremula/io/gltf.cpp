#include "tremula/io/gltf.hpp"

#include "tremula/base/error.hpp"
#include "tremula/io/atomic_file.hpp"
#include "tremula/io/finite.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include <nlohmann/json.hpp>

namespace tremula {
namespace {

using Json = nlohmann::ordered_json;
using Vec3f = Eigen::Vector3f;

static_assert(std::endian::native == std::endian::little,
              "glTF is little endian and so are the copies made here");

// Numbers that the format fixes.
enum ComponentType { type_u16 = 5123, type_u32 = 5125, type_float = 5126 };
enum BufferTarget { no_target = 0, vertex_data = 34962, index_data = 34963 };
constexpr std::size_t max_glb_size = std::numeric_limits<std::uint32_t>::max();

// The sections of the binary chunk. Accessors point into them, so there are few views however many targets.
struct View {
  const char* name;
  std::size_t stride;  // 0: tightly packed, not vertex data
  BufferTarget target;
  std::string bytes = {};
};
enum ViewId { indices, vectors, textures, scalars, keys, sparse_indices, sparse_values, view_count };

struct Builder {
  std::array<View, view_count> views{{{"indices", 0, index_data},
                                      {"vectors", 12, vertex_data},
                                      {"texture coordinates", 8, vertex_data},
                                      {"scalars", 4, vertex_data},
                                      {"weights over time", 0, no_target},
                                      {"sparse indices", 0, no_target},
                                      {"sparse values", 0, no_target}}};
  Json accessors = Json::array();

  // Returns the offset in the view; data begins at multiples of four, as the format wants.
  template <class T>
  std::size_t append(ViewId id, const std::vector<T>& data) {
    std::string& bytes = views[id].bytes;
    bytes.resize((bytes.size() + 3) / 4 * 4);
    const std::size_t offset = bytes.size();
    bytes.append(reinterpret_cast<const char*>(data.data()), data.size() * sizeof(T));
    return offset;
  }

  template <class T>
  int add_accessor(ViewId id, const std::vector<T>& data, ComponentType component, const char* type) {
    const std::size_t offset = append(id, data);
    accessors.push_back({{"bufferView", static_cast<int>(id)},
                         {"byteOffset", offset},
                         {"componentType", static_cast<int>(component)},
                         {"count", data.size()},
                         {"type", type}});
    return static_cast<int>(accessors.size()) - 1;
  }
};

Vec3f y_up(const Vec3f& v) { return {v.x(), v.z(), -v.y()}; }

void add_bounds(Json& accessor, const std::vector<Vec3f>& values) {
  Vec3f low = values.front(), high = values.front();
  for (const Vec3f& v : values) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  accessor["min"] = {low.x(), low.y(), low.z()};
  accessor["max"] = {high.x(), high.y(), high.z()};
}

int add_indices(Builder& builder, const std::vector<std::uint32_t>& data, std::size_t vertex_count) {
  // 65535 itself would mean "restart the strip".
  if (vertex_count > 65535) return builder.add_accessor(indices, data, type_u32, "SCALAR");
  return builder.add_accessor(indices, std::vector<std::uint16_t>(data.begin(), data.end()), type_u16,
                              "SCALAR");
}

// A target's change of positions or normals. Most modes leave most of a tree at rest, so few values may be
// enough.
int add_change(Builder& builder, std::vector<Vec3f> values, double tolerance, bool bounds) {
  std::vector<std::uint32_t> moved;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (values[i].norm() > tolerance) moved.push_back(static_cast<std::uint32_t>(i));
  }
  const bool short_indices = values.size() <= 65535;
  int id = static_cast<int>(builder.accessors.size());
  if (moved.size() * ((short_indices ? 2 : 4) + sizeof(Vec3f)) >= values.size() * sizeof(Vec3f)) {
    builder.add_accessor(vectors, values, type_float, "VEC3");
  } else {
    std::vector<Vec3f> kept, all(values.size(), Vec3f::Zero());
    for (const std::uint32_t i : moved) kept.push_back(all[i] = values[i]);
    values = std::move(all);
    Json accessor = {
        {"componentType", static_cast<int>(type_float)}, {"count", values.size()}, {"type", "VEC3"}};
    if (!moved.empty()) {
      const std::size_t where =
          short_indices
              ? builder.append(sparse_indices, std::vector<std::uint16_t>(moved.begin(), moved.end()))
              : builder.append(sparse_indices, moved);
      accessor["sparse"] = {{"count", moved.size()},
                            {"indices",
                             {{"bufferView", static_cast<int>(sparse_indices)},
                              {"byteOffset", where},
                              {"componentType", static_cast<int>(short_indices ? type_u16 : type_u32)}}},
                            {"values",
                             {{"bufferView", static_cast<int>(sparse_values)},
                              {"byteOffset", builder.append(sparse_values, kept)}}}};
    }
    builder.accessors.push_back(std::move(accessor));
  }
  if (bounds) add_bounds(builder.accessors.back(), values);
  return id;
}

template <class T>
std::vector<T> pick(const std::vector<T>& all, const std::vector<std::uint32_t>& which) {
  std::vector<T> result;
  result.reserve(which.size());
  for (const std::uint32_t i : which) result.push_back(all[i]);
  return result;
}

std::vector<Vec3f> pick_y_up(const std::vector<Vec3f>& all, const std::vector<std::uint32_t>& which,
                             float sign) {
  std::vector<Vec3f> result;
  result.reserve(which.size());
  for (const std::uint32_t i : which) result.push_back(y_up(sign * all[i]));
  return result;
}

// Bark or leaves: the vertices that its triangles use, in their old order, and its share of every target.
Json make_primitive(Builder& builder, const Surface& surface, const std::vector<std::uint32_t>& triangles,
                    const MorphTargets& morphs, int material, double position_tolerance,
                    const GltfOptions& options) {
  std::vector<std::uint32_t> used = triangles;
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  std::vector<std::uint32_t> renumbered(surface.vertex_count());
  for (std::size_t i = 0; i < used.size(); ++i) renumbered[used[i]] = static_cast<std::uint32_t>(i);

  const std::vector<Vec3f> positions = pick_y_up(surface.position, used, 1);
  const int position = builder.add_accessor(vectors, positions, type_float, "VEC3");
  add_bounds(builder.accessors.back(), positions);
  const std::vector<std::int32_t> branches = pick(surface.branch, used);
  Json attributes = {
      {"POSITION", position},
      {"NORMAL", builder.add_accessor(vectors, pick_y_up(surface.normal, used, 1), type_float, "VEC3")},
      {"TEXCOORD_0", builder.add_accessor(textures, pick(surface.texture, used), type_float, "VEC2")},
      {"_BRANCH", builder.add_accessor(scalars, std::vector<float>(branches.begin(), branches.end()),
                                       type_float, "SCALAR")},
      {"_ALONG", builder.add_accessor(scalars, pick(surface.along, used), type_float, "SCALAR")}};

  Json targets = Json::array();
  for (const MorphTarget& target : morphs.targets) {
    const SurfaceDelta& shape = morphs.shapes[static_cast<std::size_t>(target.shape)];
    const int moved =
        add_change(builder, pick_y_up(shape.position, used, target.sign), position_tolerance, true);
    const int turned =
        add_change(builder, pick_y_up(shape.normal, used, target.sign), options.normal_tolerance, false);
    targets.push_back({{"POSITION", moved}, {"NORMAL", turned}});
  }

  Json primitive = {{"attributes", std::move(attributes)},
                    {"indices", add_indices(builder, pick(renumbered, triangles), used.size())},
                    {"material", material}};
  if (!targets.empty()) primitive["targets"] = std::move(targets);
  return primitive;
}

double to_linear(double srgb) {
  return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}

Json make_material(const char* name, const Vec3f& srgb, double roughness, bool double_sided) {
  Json color = Json::array();
  // Six digits: what pow() gives beyond them may differ between machines.
  for (const float channel : srgb) color.push_back(std::round(to_linear(channel) * 1e6) / 1e6);
  color.push_back(1);
  Json material = {
      {"name", name},
      {"pbrMetallicRoughness",
       {{"baseColorFactor", std::move(color)}, {"metallicFactor", 0}, {"roughnessFactor", roughness}}}};
  if (double_sided) material["doubleSided"] = true;
  return material;
}

Json make_animation(Builder& builder, const MorphTargets& morphs) {
  const int input = builder.add_accessor(keys, morphs.times, type_float, "SCALAR");
  builder.accessors.back()["min"] = {morphs.times.front()};
  builder.accessors.back()["max"] = {morphs.times.back()};
  const int output = builder.add_accessor(keys, morphs.weights, type_float, "SCALAR");
  return {{"name", "wind loop"},
          {"channels", Json::array({{{"sampler", 0}, {"target", {{"node", 0}, {"path", "weights"}}}}})},
          {"samplers", Json::array({{{"input", input}, {"output", output}, {"interpolation", "LINEAR"}}})}};
}

void check_fit(const Surface& surface, const MorphTargets& morphs) {
  const std::size_t count = surface.vertex_count();
  if (surface.bark_triangles.empty() && surface.leaf_triangles.empty())
    throw Error("glTF: the surface has no triangles");
  check_finite("glTF: positions of the surface", surface.position);
  check_finite("glTF: normals of the surface", surface.normal);
  check_finite("glTF: times of the loop", morphs.times);
  check_finite("glTF: weights of the loop", morphs.weights);
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

double largest_movement(const MorphTargets& morphs) {
  float largest = 0;
  for (const SurfaceDelta& shape : morphs.shapes) {
    for (const Vec3f& change : shape.position) largest = std::max(largest, change.norm());
  }
  return largest;
}

void append_u32(std::string& bytes, std::size_t value) {
  const auto word = static_cast<std::uint32_t>(value);
  bytes.append(reinterpret_cast<const char*>(&word), sizeof word);
}

// The container: header, JSON chunk padded with blanks, binary chunk. Uses up the views, which may be large.
std::string pack(Json& document, Builder& builder) {
  Json buffer_views = Json::array();
  std::array<int, view_count> renumbered{};
  std::size_t size = 0;
  for (std::size_t id = 0; id < view_count; ++id) {
    View& view = builder.views[id];
    if (view.bytes.empty()) continue;
    renumbered[id] = static_cast<int>(buffer_views.size());
    Json json = {{"name", view.name}, {"buffer", 0}, {"byteOffset", size}, {"byteLength", view.bytes.size()}};
    if (view.stride != 0) json["byteStride"] = view.stride;
    if (view.target != no_target) json["target"] = static_cast<int>(view.target);
    buffer_views.push_back(std::move(json));
    view.bytes.resize((view.bytes.size() + 3) / 4 * 4);
    size += view.bytes.size();
  }
  const auto renumber = [&](Json& json) {
    json["bufferView"] = renumbered[json["bufferView"].get<std::size_t>()];
  };
  for (Json& accessor : builder.accessors) {
    if (accessor.contains("bufferView")) renumber(accessor);
    if (accessor.contains("sparse")) {
      renumber(accessor["sparse"]["indices"]);
      renumber(accessor["sparse"]["values"]);
    }
  }
  document["accessors"] = std::move(builder.accessors);
  document["bufferViews"] = std::move(buffer_views);
  document["buffers"] = Json::array({{{"byteLength", size}}});

  // File names end up in names, and those need not be UTF-8.
  std::string text = document.dump(-1, ' ', false, Json::error_handler_t::replace);
  text.resize((text.size() + 3) / 4 * 4, ' ');
  const std::size_t total = 12 + 8 + text.size() + 8 + size;
  if (total > max_glb_size) {
    throw Error("glTF: the file would have " + std::to_string(total) +
                " bytes and .glb ends at 4 GiB: ask for fewer modes or a coarser surface");
  }

  std::string bytes = "glTF";
  bytes.reserve(total);
  append_u32(bytes, 2);
  append_u32(bytes, total);
  append_u32(bytes, text.size());
  bytes += "JSON" + text;
  append_u32(bytes, size);
  bytes.append("BIN\0", 4);
  for (View& view : builder.views) {
    bytes += view.bytes;
    std::string().swap(view.bytes);
  }
  return bytes;
}

}  // namespace

std::string encode_glb(const Surface& surface, const MorphTargets& morphs, const LoopInfo& info,
                       const GltfOptions& options) {
  check_fit(surface, morphs);
  const bool moves = morphs.target_count() > 0;
  const double position_tolerance = options.position_tolerance * largest_movement(morphs);

  Builder builder;
  Json primitives = Json::array(), materials = Json::array();
  const auto add_part = [&](const std::vector<std::uint32_t>& triangles, Json material) {
    if (triangles.empty()) return;
    primitives.push_back(make_primitive(builder, surface, triangles, morphs,
                                        static_cast<int>(materials.size()), position_tolerance, options));
    materials.push_back(std::move(material));
  };
  add_part(surface.bark_triangles, make_material("bark", surface.bark_color, 0.9, false));
  add_part(surface.leaf_triangles, make_material("leaf", surface.leaf_color, 0.6, true));

  Json mesh = {{"name", info.name}, {"primitives", std::move(primitives)}};
  if (moves) {
    Json names = Json::array(), modes = Json::array();
    for (const MorphTarget& target : morphs.targets) {
      names.push_back(target.name);
      modes.push_back(target.mode + 1);
    }
    // A viewer that does not play shows the loop's first instant.
    mesh["weights"] = std::vector<float>(
        morphs.weights.begin(), morphs.weights.begin() + static_cast<std::ptrdiff_t>(morphs.target_count()));
    mesh["extras"] = {{"targetNames", std::move(names)}, {"targetModes", std::move(modes)}};
  }
  const Json facts = {{"period_s", morphs.period},
                      {"frames_per_second", info.frames_per_second},
                      {"wind_speed_m_s", info.wind_speed},
                      {"heading_deg", info.heading},
                      {"seed", info.seed},
                      {"frequencies_hz", morphs.frequencies}};

  Json document = {
      {"asset", {{"version", "2.0"}, {"generator", "tremula " TREMULA_VERSION}}},
      {"scene", 0},
      {"scenes",
       Json::array({{{"name", info.name}, {"nodes", Json::array({0})}, {"extras", {{"tremula", facts}}}}})},
      {"nodes", Json::array({{{"name", info.name}, {"mesh", 0}}})},
      {"meshes", Json::array({std::move(mesh)})},
      {"materials", std::move(materials)}};
  if (moves) document["animations"] = Json::array({make_animation(builder, morphs)});
  return pack(document, builder);
}

void write_glb(const std::string& path, const Surface& surface, const MorphTargets& morphs,
               const LoopInfo& info, const GltfOptions& options) {
  write_file_atomically(path, encode_glb(surface, morphs, info, options));
}

}  // namespace tremula
