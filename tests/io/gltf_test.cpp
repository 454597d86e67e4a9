#include "tremula/io/gltf.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>
#include <vector>

#include "support.hpp"
#include "tremula/base/error.hpp"
#include "tremula/numerics/random.hpp"

namespace tremula {
namespace {

using Eigen::Vector3f;
using nlohmann::json;
using ::testing::HasSubstr;

float random_number(std::uint32_t what, std::size_t i) {  // -1 … 1
  return static_cast<float>(2 * uniform({5, RandomStream::test, what, i}) - 1);
}
Vector3f random_vector(std::uint32_t what, std::size_t i) {
  return {random_number(what, 3 * i), random_number(what, 3 * i + 1), random_number(what, 3 * i + 2)};
}

// Two strips of triangles: bark on the even vertices, leaves on the odd ones, and a vertex that nobody uses.
Surface make_surface(std::uint32_t vertices_each) {
  Surface surface;
  for (std::uint32_t i = 0; i < 2 * vertices_each + 1; ++i) {
    surface.position.push_back(random_vector(0, i));
    surface.normal.push_back(random_vector(1, i).normalized());
    surface.texture.push_back({random_number(2, i), random_number(3, i)});
    surface.branch.push_back(static_cast<std::int32_t>(i / 7));
    surface.along.push_back((random_number(4, i) + 1) / 2);
  }
  for (std::uint32_t i = 0; i + 2 < vertices_each; ++i) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      surface.bark_triangles.push_back(2 * (i + k));
      surface.leaf_triangles.push_back(2 * (i + k) + 1);
    }
  }
  return surface;
}

// A lean that moves everything and a mode that moves every 20th vertex much and the others hardly.
MorphTargets make_morphs(const Surface& surface) {
  MorphTargets morphs;
  morphs.period = 2;
  morphs.frequencies = {0.5, 0.75};
  morphs.shapes.resize(2);
  for (std::size_t i = 0; i < surface.vertex_count(); ++i) {
    const float little = i / 2 % 20 == 0 ? 1 : 1e-6F;
    morphs.shapes[0].position.push_back(0.1F * random_vector(5, i));
    morphs.shapes[0].normal.push_back(0.1F * random_vector(6, i));
    morphs.shapes[1].position.push_back(little * random_vector(7, i));
    morphs.shapes[1].normal.push_back(little * random_vector(8, i));
  }
  morphs.targets = {
      {"mean lean", -1, 0, 1}, {"mode 02 0.750 Hz +", 1, 1, 1}, {"mode 02 0.750 Hz -", 1, 1, -1}};
  morphs.times = {0, 0.3F, 1.1F, 2};
  morphs.weights = {1, 0.25F, 0, 1, 0, 0, 1, 0, 1, 1, 0.25F, 0};
  return morphs;
}

// Reads .glb by the specification, knowing nothing of the writer.
struct Glb {
  json document;
  std::string binary;

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
    document = json::parse(bytes.substr(20, word(12)));
    const std::size_t chunk = 20 + word(12);
    EXPECT_EQ(bytes.substr(chunk + 4, 4), std::string("BIN\0", 4));
    binary = bytes.substr(chunk + 8);
    EXPECT_EQ(word(chunk), binary.size());
    EXPECT_EQ(document["buffers"][0]["byteLength"], binary.size());
  }

  const json& accessor(const json& id) const { return document["accessors"].at(id.get<std::size_t>()); }
  const json& primitive(std::size_t i) const { return document["meshes"][0]["primitives"].at(i); }

  // An accessor's numbers, one after the other.
  std::vector<double> numbers(const json& id) const {
    const json& a = accessor(id);
    const std::string type = a["type"];
    const std::size_t width = type == "VEC3" ? 3 : type == "VEC2" ? 2 : 1, count = a["count"];
    std::vector<double> result(count * width);
    if (a.contains("bufferView")) result = read(a, a["componentType"], count * width);
    if (a.contains("sparse")) {
      const json& sparse = a["sparse"];
      const std::size_t changed = sparse["count"];
      const std::vector<double> at = read(sparse["indices"], sparse["indices"]["componentType"], changed);
      const std::vector<double> values = read(sparse["values"], a["componentType"], changed * width);
      for (std::size_t i = 0; i < changed; ++i) {
        EXPECT_TRUE(i == 0 || at[i - 1] < at[i]);
        for (std::size_t k = 0; k < width; ++k)
          result.at(static_cast<std::size_t>(at[i]) * width + k) = values[i * width + k];
      }
    }
    return result;
  }

  std::vector<Vector3f> vectors(const json& id) const {
    const std::vector<double> flat = numbers(id);
    std::vector<Vector3f> result;
    for (std::size_t i = 0; i < flat.size(); i += 3) {
      result.push_back(Eigen::Vector3d(flat[i], flat[i + 1], flat[i + 2]).cast<float>());
    }
    return result;
  }

 private:
  std::vector<double> read(const json& from, int component, std::size_t count) const {
    const json& view = document["bufferViews"].at(from["bufferView"].get<std::size_t>());
    const std::size_t size = component == 5123 ? 2 : 4;
    std::size_t at = from.value("byteOffset", 0);
    EXPECT_LE(at + size * count, view["byteLength"].get<std::size_t>());
    at += view["byteOffset"].get<std::size_t>();
    EXPECT_EQ(at % 4, 0U);
    std::vector<double> result;
    for (std::size_t i = 0; i < count; ++i) {
      std::uint32_t bits = 0;
      std::memcpy(&bits, binary.substr(at + i * size, size).data(), size);
      result.push_back(component == 5126 ? std::bit_cast<float>(bits) : bits);
    }
    return result;
  }
};

Vector3f z_up(const Vector3f& v) { return {v.x(), -v.z(), v.y()}; }

const LoopInfo info{.name = "aspen", .frames_per_second = 24, .wind_speed = 6.5, .heading = 30, .seed = 11};

struct Written {
  Surface surface;
  MorphTargets morphs;
  Glb glb;

  explicit Written(std::uint32_t vertices_each = 200, const GltfOptions& options = {})
      : surface(make_surface(vertices_each)),
        morphs(make_morphs(surface)),
        glb(encode_glb(surface, morphs, info, options)) {}
};

TEST(EncodeGlb, EveryTriangleComesBackWithAllItsVerticesHave) {
  const Written w;
  for (const std::size_t part : {0U, 1U}) {
    const auto& triangles = part == 0 ? w.surface.bark_triangles : w.surface.leaf_triangles;
    const json& attributes = w.glb.primitive(part)["attributes"];
    const std::vector<double> indices = w.glb.numbers(w.glb.primitive(part)["indices"]);
    const std::vector<Vector3f> positions = w.glb.vectors(attributes["POSITION"]);
    const std::vector<Vector3f> normals = w.glb.vectors(attributes["NORMAL"]);
    const std::vector<double> texture = w.glb.numbers(attributes["TEXCOORD_0"]);
    const std::vector<double> branch = w.glb.numbers(attributes["_BRANCH"]);
    const std::vector<double> along = w.glb.numbers(attributes["_ALONG"]);
    EXPECT_EQ(positions.size(), 200U);
    ASSERT_EQ(indices.size(), triangles.size());
    for (std::size_t i = 0; i < indices.size(); ++i) {
      const auto there = static_cast<std::size_t>(indices[i]);
      const std::size_t here = triangles[i];
      EXPECT_EQ(z_up(positions.at(there)), w.surface.position[here]);
      EXPECT_EQ(z_up(normals.at(there)), w.surface.normal[here]);
      EXPECT_EQ(texture.at(2 * there), w.surface.texture[here].x());
      EXPECT_EQ(texture.at(2 * there + 1), w.surface.texture[here].y());
      EXPECT_EQ(branch.at(there), w.surface.branch[here]);
      EXPECT_EQ(along.at(there), w.surface.along[here]);
    }
  }
}

// Largest difference of a target's positions and normals from what went in.
std::pair<float, float> target_errors(const Written& w, std::size_t part, std::size_t target) {
  const auto& triangles = part == 0 ? w.surface.bark_triangles : w.surface.leaf_triangles;
  const std::vector<double> indices = w.glb.numbers(w.glb.primitive(part)["indices"]);
  const json& json_target = w.glb.primitive(part)["targets"].at(target);
  const std::vector<Vector3f> positions = w.glb.vectors(json_target["POSITION"]);
  const std::vector<Vector3f> normals = w.glb.vectors(json_target["NORMAL"]);
  const MorphTarget& wanted = w.morphs.targets[target];
  const SurfaceDelta& shape = w.morphs.shapes[static_cast<std::size_t>(wanted.shape)];
  std::pair<float, float> worst{0, 0};
  for (std::size_t i = 0; i < indices.size(); ++i) {
    const auto there = static_cast<std::size_t>(indices[i]);
    worst.first = std::max(worst.first,
                           (z_up(positions.at(there)) - wanted.sign * shape.position[triangles[i]]).norm());
    worst.second =
        std::max(worst.second, (z_up(normals.at(there)) - wanted.sign * shape.normal[triangles[i]]).norm());
  }
  return worst;
}

TEST(EncodeGlb, TargetsComeBackAsExactlyAsAsked) {
  const GltfOptions exact{.position_tolerance = 0, .normal_tolerance = 0};
  const Written all(200, exact), most;
  for (const std::size_t part : {0U, 1U}) {
    for (std::size_t target = 0; target < 3; ++target) {
      EXPECT_EQ(target_errors(all, part, target), std::make_pair(0.0F, 0.0F));
      const auto [position, normal] = target_errors(most, part, target);
      // The largest movement is below sqrt(3).
      EXPECT_LE(position, 1.74F * GltfOptions{}.position_tolerance);
      EXPECT_LE(normal, GltfOptions{}.normal_tolerance);
      // The lean moves everything: nothing is gained by leaving some of it out, so nothing is.
      EXPECT_EQ(position > 0, target > 0);
    }
  }
}

TEST(EncodeGlb, ALocalModeIsStoredSparsely) {
  const Written w;
  const json& lean = w.glb.accessor(w.glb.primitive(0)["targets"][0]["POSITION"]);
  const json& mode = w.glb.accessor(w.glb.primitive(0)["targets"][1]["POSITION"]);
  EXPECT_FALSE(lean.contains("sparse"));
  ASSERT_TRUE(mode.contains("sparse"));
  EXPECT_EQ(mode["sparse"]["count"], 10);
  EXPECT_LT(encode_glb(w.surface, w.morphs, info).size(),
            encode_glb(w.surface, w.morphs, info, {.position_tolerance = 0, .normal_tolerance = 0}).size());
}

TEST(EncodeGlb, ATargetThatMovesOnlyTheLeavesIsStillOnTheBark) {
  Surface surface = make_surface(50);
  MorphTargets morphs = make_morphs(surface);
  for (std::size_t i = 0; i < surface.vertex_count(); i += 2) morphs.shapes[1].position[i].setZero();
  const Glb glb(encode_glb(surface, morphs, info));
  const std::vector<Vector3f> bark = glb.vectors(glb.primitive(0)["targets"][1]["POSITION"]);
  EXPECT_EQ(bark, std::vector<Vector3f>(50, Vector3f::Zero()));
}

TEST(EncodeGlb, ManyVerticesGetLongIndices) {
  const Written small(65535), large(65536);
  EXPECT_EQ(small.glb.accessor(small.glb.primitive(0)["indices"])["componentType"], 5123);
  EXPECT_EQ(large.glb.accessor(large.glb.primitive(0)["indices"])["componentType"], 5125);
  EXPECT_EQ(target_errors(large, 1, 0), std::make_pair(0.0F, 0.0F));
  EXPECT_LE(target_errors(large, 1, 2).first, 1.74F * GltfOptions{}.position_tolerance);
}

TEST(EncodeGlb, BoundsAreThoseOfTheNumbers) {
  const Written w;
  int bounded = 0;
  for (std::size_t id = 0; id < w.glb.document["accessors"].size(); ++id) {
    const json& accessor = w.glb.accessor(id);
    if (!accessor.contains("min")) continue;
    ++bounded;
    const std::vector<double> numbers = w.glb.numbers(id);
    const std::size_t width = accessor["min"].size();
    for (std::size_t k = 0; k < width; ++k) {
      std::vector<double> column;
      for (std::size_t i = k; i < numbers.size(); i += width) column.push_back(numbers[i]);
      EXPECT_EQ(accessor["min"][k], *std::min_element(column.begin(), column.end()));
      EXPECT_EQ(accessor["max"][k], *std::max_element(column.begin(), column.end()));
    }
  }
  EXPECT_EQ(bounded, 2 * (1 + 3) + 1);  // positions of both primitives and their targets, and the keys
}

TEST(EncodeGlb, TheAnimationHoldsKeysAndWeights) {
  const Written w;
  const json& animation = w.glb.document["animations"].at(0);
  EXPECT_EQ(animation["name"], "wind loop");
  EXPECT_EQ(animation["channels"].at(0)["target"], json({{"node", 0}, {"path", "weights"}}));
  const json& sampler = animation["samplers"].at(0);
  EXPECT_EQ(sampler["interpolation"], "LINEAR");
  EXPECT_EQ(w.glb.numbers(sampler["input"]),
            std::vector<double>(w.morphs.times.begin(), w.morphs.times.end()));
  EXPECT_EQ(w.glb.numbers(sampler["output"]),
            std::vector<double>(w.morphs.weights.begin(), w.morphs.weights.end()));
  EXPECT_EQ(w.glb.document["meshes"][0]["weights"], json({1, 0.25, 0}));
}

TEST(EncodeGlb, SaysWhatIsInIt) {
  const Written w;
  const json& mesh = w.glb.document["meshes"][0];
  EXPECT_EQ(mesh["extras"]["targetNames"], json({"mean lean", "mode 02 0.750 Hz +", "mode 02 0.750 Hz -"}));
  EXPECT_EQ(mesh["extras"]["targetModes"], json({0, 2, 2}));
  const json& scene = w.glb.document["scenes"][0];
  EXPECT_EQ(scene["name"], "aspen");
  EXPECT_EQ(scene["extras"]["tremula"], json({{"period_s", 2.0},
                                              {"frames_per_second", 24.0},
                                              {"wind_speed_m_s", 6.5},
                                              {"heading_deg", 30.0},
                                              {"seed", 11},
                                              {"frequencies_hz", {0.5, 0.75}}}));
  EXPECT_THAT(w.glb.document["asset"]["generator"].get<std::string>(),
              testing::MatchesRegex("tremula [0-9.]+"));
}

TEST(EncodeGlb, ColorsAreLinear) {
  Surface surface = make_surface(9);
  surface.bark_color = {0.03F, 0.5F, 1};
  const Glb glb(encode_glb(surface, make_morphs(surface), info));
  const auto to_srgb = [](double linear) {
    return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
  };
  for (const std::size_t part : {0U, 1U}) {
    const json& material = glb.document["materials"].at(glb.primitive(part)["material"].get<std::size_t>());
    const Vector3f& wanted = part == 0 ? surface.bark_color : surface.leaf_color;
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_NEAR(to_srgb(material["pbrMetallicRoughness"]["baseColorFactor"][k]), wanted[Eigen::Index(k)],
                  2e-5);
    }
    EXPECT_EQ(material.value("doubleSided", false), part == 1);
  }
}

TEST(EncodeGlb, APlantWithoutLeavesHasOnePrimitive) {
  Surface surface = make_surface(9);
  surface.leaf_triangles.clear();
  const Glb glb(encode_glb(surface, make_morphs(surface), info));
  EXPECT_EQ(glb.document["meshes"][0]["primitives"].size(), 1U);
  EXPECT_EQ(glb.document["materials"].size(), 1U);
}

TEST(EncodeGlb, APlantThatStandsStillHasNoAnimation) {
  const Surface surface = make_surface(9);
  MorphTargets still = make_morphs(surface);
  still.shapes.clear();
  still.targets.clear();
  still.weights.clear();
  const Glb glb(encode_glb(surface, still, info));
  EXPECT_FALSE(glb.document.contains("animations"));
  EXPECT_FALSE(glb.primitive(0).contains("targets"));
  EXPECT_FALSE(glb.document["meshes"][0].contains("weights"));
}

TEST(EncodeGlb, GivesTheSameBytesEveryTime) {
  const Surface surface = make_surface(100);
  const MorphTargets morphs = make_morphs(surface);
  EXPECT_EQ(encode_glb(surface, morphs, info), encode_glb(surface, morphs, info));
}

TEST(EncodeGlb, ANameThatIsNotUtf8IsMended) {
  const Surface surface = make_surface(9);
  LoopInfo odd = info;
  odd.name = "b\xFCrke \"<\n";
  const Glb glb(encode_glb(surface, make_morphs(surface), odd));
  EXPECT_EQ(glb.document["nodes"][0]["name"], "b\xEF\xBF\xBDrke \"<\n");
}

TEST(EncodeGlb, RejectsWhatWouldBeNoMesh) {
  const auto message = [](const auto& spoil) -> std::string {
    Surface surface = make_surface(9);
    MorphTargets morphs = make_morphs(surface);
    spoil(surface, morphs);
    try {
      encode_glb(surface, morphs, info);
    } catch (const Error& error) {
      return error.what();
    }
    return "accepted";
  };
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(message([](Surface&, MorphTargets&) {}), "accepted");
  EXPECT_THAT(message([](Surface& s, MorphTargets&) {
                s.bark_triangles.clear();
                s.leaf_triangles.clear();
              }),
              HasSubstr("no triangles"));
  EXPECT_THAT(message([&](Surface& s, MorphTargets&) { s.position[3].y() = nan; }), HasSubstr("not finite"));
  EXPECT_THAT(message([&](Surface&, MorphTargets& m) { m.shapes[1].normal[3].y() = nan; }),
              HasSubstr("not finite"));
  EXPECT_THAT(message([&](Surface&, MorphTargets& m) { m.weights[4] = nan; }),
              HasSubstr("weights of the loop: number 5 of 12"));
  EXPECT_THAT(message([&](Surface&, MorphTargets& m) { m.times[1] = nan; }), HasSubstr("times of the loop"));
  EXPECT_THAT(message([&](Surface&, MorphTargets& m) { m.shapes[1].position.pop_back(); }),
              HasSubstr("18 vertices, wanted 19"));
  EXPECT_THAT(message([&](Surface&, MorphTargets& m) { m.weights.pop_back(); }), HasSubstr("11 weights"));
}

TEST(WriteGlb, WritesTheBytesOrNothing) {
  const test::TemporaryFolder folder;
  const Surface surface = make_surface(9);
  const MorphTargets morphs = make_morphs(surface);
  write_glb(folder / "tree.glb", surface, morphs, info);
  std::ifstream file(folder / "tree.glb", std::ios::binary);
  std::stringstream bytes;
  bytes << file.rdbuf();
  EXPECT_EQ(bytes.str(), encode_glb(surface, morphs, info));

  EXPECT_THROW(write_glb(folder / "no such folder/tree.glb", surface, morphs, info), Error);
  EXPECT_THROW(write_glb(folder / "bad.glb", Surface{}, morphs, info), Error);
  EXPECT_FALSE(std::filesystem::exists(folder / "bad.glb"));
}

}  // namespace
}  // namespace tremula
