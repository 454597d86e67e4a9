#include "tremula/wind/profile.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tremula/base/error.hpp"

namespace tremula {
namespace {

TEST(MeanSpeed, IsTheGivenSpeedAtTheReferenceHeightForEveryProfile) {
  for (const ProfileKind kind : {ProfileKind::constant, ProfileKind::logarithmic, ProfileKind::power}) {
    EXPECT_NEAR(mean_speed({.speed = 7, .reference_height = 12, .profile = kind}, 12), 7, 1e-14);
  }
}

TEST(MeanSpeed, OfTheLogLawGrowsByTheSameForEveryDoublingOfHeight) {
  const MeanWind wind{.speed = 8, .reference_height = 10, .roughness_length = 0.1};
  const double step = mean_speed(wind, 2) - mean_speed(wind, 1);
  EXPECT_NEAR(step, 8 * std::log(2.0) / std::log(100.0), 1e-13);
  EXPECT_NEAR(mean_speed(wind, 16) - mean_speed(wind, 8), step, 1e-13);
}

TEST(MeanSpeed, IsNeverNegativeAndZeroInTheGround) {
  for (const ProfileKind kind : {ProfileKind::constant, ProfileKind::logarithmic, ProfileKind::power}) {
    const MeanWind wind{.profile = kind};
    EXPECT_EQ(mean_speed(wind, 0), 0);
    EXPECT_EQ(mean_speed(wind, -3), 0);
    EXPECT_GE(mean_speed(wind, 0.001), 0);
  }
}

TEST(MeanSpeed, WithADisplacementIsTheLogLawOfAGroundThatMuchHigher) {
  const MeanWind raised{.speed = 5, .reference_height = 12, .roughness_length = 0.1, .displacement = 2};
  const MeanWind plain{.speed = 5, .reference_height = 10, .roughness_length = 0.1};
  for (const double z : {2.5, 4.0, 12.0, 40.0}) {
    EXPECT_NEAR(mean_speed(raised, z), mean_speed(plain, z - 2), 1e-13);
  }
  EXPECT_EQ(mean_speed(raised, 2.05), 0);
}

TEST(MeanSpeed, InACanopyFallsExponentiallyAndMeetsTheProfileAtItsTop) {
  for (const ProfileKind kind : {ProfileKind::constant, ProfileKind::logarithmic, ProfileKind::power}) {
    const MeanWind wind{.speed = 6,
                        .reference_height = 20,
                        .profile = kind,
                        .roughness_length = 0.5,
                        .displacement = 5,
                        .canopy_height = 8,
                        .canopy_decay = 2.5};
    EXPECT_NEAR(mean_speed(wind, 20), 6, 1e-13);
    EXPECT_NEAR(mean_speed(wind, 8 - 1e-9), mean_speed(wind, 8), 1e-8);
    EXPECT_NEAR(mean_speed(wind, 4) / mean_speed(wind, 8), std::exp(-1.25), 1e-13);
  }
}

TEST(MeanSpeed, IsTheGivenOneAlsoWhereTheReferenceHeightLiesInTheCanopy) {
  const MeanWind wind{.speed = 3,
                      .reference_height = 4,
                      .roughness_length = 0.5,
                      .displacement = 5,
                      .canopy_height = 8,
                      .canopy_decay = 2};
  check_mean_wind(wind);
  EXPECT_NEAR(mean_speed(wind, 4), 3, 1e-13);
  EXPECT_NEAR(mean_speed(wind, 8), 3 * std::exp(1.0), 1e-12);
  EXPECT_NEAR(mean_speed(wind, 35) / mean_speed(wind, 8), std::log(60.0) / std::log(6.0), 1e-12);
}

TEST(LogLawFrictionVelocity, IsTheSlopeOfTheProfileOverTheLogarithmOfTheHeight) {
  for (const double reference : {4.0, 30.0}) {
    const MeanWind wind{.speed = 7,
                        .reference_height = reference,
                        .roughness_length = 0.5,
                        .displacement = 5,
                        .canopy_height = 8};
    const double slope = (mean_speed(wind, 45) - mean_speed(wind, 25)) / std::log(2.0);
    EXPECT_NEAR(log_law_friction_velocity(wind), 0.4 * slope, 1e-12);
  }
}

TEST(HeadingDirection, TurnsFromXToY) {
  EXPECT_LT((heading_direction({.heading = 0}) - Vec3::UnitX()).norm(), 1e-15);
  EXPECT_LT((heading_direction({.heading = 90}) - Vec3::UnitY()).norm(), 1e-15);
  EXPECT_LT((heading_direction({.heading = 210}) - Vec3(-std::sqrt(0.75), -0.5, 0)).norm(), 1e-15);
}

TEST(CheckMeanWind, RefusesWhatIsNoWind) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const MeanWind& bad :
       {MeanWind{.speed = -1}, MeanWind{.speed = nan}, MeanWind{.speed = 1e9},
        MeanWind{.reference_height = 0}, MeanWind{.heading = nan}, MeanWind{.roughness_length = 0},
        MeanWind{.roughness_length = 11}, MeanWind{.power_exponent = -0.1}, MeanWind{.displacement = -1},
        MeanWind{.displacement = 9.99}, MeanWind{.displacement = 3, .canopy_height = 3},
        MeanWind{.canopy_height = -1}, MeanWind{.canopy_height = nan},
        MeanWind{.canopy_height = 2, .canopy_decay = -1}}) {
    EXPECT_THROW(check_mean_wind(bad), InputError);
  }
  EXPECT_NO_THROW(check_mean_wind({.speed = 0}));
}

// Mast heights, speeds, and where the wind blows to.
const std::vector<ProfileRow> mast = {{10, 4, 350}, {40, 8, 340}, {80, 9, 335}};

MeanWind measured(double speed, double reference_height) {
  return {.speed = speed,
          .reference_height = reference_height,
          .heading = 30,
          .profile = ProfileKind::table,
          .table = mast};
}

TEST(MeanSpeed, OfATableIsLinearBetweenRowsAndThatOfTheLastRowBeyond) {
  const MeanWind wind = measured(8, 40);
  EXPECT_NEAR(mean_speed(wind, 10), 4, 1e-14);
  EXPECT_NEAR(mean_speed(wind, 25), 6, 1e-14);
  EXPECT_NEAR(mean_speed(wind, 80), 9, 1e-14);
  EXPECT_NEAR(mean_speed(wind, 300), 9, 1e-14);
  EXPECT_NEAR(mean_speed(wind, 1), 4, 1e-14);
  EXPECT_EQ(mean_speed(wind, 0), 0);
  EXPECT_NEAR(mean_speed(measured(3, 25), 80), 4.5, 1e-14) << "scaled to the speed at the reference height";
}

TEST(MeanVelocity, OfATableThatVeersBlowsToTheHeadingAtTheReferenceHeightAndTurnsFromThere) {
  const MeanWind wind = measured(8, 40);
  const auto direction = [](double degrees) { return heading_direction({.heading = degrees}); };
  EXPECT_LT((mean_velocity(wind, 40) - 8 * direction(30)).norm(), 1e-13);
  EXPECT_LT((mean_velocity(wind, 25) - 6 * direction(35)).norm(), 1e-13);
  EXPECT_LT((mean_velocity(wind, 200) - 9 * direction(25)).norm(), 1e-13);
  EXPECT_EQ(veer({.heading = 30}, 100), 0);
}

TEST(CheckMeanWind, RefusesATableThatIsNoProfile) {
  const auto with = [](auto change) {
    MeanWind wind = measured(8, 40);
    change(wind);
    return wind;
  };
  EXPECT_NO_THROW(check_mean_wind(measured(8, 40)));
  EXPECT_NO_THROW(check_mean_wind(measured(0, 40)));
  for (const MeanWind& bad :
       {with([](MeanWind& w) { w.table.clear(); }), with([](MeanWind& w) { w.table[1].height = 10; }),
        with([](MeanWind& w) { w.table[0].height = -1; }), with([](MeanWind& w) { w.table[2].speed = -1; }),
        with([](MeanWind& w) { w.table[2].speed = 1e9; }),
        with([](MeanWind& w) { w.table[2].turn = std::nan(""); }),
        with([](MeanWind& w) { w.canopy_height = 5; }), with([](MeanWind& w) { w.table[1].speed = 0; })}) {
    EXPECT_THROW(check_mean_wind(bad), InputError);
  }
}

}  // namespace
}  // namespace tremula
