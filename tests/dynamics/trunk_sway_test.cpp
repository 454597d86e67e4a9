#include "tremula/dynamics/trunk_sway.hpp"

#include "tremula/base/error.hpp"
#include "tremula/dynamics/lean.hpp"
#include "tremula/geometry/impression.hpp"
#include "tremula/modes/solve_modes.hpp"
#include "tremula/structure/uniform_beam.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace tremula {
namespace {

const TimeAxis minute{.period = 60, .sample_count = 1200};

Skeleton bare_pole(double height, double radius, int pieces = 20) {
  Skeleton skeleton;
  skeleton.roots.push_back(Vec3::Zero());
  for (int i = 0; i < pieces; ++i) {
    skeleton.branches.push_back({.start_node = i,
                                 .start = {0, 0, height * i / pieces},
                                 .end = {0, 0, height * (i + 1) / pieces},
                                 .start_radius = radius,
                                 .end_radius = radius});
  }
  return skeleton;
}

Wind windy(double speed = 8, double heading = 30) {
  MeanWind mean;
  mean.speed = speed;
  mean.heading = heading;
  return turbulent_wind(mean, 0.2);
}

TEST(TrunkSway, OfAUniformPoleIsTheFirstModeOfTheBeam) {
  StructureOptions options;
  options.gravity = 0;
  const double height = 8, radius = 0.06;
  const TrunkSway sway = trunk_sway(assemble(bare_pole(height, radius), options), windy(3), minute,
                                    {.damping = {.ratio = 0.03, .aerodynamic = false}});
  const double pi = std::numbers::pi, area = pi * radius * radius;
  const UniformBeam beam{height, options.material.youngs_modulus * area * radius * radius / 4,
                         options.material.density * area};
  for (const double frequency : sway.frequency)
    EXPECT_NEAR(frequency, natural_omega(beam, 1) / (2 * pi), 0.003 * frequency);
  for (const double ratio : sway.damping_ratio) EXPECT_NEAR(ratio, 0.03, 2e-4);
  for (std::size_t i = 0; i < sway.heights.size(); ++i) {
    const double wanted = clamped_free_shape(1, sway.heights[i] / height).value / 2;
    EXPECT_NEAR(sway.share[i].x(), wanted, 0.003);
    EXPECT_NEAR(sway.share[i].y(), wanted, 0.003);
  }
}

// A second way: the exact static deflection under the change of all forces.
TEST(TrunkSway, GivesTheStaticDeflectionOfAGustThatIsTheSameEverywhere) {
  const ImpressionistTree tree = impressionist_tree("round", 9);
  const Structure structure = assemble(trunk_skeleton(tree), {.material = find_material(tree.material)});
  const Wind wind = windy();
  const TrunkSway sway = trunk_sway(structure, wind, minute);
  const Lean lean =
      find_lean(structure, [&](Eigen::Index, const Vec3& place) { return wind.statistics(place); }, {},
                {.shelter = {.on = false}});
  const double heading = std::numbers::pi / 6;
  const Vec3 axes[2] = {{std::cos(heading), std::sin(heading), 0},
                        {-std::sin(heading), std::cos(heading), 0}};
  for (std::size_t i = 0; i < 2; ++i) {
    const Eigen::Matrix3Xd even = axes[i].replicate(1, lean.sites.point_count());
    const Eigen::VectorXd moved = lean.structure.flexibility(fluctuating_force(lean.sites, lean.loads, even));
    const double top = moved.segment<3>(structure.nodes.back().row).dot(axes[i]);
    EXPECT_NEAR(sway.static_response[i], top, 0.06 * top);
  }
}

TEST(TrunkSway, LeansWithTheWindAndItsAirDampsIt) {
  const ImpressionistTree tree = impressionist_tree("poplar", 22);
  const Structure structure = assemble(trunk_skeleton(tree), {.material = find_material(tree.material)});
  double last = 0;
  for (const double speed : {4.0, 8.0, 12.0}) {
    const TrunkSway sway = trunk_sway(structure, windy(speed), minute, {.damping = {.ratio = 0.02}});
    EXPECT_GT(sway.lean.back().x(), last);
    last = sway.lean.back().x();
    EXPECT_LT(std::abs(sway.lean.back().y()), 1e-6 * last);
    EXPECT_EQ(sway.lean.front(), Eigen::Vector2d(0, 0));
    EXPECT_NEAR(sway.share.back().x(), 1, 1e-12);
    EXPECT_GT(sway.damping_ratio[0], sway.damping_ratio[1]);
    EXPECT_GT(sway.damping_ratio[1], 0.02);
    EXPECT_GT(sway.gust_height, 0.4 * tree.height);
    EXPECT_LT(sway.gust_height, tree.height);
  }
}

// f = 0.0766 + 3.1219 dbh[cm]/H[m]^2 of 602 conifers of eight species (Moore & Maguire 2004). A clamped trunk
// without knots or roots is stiffer.
TEST(TrunkSway, OfThePineIsAsFastAsConifersOfItsSizeOrFasterButNeverTwice) {
  for (const double height : {12.0, 18.0, 25.0}) {
    const ImpressionistTree tree = impressionist_tree("pine", height);
    const Structure structure = assemble(trunk_skeleton(tree), {.material = find_material(tree.material)});
    const double breast = 1.3 / tree.trunk_height;
    const double dbh = 200 * (tree.base_radius + breast * (tree.top_radius - tree.base_radius));
    const double wanted = 0.0766 + 3.1219 * dbh / (height * height);
    const double found = solve_modes(structure, {.count = 1}).frequency[0];
    EXPECT_GT(found, wanted) << height << " m high, dbh " << dbh << " cm";
    EXPECT_LT(found, 2 * wanted) << height << " m high, dbh " << dbh << " cm";
  }
}

TEST(TunedStructure, HasTheFrequencyThatIsAskedFor) {
  const ImpressionistTree tree = impressionist_tree("oak", 12);
  for (const double frequency : {0.3, 0.8, 2.0}) {
    const Structure structure =
        tuned_structure(trunk_skeleton(tree), {.material = find_material(tree.material)}, frequency);
    EXPECT_NEAR(solve_modes(structure, {.count = 1}).frequency[0], frequency, 1e-4 * frequency);
  }
}

TEST(TrunkSway, OfWhatIsNoTrunkIsRefused) {
  Skeleton beside = bare_pole(5, 0.05);
  beside.roots[0].x() = 1;
  for (Branch& branch : beside.branches) branch.start.x() = branch.end.x() = 1;
  EXPECT_THROW(trunk_sway(assemble(beside, {}), windy(), minute), InputError);
  Skeleton level = bare_pole(5, 0.05, 1);
  level.branches[0].end = {5, 0, 0};
  EXPECT_THROW(trunk_sway(assemble(level, {}), windy(), minute), InputError);
  EXPECT_THROW(tuned_structure(bare_pole(5, 0.05), {}, 0), InputError);
}

}  // namespace
}  // namespace tremula
