#include "tremula/wind/stam_wind.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tremula/base/error.hpp"
#include "tremula/numerics/random.hpp"
#include "tremula/wind/spectrum.hpp"
#include "wind/points.hpp"

namespace tremula {
namespace {

const TimeAxis loop{20, 64};

// S eq. 8 as it stands: every pair, one after the other.
Eigen::Matrix3Xcd equation_8(const StamWind& wind, const Eigen::Matrix3Xd& points, int bin) {
  constexpr RandomStream streams[] = {RandomStream::wind_u, RandomStream::wind_v, RandomStream::wind_w};
  Eigen::Matrix3Xcd velocity = Eigen::Matrix3Xcd::Zero(3, points.cols());
  for (Eigen::Index k = 0; k < points.cols(); ++k) {
    for (Eigen::Index l = 0; l < points.cols(); ++l) {
      const double distance = (points.col(k) - points.col(l)).norm();
      const double h =
          std::exp(-wind.correlation_time * loop.omega(bin) * distance / wind.correlation_length);
      for (int c = 0; c < 3; ++c) {
        velocity(c, k) += h * complex_gaussian({wind.seed, streams[c], static_cast<std::uint32_t>(bin),
                                                static_cast<std::uint64_t>(l)});
      }
    }
  }
  return velocity;
}

TEST(StamWind, AsPrintedIsEquation8) {
  const StamWind wind{.mean = {.speed = 6, .heading = 0}, .rows = StamRows::as_printed, .cutoff = 0};
  const Eigen::Matrix3Xd points = test::random_points(300, 12);
  const StamWindAtPoints at_points(wind, loop, points);
  for (const int bin : {0, 1, 7, 32}) {
    const Eigen::Matrix3Xcd wanted = equation_8(wind, points, bin);
    EXPECT_LT((at_points.velocity(bin) - wanted).norm() / wanted.norm(), 1e-5) << "bin " << bin;
  }
}

TEST(StamWind, TheCutOffChangesNoPointByMoreThanTheFiltersItDrops) {
  StamWind wind{.rows = StamRows::as_printed, .cutoff = 0};
  const Eigen::Matrix3Xd points = test::random_points(400, 40);
  const Eigen::Matrix3Xcd all = StamWindAtPoints(wind, loop, points).velocity(20);
  wind.cutoff = 1e-4;
  const Eigen::Matrix3Xcd near = StamWindAtPoints(wind, loop, points).velocity(20);
  EXPECT_GT((all - near).norm(), 0) << "nothing was cut off";
  EXPECT_LT((all - near).cwiseAbs().maxCoeff(), 400 * 1e-4);
}

TEST(StamWind, HasTheSpectrumOfItsHeightInEveryRow) {
  const StamWind wind{.mean = {.speed = 6, .heading = 0, .profile = ProfileKind::constant}};
  Eigen::Matrix3Xd points(3, 3);
  points << 0, 0.5, 0, 0, 0, 2, 2, 2.5, 9;
  const TimeAxis axis{40, 64};
  const double friction_velocity = friction_velocity_from_intensity(0.2, 6);
  constexpr int seeds = 2000, bin = 9;
  Eigen::Matrix3Xd power = Eigen::Matrix3Xd::Zero(3, 3);
  for (int seed = 0; seed < seeds; ++seed) {
    StamWind seeded = wind;
    seeded.seed = static_cast<std::uint64_t>(seed);
    power += StamWindAtPoints(seeded, axis, points).velocity(bin).cwiseAbs2() / seeds;
  }
  for (int k = 0; k < 3; ++k) {
    const Vec3 wanted =
        simiu_scanlan_spectrum(axis.frequency(bin), points(2, k), 6, friction_velocity) / (2 * axis.period);
    for (int c = 0; c < 3; ++c) {
      // |v|^2 is exponential: its mean over n seeds has a standard error of 1/sqrt(n).
      EXPECT_NEAR(power(c, k) / wanted[c], 1, 4 / std::sqrt(static_cast<double>(seeds))) << c << ", " << k;
    }
  }
}

TEST(StamWind, NearPointsMoveTogetherAndFarOnesDoNot) {
  Eigen::Matrix3Xd points = Eigen::Matrix3Xd::Zero(3, 3);
  points(0, 1) = 0.05;
  points(0, 2) = 60;
  points.row(2).setConstant(5);
  std::complex<double> near = 0, far = 0;
  double power = 0;
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    const Eigen::Matrix3Xcd v = StamWindAtPoints({.seed = seed}, {20, 600}, points).velocity(40);
    near += v(0, 0) * std::conj(v(0, 1));
    far += v(0, 0) * std::conj(v(0, 2));
    power += std::norm(v(0, 0));
  }
  EXPECT_GT(near.real() / power, 0.9);
  EXPECT_LT(std::abs(far) / power, 4 / std::sqrt(500.0));
}

TEST(StamWind, BlowsAlongItsHeading) {
  const Eigen::Matrix3Xd points = test::random_points(20, 3);
  const Eigen::Matrix3Xcd east = StamWindAtPoints({.mean = {.heading = 0}}, loop, points).velocity(3);
  const Eigen::Matrix3Xcd north = StamWindAtPoints({.mean = {.heading = 90}}, loop, points).velocity(3);
  EXPECT_LT((north.row(1) - east.row(0)).norm(), 1e-12);
  EXPECT_LT((north.row(0) + east.row(1)).norm(), 1e-12);
  EXPECT_LT((north.row(2) - east.row(2)).norm(), 1e-12);
}

TEST(StamWind, OfNoSpeedDoesNotMove) {
  const StamWind calm{.mean = {.speed = 0}};
  EXPECT_EQ(StamWindAtPoints(calm, loop, test::random_points(5, 3)).velocity(4).norm(), 0);
}

TEST(StamWind, OfSlowGustsHasThePowerOfTheirFrequencyAndAnotherDrawIsAnotherWind) {
  const Eigen::Matrix3Xd points = test::random_points(5, 3);
  double power = 0;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    const StamWindAtPoints wind({.seed = seed}, loop, points);
    power += std::norm(wind.velocity(0)(0, 0)) / 400;
    EXPECT_GT((wind.velocity(0) - wind.velocity(0, 1)).norm(), 0.1 * wind.velocity(0).norm());
  }
  const MeanWind mean;
  const double height = std::max(0.5, points(2, 0)), speed = mean_speed(mean, height);
  const double wanted = simiu_scanlan_spectrum(0.25 / loop.period, height, speed,
                                               friction_velocity_from_intensity(0.2, mean.speed))[0] /
                        (2 * loop.period);
  EXPECT_NEAR(power / wanted, 1, 3 / std::sqrt(400.0));
}

TEST(CheckStamWind, RefusesSettingsOutOfRange) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const StamWind& bad : {StamWind{.turbulence_intensity = -0.1}, StamWind{.turbulence_intensity = nan},
                              StamWind{.correlation_time = -1}, StamWind{.correlation_length = 0},
                              StamWind{.cutoff = 1}, StamWind{.mean = {.speed = -1}}}) {
    EXPECT_THROW(StamWindAtPoints(bad, loop, test::random_points(2, 1)), InputError);
  }
}

}  // namespace
}  // namespace tremula
