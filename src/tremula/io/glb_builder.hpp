// The binary side of a .glb in the making: accessors over buffer views, both gathered as they come, and the
// container around them. Knows nothing of plants. Used by gltf.cpp.
#pragma once

#include "tremula/io/mesh_compression.hpp"

#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace tremula {

class GlbBuilder {
 public:
  using Json = nlohmann::ordered_json;

  // One value a vertex, padded to whole words of four bytes as the format wants. T: float, or a whole number
  // of 8 or 16 bits.
  template <class T, std::size_t width>
  int add_attribute(const std::vector<std::array<T, width>>& values, bool normalized = false) {
    constexpr std::size_t stride = (width * sizeof(T) + 3) / 4 * 4;
    std::string bytes(values.size() * stride, '\0');
    for (std::size_t i = 0; i < values.size(); ++i)
      std::memcpy(&bytes[i * stride], values[i].data(), width * sizeof(T));
    Json accessor = header(component_type(T{}), values.size(), width);
    if (normalized) accessor["normalized"] = true;
    place(accessor, view_of({"vertices", stride, vertex_data, Coding::vertices}), bytes);
    return add(std::move(accessor));
  }

  // The same where many values are zero: stored sparsely where that is smaller (never under meshopt, which
  // packs zeros better).
  template <class T, std::size_t width>
  int add_change(const std::vector<std::array<T, width>>& values, bool normalized = false) {
    std::vector<std::uint32_t> changed;
    for (std::size_t i = 0; i < values.size(); ++i) {
      // Not !=, which calls memcmp() for every vertex.
      bool moves = false;
      for (const T number : values[i]) moves |= number != 0;
      if (moves) changed.push_back(static_cast<std::uint32_t>(i));
    }
    constexpr std::size_t stride = (width * sizeof(T) + 3) / 4 * 4;
    const std::size_t index_size = values.size() <= 65535 ? 2 : 4;
    const std::size_t sparse_size = changed.size() * (index_size + width * sizeof(T));
    const bool sparse =
        compression_ != MeshCompression::meshopt && 20 * sparse_size < 19 * values.size() * stride;
    if (!sparse && !changed.empty()) return add_attribute(values, normalized);
    std::string bytes(changed.size() * width * sizeof(T), '\0');
    for (std::size_t k = 0; k < changed.size(); ++k)
      std::memcpy(&bytes[k * width * sizeof(T)], values[changed[k]].data(), width * sizeof(T));
    Json accessor = header(component_type(T{}), values.size(), width);
    if (normalized) accessor["normalized"] = true;
    if (!changed.empty()) accessor["sparse"] = sparse_part(changed, index_size, bytes);
    return add(std::move(accessor));
  }

  // Three a triangle, in 16 bits where the number of vertices allows.
  int add_triangles(const std::vector<std::uint32_t>& indices, std::size_t vertex_count);

  // Numbers that belong to no vertex.
  int add_numbers(const std::vector<float>& values);

  // Turns, as normalised quaternions x y z w: keys of an animation.
  int add_turns(const std::vector<std::array<std::int16_t, 4>>& values);

  // So many numbers a piece: 3 places, as keys of an animation, or 16 matrices by columns.
  int add_vectors(const std::vector<float>& values, std::size_t width);

  Json& accessor(int id) { return accessors_[static_cast<std::size_t>(id)]; }

  explicit GlbBuilder(MeshCompression compression) : compression_(compression) {}

  // The container: header, JSON chunk padded with blanks, binary chunk. Puts accessors, views and buffers
  // into the document and uses itself up. Throws Error when the file would pass 4 GiB, which .glb cannot.
  std::string pack(Json& document) &&;

 private:
  // Numbers that the format fixes.
  enum ComponentType {
    type_i8 = 5120,
    type_u8 = 5121,
    type_i16 = 5122,
    type_u16 = 5123,
    type_u32 = 5125,
    type_float = 5126
  };
  enum BufferTarget { no_target = 0, vertex_data = 34962, index_data = 34963 };
  // How meshopt codes a view.
  enum class Coding { none, vertices, triangles };

  // Accessors point into views, so there are few of them however many targets.
  struct View {
    const char* name;
    std::size_t stride;  // of an element [bytes]
    BufferTarget target;
    Coding coding;
    std::string bytes = {};
  };

  static ComponentType component_type(float) { return type_float; }
  static ComponentType component_type(std::int8_t) { return type_i8; }
  static ComponentType component_type(std::int16_t) { return type_i16; }
  static ComponentType component_type(std::uint8_t) { return type_u8; }
  static ComponentType component_type(std::uint16_t) { return type_u16; }
  static Json header(ComponentType component, std::size_t count, std::size_t width);
  static std::string encode(const View& view);

  // The view of this kind, made where there is none.
  std::size_t view_of(const View& kind);
  std::size_t append(std::size_t view, const std::string& bytes);
  void place(Json& where, std::size_t view, const std::string& bytes);
  Json sparse_part(const std::vector<std::uint32_t>& changed, std::size_t index_size,
                   const std::string& values);
  int add(Json accessor);

  MeshCompression compression_;
  std::vector<View> views_;
  Json accessors_ = Json::array();
};

}  // namespace tremula
