#include "tremula/structure/load_margin.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "complaint.hpp"
#include "trees.hpp"
#include "tremula/base/error.hpp"
#include "tremula/structure/prestress.hpp"
#include "tremula/structure/structure.hpp"

namespace tremula {
namespace {

using std::numbers::pi;

const Material wood{"wood", 9e9, 7e8, 950, ""};

LoadMargin margin_of(const Skeleton& skeleton, const StructureOptions& options) {
  const BeamTree tree = assemble_tree(skeleton, options);
  return load_margin(tree, geometric_stiffness(tree, weight(skeleton, options)));
}

// q L^3 / EI at which a round stem of one radius buckles under its weight.
double greenhill(int pieces, const Vec3& direction = Vec3::UnitZ()) {
  const double length = 2, r = 0.01;
  const double load = wood.density * 9.81 * pi * r * r,
               bending = wood.youngs_modulus * pi / 4 * std::pow(r, 4);
  return margin_of(test::straight_stem(pieces, length, r, r, direction), {.material = wood}).factor * load *
         std::pow(length, 3) / bending;
}

// Rods (the same number to more digits): a uniform column under its own weight, Greenhill 1881.
TEST(LoadMargin, OfAUniformStemIsGreenhillsToTheFourthOrderInThePieces) {
  const double exact = 7.837347437214014;
  EXPECT_NEAR(greenhill(8) / exact, 1, 1e-4);
  EXPECT_NEAR(greenhill(32) / exact, 1, 1e-7);
  const double order = std::log2((greenhill(4) - exact) / (greenhill(8) - exact));
  EXPECT_NEAR(order, 4, 0.2);
}

// int F phi^2 with phi = sin: P = pi^2 EI / 4 L^2 (Euler).
TEST(LoadMargin, OfALoadOnTheTipOfAStemIsEulers) {
  const double length = 2, r = 0.01;
  const Skeleton stem = test::straight_stem(16, length, r, r);
  const BeamTree tree = assemble_tree(stem, {.material = wood});
  const DeadLoads loads{std::vector<Vec3>(16, Vec3::Zero()), {{15, 1, Vec3(0, 0, -1)}}};
  const double euler = pi * pi * wood.youngs_modulus * pi / 4 * std::pow(r, 4) / (4 * length * length);
  EXPECT_NEAR(load_margin(tree, geometric_stiffness(tree, loads)).factor / euler, 1, 1e-5);
}

// A rigid stem on a spring falls over where the spring's stiffness is the moment of the weight.
TEST(LoadMargin, OfARigidStemOnASpringIsThatOfTheSpring) {
  const Material stone{"stone", 1e20, 1e20, 2500, ""};
  const Skeleton stem = test::straight_stem(3, 2, 0.1, 0.1);
  const double moment = stone.density * 9.81 * pi * 0.01 * 2 * 1;
  for (const double stiffness : {1e3, 1e5}) {
    const LoadMargin margin = margin_of(stem, {.material = stone, .root = {.rotation = stiffness}});
    EXPECT_NEAR(margin.factor / (stiffness / moment), 1, 1e-8);
    EXPECT_EQ(margin.branch, 0);
  }
}

TEST(LoadMargin, OfWhatHangsIsInfinite) {
  EXPECT_TRUE(std::isinf(greenhill(12, -Vec3::UnitZ())));
  EXPECT_TRUE(std::isinf(margin_of(test::straight_stem(4, 1, 0.1, 0.1), {.gravity = 0}).factor));
}

TEST(LoadMargin, GrowsInProportionToTheModuliAndFallsWithGravity) {
  const Skeleton tree = test::awkward_tree();
  const double margin = margin_of(tree, {.material = wood}).factor;
  Material stiff = wood;
  stiff.youngs_modulus *= 3, stiff.shear_modulus *= 3;
  EXPECT_NEAR(margin_of(tree, {.material = stiff}).factor / margin, 3, 1e-7);
  EXPECT_NEAR(margin_of(tree, {.material = wood, .gravity = 2 * 9.81}).factor / margin, 0.5, 1e-8);
}

// The sweep's pivots are the second method.
TEST(LoadMargin, IsWhereThePivotsOfTheSweepStopBeingPositive) {
  for (const std::uint64_t seed : {3, 5, 8}) {
    const Skeleton skeleton = test::random_tree(60, seed);
    StructureOptions options{.material = wood};
    const double margin = margin_of(skeleton, options).factor;
    for (const auto& [factor, stands] : {std::pair{1 - 1e-7, true}, std::pair{1 + 1e-7, false}}) {
      options.gravity = 9.81 * margin * factor;
      BeamTree tree = assemble_tree(skeleton, options);
      EXPECT_EQ(take_load(geometric_stiffness(tree, weight(skeleton, options)), tree), stands) << seed;
    }
  }
}

TEST(LoadMargin, IsToldByTheStructureAndThereIsNoneWithoutGravity) {
  const Skeleton tree = test::awkward_tree();
  EXPECT_EQ(assemble(tree, {.material = wood}).find_load_margin().factor,
            margin_of(tree, {.material = wood}).factor);
  EXPECT_TRUE(std::isinf(assemble(tree, test::weightless()).find_load_margin().factor));
}

TEST(Assemble, RefusesAPlantThatCannotCarryItsWeightAndNamesTheStiffnessThatWould) {
  Skeleton skeleton = test::straight_stem(2, 1, 0.05, 0.05);
  skeleton.branches.push_back(test::make_branch(2, Vec3(0, 0, 1), Vec3(0, 0, 6), 0.005, 0.005));
  const double margin = margin_of(skeleton, {.material = wood}).factor;
  ASSERT_LT(margin, 1);
  const std::string complaint = test::complaint_of([&] { assemble(skeleton, {.material = wood}); });
  EXPECT_EQ(complaint.find("branch 2: buckles under the weight of the plant"), 0U) << complaint;
  EXPECT_NE(complaint.find("gravity 0"), std::string::npos) << complaint;
  EXPECT_EQ(complaint.find('\n'), std::string::npos);
  Material enough = wood;
  enough.youngs_modulus *= 1.001 / margin, enough.shear_modulus *= 1.001 / margin;
  EXPECT_NO_THROW(assemble(skeleton, {.material = enough}));
  EXPECT_NO_THROW(assemble(skeleton, test::weightless({.material = wood})));
  EXPECT_THROW(assemble(skeleton, {.gravity = -1}), InputError);
  EXPECT_THROW(assemble(skeleton, {.gravity = std::nan("")}), InputError);
}

}  // namespace
}  // namespace tremula
