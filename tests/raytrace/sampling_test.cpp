#include "tremula/raytrace/sampling.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <set>

#include <Eigen/LU>

namespace tremula {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

TEST(Sampler, FillsEveryElementaryIntervalOnceInEveryPairOfDimensions) {
  for (int pair = 0; pair < 5; ++pair) {
    for (int shape = 0; shape <= 6; ++shape) {  // 2^shape columns and 2^(6 - shape) rows
      std::set<std::pair<int, int>> cells;
      for (std::uint32_t s = 0; s < 64; ++s) {
        Sampler sampler(7, 1234, s);
        Vector2f at;
        for (int i = 0; i <= pair; ++i) at = sampler.pair();
        ASSERT_TRUE(at.x() >= 0 && at.x() < 1 && at.y() >= 0 && at.y() < 1);
        cells.emplace(static_cast<int>(at.x() * static_cast<float>(1 << shape)),
                      static_cast<int>(at.y() * static_cast<float>(1 << (6 - shape))));
      }
      EXPECT_EQ(cells.size(), 64U) << "pair " << pair << ", " << (1 << shape) << " columns";
    }
  }
}

TEST(Sampler, GivesOtherNumbersToOtherPixelsSeedsAndDimensions) {
  Sampler here(1, 5, 3), beside(1, 6, 3), seeded(2, 5, 3), again(1, 5, 3);
  const Vector2f first = here.pair(), second = here.pair();
  EXPECT_NE(first, second);
  EXPECT_NE(first, beside.pair());
  EXPECT_NE(first, seeded.pair());
  EXPECT_EQ(first, again.pair());
}

TEST(Sampler, IntegratesASmoothFunctionFarBetterThanChance) {
  const int count = 1024;
  double sum = 0;
  for (std::uint32_t s = 0; s < count; ++s) {
    Sampler sampler(3, 99, s);
    const Vector2f at = sampler.pair();
    sum += static_cast<double>(at.x() * at.y() * at.y());
  }
  EXPECT_NEAR(sum / count, 1.0 / 6, 2e-4);  // chance alone: 0.2 / 32
}

TEST(ToCone, StaysInTheConeAndFillsItEvenly) {
  const Vector3f axis = Vector3f(1, -2, 0.5F).normalized();
  const LocalAxes axes(axis);
  const float cosine = std::cos(0.1F);
  Vector3f mean = Vector3f::Zero();
  const int count = 4096;
  for (std::uint32_t s = 0; s < count; ++s) {
    Sampler sampler(1, 1, s);
    const Vector3f direction = to_cone(sampler.pair(), axes, cosine);
    EXPECT_NEAR(direction.norm(), 1, 1e-5);
    EXPECT_GE(direction.dot(axis), cosine - 1e-6F);
    mean += direction / count;
  }
  EXPECT_LT((mean - axis * (1 + cosine) / 2).norm(), 1e-4);  // the mean of cos over the cap
}

TEST(LocalAxes, AreAtRightAnglesForAnyNormal) {
  for (const Vector3f& n :
       {Vector3f(0, 0, 1), Vector3f(0, 0, -1), Vector3f(1, 0, 0), Vector3f(0.6F, 0, -0.8F)}) {
    const LocalAxes axes(n);
    Eigen::Matrix3f matrix;
    matrix << axes.x, axes.y, axes.z;
    EXPECT_LT((matrix.transpose() * matrix - Eigen::Matrix3f::Identity()).norm(), 1e-5);
    EXPECT_NEAR(matrix.determinant(), 1, 1e-5);
    const Vector3f v(0.3F, -1, 2);
    EXPECT_LT((axes.out(axes.in(v)) - v).norm(), 1e-5);
  }
}

}  // namespace
}  // namespace tremula
