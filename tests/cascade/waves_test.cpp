// Stems under waves, against closed forms.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "trees.hpp"
#include "tremula/dynamics/gauge.hpp"
#include "tremula/pipeline.hpp"
#include "tremula/wind/waves.hpp"

namespace tremula {
namespace {

using std::numbers::pi;

constexpr double depth = 4, length = 3, radius = 0.02, amplitude = 0.25, water = 1000;
const TimeAxis loop{60, 600};
constexpr int bin = 15;  // a wave of four seconds

// One wave of that amplitude, along x.
Wind one_wave() {
  Wind wind;
  const double omega = loop.omega(bin), number = wave_number(omega, depth);
  wind.statistics = [=](const Vec3& place) {
    const OrbitalMotion motion = orbital_motion(omega, number, depth, place.z());
    GustStatistics result;
    result.covariance.diagonal() << motion.along * motion.along, 0, motion.up * motion.up;
    result.covariance *= amplitude * amplitude / 2;
    return result;
  };
  wind.at_points = [=](const TimeAxis&, const Eigen::Matrix3Xd& points) {
    PointWind result;
    result.mean = Eigen::Matrix3Xd::Zero(3, points.cols());
    result.velocity = [=](int p, int) {
      Eigen::Matrix3Xcd velocity = Eigen::Matrix3Xcd::Zero(3, points.cols());
      for (Eigen::Index k = 0; p == bin && k < points.cols(); ++k) {
        const OrbitalMotion motion = orbital_motion(omega, number, depth, points(2, k));
        velocity(0, k) = 0.5 * amplitude * motion.along;
        velocity(2, k) = std::complex<double>(0, 0.5 * amplitude * motion.up);
      }
      return velocity;
    };
    result.has_draws = result.has_slow_gusts = false;
    return result;
  };
  return wind;
}

// The amplitude of the moment at the foot of a stiff stem [N m].
double moment_at_the_foot(const LoadOptions& loads, Drag drag,
                          const Skeleton& stem = test::straight_stem(24, length, radius, radius),
                          int modes = 60) {
  Material stiff = find_material("birch");
  stiff.youngs_modulus = stiff.shear_modulus = 1e14;
  const StructureOptions options{.material = stiff, .added_mass_density = water, .gravity = 0};
  const Subject subject = bake(stem, {.structure = options, .modes = {.count = modes}});
  Weather weather;
  weather.wind = one_wave();
  weather.loads = loads;
  weather.drag = drag;
  weather.damping.aerodynamic = false;
  weather.lean.shelter.on = false;
  weather.loop = loop;
  weather.gauges = {place_gauge(stem, "base")};
  const Motion motion = set_in_motion(subject, weather);
  const Eigen::VectorXd moment = gauge_series(motion.readings[0], motion, 0).along_wind;
  std::complex<double> first = 0;
  for (Eigen::Index p = 0; p < moment.size(); ++p)
    first +=
        moment[p] * std::polar(2.0 / static_cast<double>(moment.size()),
                               -2 * pi * bin * static_cast<double>(p) / static_cast<double>(moment.size()));
  return std::abs(first);
}

// The integral of z cosh(kz), from the ground to the tip.
double lever(double k) { return length * std::sinh(k * length) / k - (std::cosh(k * length) - 1) / (k * k); }

TEST(StemUnderAWave, OfInertiaAloneHasTheMomentOfMorisonsSecondTerm) {
  const double omega = loop.omega(bin), k = wave_number(omega, depth);
  const double area = pi * radius * radius;
  const double wanted = water * 2 * area * omega * omega * amplitude / std::sinh(k * depth) * lever(k);
  const LoadOptions loads{.fluid_density = water, .branch_drag_coefficient = 0, .inertia_coefficient = 2};
  EXPECT_NEAR(moment_at_the_foot(loads, Drag::linear), wanted, 2e-3 * wanted);
  EXPECT_NEAR(moment_at_the_foot(loads, Drag::quadratic), wanted, 2e-3 * wanted);
}

TEST(StemUnderAWave, WithBladesHasTheMomentOfTheWaterThatTheyCarryToo) {
  constexpr double width = 0.08, mass = 0.3;
  const double omega = loop.omega(bin), k = wave_number(omega, depth);
  const double per_length = water * 2 * pi * radius * radius + mass + water * pi * width * width / 4;
  const double wanted = per_length * omega * omega * amplitude / std::sinh(k * depth) * lever(k);
  const LoadOptions loads{.fluid_density = water,
                          .branch_drag_coefficient = 0,
                          .ribbon_normal_coefficient = 0,
                          .ribbon_friction_coefficient = 0,
                          .inertia_coefficient = 2};
  const Skeleton stem = test::stem_with_ribbon(24, length, radius, width, mass);
  EXPECT_NEAR(moment_at_the_foot(loads, Drag::linear, stem), wanted, 3e-3 * wanted);
  EXPECT_NEAR(moment_at_the_foot(loads, Drag::quadratic, stem), wanted, 3e-3 * wanted);
  // With two modes the static shapes stand in for all others.
  EXPECT_NEAR(moment_at_the_foot(loads, Drag::linear, stem, 2), wanted, 0.05 * wanted);
}

TEST(StemUnderAWave, OfDragAndInertiaHasTheRootOfTheirSquares) {
  const double omega = loop.omega(bin), k = wave_number(omega, depth);
  // Borgman's linear drag: sqrt(8/pi) times the deviation of the velocity, for a Gaussian sea of that
  // deviation, as it then goes with cosh^2.
  const auto at = [&](double z) { return amplitude * omega * std::cosh(k * z) / std::sinh(k * depth); };
  double of_drag = 0;
  constexpr int pieces = 20000;
  for (int i = 0; i < pieces; ++i) {
    const double z = (i + 0.5) * length / pieces, u = at(z);
    of_drag += 0.5 * water * 1.2 * 2 * radius * std::sqrt(8 / pi) * u / std::numbers::sqrt2 * u * z * length /
               pieces;
  }
  const double of_inertia =
      water * 2 * pi * radius * radius * omega * omega * amplitude / std::sinh(k * depth) * lever(k);
  const double wanted = std::hypot(of_drag, of_inertia);
  ASSERT_GT(of_drag, 0.2 * of_inertia);
  const LoadOptions loads{.fluid_density = water, .branch_drag_coefficient = 1.2, .inertia_coefficient = 2};
  EXPECT_NEAR(moment_at_the_foot(loads, Drag::linear), wanted, 5e-3 * wanted);
}

TEST(StemUnderASea, LoopsAndGrowsWithTheWaves) {
  const Skeleton stem = test::straight_stem(12, length, 0.01, 0.004);
  const Subject subject = bake(stem, {.structure = {.added_mass_density = water}, .modes = {.count = 8}});
  const auto sway = [&](double height) {
    Weather weather;
    weather.loads.fluid_density = water;
    weather.loads.inertia_coefficient = 2;
    weather.wind = add_waves(turbulent_wind({.speed = 0.2}, 0.1),
                             {.significant_height = height, .peak_period = 5, .water_depth = depth});
    weather.loop = loop;
    const Motion motion = set_in_motion(subject, weather);
    EXPECT_EQ(displacement_at(motion, 0), displacement_at(motion, loop.period));
    return motion_statistics(subject.structure, motion).about_mean.displacement;
  };
  const double low = sway(0.1), high = sway(0.4);
  EXPECT_GT(low, 0);
  EXPECT_GT(high, 1.5 * low);
}

}  // namespace
}  // namespace tremula
