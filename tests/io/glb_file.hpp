// Reads .glb by the specification, knowing nothing of the writer: quantised, sparse and packed by meshopt as
// well.
#pragma once

#include <meshoptimizer.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Core>

namespace tremula::test {

struct Glb {
  nlohmann::json document;
  std::string binary;
  std::vector<std::string> views;  // decoded

  explicit Glb(const std::string& bytes) {
    const auto word = [&](std::size_t at) {
      std::uint32_t value;
      std::memcpy(&value, bytes.data() + at, 4);
      return std::size_t{value};
    };
    EXPECT_EQ(bytes.substr(0, 4), "glTF");
    EXPECT_EQ(word(4), 2U);
    EXPECT_EQ(word(8), bytes.size());
    EXPECT_EQ(bytes.substr(16, 4), "JSON");
    EXPECT_EQ(word(12) % 4, 0U);
    document = nlohmann::json::parse(bytes.substr(20, word(12)));
    const std::size_t chunk = 20 + word(12);
    EXPECT_EQ(bytes.substr(chunk + 4, 4), std::string("BIN\0", 4));
    binary = bytes.substr(chunk + 8);
    EXPECT_EQ(word(chunk), binary.size());
    EXPECT_EQ(document["buffers"][0]["byteLength"], binary.size());
    for (const nlohmann::json& view : document["bufferViews"]) views.push_back(bytes_of(view));
  }

  const nlohmann::json& accessor(const nlohmann::json& id) const {
    return document["accessors"].at(id.get<std::size_t>());
  }
  const nlohmann::json& primitive(std::size_t i) const { return document["meshes"][0]["primitives"].at(i); }
  double scale() const {
    return document["nodes"][0].contains("scale") ? double(document["nodes"][0]["scale"][0]) : 1;
  }

  // An accessor's numbers, one after the other.
  std::vector<double> numbers(const nlohmann::json& id) const {
    const nlohmann::json& a = accessor(id);
    const std::string type = a["type"];
    const std::size_t width = type == "SCALAR" ? 1 : type == "MAT4" ? 16 : type[3] - '0';
    const std::size_t count = a["count"];
    std::vector<double> result(count * width);
    if (a.contains("bufferView")) result = read(a, a["componentType"], count, width);
    if (a.contains("sparse")) {
      const nlohmann::json& sparse = a["sparse"];
      const std::size_t changed = sparse["count"];
      const std::vector<double> at = read(sparse["indices"], sparse["indices"]["componentType"], changed, 1);
      const std::vector<double> values = read(sparse["values"], a["componentType"], changed, width);
      for (std::size_t i = 0; i < changed; ++i) {
        EXPECT_TRUE(i == 0 || at[i - 1] < at[i]);
        for (std::size_t k = 0; k < width; ++k)
          result.at(static_cast<std::size_t>(at[i]) * width + k) = values[i * width + k];
      }
    }
    if (a.value("normalized", false)) {
      const int component = a["componentType"];
      EXPECT_TRUE(component == 5120 || component == 5121 || component == 5122) << component;
      const double most = component == 5120 ? 127 : component == 5121 ? 255 : 32767;
      for (double& number : result) number = std::max(number / most, -1.0);
    }
    return result;
  }

  std::vector<Eigen::Vector3f> vectors(const nlohmann::json& id) const {
    const std::vector<double> flat = numbers(id);
    std::vector<Eigen::Vector3f> result;
    for (std::size_t i = 0; i < flat.size(); i += 3)
      result.push_back(Eigen::Vector3d(flat[i], flat[i + 1], flat[i + 2]).cast<float>());
    return result;
  }

  std::vector<std::uint32_t> indices(std::size_t part) const {
    const std::vector<double> flat = numbers(primitive(part)["indices"]);
    return {flat.begin(), flat.end()};
  }

 private:
  static std::size_t size_of(int component) {
    switch (component) {
      case 5120:
      case 5121:
        return 1;
      case 5122:
      case 5123:
        return 2;
      default:
        return 4;
    }
  }

  static double number(const char* at, int component) {
    std::uint32_t bits = 0;
    std::memcpy(&bits, at, size_of(component));
    switch (component) {
      case 5120:
        return static_cast<std::int8_t>(bits);
      case 5122:
        return static_cast<std::int16_t>(bits);
      case 5126:
        return std::bit_cast<float>(bits);
      default:
        EXPECT_TRUE(component == 5121 || component == 5123 || component == 5125) << component;
        return bits;
    }
  }

  std::string bytes_of(const nlohmann::json& view) const {
    const auto part = [&](const nlohmann::json& json) {
      EXPECT_EQ(json["buffer"], 0);
      return binary.substr(json["byteOffset"], json["byteLength"]);
    };
    if (!view.contains("extensions")) return part(view);
    const nlohmann::json& packed = view["extensions"]["EXT_meshopt_compression"];
    const std::string code = part(packed);
    const std::size_t count = packed["count"], stride = packed["byteStride"];
    EXPECT_EQ(view["byteLength"], count * stride);
    EXPECT_TRUE(document["buffers"][view["buffer"].get<std::size_t>()]["extensions"]
                        ["EXT_meshopt_compression"]["fallback"]);
    std::string bytes(count * stride, '\0');
    const auto* data = reinterpret_cast<const unsigned char*>(code.data());
    const int failed = packed["mode"] == "TRIANGLES"
                           ? meshopt_decodeIndexBuffer(bytes.data(), count, stride, data, code.size())
                           : meshopt_decodeVertexBuffer(bytes.data(), count, stride, data, code.size());
    EXPECT_EQ(failed, 0);
    return bytes;
  }

  std::vector<double> read(const nlohmann::json& from, int component, std::size_t count,
                           std::size_t width) const {
    const auto id = from["bufferView"].get<std::size_t>();
    const std::string& bytes = views.at(id);
    const nlohmann::json& view = document["bufferViews"][id];
    const std::size_t size = size_of(component), stride = view.value("byteStride", size * width);
    const std::size_t begin = from.value("byteOffset", 0);
    EXPECT_LE(begin + stride * (count - 1) + size * width, bytes.size());
    EXPECT_EQ((begin + view["byteOffset"].get<std::size_t>()) % 4, 0U);
    EXPECT_TRUE(!view.contains("byteStride") || stride % 4 == 0);
    std::vector<double> result;
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t k = 0; k < width; ++k)
        result.push_back(number(bytes.data() + begin + i * stride + k * size, component));
    }
    return result;
  }
};

// From glTF's axes to those of every other file.
inline Eigen::Vector3f z_up(const Eigen::Vector3f& v) { return {v.x(), -v.z(), v.y()}; }

// One part of the mesh as a player shows it that knows targets and weights only.
struct PlayedPart {
  std::vector<Eigen::Vector3f> position, normal;  // z up, [m]; normals of any length
};

inline PlayedPart play(const Glb& glb, std::size_t part, const std::vector<double>& weights) {
  const nlohmann::json& primitive = glb.primitive(part);
  PlayedPart played{glb.vectors(primitive["attributes"]["POSITION"]),
                    glb.vectors(primitive["attributes"]["NORMAL"])};
  for (std::size_t t = 0; t < weights.size(); ++t) {
    const auto weight = static_cast<float>(weights[t]);
    const nlohmann::json& target = primitive["targets"].at(t);
    const std::vector<Eigen::Vector3f> moved = glb.vectors(target["POSITION"]),
                                       turned = glb.vectors(target["NORMAL"]);
    for (std::size_t i = 0; i < moved.size(); ++i) {
      played.position[i] += weight * moved[i];
      played.normal[i] += weight * turned[i];
    }
  }
  for (Eigen::Vector3f& p : played.position) p = z_up(p) * static_cast<float>(glb.scale());
  for (Eigen::Vector3f& n : played.normal) n = z_up(n);
  return played;
}

}  // namespace tremula::test
