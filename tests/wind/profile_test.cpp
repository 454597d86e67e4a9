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
        MeanWind{.roughness_length = 11}, MeanWind{.power_exponent = -0.1}}) {
    EXPECT_THROW(check_mean_wind(bad), InputError);
  }
  EXPECT_NO_THROW(check_mean_wind({.speed = 0}));
}

}  // namespace
}  // namespace tremula
