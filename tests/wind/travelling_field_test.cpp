#include "tremula/wind/travelling_field.hpp"

#include "tremula/base/error.hpp"
#include "tremula/numerics/fft.hpp"

#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

namespace tremula {
namespace {

constexpr TimeAxis loop{10, 200};

Wind world(double heading = 0, std::uint64_t seed = 3) {
  TurbulentWind turbulent = turbulent_wind({.speed = 8, .heading = heading}, 0.2);
  turbulent.seed = seed;
  return Wind(turbulent, Realisation::of_world);
}

// What a structure at a place feels, summed bin by bin as responses sum it.
Vec3 felt_at(const Wind& wind, const Vec3& place, double time) {
  const PointWind at = wind_at_points(wind, loop, place);
  Vec3 sum = std::numbers::sqrt2 * at.velocity(0, 0).real();
  for (int bin = 1; bin < loop.bin_count(); ++bin) {
    const double sides = 2 * bin == loop.sample_count ? 1 : 2;
    const std::complex<double> turn = std::polar(1.0, loop.omega(bin) * time);
    sum += sides * (at.velocity(bin, 0) * turn).real();
  }
  return sum + at.mean;
}

TEST(GustField, IsTheWindThatStructuresFeelAtTheSamePlaceAndTime) {
  const Wind wind = world(30);
  const Vec3 along(std::cos(std::numbers::pi / 6), std::sin(std::numbers::pi / 6), 0),
      across(-along.y(), along.x(), 0);
  const FieldPlane plane{.columns = 41, .first_column = -20, .spacing = 1, .heights = {2, 6}};
  const TravellingField field = gust_field(wind, loop, plane);
  for (const auto& [x, y, z, sample] :
       {std::tuple{0.0, 0.0, 2.0, 17}, {8.0, -13.0, 6.0, 40}, {-24.0, 20.0, 2.0, 199}}) {
    const Vec3 place = x * along + y * across + z * Vec3::UnitZ();
    const double time = sample * loop.period / loop.sample_count;
    // x / U is a whole number of samples: nothing is between.
    const double error = (value_at(field, place, time) - felt_at(wind, place, time)).norm();
    EXPECT_LT(error, 2e-4) << x << " " << y;
  }
}

TEST(GustField, ArrivesDownwindAsMuchLaterAsTheWindTakes) {
  const TravellingField field = gust_field(world(), loop, {.columns = 3, .heights = {2}});
  for (const double t : {0.0, 1.3, 9.99}) {
    const Eigen::Vector3f here = local_value_at(field, Vec3(0, 1, 2), t),
                          there = local_value_at(field, Vec3(12, 1, 2), t + 12 / field.speed);
    EXPECT_LT((here - there).norm(), 1e-4F);
  }
}

TEST(GustField, ClosesBitForBit) {
  const TravellingField field = gust_field(world(), loop, {.columns = 5, .heights = {1, 3}});
  for (const double t : {0.0, 0.37, 4.2, 9.95}) {
    for (const double x : {0.0, -3.3, 71.0}) {
      const Vec3 place(x, 1.7, 1.5);
      EXPECT_EQ(local_value_at(field, place, t), local_value_at(field, place, t + loop.period));
    }
  }
}

TEST(GustField, IsNotChangedByHowMuchOfItIsAskedFor) {
  const TravellingField small = gust_field(world(), loop, {.columns = 2, .first_column = 3, .heights = {2}}),
                        large = gust_field(world(), loop,
                                           {.columns = 80, .first_column = -40, .heights = {1, 2, 9}});
  for (const double t : {0.0, 3.3}) {
    const Eigen::Vector3f a = local_value_at(small, Vec3(5, 3, 2), t),
                          b = local_value_at(large, Vec3(5, 3, 2), t);
    EXPECT_LT((a - b).norm(), 1e-3F);
  }
}

TEST(GustField, HasTheVarianceOfItsBins) {
  double variance = 0, wanted = 0;
  constexpr int seeds = 60;
  TurbulentWind turbulent = turbulent_wind({.speed = 8}, 0.2);
  for (int seed = 1; seed <= seeds; ++seed) {
    turbulent.seed = static_cast<std::uint64_t>(seed);
    const TravellingField field =
        gust_field(Wind(turbulent, Realisation::of_world), loop, {.columns = 1, .heights = {10}});
    for (const auto& value : field.values)
      variance += static_cast<double>(value[0]) * static_cast<double>(value[0]) /
                  (seeds * static_cast<double>(field.values.size()));
  }
  for (int bin = 0; bin < loop.bin_count(); ++bin) {
    const double sides = bin == 0 ? 1 : 2;
    wanted += sides * spectrum_at(turbulent, 10, loop.middle_frequency(bin))[0] / (2 * loop.period);
  }
  EXPECT_NEAR(variance / wanted, 1, 0.2);
}

TEST(GustField, StandsOnItsGround) {
  TravellingField field = gust_field(world(), loop, {.columns = 2, .heights = {1, 5}});
  const Vec3 low = value_at(field, Vec3(1, 0.5, 3), 2);
  field.ground = 100;
  EXPECT_EQ(value_at(field, Vec3(1, 0.5, 103), 2), low);
}

TEST(PlaneAcross, CoversItsPointsAcrossTheWind) {
  const std::vector<Vec3> points{Vec3(0, 0, 0), Vec3(10, 4, 0), Vec3(-3, -2, 9)};
  const FieldPlane along_x = plane_across(points, 0, 0.5, {1});
  EXPECT_EQ(along_x.first_column, -2);
  EXPECT_NEAR(along_x.first_column + (along_x.columns - 1) * along_x.spacing, 4, 1e-12);
  EXPECT_LE(along_x.spacing, 0.5);
  const FieldPlane along_y = plane_across(points, 90, 100, {1});
  EXPECT_NEAR(along_y.first_column, -10, 1e-12);
  EXPECT_EQ(along_y.columns, 2);
}

TEST(GustField, RefusesPlanesThatAreNone) {
  EXPECT_THROW(gust_field(world(), loop, {.columns = 0}), InputError);
  EXPECT_THROW(gust_field(world(), loop, {.spacing = 0}), InputError);
  EXPECT_THROW(gust_field(world(), loop, {.heights = {}}), InputError);
  EXPECT_THROW(gust_field(world(), loop, {.heights = {2, 2}}), InputError);
  EXPECT_THROW(gust_field(world(), loop, {.first_column = NAN}), InputError);
  EXPECT_THROW(gust_field(world(), loop, {.columns = 100'000'000}), InputError);
}

}  // namespace
}  // namespace tremula
