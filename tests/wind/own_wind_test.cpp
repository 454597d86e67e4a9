#include "tremula/wind/point_wind.hpp"

#include <gtest/gtest.h>

#include <complex>
#include <limits>

#include "tremula/base/error.hpp"

namespace tremula {
namespace {

const TimeAxis loop{20, 100};

PointWind still(const Eigen::Matrix3Xd& points) {
  const Eigen::Index count = points.cols();
  return {.mean = Eigen::Matrix3Xd::Zero(3, count),
          .velocity = [count](int, int) { return Eigen::Matrix3Xcd(Eigen::Matrix3Xcd::Ones(3, count)); }};
}

Wind changed(const std::function<void(PointWind&)>& change) {
  Wind own;
  own.at_points = [change](const TimeAxis&, const Eigen::Matrix3Xd& points) {
    PointWind wind = still(points);
    change(wind);
    return wind;
  };
  return own;
}

TEST(OwnWind, IsWhatItsFunctionGives) {
  const Eigen::Matrix3Xd points = Eigen::Matrix3Xd::Constant(3, 4, 2);
  const TurbulentWind turbulent = turbulent_wind({.speed = 5, .heading = 40}, 0.2);
  Wind own;
  own.reference = {.speed = 5, .heading = 40};
  own.at_points = [turbulent](const TimeAxis& axis, const Eigen::Matrix3Xd& at) {
    PointWind wind = wind_at_points(turbulent, axis, at);
    wind.is_checked = false;
    return wind;
  };
  const PointWind given = wind_at_points(own, loop, points), wanted = wind_at_points(turbulent, loop, points);
  EXPECT_EQ(given.mean, wanted.mean);
  EXPECT_EQ(given.velocity(7, 3), wanted.velocity(7, 3));
  EXPECT_EQ(given.power(0.4), wanted.power(0.4));
  EXPECT_EQ(given.has_draws, wanted.has_draws);
}

TEST(OwnWind, IsRefusedWhereItsFunctionGivesNoWind) {
  const Eigen::Matrix3Xd points = Eigen::Matrix3Xd::Ones(3, 4);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto made_of = [&](const Wind& wind) { return wind_at_points(wind, loop, points); };
  EXPECT_NO_THROW(made_of(changed([](PointWind&) {})).velocity(1, 0));
  EXPECT_THROW(made_of(Wind{}), InputError);
  for (const Wind& bad :
       {changed([](PointWind& w) { w.velocity = {}; }), changed([](PointWind& w) { w.mean.resize(3, 3); }),
        changed([nan](PointWind& w) { w.mean(1, 2) = nan; })}) {
    EXPECT_THROW(made_of(bad), InputError);
  }
  Wind fast = changed([](PointWind&) {});
  fast.reference.speed = nan;
  EXPECT_THROW(made_of(fast), InputError);
  // What is drawn later is looked at then.
  const auto one_short = [](int, int) { return Eigen::Matrix3Xcd(Eigen::Matrix3Xcd::Ones(3, 3)); };
  const auto no_number = [nan](int, int) {
    return Eigen::Matrix3Xcd(Eigen::Matrix3Xcd::Constant(3, 4, nan));
  };
  const auto no_power = [](double) { return -1.0; };
  EXPECT_THROW(made_of(changed([&](PointWind& w) { w.velocity = one_short; })).velocity(1, 0), InputError);
  EXPECT_THROW(made_of(changed([&](PointWind& w) { w.velocity = no_number; })).velocity(1, 0), InputError);
  EXPECT_THROW(made_of(changed([&](PointWind& w) { w.power = no_power; })).power(1), InputError);
}

}  // namespace
}  // namespace tremula
