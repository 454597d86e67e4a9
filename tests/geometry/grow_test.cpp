#include "tremula/geometry/grow.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "complaint.hpp"
#include "support.hpp"

namespace tremula {
namespace {

using ::testing::HasSubstr;

Skeleton grown(const std::string& text, const GrowOptions& options = {}) {
  return grow(parse_lsystem(text, "plant.lsys"), options).skeleton;
}

std::string message_of(const std::string& text, const GrowOptions& options = {}) {
  return test::complaint_of([&] { grown(text, options); });
}

GrowOptions seeded(std::uint64_t seed) { return {.seed = seed}; }

bool same(const Vec3& a, const Vec3& b) { return std::memcmp(a.data(), b.data(), sizeof(double) * 3) == 0; }

bool same(const Skeleton& a, const Skeleton& b) {
  return std::ranges::equal(a.roots, b.roots, [](const Vec3& x, const Vec3& y) { return same(x, y); }) &&
         std::ranges::equal(a.branches, b.branches,
                            [](const Branch& x, const Branch& y) {
                              return x.start_node == y.start_node && same(x.start, y.start) &&
                                     same(x.end, y.end) && x.start_radius == y.start_radius &&
                                     x.end_radius == y.end_radius;
                            }) &&
         std::ranges::equal(a.leaves, b.leaves, [](const Leaf& x, const Leaf& y) {
           return x.branch == y.branch && x.position == y.position && same(x.base, y.base) &&
                  same(x.axis, y.axis) && same(x.normal, y.normal) && x.length == y.length &&
                  x.width == y.width && x.area == y.area && x.mass == y.mass;
         });
}

// Lindenmayer's alga, the first L-system: A -> AB, B -> A. The word after n steps has F(n + 2) letters.
TEST(Grow, RewritesAllLettersInEveryStepAndSoCountsAsFibonacci) {
  const std::string alga = "n = 0\nsteps: n\naxiom: !(0.1) F(1)\nF(l) -> F(l) F(l, 0.1)\nF(l, r) -> F(l)\n";
  int count = 1, next = 2;
  for (int n = 0; n < 20; ++n) {
    EXPECT_EQ(grown(alga, {.constants = {{"n", n}}}).branch_count(), count);
    count = std::exchange(next, count + next);
  }
}

TEST(Grow, DoublesABinaryTreeAtEveryStep) {
  const std::string tree =
      "n = 0\nsteps: n\naxiom: !(0.1) A(1)\nA(l) -> F(l) [ +(30) A(l / 2) ] [ -(30) A(l / 2) ]\n";
  for (int n = 1; n < 12; ++n) {
    const Skeleton skeleton = grown(tree, {.constants = {{"n", n}}});
    EXPECT_EQ(skeleton.branch_count(), (1 << n) - 1);
  }
}

TEST(Grow, DrawsTheAxiomItselfWhenNoStepIsDone) {
  EXPECT_EQ(grown("steps: 0\naxiom: F(1, 0.1) A\nA -> F(1) A\n").branch_count(), 1);
}

TEST(Grow, PlacesBranchesAsComputedByHand) {
  const Skeleton skeleton = grown(
      "steps: 3\n"
      "axiom: !(0.2) F(2, 0.1) A(1)\n"
      "A(n) : n < 3 -> [ +(90) F(n) ] /(90) F(1, 0.1 / (n + 1)) A(n + 1)\n");
  ASSERT_EQ(skeleton.branch_count(), 5);
  const std::vector<Vec3> ends = {{0, 0, 2}, {1, 0, 2}, {0, 0, 3}, {0, -2, 3}, {0, 0, 4}};
  const std::vector<double> end_radii = {0.1, 0.1, 0.05, 0.05, 0.1 / 3};
  for (std::size_t k = 0; k < ends.size(); ++k) {
    EXPECT_LT((skeleton.branches[k].end - ends[k]).norm(), 1e-14) << k;
    EXPECT_DOUBLE_EQ(skeleton.branches[k].end_radius, end_radii[k]) << k;
  }
  EXPECT_EQ(skeleton.branches[0].start_radius, 0.2);
  EXPECT_EQ(skeleton.parent(4), 2);
}

TEST(Grow, TakesOnlyProductionsWhoseConditionHolds) {
  const Skeleton skeleton = grown(
      "steps: 1\naxiom: !(0.1) A(1) A(2) A(3) A(4)\n"
      "A(n) : n == 1 -> F(10)\nA(n) : n > 1 && n < 4 -> F(20 + n)\nA(n) : n > 100 -> F(30)\n");
  ASSERT_EQ(skeleton.branch_count(), 3);  // A(4) stays a bud
  EXPECT_DOUBLE_EQ(skeleton.branches[0].length(), 10);
  EXPECT_DOUBLE_EQ(skeleton.branches[1].length(), 22);
  EXPECT_DOUBLE_EQ(skeleton.branches[2].length(), 23);
}

TEST(Grow, KnowsTheHeightWhereALetterStands) {
  const Skeleton skeleton = grown(
      "steps: 50\naxiom: !(0.1) Up\n"
      "Up : height() < 2.75 -> F(0.5) Up\nUp : height() >= 2.75 -> [ +(90) F(height()) ]\n");
  ASSERT_EQ(skeleton.branch_count(), 7);
  EXPECT_DOUBLE_EQ(skeleton.branches[6].length(), 3);
}

// 0.2, 0.3 and 0.5 written as 2 : 3 : 5, and a fourth whose condition never holds.
TEST(Grow, ChoosesAlternativesWithTheirNormalisedProbabilities) {
  const int letters = 40000;
  const std::string text =
      "steps: 100000\naxiom: !(0.1) A(" + std::to_string(letters) +
      ")\nA(n) : n > 0 -> [ B(n) ] A(n - 1)\n"
      "B(n) -> 2 F(1)\nB(n) : n > 0 -> (1 + 2) F(2)\nB(n) -> 5 F(3)\nB(n) : n < 0 -> 90 F(4)\n";
  const Skeleton skeleton = grown(text);
  ASSERT_EQ(skeleton.branch_count(), letters);
  std::vector<int> count(5, 0);
  for (const Branch& branch : skeleton.branches)
    ++count[static_cast<std::size_t>(std::lround(branch.length()))];
  const std::vector<double> wanted = {0, 0.2, 0.3, 0.5, 0};
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const double p = wanted[i];
    EXPECT_NEAR(count[i], p * letters, 5 * std::sqrt(p * (1 - p) * letters)) << i;
  }
}

TEST(Grow, ChoosesIndependentlyOverSeeds) {
  const LSystem system =
      parse_lsystem("steps: 1\naxiom: !(0.1) A\nA -> 0.3 F(1)\nA -> 0.7 F(2)\n", "plant.lsys");
  const int seeds = 20000;
  int first = 0;
  for (int seed = 0; seed < seeds; ++seed) {
    if (grow(system, seeded(static_cast<std::uint64_t>(seed))).skeleton.branches[0].length() < 1.5) ++first;
  }
  EXPECT_NEAR(first, 0.3 * seeds, 5 * std::sqrt(0.3 * 0.7 * seeds));
}

// The condition of a letter that stays is asked again with other random numbers: it lives n steps with chance
// 1/2^n.
TEST(Grow, AsksALetterThatStaysAgainInTheNextStep) {
  const int letters = 20000;
  std::string text = "steps: 4\naxiom: !(0.1) S\nA : rand(0, 1) < 0.5 -> F(1)\nS ->";
  for (int i = 0; i < letters; ++i) text += " [ A ]";
  const double p = 1 - 1.0 / 8;  // three chances are left after the first step
  EXPECT_NEAR(grown(text).branch_count(), p * letters, 5 * std::sqrt(p * (1 - p) * letters));
}

const char* const random_bush =
    "l = 1\nsteps: 6\naxiom: !(0.1) A(l, 6)\n"
    "A(s, n) : n > 0 -> 0.5 F(s * rand(0.8, 1.2), 0.1 / s) [ +(normal(30, 5)) A(s * 0.7, n - 1) ] A(s * 0.8, "
    "n - 1)\n"
    "A(s, n) : n > 0 -> 0.5 F(s) /(rand(0, 360)) [ &(40) L(0.1, 0.05) A(s * 0.6, n - 1) ] [ ^(30) A(s * 0.9, "
    "n - 1) ]\n";

TEST(Grow, GivesTheSameBytesForTheSameSeedAndAnotherPlantForAnother) {
  EXPECT_TRUE(same(grown(random_bush), grown(random_bush)));
  EXPECT_TRUE(same(grown(random_bush, seeded(77)), grown(random_bush, seeded(77))));
  EXPECT_FALSE(same(grown(random_bush, seeded(77)), grown(random_bush, seeded(78))));
  EXPECT_TRUE(same(grown(random_bush), grown(random_bush, seeded(1))));  // 1 unless the text says otherwise
  EXPECT_TRUE(same(grown(std::string(random_bush) + "seed: 5\n"), grown(random_bush, seeded(5))));
}

TEST(Grow, LeavesOneLimbAsItIsWhenAnotherGrowsDifferently) {
  const std::string rules =
      "steps: 20\naxiom: !(0.1) F(1) [ +(40) Left(first) ] Right(8)\nRight(n) : n > 0 -> F(rand(0.5, 1)) "
      "&(rand(-30, 30)) "
      "Right(n - 1)\nLeft(n) : n > 0 -> F(rand(0.5, 1)) Left(n - 1)\n";
  const Skeleton some = grown("first = 3\n" + rules);
  const Skeleton more = grown("first = 9\n" + rules);
  ASSERT_EQ(some.branch_count(), 12);
  ASSERT_EQ(more.branch_count(), 18);
  for (std::size_t k = 0; k < 8; ++k) EXPECT_TRUE(same(some.branches[4 + k].end, more.branches[10 + k].end));
}

TEST(Grow, OverridesConstantsAndWhatIsComputedFromThem) {
  const std::string text = "a = 2\nb = a * 3\nsteps: 0\naxiom: !(0.1) F(a) F(b)\n";
  const auto lengths = [&](const std::vector<std::pair<std::string, double>>& constants) {
    const Skeleton skeleton = grown(text, {.constants = constants});
    return std::pair(skeleton.branches[0].length(), skeleton.branches[1].length());
  };
  EXPECT_EQ(lengths({}), std::pair(2.0, 6.0));
  EXPECT_EQ(lengths({{"a", 5}}), std::pair(5.0, 15.0));
  EXPECT_EQ(lengths({{"b", 1}}), std::pair(2.0, 1.0));
  EXPECT_THAT(message_of(text, {.constants = {{"c", 1}}}),
              HasSubstr("plant.lsys: no constant 'c', wanted one of its constants: a, b"));
  EXPECT_THAT(message_of(text, {.constants = {{"a", std::nan("")}}}),
              HasSubstr("constant 'a' set to nan, wanted a finite number"));
}

TEST(Grow, DrawsOneValuePerPlantForARandomConstant) {
  const Skeleton skeleton = grown("a = rand(1, 2)\nsteps: 0\naxiom: !(0.1) F(a) F(a)\n");
  EXPECT_DOUBLE_EQ(skeleton.branches[0].length(), skeleton.branches[1].length());
}

TEST(Grow, HandsOutTheColoursAndLeafPropertiesOfTheText) {
  const GrownPlant plant =
      grow(parse_lsystem("steps: 0\naxiom: F(1, 0.1) L(0.2, 0.1)\nleaf_shape_factor: 0.5\n"
                         "leaf_mass_per_area: 2\nleaf_color: 0, 0.5, 1\n",
                         "plant.lsys"));
  EXPECT_FALSE(plant.bark_color.has_value());
  EXPECT_EQ(plant.leaf_color.value(), Eigen::Vector3f(0, 0.5F, 1));
  EXPECT_DOUBLE_EQ(plant.skeleton.leaves[0].area, 0.01);
  EXPECT_DOUBLE_EQ(plant.skeleton.leaves[0].mass, 0.02);
}

TEST(Grow, ComputesPipeRadiiFromTheTips) {
  const Skeleton skeleton = grown(
      "steps: 0\nradius: pipe\ntip_radius: 0.01\npipe_exponent: 2\naxiom: F(1) [ +(30) F(1) ] [ -(30) "
      "!(0.02) F(1) ]\n");
  EXPECT_NEAR(skeleton.branches[0].start_radius, std::sqrt(0.01 * 0.01 + 0.02 * 0.02), 1e-15);
}

struct BadGrowth {
  std::string text;
  const char* message;
};

TEST(Grow, RefusesPlantsThatCannotBeWithTheirPlace) {
  const std::vector<BadGrowth> plants = {
      {"steps: 0\naxiom: F(0, 1)", "plant.lsys:2: length of F is 0, wanted 1e-06 to 10000"},
      {"steps: 0\naxiom: F(-1, 1)", "plant.lsys:2: length of F is -1, wanted"},
      {"steps: 0\naxiom: F(1e-300, 1)", "length of F is 1e-300, wanted"},
      {"steps: 0\naxiom: F(1, 0)", "radius of F is 0, wanted"},
      {"steps: 0\naxiom: !(-0.1) F(1)", "radius of ! is -0.1, wanted"},
      {"steps: 0\naxiom: F(1)", "plant.lsys:2: F without a radius, wanted !(radius) before it"},
      {"steps: 0\naxiom: F(1, 1) f(1) F(1)", "plant.lsys:2: f within the plant, wanted F"},
      {"steps: 0\naxiom: L(1, 1)", "plant.lsys:2: a leaf on the ground, wanted an F before it"},
      {"steps: 0\naxiom: F(1, 1) L(0, 1)", "leaf length of L is 0, wanted"},
      {"steps: 0\naxiom: F(1, 1) L(1, -1)", "leaf width of L is -1, wanted"},
      {"steps: 0\naxiom: F(1, 1) L(1, 1, -1)", "petiole length of L is -1, wanted 0 to"},
      {"steps: 0\naxiom: F(1, 1) L(1, 1, 0, 1.5)", "leaf position of L is 1.5, wanted 0 to 1"},
      {"steps: 0\naxiom: T(3, 0, 0, 0) F(1, 1)", "a tropism vector of length 0, wanted a direction"},
      {"steps: 0\naxiom: +(1e300) F(1, 1)", "angle of + is 1e+300, wanted"},
      {"steps: 0\naxiom: F(1 / 0, 1)", "plant.lsys:2: '1 / 0' is not finite, wanted a finite number"},
      {"steps: 1\naxiom: A(0)\n\nA(n) ->\n  F(1 / n, 1)",
       "plant.lsys:5: '1 / n' is not finite where parameter 1 is 0"},
      {"steps: 1\naxiom: A\nA -> -(3)",
       "plant.lsys: a plant without a branch after 1 steps, wanted at least one F"},
      {"steps: 1\naxiom: A\nA -> (-1) F(1, 1)", "plant.lsys:3: probability -1, wanted 0 or more"},
      {"steps: 1\naxiom: A\nA -> 0 F(1, 1)",
       "plant.lsys:3: probabilities that add up to 0, wanted one above 0"},
      {"steps: -1\naxiom: F(1, 1)", "plant.lsys:1: steps is -1, wanted 0 to 100000"},
      {"steps: 1e9\naxiom: F(1, 1)", "plant.lsys:1: steps is 1e+09, wanted"},
      {"steps: 0\naxiom: F(1)\ntip_radius: 0", "plant.lsys:3: tip_radius is 0, wanted"},
      {"steps: 0\naxiom: F(1)\nradius: pipe\ntip_radius: 1\npipe_exponent: 0",
       "pipe_exponent is 0, wanted 1 to 5"},
      {"steps: 0\naxiom: F(1, 1)\nbark_color: 0, 0, 2", "plant.lsys:3: bark_color is 2, wanted 0 to 1"},
      {"steps: 0\naxiom: F(1, 1)\nleaf_mass_per_area: -1", "leaf_mass_per_area is -1, wanted"},
      {"steps: 100000\naxiom: !(1) A\nA -> F(9999) A", "m from the origin, wanted at most 100000"},
  };
  for (const BadGrowth& plant : plants)
    EXPECT_THAT(message_of(plant.text), HasSubstr(plant.message)) << plant.text;
}

// 1+1+…: `terms` ones.
std::string long_sum(int terms) {
  std::string sum = "1";
  for (int i = 1; i < terms; ++i) sum += "+1";
  return sum;
}

TEST(Grow, RefusesRunawayGrowthAtItsLimits) {
  const GrowLimits limits = {
      .letters = 100'000, .terms = 1'000'000, .branches = 1000, .leaves = 2000, .nesting = 50};
  const std::vector<BadGrowth> plants = {
      {"steps: 1000\naxiom: A\nA -> A A", "plant.lsys:3: more than 100000 letters, the last in step"},
      {"steps: 100000\naxiom: A\nA -> A [ A A ]", "more than 100000 letters"},
      {"steps: 100000\naxiom: !(0.1) A\nA -> F(0.01) A",
       "plant.lsys:3: more branches than 1000, wanted a plant of fewer"},
      {"steps: 100000\naxiom: F(1, 1) A\nA -> L(1, 1) A A", "more leaves than 2000, wanted a plant of fewer"},
      {"steps: 100000\naxiom: A\nA -> [ A ]",
       "plant.lsys:3: '[' nested more than 50 deep, wanted a plant of less"},
      // 60 000 letters, each of which costs more than a letter should: in an argument, a condition, a weight.
      {"steps: 60000\naxiom: A(1)\nA(n) -> A(" + long_sum(100) + ")",
       "plant.lsys:3: more than 1000000 terms of expressions to work out, wanted fewer steps"},
      {"steps: 60000\naxiom: A\nA : " + long_sum(100) + " > 0 -> A", "more than 1000000 terms"},
      {"steps: 60000\naxiom: A\nA -> (" + long_sum(100) + ") A", "more than 1000000 terms"},
  };
  for (const BadGrowth& plant : plants) {
    EXPECT_THAT(message_of(plant.text, {.limits = limits}), HasSubstr(plant.message)) << plant.text;
  }
}

TEST(Grow, HasLimitsThatEndRunawayGrowthUnasked) {
  EXPECT_THAT(message_of("steps: 100000\naxiom: !(0.1) A\nA -> F(0.01) A A"),
              HasSubstr("more branches than 1000000"));
}

// Ten million letters would be within the limit of letters; with a thousand terms each they would take
// minutes.
TEST(Grow, EndsWithinSecondsHoweverLongItsExpressionsAre) {
  TREMULA_NEED_DATA("cases/grows_without_end__spins.lsys");
  std::ostringstream text;
  text << std::ifstream(test::data_folder() / "cases/grows_without_end__spins.lsys").rdbuf();
  const auto begun = std::chrono::steady_clock::now();
  EXPECT_THAT(message_of(text.str()), HasSubstr("plant.lsys:3: more than 200000000 terms of expressions"));
  EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::seconds(100))
      << "a hundred times too slow";
}

TEST(Grow, GrowsADeepPlantWithoutRecursion) {
  EXPECT_EQ(grown("steps: 90000\naxiom: !(0.1) A\nA -> F(0.001) [ A ]\n").branch_count(), 90000);
}

TEST(Grow, DrawsTubesWithTheWallThatTheThirdNumberOfFSays) {
  const GrownPlant plant = grow(
      parse_lsystem("axiom: !(0.03) F(1, 0.02, 0.005) F(0.02, 0.02) F(1, 0.01, 0.01)\nsteps: 0\n", "tube"),
      {});
  const std::vector<Branch>& branches = plant.skeleton.branches;
  ASSERT_EQ(branches.size(), 3U);
  EXPECT_DOUBLE_EQ(branches[0].wall, 0.25);
  EXPECT_EQ(branches[1].wall, 1);  // a node: the wall across the tube
  EXPECT_EQ(branches[2].wall, 1);
}

TEST(Grow, RefusesAWallThickerThanTheRadius) {
  EXPECT_EQ(test::complaint_of(
                [] { grow(parse_lsystem("axiom: !(0.03) F(1, 0.02, 0.021)\nsteps: 0\n", "tube"), {}); }),
            "tube:1: wall of F is 0.021, wanted 1e-07 to 0.02");
}

TEST(HabitatOf, IsWhatTheTextSaysAndAirWhereItSaysNothing) {
  const std::string text = "h = 3\naxiom: !(0.1) F(1)\nsteps: 1\n";
  EXPECT_FALSE(habitat_of(parse_lsystem(text, "plant")).in_water);
  const LSystem wet = parse_lsystem(
      text + "medium: water\nmaterial: scots-pine\ncurrent: h / 10\nwater_depth: 2 * h\n", "plant");
  const Habitat habitat = habitat_of(wet, {.constants = {{"h", 4}}});
  EXPECT_TRUE(habitat.in_water);
  EXPECT_EQ(habitat.material, "scots-pine");
  EXPECT_NEAR(habitat.current, 0.4, 1e-12);
  EXPECT_NEAR(habitat.water_depth, 8, 1e-12);
  EXPECT_THROW(habitat_of(wet, {.constants = {{"h", -1}}}), InputError);
}

}  // namespace
}  // namespace tremula
