#include "tremula/io/gltf.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>
#include <vector>

#include <Eigen/Geometry>

#include "io/glb_file.hpp"
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
// Each vertex has a branch of its own, by which a reader of the file knows it again.
Surface make_surface(std::uint32_t vertices_each) {
  Surface surface;
  for (std::uint32_t i = 0; i < 2 * vertices_each + 1; ++i) {
    surface.position.push_back(random_vector(0, i));
    surface.normal.push_back(random_vector(1, i).normalized());
    surface.texture.push_back({random_number(2, i), random_number(3, i)});
    surface.branch.push_back(static_cast<std::int32_t>(i));
    surface.along.push_back((random_number(4, i) + 1) / 2);
  }
  const SurfaceOptions materials;
  surface.parts = {{materials.tube, {}}, {materials.leaf, {}}};
  for (std::uint32_t i = 0; i + 2 < vertices_each; ++i) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      surface.parts[0].triangles.push_back(2 * (i + k));
      surface.parts[1].triangles.push_back(2 * (i + k) + 1);
    }
  }
  return surface;
}

// A lean that moves everything and a mode that moves every 20th vertex much and the others hardly. Zero is
// the plant at rest.
MorphTargets make_morphs(const Surface& surface) {
  MorphTargets morphs;
  morphs.period = 2;
  morphs.frequencies = {0.5, 0.75};
  morphs.static_shape_count = 1;
  morphs.shapes.resize(2);
  for (std::size_t i = 0; i < surface.vertex_count(); ++i) {
    const float little = i / 2 % 20 == 0 ? 1 : 1e-6F;
    morphs.shapes[0].position.push_back(0.1F * random_vector(5, i));
    morphs.shapes[0].normal.push_back(0.1F * random_vector(6, i));
    morphs.shapes[1].position.push_back(little * random_vector(7, i));
    morphs.shapes[1].normal.push_back(little * random_vector(8, i));
  }
  morphs.targets = {{"mean lean", ShapeKind::lean, 0, 0, 1},
                    {"mode 02 0.750 Hz", ShapeKind::mode, 1, 1, 1},
                    {"static 1 -", ShapeKind::static_shape, 0, 1, -1}};
  morphs.times = {0, 0.3F, 1.1F, 2};
  morphs.weights = {1, 0.25F, 0, 1, 0, 0, 1, 0, 1, 1, 0.25F, 0};
  return morphs;
}

using test::Glb;
using test::z_up;

const LoopFacts facts{.name = "aspen", .frames_per_second = 24, .wind_speed = 6.5, .heading = 30, .seed = 11};

// The same with weights that are not zero at rest, and normals that turn by what plants do.
MorphTargets make_biased(const Surface& surface) {
  MorphTargets morphs = make_morphs(surface);
  for (Vector3f& change : morphs.shapes[1].normal) change *= 0.2F;
  morphs.targets[1].rest = 0.375F;
  morphs.targets[2].rest = 0.75F;
  return morphs;
}

struct Written {
  Surface surface;
  MorphTargets morphs;
  Glb glb;
  double step = glb.scale();

  explicit Written(std::uint32_t vertices_each = 200,
                   MeshCompression compression = MeshCompression::quantised)
      : surface(make_surface(vertices_each)),
        morphs(make_morphs(surface)),
        glb(encode_glb(surface, morphs, facts, {.compression = compression})) {}

  std::vector<double> branches(std::size_t part) const {
    return glb.numbers(glb.primitive(part)["attributes"]["_BRANCH"]);
  }
};

// Triangles by what their corners are called, each with the lowest first, in order.
std::vector<std::array<std::size_t, 3>> sorted_triangles(const std::vector<std::size_t>& corners) {
  std::vector<std::array<std::size_t, 3>> triangles;
  for (std::size_t i = 0; i < corners.size(); i += 3) {
    std::array<std::size_t, 3> triangle{corners[i], corners[i + 1], corners[i + 2]};
    std::rotate(triangle.begin(), std::min_element(triangle.begin(), triangle.end()), triangle.end());
    triangles.push_back(triangle);
  }
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

float largest_entry(const Vector3f& v) { return v.lpNorm<Eigen::Infinity>(); }

TEST(EncodeGlb, EveryTriangleComesBackWithAllItsVerticesHave) {
  for (const MeshCompression compression : {MeshCompression::quantised, MeshCompression::meshopt}) {
    const Written w(200, compression);
    for (const std::size_t part : {0U, 1U}) {
      const auto& triangles = w.surface.parts[part].triangles;
      const json& attributes = w.glb.primitive(part)["attributes"];
      const std::vector<double> branch = w.branches(part);
      const std::vector<Vector3f> positions = w.glb.vectors(attributes["POSITION"]);
      const std::vector<Vector3f> normals = w.glb.vectors(attributes["NORMAL"]);
      const std::vector<double> texture = w.glb.numbers(attributes["TEXCOORD_0"]);
      const std::vector<double> along = w.glb.numbers(attributes["_ALONG"]);
      std::vector<std::size_t> corners;
      for (const std::uint32_t i : w.glb.indices(part)) corners.push_back(std::size_t(branch.at(i)));
      EXPECT_EQ(sorted_triangles(corners),
                sorted_triangles(std::vector<std::size_t>(triangles.begin(), triangles.end())));
      ASSERT_EQ(positions.size(), 200U);
      for (std::size_t i = 0; i < positions.size(); ++i) {
        const auto v = std::size_t(branch[i]);
        EXPECT_LE(largest_entry(z_up(positions[i]) * float(w.step) - w.surface.position[v]), 0.501 * w.step);
        EXPECT_LE(largest_entry(z_up(normals[i]) - w.surface.normal[v]), 0.501 / 127);
        EXPECT_NEAR(texture.at(2 * i), w.surface.texture[v].x(), 0.501 / 4096);
        EXPECT_NEAR(texture.at(2 * i + 1), w.surface.texture[v].y(), 0.501 / 4096);
        EXPECT_NEAR(along.at(i), w.surface.along[v], 0.501 / 4096);
      }
    }
  }
}

TEST(EncodeGlb, VerticesStandInTheOrderInWhichTrianglesUseThem) {
  const Written w;
  std::uint32_t next = 0;
  for (const std::uint32_t i : w.glb.indices(0)) {
    EXPECT_LE(i, next);
    next = std::max(next, i + 1);
  }
  EXPECT_EQ(next, 200U);
}

// Largest difference of a target's positions [steps] and normals [1/127] from what went in.
std::pair<double, double> target_errors(const Written& w, std::size_t part, std::size_t target) {
  const std::vector<double> branch = w.branches(part);
  const json& json_target = w.glb.primitive(part)["targets"].at(target);
  const std::vector<Vector3f> positions = w.glb.vectors(json_target["POSITION"]);
  const std::vector<Vector3f> normals = w.glb.vectors(json_target["NORMAL"]);
  const MorphTarget& wanted = w.morphs.targets[target];
  const SurfaceDelta& shape = w.morphs.shapes[static_cast<std::size_t>(wanted.shape)];
  std::pair<double, double> worst{0, 0};
  for (std::size_t i = 0; i < branch.size(); ++i) {
    const auto v = std::size_t(branch[i]);
    const Vector3f moved = z_up(positions.at(i)) - wanted.sign * shape.position[v] / float(w.step);
    const Vector3f turned = 127 * (z_up(normals.at(i)) - wanted.sign * shape.normal[v]);
    worst.first = std::max<double>(worst.first, largest_entry(moved));
    worst.second = std::max<double>(worst.second, largest_entry(turned));
  }
  return worst;
}

TEST(EncodeGlb, TargetsComeBackToHalfAStep) {
  for (const MeshCompression compression : {MeshCompression::quantised, MeshCompression::meshopt}) {
    const Written w(200, compression);
    for (const std::size_t part : {0U, 1U}) {
      for (std::size_t target = 0; target < 3; ++target) {
        const auto [position, normal] = target_errors(w, part, target);
        EXPECT_LE(position, 0.51);
        EXPECT_LE(normal, 0.51);
      }
    }
  }
}

TEST(EncodeGlb, WithRestWeightsThePlantStandsAtRestToHalfAStep) {
  const Surface surface = make_surface(200);
  const MorphTargets morphs = make_biased(surface);
  const Glb glb(encode_glb(surface, morphs, facts));
  EXPECT_EQ(glb.document["meshes"][0]["weights"], json({0, 0.375, 0.75}));
  for (const std::size_t part : {0U, 1U}) {
    const std::vector<double> branch = glb.numbers(glb.primitive(part)["attributes"]["_BRANCH"]);
    const test::PlayedPart rest = play(glb, part, {0, 0.375, 0.75});
    for (std::size_t i = 0; i < branch.size(); ++i) {
      const auto v = std::size_t(branch[i]);
      EXPECT_LE(largest_entry(rest.position[i] - surface.position[v]), 0.51 * glb.scale());
      // Three roundings of 1/254 in three directions.
      EXPECT_LE((rest.normal[i].normalized() - surface.normal[v]).norm(), 0.03);
    }
    for (const Vector3f& normal : glb.vectors(glb.primitive(part)["attributes"]["NORMAL"]))
      EXPECT_NEAR(normal.norm(), 1, 0.0068);
  }
}

TEST(EncodeGlb, ALocalModeIsStoredSparsely) {
  const Written w;
  const json& lean = w.glb.accessor(w.glb.primitive(0)["targets"][0]["POSITION"]);
  const json& mode = w.glb.accessor(w.glb.primitive(0)["targets"][1]["POSITION"]);
  EXPECT_FALSE(lean.contains("sparse"));
  ASSERT_TRUE(mode.contains("sparse"));
  EXPECT_EQ(mode["sparse"]["count"], 10);
}

TEST(EncodeGlb, ASmallMovementTakesEightBits) {
  const Surface surface = make_surface(50);
  MorphTargets morphs = make_morphs(surface);
  for (Vector3f& change : morphs.shapes[1].position) change *= 0.003F;
  const Glb glb(encode_glb(surface, morphs, facts));
  const auto component = [&](std::size_t target) {
    return glb.accessor(glb.primitive(0)["targets"][target]["POSITION"])["componentType"];
  };
  EXPECT_EQ(component(0), 5122);
  EXPECT_EQ(component(1), 5120);
}

TEST(EncodeGlb, WithoutCompressionItIsFloatsAndNoExtension) {
  const Surface surface = make_surface(200);
  const MorphTargets morphs = make_biased(surface);
  const Glb whole(encode_glb(surface, morphs, facts)),
      glb(encode_glb(surface, morphs, facts, {.compression = MeshCompression::none}));
  EXPECT_FALSE(glb.document.contains("extensionsUsed"));
  EXPECT_FALSE(glb.document.contains("extensionsRequired"));
  EXPECT_FALSE(glb.document["nodes"][0].contains("scale"));
  for (const std::size_t part : {0U, 1U}) {
    const std::vector<double> branch = glb.numbers(glb.primitive(part)["attributes"]["_BRANCH"]);
    for (const auto& weights : {std::vector<double>{0, 0.375, 0.75}, {1, 0, 1}}) {
      const test::PlayedPart played = play(glb, part, weights);
      for (std::size_t i = 0; i < branch.size(); ++i) {
        const auto v = std::size_t(branch[i]);
        Vector3f position = surface.position[v], normal = surface.normal[v];
        for (std::size_t t = 0; t < 3; ++t) {
          const float weight = (float(weights[t]) - morphs.targets[t].rest) * morphs.targets[t].sign;
          position += weight * morphs.shapes[std::size_t(morphs.targets[t].shape)].position[v];
          normal += weight * morphs.shapes[std::size_t(morphs.targets[t].shape)].normal[v];
        }
        // What the quantised form rounds to zero is left out here too.
        EXPECT_LE(largest_entry(played.position[i] - position), 2 * whole.scale());
        EXPECT_LE((played.normal[i].normalized() - normal.normalized()).norm(), 0.02);
      }
    }
  }
}

TEST(EncodeGlb, MeshoptHoldsTheSameNumbers) {
  const Written plain, packed(200, MeshCompression::meshopt);
  EXPECT_EQ(packed.glb.document["extensionsRequired"],
            json({"KHR_mesh_quantization", "EXT_meshopt_compression"}));
  EXPECT_EQ(plain.glb.document["extensionsRequired"], json({"KHR_mesh_quantization"}));
  const std::size_t count = plain.glb.document["accessors"].size();
  ASSERT_EQ(packed.glb.document["accessors"].size(), count);
  for (std::size_t id = 0; id < count; ++id) {
    // Triangles may be turned.
    if (id == plain.glb.primitive(0)["indices"] || id == plain.glb.primitive(1)["indices"]) continue;
    EXPECT_EQ(packed.glb.numbers(id), plain.glb.numbers(id)) << id;
    EXPECT_FALSE(packed.glb.accessor(id).contains("sparse"));
  }
}

TEST(EncodeGlb, ATargetThatMovesOnlyTheLeavesIsStillOnTheBark) {
  Surface surface = make_surface(50);
  MorphTargets morphs = make_morphs(surface);
  for (std::size_t i = 0; i < surface.vertex_count(); i += 2) morphs.shapes[1].position[i].setZero();
  const Glb glb(encode_glb(surface, morphs, facts));
  const std::vector<Vector3f> bark = glb.vectors(glb.primitive(0)["targets"][1]["POSITION"]);
  EXPECT_EQ(bark, std::vector<Vector3f>(50, Vector3f::Zero()));
}

TEST(EncodeGlb, ManyVerticesGetLongIndices) {
  const Written small(65535), large(65536);
  EXPECT_EQ(small.glb.accessor(small.glb.primitive(0)["indices"])["componentType"], 5123);
  EXPECT_EQ(large.glb.accessor(large.glb.primitive(0)["indices"])["componentType"], 5125);
  EXPECT_LE(target_errors(large, 1, 0).first, 0.51);
  EXPECT_LE(target_errors(large, 1, 2).first, 0.51);
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
  EXPECT_EQ(w.glb.document["meshes"][0]["weights"], json({0, 0, 0}));
}

TEST(EncodeGlb, SaysWhatIsInIt) {
  const Written w;
  const json& mesh = w.glb.document["meshes"][0];
  EXPECT_EQ(mesh["extras"]["targetNames"], json({"mean lean", "mode 02 0.750 Hz", "static 1 -"}));
  EXPECT_EQ(mesh["extras"]["targetKinds"], json({"lean", "mode", "static"}));
  EXPECT_EQ(mesh["extras"]["targetModes"], json({0, 2, 0}));
  const json& scene = w.glb.document["scenes"][0];
  EXPECT_EQ(scene["name"], "aspen");
  EXPECT_EQ(scene["extras"]["tremula"], json({{"period_s", 2.0},
                                              {"repeats", true},
                                              {"frames_per_second", 24.0},
                                              {"wind_speed_m_s", 6.5},
                                              {"heading_deg", 30.0},
                                              {"seed", 11},
                                              {"frequencies_hz", {0.5, 0.75}},
                                              {"static_shapes", 1}}));
  EXPECT_THAT(w.glb.document["asset"]["generator"].get<std::string>(),
              testing::MatchesRegex("tremula [0-9.]+"));
}

TEST(EncodeGlb, ColorsAreLinear) {
  Surface surface = make_surface(9);
  surface.parts[0].material.color = {0.03F, 0.5F, 1};
  const Glb glb(encode_glb(surface, make_morphs(surface), facts));
  const auto to_srgb = [](double linear) {
    return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
  };
  for (const std::size_t part : {0U, 1U}) {
    const json& material = glb.document["materials"].at(glb.primitive(part)["material"].get<std::size_t>());
    const Vector3f& wanted = surface.parts[part].material.color;
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_NEAR(to_srgb(material["pbrMetallicRoughness"]["baseColorFactor"][k]), wanted[Eigen::Index(k)],
                  2e-5);
    }
    EXPECT_EQ(material.value("doubleSided", false), part == 1);
  }
}

TEST(EncodeGlb, APlantWithoutLeavesHasOnePrimitive) {
  Surface surface = make_surface(9);
  surface.parts[1].triangles.clear();
  const Glb glb(encode_glb(surface, make_morphs(surface), facts));
  EXPECT_EQ(glb.document["meshes"][0]["primitives"].size(), 1U);
  EXPECT_EQ(glb.document["materials"].size(), 1U);
}

TEST(EncodeGlb, AsManyPartsAsTheSurfaceHasEachInItsMaterial) {
  Surface surface = make_surface(30);
  SurfacePart cloth = surface.parts[0];
  cloth.material.name = "cloth";
  cloth.material.roughness = 0.25F;
  cloth.material.two_sided = true;
  surface.parts.push_back(cloth);
  const Glb glb(encode_glb(surface, make_morphs(surface), facts));
  ASSERT_EQ(glb.document["meshes"][0]["primitives"].size(), 3U);
  const json& material = glb.document["materials"].at(glb.primitive(2)["material"].get<std::size_t>());
  EXPECT_EQ(material["name"], "cloth");
  EXPECT_EQ(material["pbrMetallicRoughness"]["roughnessFactor"], 0.25);
  EXPECT_TRUE(material["doubleSided"]);
  EXPECT_EQ(glb.indices(2).size(), cloth.triangles.size());
}

// The table of a channel at a time, linear between keys.
double weight_at(const Glb& glb, const json& sampler, double time, std::size_t target, std::size_t targets) {
  const std::vector<double> times = glb.numbers(sampler["input"]), weights = glb.numbers(sampler["output"]);
  std::size_t k = 1;
  while (k + 1 < times.size() && times[k] < time) ++k;
  const double part = (time - times[k - 1]) / (times[k] - times[k - 1]);
  return (1 - part) * weights[(k - 1) * targets + target] + part * weights[k * targets + target];
}

TEST(EncodeGlb, EveryInstanceIsANodeWithItsOwnPlaceAndTime) {
  const Surface surface = make_surface(30);
  MorphTargets morphs = make_morphs(surface);
  const Glb alone(encode_glb(surface, morphs, facts));
  morphs.instances = {{},
                      {.position = {1, 2, 3}, .turn = 0.7, .scale = 1.5, .time_shift = 0.7},
                      {.position = {-4, 0, 0}, .time_shift = -1.3}};  // a period of 2 s: as the one before
  const Glb glb(encode_glb(surface, morphs, facts));
  EXPECT_EQ(glb.document["scenes"][0]["nodes"], json({0, 1, 2}));
  EXPECT_EQ(glb.document["meshes"], alone.document["meshes"]);
  const json &nodes = glb.document["nodes"], &animation = glb.document["animations"][0];
  ASSERT_EQ(nodes.size(), 3U);
  ASSERT_EQ(animation["channels"].size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    const Instance& instance = morphs.instances[i];
    EXPECT_EQ(nodes[i]["mesh"], 0);
    // glTF: scale, rotate by the quaternion, translate.
    const Vec3 point(0.3, -0.2, 0.9);
    const auto numbers = [&](const char* key, std::vector<double> otherwise) {
      return nodes[i].contains(key) ? nodes[i][key].get<std::vector<double>>() : otherwise;
    };
    const auto t = numbers("translation", {0, 0, 0}), r = numbers("rotation", {0, 0, 0, 1}),
               s = numbers("scale", {1, 1, 1});
    const Eigen::Quaterniond q(r[3], r[0], r[1], r[2]);
    const Vec3 placed =
        q * (s[0] / glb.scale() * Vec3(point.x(), point.z(), -point.y())) + Vec3(t[0], t[1], t[2]);
    const Vec3 wanted = instance.position + instance.scale * (instance.rotation() * point);
    EXPECT_LT((Vec3(placed.x(), -placed.z(), placed.y()) - wanted).norm(), 1e-12);

    EXPECT_EQ(animation["channels"][i]["target"], (json{{"node", i}, {"path", "weights"}}));
    const json& sampler = animation["samplers"].at(animation["channels"][i]["sampler"].get<std::size_t>());
    const json& plain = alone.document["animations"][0]["samplers"][0];
    for (double time = 0.05; time < 2; time += 0.1) {
      const double there = std::fmod(time + instance.time_shift + 4, 2);
      for (std::size_t target = 0; target < 3; ++target)
        EXPECT_NEAR(weight_at(glb, sampler, time, target, 3), weight_at(alone, plain, there, target, 3),
                    1e-6);
    }
  }
  EXPECT_EQ(nodes[1]["extras"]["tremula"]["time_shift_s"], 0.7);
}

TEST(EncodeGlb, APlantThatStandsStillHasNoAnimation) {
  const Surface surface = make_surface(9);
  MorphTargets still = make_morphs(surface);
  still.shapes.clear();
  still.targets.clear();
  still.weights.clear();
  const Glb glb(encode_glb(surface, still, facts));
  EXPECT_FALSE(glb.document.contains("animations"));
  EXPECT_FALSE(glb.primitive(0).contains("targets"));
  EXPECT_FALSE(glb.document["meshes"][0].contains("weights"));
}

TEST(EncodeGlb, GivesTheSameBytesEveryTime) {
  const Surface surface = make_surface(100);
  const MorphTargets morphs = make_morphs(surface);
  EXPECT_EQ(encode_glb(surface, morphs, facts), encode_glb(surface, morphs, facts));
}

TEST(EncodeGlb, ANameThatIsNotUtf8IsMended) {
  const Surface surface = make_surface(9);
  LoopFacts odd = facts;
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
      encode_glb(surface, morphs, facts);
    } catch (const Error& error) {
      return error.what();
    }
    return "accepted";
  };
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(message([](Surface&, MorphTargets&) {}), "accepted");
  EXPECT_THAT(message([](Surface& s, MorphTargets&) {
                for (SurfacePart& part : s.parts) part.triangles.clear();
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
  write_glb(folder / "tree.glb", surface, morphs, facts);
  std::ifstream file(folder / "tree.glb", std::ios::binary);
  std::stringstream bytes;
  bytes << file.rdbuf();
  EXPECT_EQ(bytes.str(), encode_glb(surface, morphs, facts));

  EXPECT_THROW(write_glb(folder / "no such folder/tree.glb", surface, morphs, facts), Error);
  EXPECT_THROW(write_glb(folder / "bad.glb", Surface{}, morphs, facts), Error);
  EXPECT_FALSE(std::filesystem::exists(folder / "bad.glb"));
}

}  // namespace
}  // namespace tremula
