#include "tremula/io/glb_builder.hpp"

#include "tremula/base/error.hpp"

#include <bit>
#include <limits>
#include <string_view>

#include <meshoptimizer.h>
#include <tbb/parallel_for.h>

namespace tremula {
namespace {

static_assert(std::endian::native == std::endian::little,
              "glTF is little endian and so are the copies made here");

constexpr std::size_t max_glb_size = std::numeric_limits<std::uint32_t>::max();

template <class T>
std::string bytes_of(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

void append_u32(std::string& bytes, std::size_t value) {
  const auto word = static_cast<std::uint32_t>(value);
  bytes.append(reinterpret_cast<const char*>(&word), sizeof word);
}

void fill_up(std::string& bytes, char with) { bytes.resize((bytes.size() + 3) / 4 * 4, with); }

}  // namespace

GlbBuilder::Json GlbBuilder::header(ComponentType component, std::size_t count, std::size_t width) {
  constexpr std::array types{"SCALAR", "VEC2", "VEC3", "VEC4"};
  return {{"componentType", static_cast<int>(component)},
          {"count", count},
          {"type", width == 16 ? "MAT4" : types[width - 1]}};
}

std::size_t GlbBuilder::view_of(const View& kind) {
  // The triangles of one accessor are coded by themselves.
  for (std::size_t i = 0; i < views_.size() && kind.coding != Coding::triangles; ++i) {
    if (std::string_view(views_[i].name) == kind.name && views_[i].stride == kind.stride) return i;
  }
  views_.push_back(kind);
  return views_.size() - 1;
}

// Returns the offset in the view; data begins at multiples of four, as the format wants.
std::size_t GlbBuilder::append(std::size_t view, const std::string& bytes) {
  std::string& all = views_[view].bytes;
  fill_up(all, '\0');
  const std::size_t offset = all.size();
  all += bytes;
  return offset;
}

void GlbBuilder::place(Json& where, std::size_t view, const std::string& bytes) {
  where["bufferView"] = view;
  where["byteOffset"] = append(view, bytes);
}

GlbBuilder::Json GlbBuilder::sparse_part(const std::vector<std::uint32_t>& changed, std::size_t index_size,
                                         const std::string& values) {
  Json indices = {{"componentType", static_cast<int>(index_size == 2 ? type_u16 : type_u32)}};
  place(indices, view_of({"sparse indices", 0, no_target, Coding::none}),
        index_size == 2 ? bytes_of(std::vector<std::uint16_t>(changed.begin(), changed.end()))
                        : bytes_of(changed));
  Json what = Json::object();
  place(what, view_of({"sparse values", 0, no_target, Coding::none}), values);
  return {{"count", changed.size()}, {"indices", std::move(indices)}, {"values", std::move(what)}};
}

int GlbBuilder::add(Json accessor) {
  accessors_.push_back(std::move(accessor));
  return static_cast<int>(accessors_.size()) - 1;
}

int GlbBuilder::add_triangles(const std::vector<std::uint32_t>& indices, std::size_t vertex_count) {
  // 65535 itself would mean "restart the strip".
  const bool small = vertex_count <= 65535;
  Json accessor = header(small ? type_u16 : type_u32, indices.size(), 1);
  place(accessor, view_of({"triangles", small ? 2U : 4U, index_data, Coding::triangles}),
        small ? bytes_of(std::vector<std::uint16_t>(indices.begin(), indices.end())) : bytes_of(indices));
  return add(std::move(accessor));
}

int GlbBuilder::add_numbers(const std::vector<float>& values) {
  Json accessor = header(type_float, values.size(), 1);
  place(accessor, view_of({"numbers", 0, no_target, Coding::none}), bytes_of(values));
  return add(std::move(accessor));
}

int GlbBuilder::add_turns(const std::vector<std::array<std::int16_t, 4>>& values) {
  Json accessor = header(type_i16, values.size(), 4);
  accessor["normalized"] = true;
  place(accessor, view_of({"turns", sizeof values[0], no_target, Coding::vertices}), bytes_of(values));
  return add(std::move(accessor));
}

int GlbBuilder::add_vectors(const std::vector<float>& values, std::size_t width) {
  Json accessor = header(type_float, values.size() / width, width);
  place(accessor, view_of({width == 16 ? "matrices" : "numbers", 0, no_target, Coding::none}),
        bytes_of(values));
  return add(std::move(accessor));
}

std::string GlbBuilder::encode(const View& view) {
  const std::size_t count = view.bytes.size() / view.stride;
  const auto out = [](std::string& code) { return reinterpret_cast<unsigned char*>(code.data()); };
  std::string code;
  if (view.coding == Coding::vertices) {
    code.resize(meshopt_encodeVertexBufferBound(count, view.stride));
    code.resize(meshopt_encodeVertexBuffer(out(code), code.size(), view.bytes.data(), count, view.stride));
    return code;
  }
  std::vector<std::uint32_t> indices(count);
  for (std::size_t i = 0; i < count; ++i) std::memcpy(&indices[i], &view.bytes[i * view.stride], view.stride);
  code.resize(meshopt_encodeIndexBufferBound(count, std::numeric_limits<std::uint32_t>::max()));
  code.resize(meshopt_encodeIndexBuffer(out(code), code.size(), indices.data(), count));
  return code;
}

std::string GlbBuilder::pack(Json& document) && {
  const bool compressed = compression_ == MeshCompression::meshopt;
  std::vector<std::string> codes(views_.size());
  if (compressed) {
    // Those that EXT_meshopt_compression names.
    meshopt_encodeVertexVersion(0);
    meshopt_encodeIndexVersion(1);
    tbb::parallel_for(std::size_t{0}, views_.size(), [&](std::size_t i) {
      if (views_[i].coding != Coding::none) codes[i] = encode(views_[i]);
    });
  }

  Json buffer_views = Json::array();
  std::size_t size = 0, fallback_size = 0;
  for (std::size_t i = 0; i < views_.size(); ++i) {
    View& view = views_[i];
    const std::size_t byte_count = view.bytes.size();
    Json json = {{"name", view.name}, {"buffer", 0}, {"byteOffset", size}, {"byteLength", byte_count}};
    if (view.target == vertex_data) json["byteStride"] = view.stride;
    if (view.target != no_target) json["target"] = static_cast<int>(view.target);
    if (compressed && view.coding != Coding::none) {
      json["buffer"] = 1;
      json["byteOffset"] = fallback_size;
      json["extensions"]["EXT_meshopt_compression"] = {
          {"buffer", 0},
          {"byteOffset", size},
          {"byteLength", codes[i].size()},
          {"byteStride", view.stride},
          {"count", byte_count / view.stride},
          {"mode", view.coding == Coding::vertices ? "ATTRIBUTES" : "TRIANGLES"}};
      fallback_size += (byte_count + 3) / 4 * 4;
      view.bytes = std::move(codes[i]);
    }
    buffer_views.push_back(std::move(json));
    fill_up(view.bytes, '\0');
    size += view.bytes.size();
  }
  document["accessors"] = std::move(accessors_);
  document["bufferViews"] = std::move(buffer_views);
  document["buffers"] = Json::array({{{"byteLength", size}}});
  if (compressed) {
    // What the views have once they are decoded; nobody stores it.
    document["buffers"].push_back(
        {{"byteLength", fallback_size}, {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}});
  }

  // File names end up in names, and those need not be UTF-8.
  std::string text = document.dump(-1, ' ', false, Json::error_handler_t::replace);
  fill_up(text, ' ');
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
  for (View& view : views_) {
    bytes += view.bytes;
    std::string().swap(view.bytes);
  }
  return bytes;
}

}  // namespace tremula
