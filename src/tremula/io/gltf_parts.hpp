// What the writers of .glb share: vectors as they are stored, the parts of a surface, materials. Internal to
// the readers and writers.
#pragma once

#include "tremula/geometry/surface.hpp"
#include "tremula/io/glb_builder.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <vector>

#include <tbb/parallel_for.h>
#include <Eigen/Core>

namespace tremula::gltf {

using Json = nlohmann::ordered_json;
using Vec3f = Eigen::Vector3f;
using Triangles = std::vector<std::uint32_t>;

inline Vec3f y_up(const Vec3f& v) { return {v.x(), v.z(), -v.y()}; }

template <class Number>
using Vectors = std::vector<std::array<Number, 3>>;

// How vectors are stored: as whole numbers of a unit, the two kinds that KHR_mesh_quantization lets targets
// have, or as floats.
template <class PositionNumber, class NormalNumber>
struct Storage {
  using Position = PositionNumber;
  using Normal = NormalNumber;
  float position_unit;  // [m]
  float normal_unit;
  float negligible_position = 0;  // what a float is too small to be kept for, as rounding would have it
  float negligible_normal = 0;
};
using Whole = Storage<std::int16_t, std::int8_t>;
using Floats = Storage<float, float>;

template <class Number>
std::array<Number, 3> stored(const Vec3f& value, float unit, float negligible) {
  std::array<Number, 3> result{};
  if constexpr (std::is_integral_v<Number>) {
    constexpr auto most = static_cast<float>(std::numeric_limits<Number>::max());
    for (std::size_t k = 0; k < 3; ++k) {
      const float steps = std::round(value[static_cast<Eigen::Index>(k)] / unit);
      result[k] = static_cast<Number>(std::clamp(steps, -most, most));
    }
  } else if (value.lpNorm<Eigen::Infinity>() > negligible) {
    result = {value.x(), value.y(), value.z()};
  }
  return result;
}

template <class Number>
Vec3f read_back(const std::array<Number, 3>& value, float unit) {
  return unit * Vec3f(value[0], value[1], value[2]);
}

// Texture coordinates and places along branches, to what nobody sees: the zeros behind it pack well.
inline float rounded(float value) { return std::round(value * 4096) / 4096; }

template <class Work>
void for_all(std::size_t count, const Work& work) {
  constexpr std::size_t together = 4096;
  tbb::parallel_for(std::size_t{0}, (count + together - 1) / together, [&](std::size_t part) {
    for (std::size_t i = part * together; i < std::min(count, (part + 1) * together); ++i) work(i);
  });
}

// Bark or leaves in the order that graphics cards like, triangles and then the vertices they use.
struct Part {
  std::vector<std::uint32_t> vertices;  // of the surface
  Triangles triangles;                  // of positions in `vertices`
};

Part lay_out(const Triangles& triangles, std::size_t vertex_count);

template <class Number>
void add_bounds(Json& accessor, const Vectors<Number>& values) {
  std::array<Number, 3> low = values.front(), high = values.front();
  for (const std::array<Number, 3>& value : values) {
    for (std::size_t k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], value[k]);
      high[k] = std::max(high[k], value[k]);
    }
  }
  accessor["min"] = low;
  accessor["max"] = high;
}

template <class Value>
std::vector<std::array<float, 1>> numbers(const std::vector<Value>& all, const Part& part) {
  std::vector<std::array<float, 1>> result;
  result.reserve(part.vertices.size());
  for (const std::uint32_t v : part.vertices) result.push_back({rounded(static_cast<float>(all[v]))});
  return result;
}

// What is not morphed of a primitive: texture coordinates, branches and places along them, triangles.
void add_rest_of_primitive(GlbBuilder& builder, const Surface& surface, const Part& part, int material,
                           Json& primitive);

Json make_material(const SurfaceMaterial& material);

}  // namespace tremula::gltf
