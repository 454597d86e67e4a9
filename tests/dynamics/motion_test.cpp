#include "tremula/dynamics/motion.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace tremula {
namespace {

Motion some_motion() { return {3.0, Eigen::MatrixXd::Random(7, 4), Eigen::VectorXd::Zero(6)}; }

TEST(CoordinatesAt, AreTheSamplesThemselvesBitForBitInEveryLoop) {
  const Motion motion = some_motion();
  for (const Interpolation interpolation : {Interpolation::linear, Interpolation::cubic}) {
    for (int p = -7; p < 21; ++p) {
      const Eigen::VectorXd found = coordinates_at(motion, p * motion.period / 7, interpolation);
      EXPECT_EQ(found, Eigen::VectorXd(motion.coordinates.row(((p % 7) + 7) % 7))) << "sample " << p;
    }
  }
}

TEST(CoordinatesAt, LinearGoesStraightFromSampleToSampleAndAcrossTheSeam) {
  const Motion motion = some_motion();
  const Eigen::VectorXd inside = coordinates_at(motion, 3.0 * 2.25 / 7, Interpolation::linear);
  EXPECT_LT(
      (inside - (0.75 * motion.coordinates.row(2) + 0.25 * motion.coordinates.row(3)).transpose()).norm(),
      1e-14);
  const Eigen::VectorXd seam = coordinates_at(motion, 3.0 * 6.5 / 7, Interpolation::linear);
  EXPECT_LT((seam - (0.5 * motion.coordinates.row(6) + 0.5 * motion.coordinates.row(0)).transpose()).norm(),
            1e-14);
}

TEST(CoordinatesAt, CubicHasNoKinkAtSamplesNorAtTheSeam) {
  const Motion motion = some_motion();
  const double h = 1e-6;
  for (int p = 0; p < 7; ++p) {
    const double t = p * motion.period / 7;
    const Eigen::VectorXd here = coordinates_at(motion, t, Interpolation::cubic);
    const Eigen::VectorXd before = (here - coordinates_at(motion, t - h, Interpolation::cubic)) / h;
    const Eigen::VectorXd after = (coordinates_at(motion, t + h, Interpolation::cubic) - here) / h;
    EXPECT_LT((before - after).norm(), 1e-3) << "sample " << p;
  }
}

TEST(CoordinatesAt, CubicFollowsASineCloserThanLinear) {
  Motion motion{1, Eigen::MatrixXd(32, 1), {}};
  for (int p = 0; p < 32; ++p) motion.coordinates(p, 0) = std::sin(2 * M_PI * p / 32);
  const double t = 5.5 / 32, wanted = std::sin(2 * M_PI * t);
  const double cubic = std::abs(coordinates_at(motion, t, Interpolation::cubic)[0] - wanted);
  const double linear = std::abs(coordinates_at(motion, t, Interpolation::linear)[0] - wanted);
  EXPECT_LT(cubic, linear / 20);
}

}  // namespace
}  // namespace tremula
