#include "tremula/wind/point_wind.hpp"

#include <numbers>

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "tremula/base/error.hpp"
#include "tremula/wind/field_statistics.hpp"
#include "tremula/wind/synthesis.hpp"

namespace tremula {
namespace {

TEST(ReferenceWind, OfAModelIsWhatItWasMadeFrom) {
  const MeanWind mean{.speed = 9, .reference_height = 15, .heading = 70};
  for (const Wind& wind :
       {Wind(turbulent_wind(mean, 0.17)), Wind(turbulent_wind(mean, 0.17, SpectrumKind::iec_kaimal)),
        Wind(StamWind{.mean = mean, .turbulence_intensity = 0.17})}) {
    const ReferenceWind& found = wind.reference;
    EXPECT_EQ(found.speed, 9);
    EXPECT_EQ(found.height, 15);
    EXPECT_EQ(found.heading, 70);
    EXPECT_NEAR(found.intensity.value(), 0.17, 1e-12);
  }
  EXPECT_FALSE(Wind(StamWind{.rows = StamRows::as_printed}).reference.intensity);
  EXPECT_FALSE(Wind(turbulent_wind({.speed = 0}, 0.2)).reference.intensity);
}

TEST(ReferenceWind, OfAFieldIsItsOwnWithTheDeviationOfItsRow) {
  const MeanWind mean{.speed = 12, .reference_height = 8};
  const WindGrid grid{.y_count = 4,
                      .z_count = 5,
                      .step_count = 500,
                      .y_spacing = 2,
                      .z_spacing = 2,
                      .bottom = 2,
                      .step = 0.1};
  auto field = std::make_shared<WindField>(synthesise_wind(turbulent_wind(mean, 0.2), grid));
  const ReferenceWind found = Wind(GivenWind{field, 45}).reference;
  EXPECT_EQ(found.speed, 12);
  EXPECT_EQ(found.height, 8);
  EXPECT_EQ(found.heading, 45);
  // Row 3 lies at 8 m.
  EXPECT_NEAR(found.intensity.value(), field_statistics(*field).rows[3].deviation[0] / 12, 1e-12);
  EXPECT_THROW(Wind(GivenWind{}), InputError);
}

TEST(Wind, KnowsItsSpectrumWhereItsKindHasOne) {
  const TurbulentWind turbulent = turbulent_wind({.speed = 9}, 0.17);
  EXPECT_EQ(Wind(turbulent).spectrum(5, 0.3), spectrum_at(turbulent, 5, 0.3)[0]);
  EXPECT_GT(Wind(StamWind{}).spectrum(5, 0.3), 0);
  EXPECT_FALSE(Wind(StamWind{.rows = StamRows::as_printed}).spectrum);
  EXPECT_FALSE(Wind(turbulent_wind({.speed = 9}, 0)).spectrum);
}

// What two plants ask of one wind: the first alone, and both.
TEST(Wind, OfTheWorldIsTheSameGustsForWhoeverAsks) {
  Eigen::Matrix3Xd both = Eigen::Matrix3Xd::Random(3, 40);
  both.row(2) = 8 + 5 * both.row(2).array();
  both.topRows(2) *= 10;
  const Eigen::Matrix3Xd one = both.leftCols(15);
  TurbulentWind turbulent = turbulent_wind({.speed = 6, .heading = 25}, 0.2);
  turbulent.covariance_uw = -0.3;
  const TimeAxis loop{20, 200};
  const Wind shared(turbulent, Realisation::of_world), alone(turbulent);
  const PointWind near = wind_at_points(shared, loop, one), all = wind_at_points(shared, loop, both);
  for (const int bin : {0, 1, 7, 60}) {
    EXPECT_LT((near.velocity(bin, 0) - all.velocity(bin, 0).leftCols(15)).norm(),
              1e-5 * near.velocity(bin, 0).norm())
        << bin;
    EXPECT_GT((wind_at_points(alone, loop, one).velocity(bin, 0) -
               wind_at_points(alone, loop, both).velocity(bin, 0).leftCols(15))
                  .norm(),
              0.1 * near.velocity(bin, 0).norm())
        << bin;
  }
}

TEST(Wind, OfTheWorldAtManyPointsIsThatAtFewToTheErrorOfItsLevels) {
  // Many points share levels of height; few have their own.
  Eigen::Matrix3Xd many = Eigen::Matrix3Xd::Random(3, 900);
  many.row(2) = 8 + 5 * many.row(2).array();
  const Wind wind(turbulent_wind({.speed = 6}, 0.2), Realisation::of_world);
  const TimeAxis loop{20, 200};
  const Eigen::Matrix3Xcd all = wind_at_points(wind, loop, many).velocity(9, 0),
                          few = wind_at_points(wind, loop, many.leftCols(30)).velocity(9, 0);
  EXPECT_LT((all.leftCols(30) - few).norm(), 1e-3 * few.norm());
}

TEST(Wind, OfTheWorldHasTheSpectrumAndTheCovarianceOfTheModelAtItsHeight) {
  Eigen::Matrix3Xd points(3, 3);
  points << 0, 40, 7, 3, -25.3, 800, 2, 10, 30;
  constexpr int seeds = 4000, bin = 12;
  const TimeAxis loop{20, 400};
  TurbulentWind turbulent = turbulent_wind({.speed = 6}, 0.2);
  turbulent.covariance_uw = -0.4;
  Eigen::Matrix3Xd power = Eigen::Matrix3Xd::Zero(3, 3);
  Eigen::RowVector3d cross = Eigen::RowVector3d::Zero();
  for (int seed = 1; seed <= seeds; ++seed) {
    turbulent.seed = static_cast<std::uint64_t>(seed);
    const Eigen::Matrix3Xcd v =
        wind_at_points(Wind(turbulent, Realisation::of_world), loop, points).velocity(bin, 0);
    power += v.cwiseAbs2() / seeds;
    cross += (v.row(0).conjugate().cwiseProduct(v.row(2))).real() / seeds;
  }
  for (int k = 0; k < 3; ++k) {
    const Vec3 wanted = spectrum_at(turbulent, points(2, k), loop.frequency(bin)) / (2 * loop.period);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(power(c, k) / wanted[c], 1, 4 / std::sqrt(seeds)) << c << k;
    const double size = std::sqrt(wanted[0] * wanted[2]);
    EXPECT_NEAR(cross[k] / size, coherency_uw(turbulent), 4 / std::sqrt(seeds)) << k;
  }
}

TEST(Wind, OfTheWorldTurnsWithItsHeading) {
  Eigen::Matrix3Xd points = Eigen::Matrix3Xd::Random(3, 10);
  points.row(2) = 8 + 5 * points.row(2).array();
  const Mat3 turn = Eigen::AngleAxisd(std::numbers::pi / 3, Vec3::UnitZ()).toRotationMatrix();
  const TimeAxis loop{20, 200};
  const auto wind = [&](double heading, const Eigen::Matrix3Xd& at) {
    const Wind blowing(turbulent_wind({.speed = 6, .heading = heading}, 0.2), Realisation::of_world);
    return wind_at_points(blowing, loop, at).velocity(9, 0);
  };
  const Eigen::Matrix3Xcd straight = wind(0, points), turned = wind(60, turn * points);
  EXPECT_LT((turned - turn * straight).norm(), 1e-5 * straight.norm());
}

TEST(Wind, OfTheWorldRefusesAmplitudesOfPhasesOnly) {
  TurbulentWind turbulent = turbulent_wind({}, 0.2);
  turbulent.amplitudes = Amplitudes::phases_only;
  EXPECT_THROW(wind_at_points(Wind(turbulent, Realisation::of_world), {20, 200}, Vec3(0, 0, 1)), InputError);
}

TEST(Wind, MovedAcrossIsThatOfThePlaceToTheLeftOfItsHeading) {
  const Wind wind(turbulent_wind({.speed = 6, .heading = 90}, 0.2), Realisation::of_world);
  const TimeAxis loop{20, 200};
  const Vec3 here(2, 1, 4), there = here - 30 * Vec3::UnitX();
  const Wind moved = moved_across(wind, 30);
  EXPECT_EQ(wind_at_points(moved, loop, here).velocity(7, 0),
            wind_at_points(wind, loop, there).velocity(7, 0));
  EXPECT_EQ(moved.statistics(here).mean, wind.statistics(there).mean);
  EXPECT_THROW(moved_across(wind, NAN), InputError);
}

}  // namespace
}  // namespace tremula
