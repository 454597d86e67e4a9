#include "tremula/wind/gust_script.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "complaint.hpp"

namespace tremula {
namespace {

TEST(WindAtTime, IsLinearBetweenRowsAndStandsBeforeAndBehindThem) {
  const GustScript script{.rows = {{1, 4, 0}, {3, 8, 20}, {4, 2, 30}}};
  EXPECT_EQ(wind_at_time(script, 0).speed, 4);
  EXPECT_EQ(wind_at_time(script, 2).speed, 6);
  EXPECT_EQ(wind_at_time(script, 2).heading, 10);
  EXPECT_EQ(wind_at_time(script, 3).speed, 8);
  EXPECT_NEAR(wind_at_time(script, 3.25).speed, 6.5, 1e-12);
  EXPECT_EQ(wind_at_time(script, 99).speed, 2);
}

TEST(WindAtTime, TurnsTheShorterWayRound) {
  const GustScript script{.rows = {{0, 5, 350}, {1, 5, 10}, {2, 5, -170}}};
  EXPECT_NEAR(wind_at_time(script, 0.5).heading, 360, 1e-9);
  EXPECT_NEAR(std::remainder(wind_at_time(script, 0.25).heading - 355, 360), 0, 1e-9);
  // Half a turn: either way is the shorter one, and the end is met.
  EXPECT_NEAR(std::remainder(wind_at_time(script, 1.9999999).heading + 170, 360), 0, 1e-4);
}

TEST(WindAtTime, AddsOneMinusCosine) {
  const GustScript script{.rows = {{0, 3, 0}}, .gust = OneMinusCosine{8, 2, 1}};
  EXPECT_EQ(wind_at_time(script, 0.9).speed, 3);
  EXPECT_NEAR(wind_at_time(script, 1.5).speed, 3 + 4, 1e-12);
  EXPECT_NEAR(wind_at_time(script, 2).speed, 3 + 8, 1e-12);
  EXPECT_NEAR(wind_at_time(script, 2.25).speed, 3 + 4 * (1 - std::cos(1.25 * std::numbers::pi)), 1e-12);
  EXPECT_EQ(wind_at_time(script, 3).speed, 3);
}

TEST(MeanOf, IsTheWindWhoseDragIsTheMeanOne) {
  const TimeAxis axis{.period = 2, .sample_count = 2000};
  EXPECT_NEAR(mean_of({.rows = {{0, 5, 40}}}, axis).speed, 5, 1e-12);
  EXPECT_NEAR(mean_of({.rows = {{0, 5, 40}}}, axis).heading, 40, 1e-9);
  // The mean square of a ramp from 0 to 6 is 12.
  EXPECT_NEAR(mean_of({.rows = {{0, 0, 0}, {2, 6, 0}}}, axis).speed, std::sqrt(12), 0.01);
  // Half the time each way at a right angle.
  const GustRow turned = mean_of({.rows = {{0, 5, 0}, {1 - 1e-9, 5, 0}, {1, 5, 90}}}, axis);
  EXPECT_NEAR(turned.heading, 45, 0.2);
  // To and fro: no mean drag, and the first heading.
  EXPECT_EQ(mean_of({.rows = {{0, 5, 30}, {0.9995, 5, 30}, {0.99951, 5, 210}}}, axis).heading, 30);
}

TEST(ChangeOfWind, ScalesAndTurns) {
  const Mat3 change = change_of_wind({0, 12, 120}, 6, 30);
  EXPECT_NEAR((change * Vec3(1, 0, 0.5) - Vec3(0, 2, 1)).norm(), 0, 1e-12);
  EXPECT_EQ(test::complaint_of([] {
              change_of_wind({0, 12, 120}, 0, 0);
            }),
            "wind under a gust script: 0 m/s, wanted above 0 m/s");
}

TEST(CheckGustScript, RefusesWhatCannotBlowInOneLine) {
  const auto complaint = [](const GustScript& script) {
    return test::complaint_of([&] { check_gust_script(script); });
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(complaint({}), "rows of a gust script: 0, wanted at least 1");
  EXPECT_EQ(complaint({.rows = {{1, 1, 0}, {1, 2, 0}}}),
            "time in row 2 of a gust script: 1 s, wanted finite, and more than in the row before");
  EXPECT_EQ(complaint({.rows = {{1, -1, 0}}}),
            "speed in row 1 of a gust script: -1 m/s, wanted 0 to 100 m/s");
  EXPECT_FALSE(complaint({.rows = {{1, 1, nan}}}).empty());
  EXPECT_EQ(complaint({.rows = {{0, 1, 0}}, .gust = OneMinusCosine{1, 0, 0}}),
            "duration of the gust: 0 s, wanted above 0 s");
  EXPECT_EQ(complaint({.rows = {{0, 1, 0}}, .gust = OneMinusCosine{-2, 1, 0}}),
            "amplitude of the gust: -2 m/s, wanted a lull that leaves a wind of 0 m/s or more");
  EXPECT_EQ(complaint({.rows = {{0, 3, 0}}, .gust = OneMinusCosine{-2, 1, 0}}), "");
}

}  // namespace
}  // namespace tremula
