#include "tremula/reference/large_motion.hpp"

#include "trees.hpp"
#include "tremula/base/error.hpp"
#include "tremula/dynamics/damping.hpp"
#include "tremula/modes/solve_modes.hpp"
#include "tremula/numerics/quadrature.hpp"
#include "tremula/reference/newmark.hpp"

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

namespace tremula {
namespace {

using std::numbers::pi;

const WeightAndDrag nothing{.gravity = Vec3::Zero(), .fluid_density = 0};

Skeleton stem() { return test::straight_stem(6, 2, 0.01, 0.006); }

// A rope of rubber: 1 m long, it hangs from the origin if nothing holds it up.
BeamTree rope(int pieces, const Vec3& direction) {
  StructureOptions options;
  options.material.youngs_modulus = 5e6;
  options.material.shear_modulus = 2e6;
  return assemble_tree(test::straight_stem(pieces, 1, 0.01, 0.01, direction), options);
}

// The lowest mode, as strains and as displacement, so large that the tip moves by a ten-thousandth.
struct SmallMode {
  double frequency;  // [Hz]
  Eigen::VectorXd displacement;
};
SmallMode lowest_mode(const Skeleton& skeleton) {
  const Modes modes = solve_modes(assemble(skeleton, test::weightless()), {.count = 1});
  const Eigen::VectorXd shape = modes.shapes.col(0);
  return {modes.frequency[0], 1e-4 / shape.tail<6>().head<3>().norm() * shape};
}

// How far along a mode the tip is, over where it began.
double tip_along(const SmallMode& mode, const BeamTree& tree, const LargeMotionState& state) {
  const Vec3 wanted = mode.displacement.tail<6>().head<3>();
  return Vec3(displacement_of(tree, state.bent).tail<6>().head<3>()).dot(wanted) / wanted.squaredNorm();
}

// The times when the tip comes through its rest upwards, by the line between two instants, and the largest
// values between them by the parabola through three.
struct Swings {
  std::vector<double> crossings, peaks;
};
Swings swings_of(const std::vector<double>& series, double step) {
  Swings swings;
  for (std::size_t i = 1; i + 1 < series.size(); ++i) {
    const double before = series[i - 1], here = series[i], after = series[i + 1];
    if (before < 0 && here >= 0)
      swings.crossings.push_back((static_cast<double>(i) - here / (here - before)) * step);
    if (here > 0 && here >= before && here > after) {
      swings.peaks.push_back(here - std::pow(after - before, 2) / (8 * (after - 2 * here + before)));
    }
  }
  return swings;
}

struct Vibration {
  double frequency, decrement;  // [Hz], by swing
};
Vibration vibration(const Skeleton& skeleton, const SmallMode& mode, double ratio, int steps_per_swing) {
  const BeamTree tree = assemble_tree(skeleton, {});
  const int swing_count = 8;
  std::vector<double> series;
  const double step = 1 / mode.frequency / steps_per_swing;
  integrate_large_motion(
      tree, nothing,
      {.step = step,
       .step_count = swing_count * steps_per_swing,
       .high_frequency_radius = 1,
       .damping = rayleigh_damping(ratio, mode.frequency, 6 * mode.frequency),
       .strains = strains_of(tree, mode.displacement)},
      [&](int, const LargeMotionState& state) { series.push_back(tip_along(mode, tree, state)); });
  const auto [crossings, peaks] = swings_of(series, step);
  const auto count = static_cast<double>(crossings.size() - 1);
  return {count / (crossings.back() - crossings.front()),
          std::log(peaks.front() / peaks.back()) / static_cast<double>(peaks.size() - 1)};
}

TEST(IntegrateLargeMotion, OfASmallVibrationHasTheFrequencyOfTheModeToTheSquareOfTheStep) {
  const SmallMode mode = lowest_mode(stem());
  const auto error = [&](int steps) {
    return 1 - vibration(stem(), mode, 0, steps).frequency / mode.frequency;
  };
  const double coarse = error(40), fine = error(80);
  // Without dissipation it is Newmark's with average acceleration: (omega h)^2/12.
  EXPECT_NEAR(coarse / (std::pow(2 * pi / 40, 2) / 12), 1, 0.05);
  EXPECT_NEAR(coarse / fine, 4, 0.2);
}

TEST(IntegrateLargeMotion, DampsASmallVibrationByTheRatioAskedFor) {
  const SmallMode mode = lowest_mode(stem());
  for (const double ratio : {0.02, 0.08}) {
    const double wanted = 2 * pi * ratio / std::sqrt(1 - ratio * ratio);
    EXPECT_NEAR(vibration(stem(), mode, ratio, 100).decrement / wanted, 1, 0.005) << ratio;
  }
}

TEST(IntegrateLargeMotion, LosesToTheWindWhatTheLinearDampingOfTheWindTakes) {
  Skeleton skeleton = stem();
  skeleton.leaves.push_back(
      {.branch = 5, .position = 0.7, .length = 0.1, .width = 0.1, .area = 0.02, .mass = 0.005});
  const Structure structure = assemble(skeleton, test::weightless());
  const SmallMode mode = lowest_mode(skeleton);
  const Sites sites = structure.find_sites();
  const Vec3 wind = mode.displacement.tail<6>().head<3>().normalized() * 0.5;
  const Loads loads = linearise_loads(sites, wind.replicate(1, sites.point_count()));
  const double scale = std::sqrt(mode.displacement.dot(structure.mass(mode.displacement)));
  const double rate = aerodynamic_damping(sites, loads, mode.displacement / scale)(0, 0);

  const WeightAndDrag blown{.gravity = Vec3::Zero(),
                            .leaves = {{5, 0.7, Vec3::UnitZ(), 0.02}},
                            .leaf_drag_coefficient = [](double) { return 0.25; },
                            .wind = [&](std::size_t, double, const Vec3&) { return wind; }};
  const Equilibrium lean = find_equilibrium(*structure.tree, loads_at_rest(*structure.tree, blown));
  std::vector<double> series;
  const double step = 1 / mode.frequency / 100;
  integrate_large_motion(
      *structure.tree, blown,
      {.step = step,
       .step_count = 1000,
       .high_frequency_radius = 1,
       .strains = lean.strains + strains_of(*structure.tree, mode.displacement)},
      [&](int, const LargeMotionState& state) { series.push_back(tip_along(mode, *structure.tree, state)); });
  const double rest =
      tip_along(mode, *structure.tree, {.strains = {}, .velocity = {}, .bent = lean.bent, .wrenches = {}});
  for (double& value : series) value -= rest;
  const std::vector<double> peaks = swings_of(series, step).peaks;
  const double decrement = std::log(peaks.front() / peaks.back()) / static_cast<double>(peaks.size() - 1);
  EXPECT_NEAR(decrement * mode.frequency / (rate / 2), 1, 0.01);
}

// A weight so small that angles stay near 1e-4, which begins to pull at once.
TEST(IntegrateLargeMotion, UnderASmallStepLoadIsNewmarksOfTheLinearStructure) {
  Skeleton skeleton = test::awkward_tree();
  for (Branch& branch : skeleton.branches) branch.start_radius *= 0.2, branch.end_radius *= 0.2;
  const BeamTree tree = assemble_tree(skeleton, {});
  const SparseMatrices matrices = assemble_sparse(tree);
  const double frequency = solve_modes(assemble(skeleton, test::weightless()), {.count = 1}).frequency[0];
  const RayleighDamping damping = rayleigh_damping(0.05, frequency, 5 * frequency);
  const Eigen::SparseMatrix<double> dampers =
      damping.mass * matrices.mass + damping.stiffness * matrices.stiffness;
  const Vec3 gravity(1e-3, 2e-4, 0);
  Eigen::VectorXd falling = Eigen::VectorXd::Zero(tree.size());
  for (int k = 0; k < tree.branch_count(); ++k) falling.segment<3>(6 * k) = gravity;
  const BranchLoads weight = loads_at_rest(tree, {.gravity = gravity, .fluid_density = 0});
  Eigen::VectorXd force = Eigen::VectorXd::Zero(tree.size());
  const std::vector<BentBranch> rest = bend(tree, Eigen::VectorXd::Zero(tree.size()));
  for (int k = 0; k < tree.branch_count(); ++k) {
    const EndLoads load = weight(k, rest[index_of(k)]);
    force.segment<3>(6 * k) += load.end_force;
    force.segment<3>(6 * k + 3) += load.end_moment;
    if (const int parent = tree.parent[index_of(k)]; parent >= 0) {
      force.segment<3>(6 * parent) += load.start_force;
      force.segment<3>(6 * parent + 3) +=
          load.start_moment + tree.members[index_of(k)].start_arm.cross(load.start_force);
    }
  }
  const int count = 400;
  const double step = 1 / frequency / 200;
  std::vector<Eigen::VectorXd> wanted;
  const Eigen::VectorXd still = Eigen::VectorXd::Zero(tree.size());
  integrate_newmark(
      matrices, dampers, [&](double) { return force; }, {still, still, {}}, {step, count},
      [&](int, const TimeState& state) { wanted.push_back(state.displacement); });
  double largest = 0, difference = 0;
  integrate_large_motion(tree, {.gravity = gravity, .fluid_density = 0},
                         {.step = step, .step_count = count, .damping = damping, .tolerance = 1e-10},
                         [&](int i, const LargeMotionState& state) {
                           const Eigen::VectorXd found = displacement_of(tree, state.bent);
                           difference = std::max(difference, (found - wanted[index_of(i)]).norm());
                           largest = std::max(largest, wanted[index_of(i)].norm());
                         });
  EXPECT_LT(difference, 1e-3 * largest);
  EXPECT_GT(largest, 1e-6);
}

double kinetic_energy(const BeamTree& tree, const LargeMotionState& state) {
  return 0.5 * state.velocity.dot(apply_mass(tree_at(tree, state.bent), state.velocity));
}

// Of a rope that nothing damps: what its strains answer to, they hold.
double energy_of(const BeamTree& rope, const LargeMotionState& state, const Vec3& gravity) {
  static const std::vector<QuadraturePoint> quadrature = gauss_legendre(4);
  double energy = kinetic_energy(rope, state);
  energy +=
      0.5 * state.strains.dot(forces_on_strains(rope, state.strains, state.bent, state.wrenches.at_end));
  for (std::size_t k = 0; k < rope.parent.size(); ++k) {
    const double mass = rope.masses[k].axial.sum();
    for (const QuadraturePoint& point : quadrature) {
      const Vec3 position = point_on(rope.members[k], state.bent[k], point.position).position;
      energy -= mass * point.weight * gravity.dot(position);
    }
  }
  return energy;
}

// How far the energy of a rope strays that is let go aslant with a turn out of the plane, over the most that
// is in its motion. Not from the start: the tension comes at once, and what rings along the rope dies.
double stray_energy(int pieces, double step) {
  const BeamTree tree = rope(pieces, Vec3(0.8, 0, -0.6));
  const WeightAndDrag weight{.fluid_density = 0};
  const Vec3 spin(0.8, 0, 2);
  Eigen::VectorXd velocity(tree.size());
  for (int k = 0; k < tree.branch_count(); ++k)
    velocity.segment<6>(6 * k) << spin.cross(tree.members[index_of(k)].point(1)), spin;
  double least = 1e9, most = -1e9, in_motion = 0;
  integrate_large_motion(tree, weight,
                         {.step = step,
                          .step_count = static_cast<int>(std::lround(2 / step)),
                          .high_frequency_radius = 0.8,
                          .velocity = velocity},
                         [&](int i, const LargeMotionState& state) {
                           in_motion = std::max(in_motion, kinetic_energy(tree, state));
                           if (i * step < 0.2) return;
                           const double energy = energy_of(tree, state, weight.gravity);
                           least = std::min(least, energy);
                           most = std::max(most, energy);
                         });
  return (most - least) / in_motion;
}

// The shapes within a piece leave an error of the square of its length.
TEST(IntegrateLargeMotion, OfASwingingRopeKeepsTheEnergyTheBetterTheShorterThePieces) {
  const double coarse = stray_energy(8, 0.002), fine = stray_energy(16, 0.002);
  EXPECT_LT(coarse, 0.01);
  EXPECT_GT(coarse / fine, 3);
  EXPECT_NEAR(stray_energy(8, 0.004) / coarse, 1, 0.1);
}

WeightAndDrag steady_wind() {
  return {.leaves = {{3, 0.6, Vec3::UnitZ(), 0.02}, {7, 1, Vec3::UnitZ(), 0.03}},
          .leaf_drag_coefficient = [](double speed) { return 0.5 / std::sqrt(1 + speed); },
          .wind = [](std::size_t, double, const Vec3& place) -> Vec3 {
            return (6 + place.z()) * Vec3(0.8, 0.6, 0.1);
          }};
}

TEST(IntegrateLargeMotion, InASteadyWindComesToRestWhereTheEquilibriumIs) {
  Skeleton skeleton = test::awkward_tree();
  for (Branch& branch : skeleton.branches) branch.start_radius *= 0.12, branch.end_radius *= 0.12;
  const BeamTree tree = assemble_tree(skeleton, {});
  const WeightAndDrag blown = steady_wind();
  const Equilibrium rest = find_equilibrium(tree, loads_at_rest(tree, blown));
  const LargeMotionState last = integrate_large_motion(
      tree, blown, {.step = 0.05, .step_count = 600, .damping = {.mass = 3, .stiffness = 0.05}});
  const Eigen::VectorXd wanted = displacement_of(tree, rest.bent);
  EXPECT_LT((displacement_of(tree, last.bent) - wanted).norm(), 1e-6 * wanted.norm());
  EXPECT_LT((last.wrenches.ground_force - rest.wrenches.ground_force).norm(),
            1e-6 * rest.wrenches.ground_force.norm());
  EXPECT_GT(wanted.cwiseAbs().maxCoeff(), 0.2);
}

// A gust lays the rope over and lets it come back, through angles beyond 1.
TEST(IntegrateLargeMotion, OfABigSwingIsOfTheSecondOrder) {
  const BeamTree tree = rope(6, -Vec3::UnitZ());
  const WeightAndDrag gust{.wind = [](std::size_t, double time, const Vec3&) -> Vec3 {
    return 40 * std::pow(std::sin(2 * pi * time), 2) * Vec3(1, 0.5 * time, 0);
  }};
  const Equilibrium rest = find_equilibrium(tree, loads_at_rest(tree, gust));
  double largest = 0;
  const auto end = [&](int count) {
    const LargeMotionState last = integrate_large_motion(
        tree, gust,
        {.step = 0.8 / count,
         .step_count = count,
         .damping = {.stiffness = 0.01},
         .strains = rest.strains,
         .tolerance = 1e-10},
        [&](int, const LargeMotionState& state) {
          largest = std::max(largest, displacement_of(tree, state.bent).tail<3>().norm());
        });
    return displacement_of(tree, last.bent);
  };
  const Eigen::VectorXd truth = end(1600);
  const auto error = [&](int count) { return (end(count) - truth).norm(); };
  const double coarse = error(100), middle = error(200), fine = error(400);
  EXPECT_GT(largest, 1);
  EXPECT_NEAR(coarse / middle, 4, 0.5);
  EXPECT_NEAR(middle / fine, 4, 0.3);
}

TEST(IntegrateLargeMotion, RefusesWhatIsNoMotion) {
  const BeamTree tree = rope(2, Vec3::UnitZ());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto integrate = [&](const LargeMotionSettings& settings, const WeightAndDrag& outside = {}) {
    integrate_large_motion(tree, outside, settings);
  };
  EXPECT_NO_THROW(integrate({.step = 0.01, .step_count = 1}));
  for (const double step : {0.0, -1.0, nan})
    EXPECT_THROW(integrate({.step = step, .step_count = 1}), InputError);
  EXPECT_THROW(integrate({.step = 0.01, .step_count = 0}), InputError);
  EXPECT_THROW(integrate({.step = 0.01, .step_count = 1, .high_frequency_radius = 1.1}), InputError);
  EXPECT_THROW(integrate({.step = 0.01, .step_count = 1, .damping = {.mass = -1}}), InputError);
  EXPECT_THROW(integrate({.step = 0.01, .step_count = 1, .strains = Eigen::VectorXd::Zero(5)}), InputError);
  EXPECT_THROW(integrate({.step = 0.01, .step_count = 1, .velocity = Eigen::VectorXd::Constant(12, nan)}),
               InputError);
  EXPECT_THROW(integrate({.step = 0.01, .step_count = 1}, {.fluid_density = -1}), InputError);
  EXPECT_THROW(integrate({.step = 0.01, .step_count = 1}, {.leaves = {{.member = 2}}}), InputError);
  EXPECT_THROW(loads_at_rest(tree, {.leaves = {{.member = -1}}}), InputError);
}

TEST(RayleighDamping, GivesBothFrequenciesTheRatio) {
  const RayleighDamping damping = rayleigh_damping(0.03, 0.4, 5);
  for (const double frequency : {0.4, 5.0}) {
    const double omega = 2 * pi * frequency;
    EXPECT_NEAR((damping.mass / omega + damping.stiffness * omega) / 2, 0.03, 1e-15);
  }
  EXPECT_THROW(rayleigh_damping(0.03, 2, 2), InputError);
  EXPECT_THROW(rayleigh_damping(-0.1, 1, 2), InputError);
  EXPECT_THROW(rayleigh_damping(0.1, 0, 2), InputError);
}

}  // namespace
}  // namespace tremula
