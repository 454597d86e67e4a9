// Plants under water against closed forms: the water that blades carry, the drag that damps, floats that hold
// a stem up. And the plants that come with tremula.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "trees.hpp"
#include "tremula/base/error.hpp"
#include "tremula/dynamics/damping.hpp"
#include "tremula/geometry/grow.hpp"
#include "tremula/geometry/plants.hpp"
#include "tremula/pipeline.hpp"
#include "tremula/structure/plausibility.hpp"
#include "tremula/structure/sag.hpp"
#include "tremula/wind/waves.hpp"

namespace tremula {
namespace {

using std::numbers::pi;

constexpr double water = 1000, length = 1.2, radius = 0.004, width = 0.06, blade_mass = 0.05;  // [kg/m]
constexpr int pieces = 48;

const StructureOptions kelp_in_water{
    .material = find_material("kelp"), .rotatory_inertia = false, .added_mass_density = water, .gravity = 0};

// [kg/m] across the blade, and along its width.
double mass_across() {
  return (kelp_in_water.material.density + water) * pi * radius * radius + blade_mass +
         water * pi * width * width / 4;
}
double mass_edgeways() {
  return (kelp_in_water.material.density + water) * pi * radius * radius + blade_mass;
}

// The first frequency of a cantilever [rad/s].
double omega_of_cantilever(double mass) {
  const double stiffness = kelp_in_water.material.youngs_modulus * pi / 4 * std::pow(radius, 4);
  return 1.8751040687 * 1.8751040687 * std::sqrt(stiffness / (mass * std::pow(length, 4)));
}

TEST(KelpUnderWater, SwaysAcrossItsBladeAsACantileverWithTheWaterOfTheBlade) {
  const Structure structure =
      assemble(test::stem_with_ribbon(pieces, length, radius, width, blade_mass), kelp_in_water);
  const Modes modes = solve_modes(structure, {.count = 8});
  const double across = omega_of_cantilever(mass_across()), edgeways = omega_of_cantilever(mass_edgeways());
  EXPECT_NEAR(modes.omega()[0], across, 1e-3 * across);
  EXPECT_NEAR(std::abs(modes.shapes.col(0)[6 * (pieces - 1)]), modes.shapes.col(0).tail<6>().head<3>().norm(),
              1e-6);
  const Eigen::VectorXd off = (modes.omega().array() - edgeways).abs();
  EXPECT_LT(off.minCoeff(), 1e-3 * edgeways);
  EXPECT_GT(edgeways, 4 * across);
}

// zeta = c / (2 mu omega), c what a metre of drag grows by with the speed of the water.
TEST(KelpUnderWater, IsDampedByTheDragThatIsLinearAboutTheCurrent) {
  const Structure structure =
      assemble(test::stem_with_ribbon(pieces, length, radius, width, blade_mass), kelp_in_water);
  const Modes modes = solve_modes(structure, {.count = 1});
  const Sites sites = structure.find_sites();
  constexpr double current = 0.25;
  const LoadOptions options{.fluid_density = water};
  const double omega = omega_of_cantilever(mass_across());
  const double blade = (options.ribbon_normal_coefficient + options.ribbon_friction_coefficient) * width,
               stem = options.branch_drag_coefficient * 2 * radius;
  const auto ratio = [&](const Vec3& direction) {
    const Loads loads =
        linearise_loads(sites, (current * direction).replicate(1, sites.point_count()), options);
    return aerodynamic_damping(sites, loads, modes.shapes)(0, 0) / (2 * omega);
  };
  // Along the flow a square law counts twice, across it once.
  const double along = 2 * 0.5 * water * current * (blade + stem) / (2 * mass_across() * omega);
  EXPECT_NEAR(ratio(Vec3::UnitX()), along, 2e-3 * along);
  EXPECT_NEAR(ratio(Vec3::UnitY()), 0.5 * along, 1e-3 * along);
  EXPECT_GT(along, 1);  // no kelp swings on
}

// A stiff stem on a soft hinge with a sealed float on top: of the float's pull B at the height h, of the
// stem's weight w a metre and of the spring k the hinge has the stiffness k + B h - w L^2/2.
TEST(BuoyantStem, IsAnInvertedPendulumThatItsFloatHoldsUp) {
  constexpr double spring = 0.2, float_length = 0.08, float_radius = 0.03, wall = 0.15, g = 9.81;
  Skeleton stem = test::straight_stem(10, length, 0.008, 0.008);
  stem.branches.push_back(
      test::make_branch(10, {0, 0, length}, {0, 0, length + float_length}, float_radius, float_radius));
  stem.branches.back().wall = wall;
  Material stiff = find_material("kelp");
  stiff.youngs_modulus = stiff.shear_modulus = 1e15;
  const StructureOptions options{.material = stiff,
                                 .rotatory_inertia = false,
                                 .root = {.rotation = spring},
                                 .added_mass_density = water,
                                 .gravity = g};
  const double area = pi * 0.008 * 0.008, volume = pi * float_radius * float_radius * float_length;
  const double shell = stiff.density * volume * (1 - (1 - wall) * (1 - wall));
  const double lift = g * (water * volume - shell), height = length + float_length / 2;
  const double weight = g * (stiff.density - water) * area;
  const double stiffness = spring + lift * height - weight * length * length / 2;
  const double inertia = (stiff.density + water) * area * std::pow(length, 3) / 3 +
                         (shell + water * volume) * (height * height + float_length * float_length / 12);
  const Structure structure = assemble(stem, options);
  const double omega = std::sqrt(stiffness / inertia);
  EXPECT_NEAR(solve_modes(structure, {.count = 1}).omega()[0], omega, 1e-5 * omega);
  ASSERT_GT(lift * height, 5 * spring);  // it is the float that counts
  // And a force at the top leans it as that stiffness says.
  Eigen::VectorXd force = Eigen::VectorXd::Zero(structure.size());
  force[6 * 9] = 1e-3;
  const double lean = 1e-3 * length * length / stiffness;
  EXPECT_NEAR(structure.flexibility(force)[6 * 9], lean, 1e-5 * lean);
  // Full of water it would not stand: the hinge alone is too soft for a stem heavier than water.
  StructureOptions heavy = options;
  heavy.material.density = 1600;
  heavy.root.rotation = 0.1;
  stem.branches.back().wall = 1;
  EXPECT_THROW(assemble(stem, heavy), InputError);
}

TEST(BuoyantStem, IsStifferTheMoreItsFloatPulls) {
  double last = 0;
  for (const double size : {0.01, 0.015, 0.02}) {
    Skeleton stem = test::straight_stem(20, 5, 0.005, 0.005);
    stem.branches.push_back(test::make_branch(20, {0, 0, 5}, {0, 0, 5.1}, size, size));
    stem.branches.back().wall = 0.15;
    const Structure structure =
        assemble(stem, {.material = find_material("kelp"), .added_mass_density = water});
    const double frequency = solve_modes(structure, {.count = 1}).frequency[0];
    EXPECT_GT(frequency, 1.1 * last) << size;
    last = frequency;
  }
}

// The blades' water turns with them: of a stem laid on its side it is what moves up and down.
TEST(BladeWater, TurnsWithTheBladesOfAStemThatBends) {
  const Structure structure =
      assemble(test::stem_with_ribbon(pieces, length, radius, width, blade_mass), kelp_in_water);
  Eigen::VectorXd strains = Eigen::VectorXd::Zero(structure.size());
  const double each = pi / 2 / pieces;
  for (int k = 0; k < pieces; ++k) {
    strains[6 * k] = length / pieces * each / 2;
    strains[6 * k + 4] = each;
  }
  const std::vector<BentBranch> bent = bend(*structure.tree, strains);
  ASSERT_LT((bent.back().end_frame * Vec3::UnitX() + Vec3::UnitZ()).norm(), 1e-9);
  const Structure lying = bent_structure(structure, bent);
  const auto moved = [&](const Structure& of, int axis) {  // of the last piece, both ends along an axis
    Eigen::VectorXd u = Eigen::VectorXd::Zero(of.size());
    u[6 * (pieces - 2) + axis] = u[6 * (pieces - 1) + axis] = 1;
    return of.mass(u)[6 * (pieces - 1) + axis];
  };
  EXPECT_NEAR(moved(lying, 2), moved(structure, 0), 2e-3 * moved(structure, 0));
  EXPECT_LT(moved(lying, 0), 0.1 * moved(structure, 0));
}

struct WaterPlant {
  Habitat habitat;
  Skeleton skeleton;
  StructureOptions options;
};

WaterPlant grown(const std::string& name, std::uint64_t seed = 1) {
  const LSystem system = parse_lsystem(find_preset(name).text, name);
  WaterPlant plant{habitat_of(system), grow(system, {.seed = seed}).skeleton, {}};
  plant.options.material = find_material(plant.habitat.material);
  plant.options.added_mass_density = water;
  if (plant.habitat.drawn_unloaded) plant.skeleton = sagged(plant.skeleton, plant.options);
  return plant;
}

class WaterPlantPreset : public testing::TestWithParam<std::string> {};

TEST_P(WaterPlantPreset, LivesInWaterThatCoversItAndIsPlausible) {
  const WaterPlant plant = grown(GetParam());
  EXPECT_TRUE(plant.habitat.in_water);
  EXPECT_LT(extent(plant.skeleton).high.z(), plant.habitat.water_depth);
  EXPECT_EQ(plausibility(plant.skeleton, plant.options), std::vector<std::string>{});
}

TEST_P(WaterPlantPreset, StandsInTheCurrentAndSwaysWithTheWavesAndLoops) {
  WaterPlant plant = grown(GetParam(), 2);
  const Subject subject = bake(plant.skeleton, {.structure = plant.options, .modes = {.count = 12}});
  Weather weather;
  const double depth = plant.habitat.water_depth;
  weather.wind = add_waves(
      turbulent_wind({.speed = plant.habitat.current + wind_drift * 8, .reference_height = depth}, 0.2),
      wind_waves(8, depth));
  weather.loads = {.fluid_density = water, .inertia_coefficient = 2};
  weather.loop = {20, 100};
  const Motion motion = set_in_motion(subject, weather);
  const Eigen::VectorXd first = displacement_at(motion, 0);
  EXPECT_TRUE(first.allFinite());
  EXPECT_EQ(first, displacement_at(motion, weather.loop.period));
  const double height = extent(plant.skeleton).high.z();
  const MotionStatistics statistics = motion_statistics(subject.structure, motion);
  EXPECT_GT(statistics.about_mean.displacement, 0.01 * height);
  EXPECT_LT(statistics.about_mean.displacement, height);
  // It leans and does not lie on the ground: the highest branch is still in the upper half of its height.
  double highest = 0;
  for (const BentBranch& branch : bend(*subject.structure.tree, motion.lean_strains))
    highest = std::max(highest, branch.end.z());
  EXPECT_GT(highest, 0.5 * height);
  EXPECT_GT(motion.damping.medium[0], motion.damping.structure[0]);
}

INSTANTIATE_TEST_SUITE_P(Presets, WaterPlantPreset, testing::Values("kelp", "seagrass", "algae"),
                         [](const auto& preset) { return preset.param; });

}  // namespace
}  // namespace tremula
