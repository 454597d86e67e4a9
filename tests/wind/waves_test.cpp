#include "tremula/wind/waves.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "tremula/base/error.hpp"
#include "tremula/wind/turbulent_wind.hpp"

namespace tremula {
namespace {

using std::numbers::pi;
using testing::HasSubstr;

constexpr double gravity = 9.81;
const Waves sea{.significant_height = 1.2, .peak_period = 7, .water_depth = 9, .heading = 30};

std::string complaint(const Waves& waves) {
  try {
    check_waves(waves);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(WaveNumber, SolvesTheDispersionRelationFromPuddlesToTheDeepSea) {
  for (double depth = 1e-3; depth < 1e4; depth *= 7) {
    for (double omega = 1e-3; omega < 100; omega *= 3) {
      const double k = wave_number(omega, depth);
      EXPECT_NEAR(gravity * k * std::tanh(k * depth), omega * omega, 4e-15 * omega * omega) << depth;
    }
  }
  EXPECT_DOUBLE_EQ(wave_number(2, 1e3), 4 / gravity);
  EXPECT_NEAR(wave_number(1e-4, 2) * std::sqrt(gravity * 2) / 1e-4, 1, 1e-8);
  EXPECT_EQ(wave_number(0, 5), 0);
}

TEST(WaveSpectrum, HasTheSignificantHeightAndThePeakThatWereAskedFor) {
  for (const double enhancement : {1.0, 3.3, 7.0}) {
    Waves waves = sea;
    waves.peak_enhancement = enhancement;
    const WaveSpectrum spectrum(waves);
    // By the rectangle rule, to where a millionth is left.
    double variance = 0, largest = 0, peak = 0;
    const double step = 1e-5;
    for (double f = step / 2; f < 4; f += step) {
      const double value = spectrum(f);
      variance += value * step;
      if (value > largest) {
        largest = value;
        peak = f;
      }
    }
    EXPECT_NEAR(4 * std::sqrt(variance), 1.2, 1e-5);
    EXPECT_NEAR(peak, 1 / 7.0, 2 * step);
  }
}

TEST(WaveSpectrum, WithoutEnhancementIsThatOfPiersonAndMoskowitz) {
  Waves waves = sea;
  waves.peak_enhancement = 1;
  const WaveSpectrum spectrum(waves);
  for (const double f : {0.1, 0.14, 0.2, 0.5}) {
    const double wanted =
        5.0 / 16 * 1.2 * 1.2 * std::pow(7, -4) * std::pow(f, -5) * std::exp(-1.25 * std::pow(7 * f, -4));
    EXPECT_NEAR(spectrum(f), wanted, 2e-6 * wanted);
  }
  EXPECT_EQ(spectrum(0), 0);
}

// The potential of Airy's wave, by hand, at points and instants.
TEST(WavesAtPoints, MoveTheWaterAsAnAiryWaveDoesAtEveryDepth) {
  const TimeAxis loop{60, 512};
  Eigen::Matrix3Xd points(3, 4);
  points << 0, 3, 3, -20, 0, 1, 1, 5, 0, 2, 9, 6.5;
  const PointWind water = wind_at_points(wind_of(sea), loop, points);
  const Vec3 along(std::cos(pi / 6), std::sin(pi / 6), 0);
  const int bin = 9;
  const Eigen::Matrix3Xcd velocity = water.velocity(bin, 0);
  const double omega = loop.omega(bin), k = wave_number(omega, 9);
  // The crest at the origin, from the first point, which lies on the ground.
  const std::complex<double> first = along.cast<std::complex<double>>().dot(velocity.col(0));
  const std::complex<double> crest = first / (omega / std::sinh(k * 9));
  for (Eigen::Index i = 0; i < 4; ++i) {
    const double x = along.dot(points.col(i)), z = points(2, i);
    for (const double t : {0.0, 1.3, 4.0}) {
      const double phase = k * x - omega * t - std::arg(crest), height = 2 * std::abs(crest);
      const double u = height * omega * std::cosh(k * z) / std::sinh(k * 9) * std::cos(phase);
      const double w = height * omega * std::sinh(k * z) / std::sinh(k * 9) * std::sin(phase);
      const Vec3 wanted = u * along + w * Vec3::UnitZ();
      const Vec3 found = 2 * (velocity.col(i) * std::polar(1.0, omega * t)).real();
      EXPECT_LT((found - wanted).norm(), 1e-12 * height) << i << " at " << t;
    }
  }
}

TEST(WavesAtPoints, HaveTheVarianceThatTheirStatisticsSay) {
  const TimeAxis loop{400, 8192};
  const Wind wind = wind_of(sea);
  for (const double z : {0.0, 4.0, 9.0}) {
    const Eigen::Matrix3Xd point = Vec3(2, 1, z);
    const PointWind water = wind_at_points(wind, loop, point);
    // Of many seas, and the spectrum at the place by its own function.
    Mat3 covariance = Mat3::Zero();
    double by_spectrum = 0;
    constexpr int draws = 60;
    for (int bin = 1; bin < loop.bin_count(); ++bin) {
      by_spectrum += wind.spectrum(z, loop.frequency(bin)) / loop.period;
      for (int draw = 0; draw < draws; ++draw) {
        const Eigen::Vector3cd v = water.velocity(bin, draw);
        covariance += 2.0 / draws * (v * v.adjoint()).real();
      }
    }
    const Mat3 wanted = wind.statistics(point).covariance;
    const Vec3 along(std::cos(pi / 6), std::sin(pi / 6), 0);
    EXPECT_NEAR(by_spectrum, along.dot(wanted * along), 2e-3 * by_spectrum);
    // Some fifty bins carry the energy, each with sixty draws.
    EXPECT_LT((covariance - wanted).norm(), 0.08 * wanted.norm()) << z;
  }
}

TEST(WavesAtPoints, OfShallowWaterMoveItAlikeFromGroundToSurface) {
  const Waves shallow{.significant_height = 0.1, .peak_period = 60, .water_depth = 1};
  const GustStatistics low = wind_of(shallow).statistics(Vec3(0, 0, 0)),
                       high = wind_of(shallow).statistics(Vec3(0, 0, 1));
  EXPECT_NEAR(low.covariance(0, 0), high.covariance(0, 0), 5e-3 * high.covariance(0, 0));
  // u = eta sqrt(g/h) in long waves.
  EXPECT_NEAR(low.covariance(0, 0), std::pow(0.1 / 4, 2) * gravity, 5e-3 * low.covariance(0, 0));
  EXPECT_EQ(low.covariance(2, 2), 0);
}

TEST(AddWaves, AddsUpMeansSpectraAndVelocities) {
  const TimeAxis loop{60, 256};
  const Eigen::Matrix3Xd points = Vec3(1, 2, 3);
  const Wind current = turbulent_wind({.speed = 0.5, .reference_height = 5}, 0.1);
  const Wind both = add_waves(current, sea);
  const PointWind sum = wind_at_points(both, loop, points), one = wind_at_points(current, loop, points),
                  other = wind_at_points(wind_of(sea), loop, points);
  EXPECT_EQ(sum.mean, one.mean);
  for (const int bin : {0, 1, 8, 100}) {
    EXPECT_LT((sum.velocity(bin, 2) - one.velocity(bin, 2) - other.velocity(bin, 2)).norm(), 1e-15);
  }
  EXPECT_EQ(both.reference.speed, 0.5);
  EXPECT_EQ(both.spectrum(3, 0.15), current.spectrum(3, 0.15) + wind_of(sea).spectrum(3, 0.15));
  const Vec3 place(1, 2, 3);
  EXPECT_EQ(both.statistics(place).covariance,
            Mat3(current.statistics(place).covariance + wind_of(sea).statistics(place).covariance));
}

// In deep water 0.283 U^2/g and 7.54 U/g; in shallow water the depth decides, and nothing breaks.
TEST(WindWaves, AreAFullyDevelopedSeaInDeepWaterAndLowerAndShorterInShallow) {
  const Waves deep = wind_waves(10, 1e4);
  EXPECT_NEAR(deep.significant_height, 0.283 * 100 / gravity, 1e-7);
  EXPECT_NEAR(deep.peak_period, 7.54 * 10 / gravity, 1e-7);
  for (const double depth : {0.2, 1.0, 3.0, 10.0, 40.0}) {
    double height = 0, period = 0;
    for (const double wind : {0.5, 2.0, 6.0, 12.0, 25.0, 60.0}) {
      const Waves waves = wind_waves(wind, depth);
      EXPECT_GE(waves.significant_height, height);
      EXPECT_GT(waves.peak_period, period);
      EXPECT_LE(waves.significant_height, wind_waves(wind, 2 * depth).significant_height);
      EXPECT_EQ(waves.water_depth, depth);
      EXPECT_NO_THROW(check_waves(waves)) << wind << " " << depth;
      height = waves.significant_height;
      period = waves.peak_period;
    }
  }
  EXPECT_THROW(wind_waves(0, 3), InputError);
  EXPECT_THROW(wind_waves(5, 0), InputError);
}

TEST(Waves, ThatCannotBeAreRefused) {
  Waves waves = sea;
  waves.significant_height = -1;
  EXPECT_THAT(complaint(waves), HasSubstr("significant height of the waves: -1, wanted 0 m or more"));
  waves = sea;
  waves.peak_period = 0;
  EXPECT_THAT(complaint(waves), HasSubstr("peak period of the waves"));
  waves = sea;
  waves.water_depth = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(complaint(waves), HasSubstr("depth of the water"));
  waves = sea;
  waves.peak_enhancement = 0.5;
  EXPECT_THAT(complaint(waves), HasSubstr("1 to 10"));
  waves = {.significant_height = 2, .peak_period = 20, .water_depth = 3};
  EXPECT_THAT(complaint(waves), HasSubstr("higher ones break in 3 m of water"));
  waves = {.significant_height = 2, .peak_period = 2, .water_depth = 300};
  EXPECT_THAT(complaint(waves), HasSubstr("at most 0.892"));
  EXPECT_THROW(wind_of(waves), InputError);
}

TEST(Waves, LongerThanTheLoopAreRefusedAndAPlantAboveTheSurfaceIsToldOf) {
  const Eigen::Matrix3Xd points = Vec3(0, 0, 9.5);
  EXPECT_THROW(wind_at_points(wind_of(sea), {6, 100}, points), InputError);
  const PointWind water = wind_at_points(wind_of(sea), {60, 100}, points);
  ASSERT_EQ(water.warnings.size(), 1U);
  EXPECT_THAT(water.warnings[0], HasSubstr("reaches 9.5 m above the ground and the water is 9 m deep"));
}

}  // namespace
}  // namespace tremula
