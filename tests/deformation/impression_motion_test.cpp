#include "tremula/deformation/impression_motion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace tremula {
namespace {

// A parabola, whose cubics are exact but for the ends.
ImpressionMotion parabola(double height) {
  ImpressionMotion motion;
  motion.heading = 30;
  for (int i = 0; i <= 64; ++i) {
    const double share = i / 64.0;
    motion.heights.push_back(height * share);
    motion.lean.emplace_back(0.3 * share * share, 0);
    motion.share.emplace_back(share * share, 0.5 * share * share);
  }
  auto field = std::make_shared<TravellingField>();
  field->loop = {.period = 4, .sample_count = 64};
  field->heading = 30;
  field->speed = 5;
  field->mean = {Vec3::Zero()};
  for (int p = 0; p < 64; ++p) {
    const auto value = static_cast<float>(std::sin(2 * std::numbers::pi * p / 64));
    field->values.push_back({value, 0.5F * value, 0, 0});
  }
  motion.sway = field;
  return motion;
}

TEST(TrunkCurve, IsTheCurveItIsMadeOfAndGoesStraightOnAbove) {
  const ImpressionMotion motion = parabola(8);
  const TrunkCurve curve = trunk_curve(motion);
  Eigen::Vector4f value, slope;
  for (const double height : {0.0, 1.7, 4.0, 6.3}) {
    const double share = height / 8;
    curve.at(static_cast<float>(height), value, slope);
    EXPECT_NEAR(value[0], 0.3 * share * share, 1e-3);
    EXPECT_NEAR(value[3], 0.5 * share * share, 1e-3);
  }
  Eigen::Vector4f top, rise;
  curve.at(8, top, rise);
  curve.at(11, value, slope);
  EXPECT_LT((value - (top + 3 * rise)).norm(), 1e-5F);
  EXPECT_EQ(slope, rise);
}

TEST(TrunkCurve, HasTheSlopesThatItsValuesHave) {
  const TrunkCurve curve = trunk_curve(parabola(8));
  constexpr float h = 0.01F;
  for (const float height : {0.3F, 2.2F, 5.1F, 7.9F, 9.0F}) {
    Eigen::Vector4f low, high, unused, slope;
    curve.at(height - h, low, unused);
    curve.at(height + h, high, unused);
    curve.at(height, unused, slope);
    EXPECT_LT((slope - (high - low) / (2 * h)).norm(), 1e-3F) << height;
  }
}

TEST(PlaceInWind, ShiftsALevelAsTheTrunkIsShiftedThereInTheAxesOfTheWind) {
  const ImpressionMotion motion = parabola(8);
  const TrunkCurve curve = trunk_curve(motion);
  const Instance at{.position = {3, -2, 1}, .turn = 1.1, .scale = 2, .time_shift = 0.25};
  const Vec3 resting(0.4, -0.2, 6);
  const double heading = 30 * std::numbers::pi / 180;
  const Vec3 along(std::cos(heading), std::sin(heading), 0), across(-along.y(), along.x(), 0);
  for (const double time : {0.0, 0.6, 3.1}) {
    const double phase = 2 * std::numbers::pi * (time + 0.25 - at.position.dot(along) / 5) / 4;
    const double share = 0.75 * 0.75, top = std::sin(phase);
    const Vec3 shift = (0.3 * share + share * top) * along + 0.5 * share * 0.5 * top * across;
    const Vec3 wanted = at.position + 2 * (at.rotation() * resting + shift);
    EXPECT_LT((place_in_wind(motion, curve, at, resting, time) - wanted).norm(), 5e-3) << time;
    EXPECT_EQ(place_in_wind(motion, curve, at, resting, time),
              place_in_wind(motion, curve, at, resting, time + 4))
        << "the loop closes";
  }
  EXPECT_EQ(place_in_wind({}, trunk_curve({}), at, resting, 1), at.position + 2 * (at.rotation() * resting));
}

}  // namespace
}  // namespace tremula
