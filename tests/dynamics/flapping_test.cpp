#include "tremula/dynamics/flapping.hpp"

#include "crossings.hpp"
#include "tremula/base/error.hpp"
#include "tremula/dynamics/flutter.hpp"
#include "tremula/structure/sheet_presets.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include <gtest/gtest.h>

namespace tremula {
namespace {

constexpr double pi = std::numbers::pi;

Sheet preset(const char* name) {
  return std::ranges::find(sheet_presets(), std::string(name), &SheetPreset::name)->sheet;
}

WindInTime steady(double speed) {
  return [speed](double) { return Vec3(speed, 0, 0); };
}

Eigen::VectorXd fly(const Flag& flag, const FlappingOptions& options, const Eigen::MatrixXd& angles) {
  Eigen::VectorXd side(angles.cols());
  for (Eigen::Index i = 0; i < side.size(); ++i) side[i] = thread(flag, options, angles.col(i), 40)(1, 40);
  return side;
}

Sheet plate(double span, double mass_ratio) {
  Sheet sheet;
  sheet.width = 1;
  sheet.height = span;
  sheet.thickness = 1e-3;
  sheet.density = 1.2 / mass_ratio / sheet.thickness;
  sheet.poisson_ratio = 0;
  sheet.youngs_modulus = 12 * 0.02 / std::pow(sheet.thickness, 3);
  sheet.clamped = {SheetEdge::left};
  return sheet;
}

FlappingOptions without_air() { return {.fluid_density = 0, .gravity = 0}; }

TEST(FlagOf, IsASheetHeldOnOneEdgeAndNothingElse) {
  EXPECT_TRUE(flag_of(preset("flag")));
  EXPECT_TRUE(flag_of(preset("flag"))->shears);
  EXPECT_FALSE(flag_of(preset("banner")));
  ASSERT_TRUE(flag_of(preset("curtain")));
  EXPECT_TRUE(flag_of(preset("curtain"))->is_hung());
  EXPECT_FALSE(flag_of(preset("curtain"))->shears);
  Sheet stands = preset("curtain");
  stands.pinned = {SheetEdge::bottom};
  EXPECT_FALSE(flag_of(stands));
  Sheet pulled = preset("flag");
  pulled.tension.x = 1;
  EXPECT_FALSE(flag_of(pulled));
  Sheet corner = preset("flag");
  corner.pinned_points = {{1.5, 1}};
  EXPECT_FALSE(flag_of(corner));
}

TEST(FlagOf, RunsFromWhicheverEdgeHoldsIt) {
  Sheet sheet = plate(0.5, 1);
  sheet.clamped = {SheetEdge::right};
  const Flag flag = *flag_of(sheet);
  EXPECT_LT((flag.onwards + Vec3::UnitX()).norm(), 1e-12);
  EXPECT_LT((flag.edge - Vec3::UnitZ()).norm(), 1e-12);
  EXPECT_LT((flag.side - flag.edge.cross(flag.onwards)).norm(), 1e-12);
  EXPECT_TRUE(blows_along(flag, {-3, 1, 0}));
  EXPECT_FALSE(blows_along(flag, {3, 1, 0}));
}

// Blevins 1979, table 8-1: 1.87510 squared for a beam clamped at one end.
TEST(IntegrateFlapping, SwingsWithoutAirAsAClampedBeam) {
  const Flag flag = *flag_of(plate(0.3, 1));
  FlappingState start = flapping_start(flag, without_air());
  start.angles.setZero();
  start.angles[0] = 1e-3;
  const double omega = 1.8751041 * 1.8751041 * std::sqrt(flag.bending_stiffness / flag.mass_per_area);
  const double step = 2 * pi / omega / 40;
  const FlappingCourse course = integrate_flapping(flag, without_air(), start, steady(0), step, 400);
  EXPECT_NEAR(test::frequency_of_crossings(fly(flag, without_air(), course.angles), step) * 2 * pi / omega, 1,
              0.005);
}

// Lighthill's added mass of a narrow ribbon, rho pi b/4 on its area.
TEST(IntegrateFlapping, SwingsInStillAirByTheMassOfItsSections) {
  const Flag flag = *flag_of(plate(0.05, 30));
  FlappingOptions options{.gravity = 0};
  options.normal_coefficient = options.friction_coefficient = 0;
  FlappingState start = flapping_start(flag, options);
  start.angles.setZero();
  start.angles[0] = 1e-4;
  const double mass = flag.mass_per_area + 1.2 * pi / 4 * flag.span;
  const double omega = 1.8751041 * 1.8751041 * std::sqrt(flag.bending_stiffness / mass);
  const double step = 2 * pi / omega / 40;
  const FlappingCourse course = integrate_flapping(flag, options, start, steady(0), step, 400);
  EXPECT_NEAR(test::frequency_of_crossings(fly(flag, options, course.angles), step) * 2 * pi / omega, 1,
              0.01);
}

TEST(IntegrateFlapping, KeepsItsEnergyHoweverFarItSwingsWithoutAir) {
  Flag flag = *flag_of(plate(0.5, 1));
  flag.shears = true;
  FlappingState start = flapping_start(flag, without_air());
  start.angles << 0.9, -0.4, 0.2, 0, 0, 0, 0.5, -0.2;
  start.rates << 3, 1, 0, 1, 0, 0, 2, 1;
  const double before = flapping_energy(flag, without_air(), start);
  const FlappingCourse course = integrate_flapping(flag, without_air(), start, steady(0), 0.01, 60);
  EXPECT_GT((course.angles.col(60) - start.angles).norm(), 0.3);
  EXPECT_NEAR(flapping_energy(flag, without_air(), course.last) / before, 1, 2e-4);
}

// The air of a ribbon keeps the energy, too, but for what goes off at the fly: w^2 u of it there (Candelier,
// Boyer & Leroyer 2011). A ribbon so fine that it is held by 1/m of its mass gains none.
TEST(IntegrateFlapping, LosesEnergyInStillAirAndNeverGains) {
  Flag flag = *flag_of(plate(0.1, 3));
  FlappingOptions options{.gravity = 0};
  options.normal_coefficient = options.friction_coefficient = 0;
  FlappingState state = flapping_start(flag, options);
  state.angles << 0.8, 0.3, -0.1, 0, 0, 0;
  double before = flapping_energy(flag, options, state);
  const double first = before;
  for (int i = 0; i < 20; ++i) {
    state = integrate_flapping(flag, options, state, steady(0), 0.02, 1).last;
    const double after = flapping_energy(flag, options, state);
    EXPECT_LT(after, before + 0.02 * first);
    before = after;
  }
}

TEST(IntegrateFlapping, GrowsAboveTheFlutterSpeedAndDiesBelow) {
  for (const double span : {0.1, 0.5}) {
    for (const double mass_ratio : {0.3, 1.0}) {
      const Sheet sheet = plate(span, mass_ratio);
      const double onset = find_flutter(sheet, {.gravity = 0, .fluid_density = 1.2}, Vec3::UnitX(), 40).speed;
      const Flag flag = *flag_of(sheet);
      FlappingOptions options{.gravity = 0};
      options.friction_coefficient = options.fluid_damping = 0;
      const auto growth = [&](double speed) {
        FlappingState start = flapping_start(flag, options);
        start.angles *= 1e-4;
        const Eigen::MatrixXd angles =
            integrate_flapping(flag, options, start, steady(speed), 0.1 / onset, 400).angles;
        return angles.rightCols(100).norm() / angles.middleCols(150, 100).norm();
      };
      EXPECT_LT(growth(0.85 * onset), 1) << span << " " << mass_ratio;
      EXPECT_GT(growth(1.15 * onset), 1) << span << " " << mass_ratio;
    }
  }
}

// fA/U 0.2 to 0.4 (Shelley & Zhang 2011, Annu. Rev. Fluid Mech. 43), fL/U from 0.3 on, rising with rho L/m
// (Taneda 1968, J. Phys. Soc. Jpn. 24), drag of 0.1 to 0.3 on its area (Morris-Thomas & Steen 2009, J. Fluids
// Struct. 25; Hoerner 1965 3-25).
TEST(IntegrateFlapping, OfClothHasTheFrequencyAmplitudeAndDragOfFlags) {
  const Flag flag = *flag_of(preset("flag"));
  const FlappingOptions options;
  for (const double speed : {4.0, 12.0}) {
    const double step = 0.1 * flag.length / speed;
    const FlappingCourse course =
        integrate_flapping(flag, options, flapping_start(flag, options), steady(speed), step, 800);
    const Eigen::VectorXd side = fly(flag, options, course.angles.rightCols(300));
    const double frequency = test::frequency_of_crossings(side, step),
                 sway = side.maxCoeff() - side.minCoeff();
    EXPECT_GT(frequency * sway / speed, 0.2);
    EXPECT_LT(frequency * sway / speed, 0.4);
    EXPECT_GT(frequency * flag.length / speed, 0.3);
    EXPECT_LT(frequency * flag.length / speed, 0.9);
    const double drag = course.pull.tail(300).mean() / (0.5 * 1.2 * speed * speed * flag.length);
    EXPECT_GT(drag, 0.1);
    EXPECT_LT(drag, 0.3);
  }
}

TEST(IntegrateFlapping, EndsInTheSameCycleFromAnyStart) {
  const Flag flag = *flag_of(preset("flag"));
  const FlappingOptions options;
  const auto sway = [&](double start_angle) {
    FlappingState start = flapping_start(flag, options);
    start.angles[0] = start_angle;
    const FlappingCourse course = integrate_flapping(flag, options, start, steady(6), 0.02, 600);
    const Eigen::VectorXd side = fly(flag, options, course.angles.rightCols(200));
    return side.maxCoeff() - side.minCoeff();
  };
  EXPECT_NEAR(sway(0.4) / sway(0.001), 1, 0.02);
}

TEST(IntegrateFlapping, HangsInNoWindAndRisesWithIt) {
  const Flag flag = *flag_of(preset("flag"));
  const FlappingOptions options;
  double above = 100;
  for (const double speed : {0.0, 2.0, 4.0, 8.0}) {
    const FlappingCourse course =
        integrate_flapping(flag, options, flapping_start(flag, options), steady(speed), 0.05, 240);
    const double droop = course.angles.row(options.modes).tail(120).mean() * 180 / pi;
    EXPECT_LT(droop, above - 3) << speed;
    if (speed == 0) {
      EXPECT_NEAR(droop, 80, 6);
    }
    above = droop;
  }
  EXPECT_LT(above, 12);
}

// Virtual work of turning all threads by delta: m g cos delta = 1/2 rho C U^2 cos delta sin delta.
TEST(IntegrateFlapping, HangsAtTheAngleOfWeightAndFriction) {
  const Flag flag = *flag_of(preset("flag"));
  FlappingOptions options{.droop_modes = 1};
  options.friction_coefficient = 1;
  options.normal_coefficient = 0;
  options.fluid_damping = 0.1;  // it shall not flap
  FlappingState start = flapping_start(flag, options);
  start.angles.head(options.modes).setZero();
  const FlappingCourse course = integrate_flapping(flag, options, start, steady(1.5), 0.05, 400);
  const double delta = course.last.angles[options.modes];
  const double weight = flag.mass_per_area * 9.81, drag = 0.5 * 1.2 * 1.5 * 1.5;
  EXPECT_NEAR(drag * std::sin(delta) / weight, 1, 0.02);
}

// A hanging chain without air: omega = 1.2024 sqrt(g/L) (Bernoulli; the first zero of J_0 is 2.40483).
TEST(IntegrateFlapping, SwingsWithoutAirAsAHangingChain) {
  Flag flag = *flag_of(preset("curtain"));
  flag.bending_stiffness = 1e-9;
  const FlappingOptions options{.fluid_density = 0};
  FlappingState start = flapping_start(flag, options);
  start.angles.setZero();
  // The slopes of the mode, J_0(2 omega sqrt((L - s)/g)), rise towards the fly.
  for (int j = 0; j < 2; ++j) start.angles[j] = j == 0 ? 0.01 : -0.0042;
  const double omega = 0.5 * 2.404826 * std::sqrt(9.81 / flag.length), step = 2 * pi / omega / 40;
  const FlappingCourse course = integrate_flapping(flag, options, start, steady(0), step, 800);
  EXPECT_NEAR(test::frequency_of_crossings(fly(flag, options, course.angles), step) * 2 * pi / omega, 1,
              0.01);
}

// A curtain that turns in a wind through it stands off at the angle at which drag and weight agree.
TEST(IntegrateFlapping, StandsOffInAWindThroughItByDragAndWeight) {
  const Flag flag = *flag_of(preset("curtain"));
  FlappingOptions options{.modes = 1};
  options.friction_coefficient = 0;
  const FlappingCourse course = integrate_flapping(
      flag, options, flapping_start(flag, options), [](double) { return Vec3(0, 2, 0); }, 0.1, 300);
  const double theta = course.last.angles[0], across = 2 * std::cos(theta);
  EXPECT_GT(theta, 0.5);
  EXPECT_NEAR(0.5 * 1.2 * 1.8 * across * across / (flag.mass_per_area * 9.81 * std::sin(theta)), 1, 0.02);
}

TEST(Flaps, WhereAMotionAboutRestWouldBeWrong) {
  const SheetOptions air{.fluid_density = 1.2};
  EXPECT_TRUE(flaps(preset("flag"), air, {0.2, 0, 0}));
  EXPECT_FALSE(flaps(preset("flag"), air, {-2, 0, 0}));
  EXPECT_FALSE(flaps(preset("curtain"), air, {1, 0, 0}));
  EXPECT_TRUE(flaps(preset("curtain"), air, {5, 0, 0}));
  EXPECT_FALSE(flaps(preset("banner"), air, {5, 0, 0}));
  const Sheet sheet = plate(0.5, 1);
  const SheetOptions weightless{.gravity = 0, .fluid_density = 1.2};
  const double onset = find_flutter(sheet, weightless, Vec3::UnitX(), 40).speed;
  EXPECT_FALSE(flaps(sheet, weightless, {0.95 * onset, 0, 0}));
  EXPECT_TRUE(flaps(sheet, weightless, {1.05 * onset, 0, 0}));
}

TEST(IntegrateFlapping, DoesNotDependOnTheStep) {
  const Flag flag = *flag_of(preset("flag"));
  const FlappingOptions options;
  const auto at_end = [&](int parts) {
    return integrate_flapping(flag, options, flapping_start(flag, options), steady(5), 0.1 / parts,
                              10 * parts)
        .last.angles;
  };
  EXPECT_LT((at_end(100) - at_end(200)).norm(), 1e-4);
  EXPECT_LT((at_end(10) - at_end(200)).norm(), 0.02);
}

TEST(Thread, KeepsItsLength) {
  const Flag flag = *flag_of(preset("flag"));
  const FlappingOptions options;
  Eigen::VectorXd angles(8);
  angles << 0.6, 0.5, -0.4, 0.3, 0.1, -0.1, 0.7, -0.2;
  const Eigen::Matrix3Xd places = thread(flag, options, angles, 200);
  double length = 0;
  for (int i = 0; i < 200; ++i) length += (places.col(i + 1) - places.col(i)).norm();
  EXPECT_NEAR(length, flag.length, 1e-4);
}

Eigen::Matrix3Xd gusts(int count) {
  Eigen::Matrix3Xd wind(3, count);
  for (int p = 0; p < count; ++p) {
    const double phase = 2 * pi * p / count;
    wind.col(p) << 6 + std::sin(phase) + 0.5 * std::cos(5 * phase), std::sin(3 * phase), 0;
  }
  return wind;
}

TEST(Flap, ClosesTheLoop) {
  const Flag flag = *flag_of(preset("flag"));
  const TimeAxis loop{4, 120};
  const FlappingLoop found = flap(flag, {}, loop, gusts(120));
  double largest = 0;
  for (int p = 0; p + 1 < 120; ++p)
    largest = std::max(largest, (found.angles.col(p + 1) - found.angles.col(p)).norm());
  EXPECT_LT((found.angles.col(0) - found.angles.col(119)).norm(), 1.05 * largest);
  EXPECT_NEAR(found.stretch, 1, 0.1);
  EXPECT_LT(found.seam, 0.5);
  EXPECT_GT(found.pull, 0);
}

TEST(Flap, InAnEvenWindRepeatsAtItsOwnTime) {
  const Flag flag = *flag_of(preset("flag"));
  const FlappingLoop found = flap(flag, {}, {5, 150}, Vec3(6, 0, 0).replicate(1, 150));
  EXPECT_LT(found.seam, 0.1);
}

TEST(FlapThrough, BeginsAtRestAndRisesWithItsGust) {
  const Flag flag = *flag_of(preset("flag"));
  const FlappingOptions options;
  Eigen::Matrix3Xd wind = Eigen::Matrix3Xd::Zero(3, 90);
  for (int p = 30; p < 90; ++p) wind(0, p) = 10;
  const FlappingLoop clip = flap_through(flag, options, {3, 90}, wind, true);
  ASSERT_EQ(clip.angles.cols(), 90);
  EXPECT_LT((clip.angles.col(20) - clip.angles.col(0)).norm(), 0.1);
  EXPECT_GT(clip.angles(options.modes, 0), 1.2);
  EXPECT_LT(clip.angles(options.modes, 89), 0.4);
}

TEST(FlapThrough, BeginsAsTheFirstWindKeepsItUp) {
  const Flag flag = *flag_of(preset("flag"));
  const FlappingOptions options;
  const FlappingLoop clip = flap_through(flag, options, {2, 60}, Vec3(8, 0, 0).replicate(1, 60), false);
  EXPECT_NEAR(clip.angles.row(options.modes).head(20).mean(), clip.angles.row(options.modes).tail(20).mean(),
              0.05);
  EXPECT_LT(clip.angles(options.modes, 0), 0.3);
}

TEST(WindOn, TurnsAndScalesAsAScriptSays) {
  const Flag flag = *flag_of(preset("flag"));
  PointWind wind;
  wind.mean = Vec3(4, 0, 0);
  wind.velocity = [](int, int) -> Eigen::Matrix3Xcd { return Eigen::Matrix3Xcd::Zero(3, 1); };
  const Eigen::Matrix3Xd turned = wind_on(flag, wind, {2, 8}, [](double time) -> Mat3 {
    return Eigen::AngleAxisd(time, Vec3::UnitZ()).toRotationMatrix() * (1 + time);
  });
  EXPECT_LT((turned.col(0) - Vec3(4, 0, 0)).norm(), 1e-12);
  EXPECT_LT((turned.col(4) - 8 * Vec3(std::cos(1), std::sin(1), 0)).norm(), 1e-12);
}

TEST(DampingRates, AreThoseOfTheBendingModes) {
  Flag flag = *flag_of(plate(0.5, 1));
  flag.pinned = true;
  const Eigen::VectorXd omega = natural_omega(flag, {});
  const std::array<double, 8> rates = damping_rates(flag, {}, {.ratio = 0.03});
  EXPECT_EQ(rates[0], 0);
  for (std::size_t j = 1; j < 6; ++j)
    EXPECT_NEAR(rates[j], 2 * 0.03 * omega[static_cast<Eigen::Index>(j)], 1e-12);
}

TEST(NodeDisplacements, KeepTheThreadsOfTheSheet) {
  const Sheet sheet = preset("flag");
  const Structure structure = assemble(sheet);
  const Flag flag = *flag_of(sheet);
  Eigen::VectorXd angles(8);
  angles << 0.6, 0.5, -0.4, 0.3, 0, 0, 0.7, -0.2;
  const Eigen::VectorXd moved = node_displacements(structure, flag, {}, angles);
  const auto place = [&](int column, int row) -> Vec3 {
    const auto node = static_cast<std::size_t>(sheet.node(column, row));
    return structure.nodes[node].position + node_displacement(structure, moved, node).head<3>();
  };
  for (int row = 0; row <= sheet.elements[1]; row += 4) {
    double length = 0;
    for (int column = 0; column < sheet.elements[0]; ++column)
      length += (place(column + 1, row) - place(column, row)).norm();
    EXPECT_NEAR(length / sheet.width, 1, 0.003);
  }
  EXPECT_NEAR((place(20, 16) - place(20, 0)).norm(), sheet.height, 1e-9);
}

TEST(IntegrateFlapping, RefusesWhatIsNotSo) {
  const Flag flag = *flag_of(preset("flag"));
  const auto run = [](const Flag& of, const FlappingOptions& options) {
    return integrate_flapping(of, options, {Eigen::VectorXd::Zero(8), Eigen::VectorXd::Zero(8)}, steady(1),
                              0.1, 1);
  };
  EXPECT_THROW(run(flag, {.modes = 0}), InputError);
  EXPECT_THROW(run(flag, {.modes = 5}), InputError);
  EXPECT_THROW(run(flag, {.fluid_density = -1}), InputError);
  Flag other = flag;
  other.mass_per_area = 0;
  EXPECT_THROW(run(other, {}), InputError);
  EXPECT_THROW(flap(flag, {}, {4, 100}, gusts(99)), InputError);
}

}  // namespace
}  // namespace tremula
