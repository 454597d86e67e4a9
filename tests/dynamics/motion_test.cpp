#include "tremula/dynamics/motion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <vector>

#include "tremula/base/error.hpp"

namespace tremula {
namespace {

// Four coordinates, of modes.
Motion some_motion() {
  return {3.0,
          {std::vector(4, ShapeKind::mode), Eigen::VectorXd::Ones(4), Eigen::MatrixXd::Random(6, 4)},
          Eigen::MatrixXd::Random(7, 4)};
}

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
  Motion motion{
      1, {{ShapeKind::mode}, Eigen::VectorXd::Ones(1), Eigen::MatrixXd::Ones(6, 1)}, Eigen::MatrixXd(32, 1)};
  for (int p = 0; p < 32; ++p) motion.coordinates(p, 0) = std::sin(2 * M_PI * p / 32);
  const double t = 5.5 / 32, wanted = std::sin(2 * M_PI * t);
  const double cubic = std::abs(coordinates_at(motion, t, Interpolation::cubic)[0] - wanted);
  const double linear = std::abs(coordinates_at(motion, t, Interpolation::linear)[0] - wanted);
  EXPECT_LT(cubic, linear / 20);
}

TEST(CoordinatesAt, OfALeanAreOneToTheLastBit) {
  Motion motion = some_motion();
  motion.basis.kind[0] = ShapeKind::lean;
  motion.coordinates.col(0).setOnes();
  for (const Interpolation interpolation : {Interpolation::linear, Interpolation::cubic}) {
    for (double time = -3; time < 6; time += 0.0371)
      EXPECT_EQ(coordinates_at(motion, time, interpolation)[0], 1) << time;
  }
}

TEST(DisplacementAt, IsTheSumOfTheShapesByTheirCoordinates) {
  const Motion motion = some_motion();
  for (const double time : {0.0, 1.234, -7.0}) {
    const Eigen::VectorXd wanted = motion.basis.columns * coordinates_at(motion, time, Interpolation::cubic);
    EXPECT_LT((displacement_at(motion, time, Interpolation::cubic) - wanted).norm(), 1e-14);
  }
}

TEST(MakeMotion, PutsTheLeanBeforeTheSeriesOfTheSpectra) {
  const Basis basis{{ShapeKind::lean, ShapeKind::mode}, Eigen::Vector2d(0, 1), Eigen::MatrixXd::Ones(6, 2)};
  Eigen::MatrixXcd spectra = Eigen::MatrixXcd::Zero(5, 1);
  spectra(1, 0) = {0.3, -0.2};
  const TimeAxis loop{.period = 2, .sample_count = 8};
  const Motion motion = make_motion(basis, loop, spectra);
  EXPECT_EQ(motion.period, 2);
  for (int p = 0; p < 8; ++p) {
    EXPECT_EQ(motion.coordinates(p, 0), 1);
    EXPECT_NEAR(motion.coordinates(p, 1), 2 * (spectra(1, 0) * std::polar(1.0, 2 * M_PI * p / 8)).real(),
                1e-15);
  }
  EXPECT_THROW(make_motion(basis, loop, Eigen::MatrixXcd(Eigen::MatrixXcd::Zero(5, 2))), InputError);
}

}  // namespace
}  // namespace tremula
