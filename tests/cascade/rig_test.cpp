// Presets on bones, as their .glb is played, against the poses of the program.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "io/glb_skin.hpp"
#include "tremula/deformation/bent_pose.hpp"
#include "tremula/deformation/fit_rig.hpp"
#include "tremula/geometry/grow.hpp"
#include "tremula/geometry/lsystem.hpp"
#include "tremula/geometry/plants.hpp"
#include "tremula/io/gltf.hpp"
#include "tremula/pipeline.hpp"

namespace tremula {
namespace {

using test::Glb;
using test::SkinPlayer;

constexpr double of_height = 0.005;

// A preset in wind, on bones, and its file. Every vertex has a branch of its own in the file, by which it is
// known again.
struct Plant {
  Subject subject;
  Motion motion;
  Surface surface;
  Rig rig;
  double height = 0;
  Loop loop;

  Plant(const std::string& name, double speed) {
    const Skeleton skeleton = grow(parse_lsystem(find_preset(name).text, name)).skeleton;
    subject = bake(skeleton, {.modes = {.count = 20}});
    Weather weather;
    weather.wind = turbulent_wind({.speed = speed}, 0.2);
    weather.loop = {20, 600};
    motion = set_in_motion(subject, weather);
    surface = mesh_surface(skeleton);
    const Extent box = extent(skeleton);
    height = box.high.z() - box.low.z();
    const ClipSource clip{"wind loop", &motion};
    rig = fit_rig(subject.structure, surface, {&clip, 1}, {.tolerance = of_height * height});
    Surface numbered = surface;
    for (std::size_t i = 0; i < surface.vertex_count(); ++i) numbered.branch[i] = static_cast<int>(i);
    loop.facts.name = name;
    loop.period = motion.period;
    loop.rest = std::make_shared<const Surface>(std::move(numbered));
  }

  std::vector<Vec3> bent(double time) const {
    const SurfaceDelta delta =
        bend_surface(subject.structure, surface, bent_at(subject.structure, motion, time));
    std::vector<Vec3> at;
    for (std::size_t i = 0; i < surface.vertex_count(); ++i)
      at.push_back((surface.position[i] + delta.position[i]).cast<double>());
    return at;
  }
};

std::vector<Vec3> played(const Plant& plant, const Glb& glb, const SkinPlayer& player, double time) {
  std::vector<Vec3> at(plant.surface.vertex_count(), Vec3::Constant(NAN));
  for (std::size_t part = 0; part < plant.surface.parts.size(); ++part) {
    const std::vector<double> number = glb.numbers(glb.primitive(part)["attributes"]["_BRANCH"]);
    const std::vector<Eigen::Vector3d> positions = player.play(part, time);
    for (std::size_t i = 0; i < positions.size(); ++i) at[static_cast<std::size_t>(number[i])] = positions[i];
  }
  return at;
}

// As the file has the skin at rest, to its whole steps.
std::vector<Vec3> standing(const Plant& plant, const Glb& glb) {
  const double step = glb.numbers(glb.document["skins"][0]["inverseBindMatrices"])[0];
  std::vector<Vec3> at(plant.surface.vertex_count());
  for (std::size_t part = 0; part < plant.surface.parts.size(); ++part) {
    const nlohmann::json& attributes = glb.primitive(part)["attributes"];
    const std::vector<double> number = glb.numbers(attributes["_BRANCH"]);
    const std::vector<Eigen::Vector3f> positions = glb.vectors(attributes["POSITION"]);
    for (std::size_t i = 0; i < positions.size(); ++i)
      at[static_cast<std::size_t>(number[i])] = step * test::z_up(positions[i]).cast<double>();
  }
  return at;
}

double longest_edge(const Surface& surface, const std::vector<Vec3>& still, const std::vector<Vec3>& at) {
  const std::vector<std::uint32_t>& corners = surface.parts[0].triangles;
  double longest = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const std::uint32_t a = corners[i], b = corners[i % 3 == 2 ? i - 2 : i + 1];
    const double rest = (still[a] - still[b]).norm();
    if (rest > 1e-3) longest = std::max(longest, (at[a] - at[b]).norm() / rest);
  }
  return longest;
}

double largest_change_of_leaf_area(const Surface& surface, const std::vector<Vec3>& still,
                                   const std::vector<Vec3>& at) {
  const SurfacePart& leaves = surface.parts.at(1);
  const auto area = [&](std::size_t triangle, const auto& place) {
    const std::uint32_t* c = &leaves.triangles[3 * triangle];
    const Vec3 a = place(c[0]), b = place(c[1]), d = place(c[2]);
    return (b - a).cross(d - a).norm();
  };
  double largest = 0;
  for (std::size_t first = 0; first < leaves.triangles.size() / 3; first += leaf_triangle_count) {
    double now = 0, rest = 0;
    for (std::size_t i = first; i < first + leaf_triangle_count; ++i) {
      now += area(i, [&](std::uint32_t v) -> Vec3 { return at[v]; });
      rest += area(i, [&](std::uint32_t v) -> Vec3 { return still[v]; });
    }
    largest = std::max(largest, std::abs(now / rest - 1));
  }
  return largest;
}

struct Case {
  const char* preset;
  double speed;
};
class OnBones : public testing::TestWithParam<Case> {};

TEST_P(OnBones, FollowsThePosesWithinTheToleranceAndStretchesNothing) {
  const Plant plant(GetParam().preset, GetParam().speed);
  const double tolerance = of_height * plant.height;
  EXPECT_LE(plant.rig.largest_error, tolerance);
  const Glb glb(encode_glb(plant.loop, plant.rig));
  const SkinPlayer player(glb);
  const std::vector<Vec3> still = standing(plant, glb);
  for (const double time : {0.0, 1.237, 6.6667, 11.49, 13.3, 17.777}) {
    const std::vector<Vec3> wanted = plant.bent(time), found = played(plant, glb, player, time);
    double off = 0;
    for (std::size_t i = 0; i < wanted.size(); ++i) off = std::max(off, (wanted[i] - found[i]).norm());
    EXPECT_LT(off, 1.05 * tolerance) << time;
    EXPECT_LT(longest_edge(plant.surface, still, found), 1.02) << time;
    EXPECT_LT(largest_change_of_leaf_area(plant.surface, still, found), 0.01) << time;
  }
}

TEST_P(OnBones, ClosesExactlyAndTurnsTheShortWayBetweenKeys) {
  const Plant plant(GetParam().preset, GetParam().speed);
  const Glb glb(encode_glb(plant.loop, plant.rig));
  const SkinPlayer player(glb);
  for (const auto& [node, paths] : player.tracks()) {
    for (const auto& [path, track] : paths) {
      const std::size_t width = path == "rotation" ? 4 : 3, count = track.times.size();
      EXPECT_EQ(track.times.front(), 0);
      EXPECT_EQ(track.times.back(), 20);
      for (std::size_t i = 0; i < width; ++i)
        EXPECT_EQ(track.values[i], track.values[width * (count - 1) + i]);
      if (width == 3) continue;
      for (std::size_t k = 0; k + 1 < count; ++k) {
        double dot = 0;
        for (std::size_t i = 0; i < 4; ++i) dot += track.values[4 * k + i] * track.values[4 * k + 4 + i];
        EXPECT_GT(dot, 0.5) << node;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Presets, OnBones,
                         testing::Values(Case{"sapling", 4}, Case{"sapling", 8}, Case{"sapling", 20},
                                         Case{"oak", 8}, Case{"oak", 20}, Case{"birch", 8},
                                         Case{"willow", 8}),
                         [](const auto& one) {
                           return one.param.preset + std::to_string(static_cast<int>(one.param.speed));
                         });

TEST(EncodeGlb, OnBonesEveryInstanceHasItsOwnPlaceAndTime) {
  Plant plant("sapling", 8);
  plant.loop.instances = {{}, {.position = {3, -2, 0.5}, .turn = 0.7, .scale = 1.5, .time_shift = 7.123}};
  const Glb glb(encode_glb(plant.loop, plant.rig));
  const SkinPlayer first(glb, 0, 0), second(glb, 0, 1);
  const Instance& it = plant.loop.instances[1];
  for (const double time : {0.0, 3.3, 12.8765, 12.8775, 19.99}) {
    const double there = std::fmod(time + it.time_shift, 20);
    const std::vector<Vec3> wanted = played(plant, glb, first, there),
                            found = played(plant, glb, second, time);
    for (std::size_t i = 0; i < wanted.size(); i += 7) {
      EXPECT_LT((it.position + it.scale * (it.rotation() * wanted[i]) - found[i]).norm(), 3e-4 * plant.height)
          << time;
    }
  }
}

TEST(EncodeGlb, OnBonesIsTheSameInFloatsAndPacked) {
  const Plant plant("sapling", 8);
  std::map<MeshCompression, std::vector<Vec3>> forms;
  for (const MeshCompression form :
       {MeshCompression::none, MeshCompression::quantised, MeshCompression::meshopt}) {
    const Glb glb(encode_glb(plant.loop, plant.rig, {.compression = form}));
    EXPECT_EQ(glb.document.contains("extensionsRequired"), form != MeshCompression::none);
    forms[form] = played(plant, glb, SkinPlayer(glb), 4.56);
  }
  for (std::size_t i = 0; i < plant.surface.vertex_count(); ++i) {
    EXPECT_EQ(forms[MeshCompression::quantised][i], forms[MeshCompression::meshopt][i]);
    EXPECT_LT((forms[MeshCompression::quantised][i] - forms[MeshCompression::none][i]).norm(),
              1e-4 * plant.height);
  }
}

// For the page, and for nobody else.
TEST(EncodeGlb, OnBonesTellsShapesInStepsOfTheirOwnWhereAsked) {
  Plant plant("sapling", 8);
  const ClipSource clip{"wind loop", &plant.motion, 8};
  plant.rig = fit_rig(plant.subject.structure, plant.surface, {&clip, 1},
                      {.tolerance = of_height * plant.height, .shapes_of = 0});
  const auto extras = [&](bool shapes) {
    const Glb glb(encode_glb(plant.loop, plant.rig, {.shapes = shapes}));
    return std::pair(glb, glb.document["scenes"][0]["extras"]["tremula"]);
  };
  EXPECT_FALSE(extras(false).second.contains("shapes"));
  const auto [glb, told] = extras(true);
  EXPECT_EQ(told["clips"][0], nlohmann::json({{"name", "wind loop"}, {"wind_speed_m_s", 8.0}}));
  const nlohmann::json& shapes = told["shapes"];
  EXPECT_EQ(shapes["kinds"][0], "lean");
  EXPECT_EQ(shapes["kinds"][1], "mode");
  EXPECT_EQ(shapes["frequencies_hz"][1], plant.motion.basis.frequency[1]);
  const std::vector<double> weights = glb.numbers(shapes["weights"]),
                            turns = glb.numbers(shapes["turns"]["accessor"]);
  const std::size_t count = shapes["kinds"].size(), joints = plant.rig.joints.size();
  ASSERT_EQ(weights.size(), 600 * count);
  ASSERT_EQ(turns.size(), 3 * joints * count);
  for (std::size_t c = 0; c < count; ++c) {
    double farthest = 0;
    for (std::size_t p = 0; p < 600; ++p) farthest = std::max(farthest, std::abs(weights[p * count + c]));
    EXPECT_NEAR(farthest, 1, 1e-6);
    const auto column = static_cast<Eigen::Index>(c);
    const double step = shapes["turns"]["steps"][c].get<double>();
    for (std::size_t j = 0; j < joints; ++j) {
      const double* stored = &turns[3 * (joints * c + j)];
      const Vec3 z_up = step * Vec3(stored[0], -stored[2], stored[1]);
      const Vec3 wanted =
          plant.motion.coordinates.col(column).cwiseAbs().maxCoeff() *
          plant.rig.shapes.turn.col(column).segment<3>(static_cast<Eigen::Index>(3 * j)).cast<double>();
      EXPECT_LT((z_up - wanted).lpNorm<Eigen::Infinity>(), 0.51 * step + 1e-9);
    }
  }
}

TEST(FitRig, OfFewJointsSaysWhatErrorThatCosts) {
  const Plant plant("sapling", 8);
  const ClipSource clip{"wind loop", &plant.motion};
  const Rig few = fit_rig(plant.subject.structure, plant.surface, {&clip, 1},
                          {.tolerance = of_height * plant.height, .max_joints = 9});
  EXPECT_LE(few.joints.size(), 9U);
  EXPECT_GT(few.joints.size(), 4U);
  EXPECT_GT(few.largest_error, plant.rig.largest_error);
}

}  // namespace
}  // namespace tremula
