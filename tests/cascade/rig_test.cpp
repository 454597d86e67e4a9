// Presets on bones, as their .glb is played, against the poses of the program.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "io/glb_skin.hpp"
#include "support.hpp"
#include "tremula/deformation/bent_pose.hpp"
#include "tremula/deformation/fit_rig.hpp"
#include "tremula/geometry/grow.hpp"
#include "tremula/geometry/lsystem.hpp"
#include "tremula/geometry/plants.hpp"
#include "tremula/io/gltf.hpp"
#include "tremula/io/skeleton_files.hpp"
#include "tremula/pipeline.hpp"

namespace tremula {
namespace {

using test::Glb;
using test::SkinPlayer;

constexpr double of_height = 0.005;

// A plant in one wind or several, on bones, and its file. Every vertex has a branch of its own in the file,
// by which it is known again.
struct Plant {
  Subject subject;
  std::vector<Motion> motions;
  Surface surface;
  Rig rig;
  double height = 0;
  Loop loop;

  Plant(const std::string& name, const Skeleton& skeleton, const std::vector<double>& speeds) {
    subject = bake(skeleton, {.modes = {.count = 20}});
    surface = mesh_surface(skeleton, {.max_sides = 6});
    const Extent box = extent(skeleton);
    height = box.high.z() - box.low.z();
    for (const double speed : speeds) {
      Weather weather;
      weather.wind = turbulent_wind({.speed = speed}, 0.2);
      weather.loop = {20, 600};
      motions.push_back(set_in_motion(subject, weather));
    }
    rig = fit_rig(subject.structure, surface, clips(), {.tolerance = of_height * height});
    Surface numbered = surface;
    for (std::size_t i = 0; i < surface.vertex_count(); ++i) numbered.branch[i] = static_cast<int>(i);
    loop.facts.name = name;
    loop.period = motions[0].period;
    loop.rest = std::make_shared<const Surface>(std::move(numbered));
  }

  Plant(const std::string& preset, double speed) : Plant(preset, grown(preset), {speed}) {}

  static Skeleton grown(const std::string& preset) {
    return grow(parse_lsystem(find_preset(preset).text, preset)).skeleton;
  }

  std::vector<ClipSource> clips() const {
    std::vector<ClipSource> sources;
    for (const Motion& motion : motions)
      sources.push_back({"clip " + std::to_string(sources.size()), &motion});
    return sources;
  }

  std::vector<Vec3> bent(double time) const {
    const SurfaceDelta delta =
        bend_surface(subject.structure, surface, bent_at(subject.structure, motions[0], time));
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
  if (surface.parts.size() < 2) return 0;
  const SurfacePart& leaves = surface.parts[1];
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

void expect_to_follow(const Plant& plant, const Glb& glb, const SkinPlayer& player) {
  const double tolerance = of_height * plant.height;
  EXPECT_LE(plant.rig.largest_error, tolerance);
  const std::vector<Vec3> still = standing(plant, glb);
  for (const double time : {0.0, 1.237, 6.6667, 13.3, 17.777}) {
    const std::vector<Vec3> wanted = plant.bent(time), found = played(plant, glb, player, time);
    double off = 0;
    for (std::size_t i = 0; i < wanted.size(); ++i) off = std::max(off, (wanted[i] - found[i]).norm());
    EXPECT_LT(off, 1.05 * tolerance) << time;
    EXPECT_LT(longest_edge(plant.surface, still, found), 1.02) << time;
    EXPECT_LT(largest_change_of_leaf_area(plant.surface, still, found), 0.01) << time;
  }
}

void expect_to_close_and_turn_the_short_way(const SkinPlayer& player) {
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

void expect_to_bend_well(const Plant& plant) {
  const Glb glb(encode_glb(plant.loop, plant.rig));
  const SkinPlayer player(glb);
  expect_to_follow(plant, glb, player);
  expect_to_close_and_turn_the_short_way(player);
}

struct Case {
  const char* plant;
  double speed;
};
void PrintTo(const Case& one, std::ostream* out) { *out << one.plant << " at " << one.speed << " m/s"; }

class OnBones : public testing::TestWithParam<Case> {};

TEST_P(OnBones, FollowsThePosesStretchesNothingClosesAndTurnsTheShortWay) {
  expect_to_bend_well({GetParam().plant, GetParam().speed});
}

INSTANTIATE_TEST_SUITE_P(
    Presets, OnBones,
    testing::Values(Case{"sapling", 4}, Case{"sapling", 8}, Case{"sapling", 14}, Case{"sapling", 20},
                    Case{"oak", 8}, Case{"oak", 14}, Case{"oak", 20}, Case{"birch", 8}, Case{"birch", 14},
                    Case{"birch", 20}, Case{"willow", 8}, Case{"willow", 14}, Case{"willow", 20}),
    [](const auto& one) { return one.param.plant + std::to_string(static_cast<int>(one.param.speed)); });

class ScanOnBones : public testing::TestWithParam<Case> {};

TEST_P(ScanOnBones, FollowsThePosesStretchesNothingClosesAndTurnsTheShortWay) {
  TREMULA_NEED_DATA(GetParam().plant);
  const Skeleton scan = read_skeleton((test::data_folder() / GetParam().plant).string()).skeleton;
  expect_to_bend_well({"scan", scan, {GetParam().speed}});
}

INSTANTIATE_TEST_SUITE_P(Data, ScanOnBones,
                         testing::Values(Case{"qsm/rtwig_sapling_simpleforest.csv", 8},
                                         Case{"qsm/rtwig_sapling_simpleforest.csv", 20},
                                         Case{"qsm/itsme_tree_treeqsm_v200.mat", 8},
                                         Case{"qsm/itsme_tree_treeqsm_v200.mat", 20}));

// How far, at most, fading from one pose to another takes the vertices of every joint off the straight way.
// Joints that turn by a_k, evenly along the fade, bend the way of a point by the second derivative of its
// position: the sum over pairs of them of a_i a_k times how far beyond the later of the two it sits; and
// where the joints move as well, by twice what carries them turns, times that.
struct WayBend {
  double angle = 0, at_joint = 0, beyond = 0;  // (rad), [m], the latter for each metre beyond the joint

  WayBend then(double turned, double moved, double length) const {
    return {angle + turned, at_joint + beyond * length + 2 * angle * moved,
            beyond + turned * (2 * angle + turned)};
  }
};

// Of every joint of a skin: its node, and how the way of what it carries bends.
std::map<std::size_t, WayBend> way_bends(const Glb& glb, const SkinPlayer& one, const SkinPlayer& two,
                                         double time) {
  std::map<std::size_t, WayBend> bends;
  const std::vector<int>& parents = one.parents();
  const auto bend_of = [&](const auto& self, std::size_t node) -> WayBend {
    const auto known = bends.find(node);
    if (known != bends.end()) return known->second;
    const SkinPlayer::Pose a = one.pose(node, time), b = two.pose(node, time);
    const WayBend below = parents[node] < 0 ? WayBend{} : self(self, static_cast<std::size_t>(parents[node]));
    const double length = std::max(a.translation.norm(), b.translation.norm());
    return bends[node] =
               below.then(a.turn.angularDistance(b.turn), (a.translation - b.translation).norm(), length);
  };
  for (const nlohmann::json& joint : glb.document["skins"][0]["joints"])
    bend_of(bend_of, joint.get<std::size_t>());
  return bends;
}

class CrossFade : public testing::TestWithParam<const char*> {};

TEST_P(CrossFade, OfTwoClipsStaysBetweenThem) {
  const Plant plant(GetParam(), Plant::grown(GetParam()), {2, 16});
  const Glb glb(encode_glb(plant.loop, plant.rig));
  const SkinPlayer calm(glb, 0), gale(glb, 1);
  const std::vector<Vec3> still = standing(plant, glb);
  const double slack = 1e-4 * plant.height;
  for (const double time : {3.21, 14.5}) {
    const std::map<std::size_t, WayBend> bends = way_bends(glb, calm, gale, time);
    const std::vector<Vec3> from = played(plant, glb, calm, time), to = played(plant, glb, gale, time);
    for (const auto fade : {SkinPlayer::Fade::even, SkinPlayer::Fade::straight}) {
      for (const double weight : {0.0, 0.25, 0.5, 0.75, 1.0}) {
        SkinPlayer both(glb, 0);
        both.fade(gale, weight, fade);
        for (const auto& [node, bend] : bends) {
          const Eigen::Quaterniond a = calm.pose(node, time).turn, b = gale.pose(node, time).turn,
                                   turn = both.pose(node, time).turn;
          EXPECT_GT(a.dot(b), 0.5) << "engines that mind no signs go the long way";
          EXPECT_NEAR(a.angularDistance(turn) + turn.angularDistance(b), a.angularDistance(b), 1e-6);
        }
        const std::vector<Vec3> at = played(plant, glb, both, time);
        EXPECT_LT(longest_edge(plant.surface, still, at), 1.02) << time << " " << weight;
        EXPECT_LT(largest_change_of_leaf_area(plant.surface, still, at), 0.01) << time << " " << weight;
        if (fade == SkinPlayer::Fade::straight) continue;
        double off = 0;
        for (std::size_t i = 0; i < at.size(); ++i) {
          double bend = 0;
          for (std::size_t n = 0; n < 4; ++n) {
            const JointShares& shares = plant.rig.shares[i];
            const std::size_t j = shares.joint[n];
            const WayBend& way = bends.at(glb.document["skins"][0]["joints"][j].get<std::size_t>());
            const double beyond =
                (plant.surface.position[i].cast<double>() - plant.rig.joints[j].position).norm();
            bend += shares.share[n] / 255.0 * (way.at_joint + way.beyond * beyond);
          }
          const double straight = (at[i] - (1 - weight) * from[i] - weight * to[i]).norm();
          off = std::max(off, straight - 0.5 * weight * (1 - weight) * bend);
        }
        EXPECT_LT(off, slack) << time << " " << weight;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Presets, CrossFade, testing::Values("sapling", "oak"));

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
  const ClipSource clip{"wind loop", &plant.motions[0], 8};
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
  EXPECT_EQ(shapes["frequencies_hz"][1], plant.motions[0].basis.frequency[1]);
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
          plant.motions[0].coordinates.col(column).cwiseAbs().maxCoeff() *
          plant.rig.shapes.turn.col(column).segment<3>(static_cast<Eigen::Index>(3 * j)).cast<double>();
      EXPECT_LT((z_up - wanted).lpNorm<Eigen::Infinity>(), 0.51 * step + 1e-9);
    }
  }
}

TEST(FitRig, OfFewJointsSaysWhatErrorThatCosts) {
  const Plant plant("sapling", 8);
  const Rig few = fit_rig(plant.subject.structure, plant.surface, plant.clips(),
                          {.tolerance = of_height * plant.height, .max_joints = 9});
  EXPECT_LE(few.joints.size(), 9U);
  EXPECT_GT(few.joints.size(), 4U);
  EXPECT_GT(few.largest_error, plant.rig.largest_error);
}

}  // namespace
}  // namespace tremula
