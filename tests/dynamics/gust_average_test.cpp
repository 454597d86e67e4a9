#include "tremula/dynamics/gust_average.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <Eigen/LU>

#include "tremula/base/error.hpp"

namespace tremula {
namespace {

// Standard deviations of 1, 0.8 and 0.5 of the first along x, y, z, turned.
GustStatistics gusts_of(const Vec3& mean, double deviation, double turn = 0.4) {
  const Vec3 deviations = deviation * Vec3(1, 0.8, 0.5);
  const Mat3 axes = Eigen::AngleAxisd(turn, Vec3(0.3, -0.2, 1).normalized()).toRotationMatrix();
  return {mean, axes * deviations.cwiseAbs2().asDiagonal() * axes.transpose()};
}

// The second method: the force summed over a grid of the three-dimensional Gaussian, and its slope from the
// covariance of force and wind, E f u^T Sigma^-1.
template <class Force>
AverageForce sum_over_grid(const GustStatistics& gusts, const Force& force) {
  const Mat3 root = gusts.covariance.llt().matrixL();
  constexpr int half = 45;
  constexpr double step = 6.0 / half;
  AverageForce sum;
  double total = 0;
  for (int i = -half; i <= half; ++i) {
    for (int j = -half; j <= half; ++j) {
      for (int k = -half; k <= half; ++k) {
        const Vec3 z = step * Vec3(i + 0.41, j + 0.27, k + 0.13), u = root * z;
        const double weight = std::exp(-0.5 * z.squaredNorm());
        const Vec3 f = weight * force(gusts.mean + u);
        total += weight;
        sum.mean += f;
        sum.per_velocity += f * u.transpose();
      }
    }
  }
  return {sum.mean / total, sum.per_velocity / total * gusts.covariance.inverse()};
}

void expect_near(const AverageForce& found, const AverageForce& wanted, double tolerance) {
  EXPECT_LT((found.mean - wanted.mean).norm(), tolerance * wanted.mean.norm());
  EXPECT_LT((found.per_velocity - wanted.per_velocity).norm(), tolerance * wanted.per_velocity.norm());
}

const Vec3 axis = Vec3(0.2, 0.5, 1).normalized();

Vec3 drag_across(const Vec3& wind) {
  const Vec3 across = wind - axis * axis.dot(wind);
  return across.norm() * across;
}

TEST(AverageDragAcross, IsTheSumOverTheDistributionOfTheWind) {
  for (const double deviation : {0.5, 2.0, 3.0, 12.0}) {
    const GustStatistics gusts = gusts_of({6, 1, -0.5}, deviation);
    SCOPED_TRACE(deviation);
    expect_near(average_drag_across(axis, gusts), sum_over_grid(gusts, drag_across), 1e-4);
  }
}

TEST(AverageDragAcross, IsTheSumWhereTheMeanWindBlowsAlongTheAxisToo) {
  const GustStatistics gusts = gusts_of(6 * axis + Vec3(0.3, 0, 0), 3);
  expect_near(average_drag_across(axis, gusts), sum_over_grid(gusts, drag_across), 1e-3);
  const GustStatistics calm = gusts_of(6 * axis, 3);
  const AverageForce found = average_drag_across(axis, calm);
  EXPECT_LT(found.mean.norm(), 1e-13);
  const Mat3 wanted = sum_over_grid(calm, drag_across).per_velocity;
  EXPECT_LT((found.per_velocity - wanted).norm(), 1e-3 * wanted.norm());
}

TEST(AverageDragAcross, OfGustsInOneDirectionIsTheClosedForm) {
  // E|U + u|(U + u) = (U^2 + s^2) erf(U/(s sqrt 2)) + U s sqrt(2/pi) exp(-U^2/(2 s^2)) and its derivative
  // along the wind; across it E|U + u|.
  const Vec3 x = axis.unitOrthogonal(), y = axis.cross(x);
  for (const double U : {0.0, 0.01, 1.0, 5.0, 40.0}) {
    const double s = 2;
    const double error = std::erf(U / (s * std::numbers::sqrt2));
    const double bell = s * std::sqrt(2 / std::numbers::pi) * std::exp(-U * U / (2 * s * s));
    const AverageForce found = average_drag_across(axis, {U * x + 3 * axis, s * s * x * x.transpose()});
    const double mean = (U * U + s * s) * error + U * bell;
    EXPECT_LT((found.mean - mean * x).norm(), 1e-4 * mean + 1e-13) << U;
    const double speed = U * error + bell;
    const Mat3 slope = 2 * speed * x * x.transpose() + speed * y * y.transpose();
    EXPECT_LT((found.per_velocity - slope).norm(), 1e-4 * slope.norm()) << U;
  }
}

TEST(AverageDragAcross, WithoutGustsIsTheLinearisedDrag) {
  const Vec3 wind(6, 1, -0.5), across = wind - axis * axis.dot(wind), n = across.normalized();
  const AverageForce found = average_drag_across(axis, {wind, Mat3::Zero()});
  EXPECT_LT((found.mean - drag_across(wind)).norm(), 1e-13 * across.squaredNorm());
  const Mat3 slope = across.norm() * (Mat3::Identity() - axis * axis.transpose() + n * n.transpose());
  EXPECT_LT((found.per_velocity - slope).norm(), 1e-13 * slope.norm());
  EXPECT_EQ(average_drag_across(axis, {}).per_velocity.norm(), 0) << "no wind at all";
}

TEST(AverageDragAcross, KeepsItsDigitsWhereGustsAreAlmostNone) {
  const Vec3 wind(6, 1, -0.5);
  const AverageForce none = average_drag_across(axis, {wind, Mat3::Zero()});
  for (const double deviation : {1e-2, 1e-4, 1e-8, 1e-160})
    expect_near(average_drag_across(axis, gusts_of(wind, deviation)), none, 1e-12 + deviation * deviation);
}

TEST(AverageDrag, IsTheSumOverTheDistributionOfTheWind) {
  for (const double deviation : {0.5, 3.0, 12.0}) {
    const GustStatistics gusts = gusts_of({6, 1, -0.5}, deviation);
    SCOPED_TRACE(deviation);
    expect_near(average_drag(gusts), sum_over_grid(gusts, [](const Vec3& v) -> Vec3 { return v.norm() * v; }),
                1e-4);
  }
}

TEST(AverageDrag, InGustsAloneIsTheMeanSpeedOfMaxwellsDistribution) {
  // E df/dv of |v| v without a mean wind: (1 + 1/3) E|v|, E|v| = 2 s sqrt(2/pi).
  const AverageForce found = average_drag({Vec3::Zero(), 9 * Mat3::Identity()});
  const double wanted = 4.0 / 3.0 * 2 * 3 * std::sqrt(2 / std::numbers::pi);
  EXPECT_LT((found.per_velocity - wanted * Mat3::Identity()).norm(), 1e-4 * wanted);
  EXPECT_LT(found.mean.norm(), 1e-14);
}

TEST(AverageFoldingDrag, IsTheSumOverTheDistributionOfTheWind) {
  for (const double exponent : {0.0, -0.4, -0.7, -1.0, -1.3}) {
    const FoliageLaw law{.vogel_exponent = exponent, .folding_speed = 4};
    const FoldingMixture mixture = mix_folding(law);
    const auto force = [&](const Vec3& v) -> Vec3 { return folding_factor(law, v.norm()) * v.norm() * v; };
    for (const double speed : {0.5, 6.0, 25.0}) {
      for (const double intensity : {0.2, 0.5}) {
        const GustStatistics gusts = gusts_of(speed * Vec3(1, 0.2, -0.1), speed * intensity);
        SCOPED_TRACE(testing::Message() << exponent << ' ' << speed << ' ' << intensity);
        expect_near(average_folding_drag(mixture, gusts), sum_over_grid(gusts, force), 1e-3);
      }
    }
  }
}

TEST(AverageFoldingDrag, InGustsLargerThanTheMeanIsTheSumToo) {
  const FoldingMixture mixture = mix_folding({.vogel_exponent = -0.7, .folding_speed = 4});
  const auto force = [&](const Vec3& v) -> Vec3 {
    return folding_factor(mixture.law, v.norm()) * v.norm() * v;
  };
  for (const double speed : {0.1, 2.0}) {
    const GustStatistics gusts = gusts_of(speed * Vec3::UnitX(), 4);
    SCOPED_TRACE(speed);
    expect_near(average_folding_drag(mixture, gusts), sum_over_grid(gusts, force), 1e-3);
  }
}

TEST(AverageFoldingDrag, OfLeavesThatDoNotFoldIsThatOfAverageDrag) {
  const FoldingMixture mixture = mix_folding({.vogel_exponent = 0, .folding_speed = 3});
  for (const double deviation : {0.0, 2.0, 9.0}) {
    const GustStatistics gusts = gusts_of({1, 3, 0.2}, deviation);
    expect_near(average_folding_drag(mixture, gusts), average_drag(gusts), 1e-5);
  }
}

TEST(AverageFoldingDrag, WithoutGustsIsTheDerivativeOfTheDragInTheMeanWind) {
  const FoldingMixture mixture = mix_folding({.vogel_exponent = -0.7, .folding_speed = 4});
  const Vec3 wind(5, 2, -1);
  const double h = 1e-6, speed = wind.norm();
  const AverageForce found = average_folding_drag(mixture, {wind, Mat3::Zero()});
  EXPECT_LT((found.mean - folding_factor(mixture.law, speed) * speed * wind).norm(), 1e-12);
  for (int c = 0; c < 3; ++c) {
    const auto force_at = [&](double change) -> Vec3 {
      const Vec3 v = wind + change * Vec3::Unit(c);
      return folding_factor(mixture.law, v.norm()) * v.norm() * v;
    };
    const Vec3 slope = (force_at(h) - force_at(-h)) / (2 * h);
    EXPECT_LT((found.per_velocity.col(c) - slope).norm(), 1e-7 * slope.norm());
  }
}

TEST(AverageFoldingDrag, ChangesSmoothlyWithTheWind) {
  // An iteration that looks for a wind must not meet steps where the rule moves on in its table.
  const FoldingMixture mixture = mix_folding({.vogel_exponent = -0.7, .folding_speed = 4});
  const auto force_at = [&](double speed) {
    return average_folding_drag(mixture, gusts_of(speed * Vec3::UnitX(), 0.4 * speed)).mean.x();
  };
  for (double speed = 1; speed < 3; speed *= 1.01) {
    const double h = 1e-7 * speed;
    const double before = force_at(speed) - force_at(speed - h),
                 after = force_at(speed + h) - force_at(speed);
    EXPECT_NEAR(after / before, 1, 1e-4) << speed;
  }
}

TEST(AverageFoldingDrag, TakesEverySpeedAndGustsInOneDirection) {
  const FoldingMixture mixture = mix_folding({.vogel_exponent = -0.7, .folding_speed = 4});
  for (const double speed : {1e-200, 1e-9, 1e-4, 1.0, 1e4, 1e9}) {
    const Mat3 covariance = 0.1 * speed * speed * Vec3::UnitX() * Vec3::UnitX().transpose();
    const AverageForce found = average_folding_drag(mixture, {speed * Vec3::UnitX(), covariance});
    const double steady = folding_factor(mixture.law, speed) * speed * speed;
    EXPECT_GE(found.mean.x(), steady * (1 - 1e-3)) << speed;
    EXPECT_LE(found.mean.x(), 1.1001 * steady) << speed;
    EXPECT_EQ(found.mean.tail<2>().norm(), 0);
  }
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(average_folding_drag(mixture, {Vec3(1, nan, 0), Mat3::Identity()}).mean.hasNaN());
}

TEST(AlongNormal, IsTheAverageOfTheForceOnAFlatBlade) {
  const GustStatistics gusts = gusts_of({6, 1, -0.5}, 3);
  const auto force = [](const Vec3& v) -> Vec3 { return v.norm() * v.dot(axis) * axis; };
  expect_near(along_normal(average_drag(gusts), axis), sum_over_grid(gusts, force), 1e-4);
}

TEST(MixFolding, RefusesWhatIsNoLaw) {
  EXPECT_THROW(mix_folding({.vogel_exponent = 1}), InputError);
  EXPECT_THROW(mix_folding({.folding_speed = 0}), InputError);
}

}  // namespace
}  // namespace tremula
