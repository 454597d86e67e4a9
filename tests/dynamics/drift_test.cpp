#include "tremula/dynamics/drift.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include <tbb/global_control.h>

#include "complaint.hpp"
#include "tremula/base/error.hpp"
#include "tremula/wind/point_wind.hpp"

namespace tremula {
namespace {

using Eigen::Vector3f;

constexpr double gravity = 9.81;

// The same everywhere; along x the mean, and a wave of one frequency that fits the loop.
TravellingField even_wind(const TimeAxis& loop, const Vec3& mean, double amplitude = 0, int waves = 0) {
  TravellingField field{.loop = loop, .plane = {}, .mean = {mean}, .values = {}};
  field.values.resize(index_of(loop.sample_count));
  for (int p = 0; p < loop.sample_count; ++p) {
    const double phase = 2 * std::numbers::pi * waves * p / loop.sample_count;
    field.values[index_of(p)] = {static_cast<float>(amplitude * std::sin(phase)), 0, 0, 0};
  }
  return field;
}

Wind breeze(double speed, std::uint64_t seed = 1) {
  TurbulentWind wind = turbulent_wind(mean_wind_over(terrain_named("grass"), speed, 10, 30), 0.2);
  wind.seed = seed;
  return wind;
}

TravellingField gusts_for(const Drift& drift, double speed, const TimeAxis& loop, std::uint64_t seed = 1) {
  return gust_field(breeze(speed, seed), loop, plane_around(drift, 30));
}

// All of one size and speed.
DriftKind alike(double fall_speed, double number_density) {
  DriftKind kind = drift_kind_named("snow");
  kind.smallest = kind.largest = kind.size;
  kind.fall_spread = 0;
  kind.fall_speed = fall_speed;
  kind.number_density = number_density;
  return kind;
}

constexpr TimeAxis loop{.period = 6, .sample_count = 180};

TEST(Carry, InStillAirAllFallAtTheirFallSpeedFromTheTopToTheGround) {
  const Drift drift{.kind = alike(1.5, 2)};
  const DriftPaths paths = carry(even_wind(loop, Vec3::Zero()), drift);
  ASSERT_GT(paths.paths.size(), 100U);
  for (const DriftPath& path : paths.paths) {
    EXPECT_NEAR(path.air_time, 10 / 1.5, 1e-4);
    for (const float age : {0.0F, 1.23F, 4.0F}) {
      const Vector3f fallen = place_at(paths, path, age) - path.start;
      EXPECT_LT((fallen - Vector3f(0, 0, -1.5F * age)).norm(), 2e-4F);
    }
  }
}

TEST(Carry, AMeanWindTakesThemAlongAtItsSpeed) {
  const Drift drift{.kind = alike(1, 2)};
  const DriftPaths paths = carry(even_wind(loop, Vec3(4, -2, 0)), drift);
  ASSERT_GT(paths.paths.size(), 100U);
  for (const DriftPath& path : paths.paths) {
    const float age = 0.5F * path.air_time;
    EXPECT_LT((place_at(paths, path, age) - path.start - age * Vector3f(4, -2, -1)).norm(), 1e-3F);
  }
}

// x'' = (A sin(omega t) - x')/tau: x' = A/sqrt(1 + (omega tau)^2) sin(omega t - atan(omega tau)).
TEST(Carry, AGustThatSwingsMovesThemByTheClosedFormOfAFirstOrderLag) {
  constexpr double amplitude = 3;
  for (const double speed : {1.0, 6.0}) {
    for (const int waves : {3, 6}) {
      const TimeAxis fine{.period = 6, .sample_count = 1200};
      const Drift drift{.kind = alike(speed, 0.005), .low = {-40, -40, 0}, .high = {40, 40, 60}};
      const DriftPaths paths = carry(even_wind(fine, Vec3::Zero(), amplitude, waves), drift);
      const double omega = 2 * std::numbers::pi * waves / fine.period, tau = speed / gravity;
      const double swing = amplitude / (omega * std::hypot(1, omega * tau)), late = std::atan(omega * tau);
      int seen = 0;
      for (const DriftPath& path : paths.paths) {
        const auto first = static_cast<float>(paths.step * std::ceil(6 * tau / paths.step));
        if (path.air_time < first + 2) continue;
        ++seen;
        const float start = place_at(paths, path, first).x();
        const auto phase = [&](float age) { return omega * static_cast<double>(path.birth + age) - late; };
        for (int i = 1; first + static_cast<float>(i * paths.step) < path.air_time; ++i) {
          const float age = first + static_cast<float>(i * paths.step);
          const double expected = -swing * (std::cos(phase(age)) - std::cos(phase(first)));
          EXPECT_NEAR(static_cast<double>(place_at(paths, path, age).x() - start), expected, 0.03 * swing);
        }
      }
      EXPECT_GT(seen, 20);
    }
  }
}

// v is what 1/(1 + i omega tau) makes of the wind that each meets on its way: by cross spectra of 12.8 s
// (Hann), of velocities from differences, whose factor sin(omega h)/(omega h) is known.
TEST(Carry, InTurbulenceVelocityFollowsTheWindOnTheWayAsTheTransferFunctionSays) {
  const TimeAxis axis{.period = 20, .sample_count = 600};
  const Drift drift{.kind = alike(3, 0.004), .low = {-60, -60, 0}, .high = {60, 60, 48}};
  const TravellingField gusts = gusts_for(drift, 5, axis);
  const DriftPaths paths = carry(gusts, drift);
  constexpr int count = 256;
  constexpr float h = 0.05F;
  const double tau = 3 / gravity;
  for (const int bin : {5, 7}) {
    const double omega = 2 * std::numbers::pi * bin / (count * static_cast<double>(h));
    std::complex<double> cross = 0;
    double power = 0;
    int seen = 0;
    for (const DriftPath& path : paths.paths) {
      if (path.air_time < h * (count + 45)) continue;
      ++seen;
      std::array<std::complex<double>, 2> velocity{}, wind{};
      for (int k = 0; k < count; ++k) {
        const float age = 2 + h * static_cast<float>(k);
        const Vector3f before = place_at(paths, path, age - h), after = place_at(paths, path, age + h);
        const Vec3 u = value_at(gusts, place_at(paths, path, age).cast<double>(),
                                static_cast<double>(path.birth) + static_cast<double>(age));
        const double angle = 2 * std::numbers::pi * k / count;
        const std::complex<double> wave = (1 - std::cos(angle)) * std::polar(1.0, -bin * angle);
        for (int c = 0; c < 2; ++c) {
          velocity[index_of(c)] += wave * static_cast<double>((after[c] - before[c]) / (2 * h));
          wind[index_of(c)] += wave * u[c];
        }
      }
      for (std::size_t c = 0; c < 2; ++c) {
        cross += velocity[c] * std::conj(wind[c]);
        power += std::norm(wind[c]);
      }
    }
    ASSERT_GT(seen, 100);
    const double differences = std::sin(omega * static_cast<double>(h)) / (omega * static_cast<double>(h));
    const std::complex<double> expected = 1.0 / std::complex<double>(1, omega * tau);
    EXPECT_LT(std::abs(cross / power / differences - expected), 0.04) << bin;
  }
}

// Flakes are born independently of each other: numbers are Poisson's, here to 4 standard deviations. A gust
// that travels with the mean wind presses together what it comes upon, for it has no wind across to match:
// in turbulence their number goes up and down with it, about the same mean.
void check_numbers(const TravellingField& wind, const Drift& drift, double swing, double of_mean) {
  const DriftPaths paths = carry(wind, drift);
  const Vec3 middle = 0.5 * (drift.low + drift.high), half = 0.5 * (drift.high - drift.low);
  const double all = drift.kind.number_density * (2 * half).prod();
  constexpr int times = 12;
  double mean = 0;
  std::array<double, 8> octants{};
  for (int i = 0; i < times; ++i) {
    const std::vector<DriftSight> seen = drift_at(paths, i * wind.loop.period / times);
    EXPECT_NEAR(static_cast<double>(seen.size()), all, 4 * std::sqrt(all) + swing * all) << i;
    mean += static_cast<double>(seen.size()) / times;
    for (const DriftSight& one : seen) {
      const Vec3 off = one.place.cast<double>() - middle;
      EXPECT_LT(off.cwiseQuotient(half).cwiseAbs().maxCoeff(), 1.002);
      octants[index_of((off.x() > 0 ? 1 : 0) + (off.y() > 0 ? 2 : 0) + (off.z() > 0 ? 4 : 0))] += 1.0 / times;
    }
  }
  EXPECT_NEAR(mean, all, 4 * std::sqrt(all / times) + of_mean * all);
  for (const double octant : octants)
    EXPECT_NEAR(octant, all / 8, 4 * std::sqrt(all / 8) + of_mean * all / 8);
}

TEST(Carry, NumberAndDensityStayWhatIsAskedAtAllTimesAndPlaces) {
  const TimeAxis axis{.period = 12, .sample_count = 240};
  const Drift drift{.kind = alike(1.2, 2), .low = {-12, -9, 4}, .high = {12, 9, 16}};
  check_numbers(even_wind(axis, Vec3(3, 2, 0), 2, 3), drift, 0, 0);
  check_numbers(gusts_for(drift, 5, axis), drift, 0.12, 0.03);
}

TEST(DriftAt, ALoopLaterTheBitsAreTheSame) {
  const Drift drift{.kind = alike(1, 1)};
  const DriftPaths paths = carry(gusts_for(drift, 4, loop), drift);
  for (const double time : {0.0, 0.2, 1.7, 3.1415, 5.999}) {
    const std::vector<DriftSight> now = drift_at(paths, time);
    for (const double periods : {1.0, -1.0, 7.0}) {
      const std::vector<DriftSight> later = drift_at(paths, time + periods * loop.period);
      ASSERT_EQ(now.size(), later.size());
      for (std::size_t i = 0; i < now.size(); ++i) {
        EXPECT_EQ(now[i].path, later[i].path);
        EXPECT_EQ(now[i].place, later[i].place);
      }
    }
  }
}

TEST(DriftAt, OverTheSeamOfTheLoopEachGoesOn) {
  const Drift drift{.kind = alike(1, 1), .lying_time = 2};
  const DriftPaths paths = carry(gusts_for(drift, 4, loop), drift);
  constexpr float moment = 1e-3F;
  std::multimap<std::uint32_t, DriftSight> before;
  for (const DriftSight& one : drift_at(paths, loop.period - static_cast<double>(moment)))
    before.emplace(one.path, one);
  int going_on = 0;
  for (const DriftSight& one : drift_at(paths, 0)) {
    if (one.age < 2 * moment) continue;
    const auto [first, last] = before.equal_range(one.path);
    const bool found = std::any_of(first, last, [&](const auto& was) {
      return std::abs(was.second.age + moment - one.age) < 1e-4F &&
             (was.second.place - one.place).norm() < 20 * moment;
    });
    EXPECT_TRUE(found);
    ++going_on;
  }
  EXPECT_GT(going_on, 1000);
}

TEST(DriftAt, WhatHasComeDownLiesStillOnTheGroundForItsTime) {
  const TimeAxis axis{.period = 9, .sample_count = 90};
  const Drift drift{.kind = alike(1, 1), .low = {-10, -10, -3}, .high = {10, 10, 12}, .lying_time = 5};
  TravellingField wind = even_wind(axis, Vec3(1, 0, 0), 1, 4);
  wind.ground = 2;
  const DriftPaths paths = carry(wind, drift);
  double lying = 0;
  for (int i = 0; i < 6; ++i) {
    for (const DriftSight& one : drift_at(paths, 1.5 * i)) {
      EXPECT_GT(one.place.z(), 1.99F);
      const DriftPath& path = paths.paths[one.path];
      if (one.age <= path.air_time) continue;
      lying += 1.0 / 6;
      EXPECT_EQ(one.place.z(), 2);
      EXPECT_EQ(one.place, place_at(paths, path, path.air_time + 5));
    }
  }
  // What comes down on 400 m^2 in 5 s, but for the strip that is not reached before the box ends.
  EXPECT_NEAR(lying, 2000, 4 * std::sqrt(2000.0));
}

TEST(MeanSeen, IsTheMeanOfThoseThatAreSeen) {
  const Drift drift{.kind = alike(1, 1), .lying_time = 2};
  const DriftPaths paths = carry(gusts_for(drift, 4, loop), drift);
  double sum = 0;
  constexpr int times = 120;
  for (int i = 0; i < times; ++i)
    sum += static_cast<double>(drift_at(paths, i * loop.period / times).size()) / times;
  EXPECT_NEAR(mean_seen(paths), sum, 1e-3 * sum);
}

TEST(Thinned, LeavesEachWithTheSameChanceWhereItWas) {
  const Drift drift{.kind = alike(1, 2)};
  const DriftPaths all = carry(gusts_for(drift, 4, loop), drift);
  std::map<std::pair<std::uint32_t, float>, const DriftPath*> by_mark;
  for (const DriftPath& path : all.paths) by_mark[{path.mark, path.birth}] = &path;
  for (const double share : {0.1, 0.5, 0.9}) {
    const DriftPaths fewer = thinned(all, share);
    const auto count = static_cast<double>(all.paths.size());
    EXPECT_NEAR(static_cast<double>(fewer.paths.size()), share * count,
                4 * std::sqrt(share * (1 - share) * count));
    // By what they are, none is favoured: in the halves of the box, and of the short and the long flights.
    double left = 0, all_left = 0, flights = 0, all_flights = 0;
    for (const DriftPath& path : all.paths)
      all_left += path.start.x() < 0 ? 1 : 0, all_flights += path.air_time > 2 ? 1 : 0;
    for (const DriftPath& path : fewer.paths) {
      left += path.start.x() < 0 ? 1 : 0, flights += path.air_time > 2 ? 1 : 0;
      const DriftPath& was = *by_mark.at({path.mark, path.birth});
      for (const float age : {0.0F, 0.37F, 1.2F, 9.0F})
        EXPECT_EQ(place_at(fewer, path, age), place_at(all, was, age));
    }
    EXPECT_NEAR(left, share * all_left, 4 * std::sqrt(share * all_left));
    EXPECT_NEAR(flights, share * all_flights, 4 * std::sqrt(share * all_flights));
  }
  EXPECT_EQ(thinned(all, 1).off_line, all.off_line);
  EXPECT_TRUE(thinned(all, 0).paths.empty());
}

TEST(Carry, ASourceLetsGoAsManyAsItsRateSaysFromItsBox) {
  Drift drift{.kind = drift_kind_named("leaves"), .low = {-30, -30, 0}, .high = {30, 30, 12}};
  drift.source = {.low = {-2, -2, 5}, .high = {2, 2, 9}, .rate = 40};
  const DriftPaths paths = carry(gusts_for(drift, 4, loop), drift);
  EXPECT_EQ(paths.paths.size(), 240U);
  for (const DriftPath& path : paths.paths) {
    EXPECT_LE((path.start - Vector3f(0, 0, 7)).cwiseAbs().maxCoeff(), 2);
    // Let go from rest: at first as gravity and the wind pull.
    const Vector3f moved = place_at(paths, path, 0.05F) - place_at(paths, path, 0);
    EXPECT_LT(moved.norm(), 0.2F);
  }
}

TEST(Carry, TheBytesDoNotDependOnTheThreads) {
  const Drift drift{.kind = drift_kind_named("snow"), .low = {-5, -5, 0}, .high = {5, 5, 5}};
  const TravellingField gusts = gusts_for(drift, 4, loop);
  const DriftPaths many = carry(gusts, drift);
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  const DriftPaths one = carry(gusts, drift);
  ASSERT_EQ(many.paths.size(), one.paths.size());
  EXPECT_EQ(many.off_line, one.off_line);
  for (std::size_t i = 0; i < one.paths.size(); ++i) {
    EXPECT_EQ(many.paths[i].start, one.paths[i].start);
    EXPECT_EQ(many.paths[i].birth, one.paths[i].birth);
    EXPECT_EQ(many.paths[i].air_time, one.paths[i].air_time);
  }
}

TEST(FallSpeed, OfRainIsThatOfGunnAndKinzer) {
  const DriftKind rain = drift_kind_named("rain");
  const std::map<double, double> measured = {{1, 4.03}, {2, 6.49}, {3, 8.06}, {4, 8.83}, {5, 9.09}};
  for (const auto& [diameter, speed] : measured)
    EXPECT_NEAR(fall_speed(rain, 1e-3 * diameter), speed, 0.02 * speed);
}

TEST(FallSpeed, OfSnowIsThatOfLocatelliAndHobbs) {
  const DriftKind snow = drift_kind_named("snow");
  for (const double diameter : {2.0, 4.0, 8.0})
    EXPECT_NEAR(fall_speed(snow, 1e-3 * diameter), 0.8 * std::pow(diameter, 0.16), 0.01);
}

TEST(WithIntensity, OfRainHasTheNumbersOfMarshallAndPalmer) {
  for (const double rate : {1.0, 10.0}) {
    const DriftKind rain = with_intensity(drift_kind_named("rain"), rate);
    const double slope = 4.1 * std::pow(rate, -0.21);  // [1/mm]
    double sum = 0, diameters = 0;
    for (double d = 1; d < 20; d += 1e-3) {
      const double number = 8000 * std::exp(-slope * (d + 5e-4)) * 1e-3;  // [1/m^3]
      sum += number;
      diameters += (d + 5e-4) * number;
    }
    EXPECT_NEAR(rain.number_density, sum, 1e-3 * sum);
    EXPECT_NEAR(1e3 * rain.size, diameters / sum, 1e-3);
    EXPECT_NEAR(fall_speed(rain, 2e-3), fall_speed(drift_kind_named("rain"), 2e-3), 1e-9);
  }
}

// Water that comes down on a square metre in an hour, from the flakes themselves.
TEST(WithIntensity, OfSnowBringsDownThatMuchWater) {
  const Drift drift{
      .kind = with_intensity(drift_kind_named("snow"), 1.5), .low = {0, 0, 0}, .high = {5, 5, 4}};
  const TimeAxis axis{.period = 20, .sample_count = 100};
  const DriftPaths paths = carry(even_wind(axis, Vec3::Zero()), drift);
  double mass = 0, squares = 0;
  for (const DriftPath& path : paths.paths) {
    const double one = 16 * std::numbers::pi / 6 * std::pow(static_cast<double>(path.size), 3);
    mass += one;
    squares += one * one;
  }
  const double per_hour = 3600 / (25 * axis.period);
  EXPECT_NEAR(mass * per_hour, 1.5, 4 * std::sqrt(squares) * per_hour);
}

TEST(CheckDrift, RefusesWhatDoesNotDrift) {
  const auto complaint = [](const auto& change) {
    Drift drift{.kind = drift_kind_named("snow")};
    change(drift);
    return test::complaint_of([&] { check_drift(drift); });
  };
  EXPECT_EQ(complaint([](Drift& d) { d.kind.matter_density = 2600; }),
            "matter density of snow: 2600 kg/m^3, wanted above 0 to 2000: stone does not drift");
  EXPECT_EQ(complaint([](Drift& d) { d.kind.fall_speed = 70; }),
            "fall speed of snow: 70 m/s, wanted 0.01 to 60 m/s, the largest and fastest included: stone does "
            "not drift");
  EXPECT_NE(complaint([](Drift& d) { d.high.x() = d.low.x(); }), "");
  EXPECT_NE(complaint([](Drift& d) { d.kind.size = 0; }), "");
  EXPECT_NE(complaint([](Drift& d) { d.lying_time = std::numeric_limits<double>::quiet_NaN(); }), "");
  EXPECT_NE(complaint([](Drift& d) { d.source = {.low = {0, 0, 0}, .high = {1, 1, 99}}; }), "");
  EXPECT_EQ(complaint([](Drift&) {}), "");
}

TEST(Carry, RefusesMoreThanMemoryHolds) {
  const Drift drift{.kind = alike(1, 1000), .low = {-1000, -1000, 0}, .high = {1000, 1000, 100}};
  EXPECT_THROW(carry(even_wind(loop, Vec3::Zero()), drift), InputError);
}

}  // namespace
}  // namespace tremula
