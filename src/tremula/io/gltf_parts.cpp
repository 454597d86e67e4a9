#include "tremula/io/gltf_parts.hpp"

#include "tremula/base/color.hpp"

#include <meshoptimizer.h>

namespace tremula::gltf {

Part lay_out(const Triangles& triangles, std::size_t vertex_count) {
  Part part{{}, Triangles(triangles.size())};
  meshopt_optimizeVertexCache(part.triangles.data(), triangles.data(), triangles.size(), vertex_count);
  std::vector<std::uint32_t> place(vertex_count);
  part.vertices.resize(
      meshopt_optimizeVertexFetchRemap(place.data(), part.triangles.data(), triangles.size(), vertex_count));
  for (std::size_t i = 0; i < vertex_count; ++i) {
    if (place[i] < part.vertices.size()) part.vertices[place[i]] = static_cast<std::uint32_t>(i);
  }
  for (std::uint32_t& corner : part.triangles) corner = place[corner];
  return part;
}

void add_rest_of_primitive(GlbBuilder& builder, const Surface& surface, const Part& part, int material,
                           Json& primitive) {
  std::vector<std::array<float, 2>> texture;
  for (const std::uint32_t v : part.vertices)
    texture.push_back({rounded(surface.texture[v].x()), rounded(surface.texture[v].y())});
  Json& attributes = primitive["attributes"];
  attributes["TEXCOORD_0"] = builder.add_attribute(texture);
  attributes["_BRANCH"] = builder.add_attribute(numbers(surface.branch, part));
  attributes["_ALONG"] = builder.add_attribute(numbers(surface.along, part));
  primitive["indices"] = builder.add_triangles(part.triangles, part.vertices.size());
  primitive["material"] = material;
}

Json make_material(const SurfaceMaterial& material) {
  Json color = Json::array();
  // Six digits: what pow() gives beyond them may differ between machines, and floats have no more.
  const auto six_digits = [](double value) { return std::round(value * 1e6) / 1e6; };
  for (const float channel : material.color)
    color.push_back(six_digits(linear_from_srgb(static_cast<double>(channel))));
  color.push_back(1);
  Json json = {{"name", material.name},
               {"pbrMetallicRoughness",
                {{"baseColorFactor", std::move(color)},
                 {"metallicFactor", 0},
                 {"roughnessFactor", six_digits(static_cast<double>(material.roughness))}}}};
  if (material.two_sided) json["doubleSided"] = true;
  return json;
}

}  // namespace tremula::gltf
