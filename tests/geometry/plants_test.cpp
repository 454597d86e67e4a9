#include "tremula/geometry/plants.hpp"

#include "tremula/geometry/grow.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "complaint.hpp"
#include "support.hpp"

namespace tremula {
namespace {

GrownPlant grow_preset(const std::string& name, std::uint64_t seed) {
  return grow(parse_lsystem(find_preset(name).text, name), {.seed = seed});
}

struct Range {
  double low, high;
  bool has(double x) const { return x >= low && x <= high; }
};

// What docs/guide/growing.md says of them.
struct Stated {
  Range height;  // [m]
  Range branches, leaves;
  Range slenderness;  // height / diameter at the base
  int roots;
};

const std::map<std::string, Stated> stated = {
    {"sapling", {{1.9, 2.5}, {70, 120}, {180, 330}, {70, 110}, 1}},
    {"oak", {{6, 8.5}, {4000, 6000}, {7500, 11000}, {20, 32}, 1}},
    {"birch", {{9, 10.5}, {4000, 6000}, {8000, 11000}, {55, 80}, 1}},
    {"willow", {{5.5, 8.5}, {3800, 6000}, {7500, 11500}, {32, 50}, 1}},
    {"bamboo", {{3.5, 5}, {700, 1200}, {1200, 2000}, {140, 300}, 9}},
    {"bamboo-2942", {{7, 10.5}, {2942, 2942}, {2000, 6000}, {75, 120}, 1}},
    {"kelp", {{5, 7.5}, {700, 1150}, {340, 570}, {150, 250}, 6}},
    {"seagrass", {{0.45, 0.65}, {700, 1000}, {700, 1000}, {220, 330}, 40}},
    {"algae", {{0.65, 0.95}, {324, 324}, {198, 198}, {38, 56}, 9}},
    {"stam-17", {{1.2, 1.9}, {17, 17}, {0, 0}, {50, 95}, 1}},
    {"stam-55", {{1.8, 2.9}, {55, 55}, {0, 0}, {45, 80}, 1}},
    {"stam-62", {{1.9, 3.0}, {62, 62}, {0, 0}, {45, 80}, 1}},
    {"stam-212", {{3.0, 4.6}, {212, 212}, {0, 0}, {40, 70}, 1}},
    {"stam-692", {{4.5, 6.6}, {692, 692}, {0, 0}, {35, 60}, 1}},
    {"stam-2257", {{6.5, 9.5}, {2257, 2257}, {0, 0}, {30, 55}, 1}},
};

TEST(PlantPresets, AreTheStatedOnesEachWithALineThatSaysWhatItIs) {
  std::vector<std::string> names;
  for (const PlantPreset& preset : plant_presets()) {
    names.push_back(preset.name);
    EXPECT_FALSE(preset.description.empty());
    EXPECT_TRUE(preset.text.starts_with("# " + preset.description + "\n"));
    EXPECT_EQ(preset.text.find('@'), std::string::npos);
    EXPECT_EQ(find_preset(preset.name).text, preset.text);
  }
  std::ranges::sort(names);
  std::vector<std::string> wanted;
  for (const auto& [name, plant] : stated) wanted.push_back(name);
  EXPECT_EQ(names, wanted);
}

TEST(PlantPresets, AreListedWhereOneIsAskedForThatIsNotThere) {
  const std::string complaint = test::complaint_of([] { find_preset("baobab"); });
  EXPECT_THAT(complaint, testing::HasSubstr("'baobab', wanted one of "));
  for (const auto& [name, plant] : stated) EXPECT_THAT(complaint, testing::HasSubstr(name));
}

TEST(PlantPresets, KeepTheirStatedHeightCountsAndSlendernessForManySeeds) {
  for (const auto& [name, plant] : stated) {
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
      const Skeleton skeleton = grow_preset(name, seed).skeleton;  // has passed check_skeleton
      SCOPED_TRACE(name + ", seed " + std::to_string(seed));
      double height = 0;
      for (const Branch& branch : skeleton.branches) height = std::max(height, branch.end.z());
      const double slenderness = height / (2 * skeleton.branches[0].start_radius);
      EXPECT_TRUE(plant.height.has(height)) << height;
      EXPECT_TRUE(plant.branches.has(skeleton.branch_count())) << skeleton.branch_count();
      EXPECT_TRUE(plant.leaves.has(static_cast<double>(skeleton.leaves.size()))) << skeleton.leaves.size();
      EXPECT_TRUE(plant.slenderness.has(slenderness)) << slenderness;
      EXPECT_EQ(skeleton.root_count(), plant.roots);
    }
  }
}

TEST(PlantPresets, StandOnTheGroundAndStayAboveIt) {
  for (const auto& [name, plant] : stated) {
    const Skeleton skeleton = grow_preset(name, 3).skeleton;
    for (const Vec3& root : skeleton.roots) EXPECT_NEAR(root.z(), 0, 1e-12) << name;
    for (const Branch& branch : skeleton.branches) EXPECT_GT(branch.end.z(), 0) << name;
    for (const Leaf& leaf : skeleton.leaves) EXPECT_GT(leaf.base.z(), -1e-12) << name;
  }
}

TEST(PlantPresets, CarryLeavesWithUprightFaces) {
  for (const auto& [name, plant] : stated) {
    const Skeleton skeleton = grow_preset(name, 2).skeleton;
    for (const Leaf& leaf : skeleton.leaves) {
      ASSERT_NEAR(leaf.axis.norm(), 1, 1e-12);
      ASSERT_NEAR(leaf.normal.norm(), 1, 1e-12);
      ASSERT_NEAR(leaf.axis.dot(leaf.normal), 0, 1e-12);
      ASSERT_GT(leaf.mass, 0);
    }
  }
}

// r_parent^d = sum of r_child^d with one d for the whole plant, between 2 and 2.5 for all that follow the
// pipe model.
TEST(PlantPresets, ObeyLeonardosRuleAtEveryFork) {
  for (const auto& [name, plant] : stated) {
    const LSystem system = parse_lsystem(find_preset(name).text, name);
    if (!system.pipe_radii) continue;
    const double exponent = evaluate(system.pipe_exponent, {}, name);
    EXPECT_TRUE((Range{2, 2.5}.has(exponent))) << name;
    const Skeleton skeleton = grow(system).skeleton;
    std::vector<double> pipes(skeleton.branches.size(), 0.0);
    for (int k = 0; k < skeleton.branch_count(); ++k) {
      const Branch& branch = skeleton.branches[static_cast<std::size_t>(k)];
      EXPECT_GE(branch.start_radius, branch.end_radius);
      if (skeleton.parent(k) >= 0) {
        pipes[static_cast<std::size_t>(skeleton.parent(k))] += std::pow(branch.start_radius, exponent);
      }
    }
    for (std::size_t k = 0; k < pipes.size(); ++k) {
      if (pipes[k] == 0) continue;
      EXPECT_NEAR(std::pow(skeleton.branches[k].end_radius, exponent) / pipes[k], 1, 1e-12)
          << name << " " << k;
    }
  }
}

TEST(PlantPresets, AreDifferentPlantsForDifferentSeedsAndTheSameForTheSame) {
  for (const auto& [name, plant] : stated) {
    const Skeleton first = grow_preset(name, 1).skeleton, again = grow_preset(name, 1).skeleton;
    const Skeleton other = grow_preset(name, 2).skeleton;
    ASSERT_EQ(first.branch_count(), again.branch_count());
    EXPECT_EQ(first.branches.back().end, again.branches.back().end) << name;
    EXPECT_NE(first.branches.back().end, other.branches.back().end) << name;
  }
}

TEST(StamTree, HasExactlyAsManyBranchesAsItIsToldWhateverTheNumberAndSeed) {
  const LSystem system = parse_lsystem(find_preset("stam-17").text, "stam");
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    for (int n = 1; n <= 150; ++n) {
      const GrownPlant plant = grow(system, {.seed = seed, .constants = {{"N", n}}});
      ASSERT_EQ(plant.skeleton.branch_count(), n) << seed;
    }
  }
  EXPECT_EQ(grow(system, {.constants = {{"N", 200000}}}).skeleton.branch_count(), 200000);
}

TEST(GrowingGuide, ShowsPlantsThatGrow) {
  std::ifstream file(test::source_folder() / "docs/guide/growing.md");
  std::stringstream guide;
  guide << file.rdbuf();
  const std::string text = guide.str(), fence = "```lsys\n";
  std::vector<int> branches;
  for (auto begin = text.find(fence); begin != std::string::npos; begin = text.find(fence, begin)) {
    begin += fence.size();
    const std::string example = text.substr(begin, text.find("```", begin) - begin);
    branches.push_back(grow(parse_lsystem(example, "growing.md")).skeleton.branch_count());
  }
  // Six pieces; eight with shoots of 8, 7, ... 1; and the rowan
  ASSERT_EQ(branches.size(), 3U);
  EXPECT_EQ(branches[0], 6);
  EXPECT_EQ(branches[1], 8 + 8 * 9 / 2);
  EXPECT_GT(branches[2], 80);
}

TEST(Bamboo, HasExactly2942BranchesWhateverTheSeed) {
  for (std::uint64_t seed = 1; seed <= 12; ++seed)
    EXPECT_EQ(grow_preset("bamboo-2942", seed).skeleton.branch_count(), 2942) << seed;
}

// One culm: tubes of one share of their radius, with a solid piece after each, and twigs that are solid.
TEST(Bamboo, IsACulmOfTubesWithNodesBetweenThem) {
  const Skeleton skeleton = grow_preset("bamboo-2942", 1).skeleton;
  ASSERT_EQ(skeleton.root_count(), 1);
  int tubes = 0;
  for (int k = 0; k < skeleton.branch_count(); ++k) {
    const Branch& branch = skeleton.branches[static_cast<std::size_t>(k)];
    if (branch.wall == 1) continue;
    ++tubes;
    EXPECT_NEAR(branch.wall, 0.2, 1e-12);
    const int below = skeleton.parent(k);
    if (below >= 0) {
      EXPECT_EQ(skeleton.branches[static_cast<std::size_t>(below)].wall, 1);
    }
  }
  EXPECT_EQ(tubes, 34);
  double wall = 1;
  for (const Branch& branch : grow_preset("bamboo", 1).skeleton.branches) wall = std::min(wall, branch.wall);
  EXPECT_NEAR(wall, 0.25, 1e-12);
}

}  // namespace
}  // namespace tremula
