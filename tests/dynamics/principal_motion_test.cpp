#include "tremula/dynamics/principal_motion.hpp"

#include "tremula/base/error.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace tremula {
namespace {

constexpr double two_pi = 2 * std::numbers::pi;
const TimeAxis loop{10, 200};

// Three nodes that move by three shapes, at 1, 2 and 3 Hz and of falling strength.
Eigen::MatrixXd three_shapes() {
  Eigen::MatrixXd shapes = Eigen::MatrixXd::Random(18, 3), samples(3, loop.sample_count);
  for (int p = 0; p < loop.sample_count; ++p) {
    for (int k = 0; k < 3; ++k)
      samples(k, p) = std::pow(0.1, k) * std::sin(two_pi * (k + 1) * p * loop.period / loop.sample_count + k);
  }
  return shapes * samples;
}

TEST(PrincipalMotion, OfThreeShapesIsThemAndGivesEveryDisplacementBack) {
  const Eigen::MatrixXd displacements = three_shapes();
  const Eigen::VectorXd lean = Eigen::VectorXd::LinSpaced(18, 0, 1);
  const PrincipalMotion found = principal_motion(lean, loop, displacements, {.tolerance = 1e-9});
  EXPECT_EQ(found.motion.basis.count(ShapeKind::mode), 3);
  EXPECT_LT(found.left_out, 1e-7);
  for (const int p : {0, 17, 199}) {
    const Eigen::VectorXd at = displacement_at(found.motion, p * loop.period / loop.sample_count);
    EXPECT_LT((at - lean - displacements.col(p)).norm(), 1e-7 * displacements.norm());
  }
}

TEST(PrincipalMotion, LeavesOutNoMoreThanItSays) {
  const Eigen::MatrixXd displacements = three_shapes();
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(18);
  for (const double tolerance : {0.3, 0.05, 0.005}) {
    const PrincipalMotion found = principal_motion(none, loop, displacements, {.tolerance = tolerance});
    double missing = 0, all = 0;
    for (int p = 0; p < loop.sample_count; ++p) {
      const Eigen::VectorXd at = displacement_at(found.motion, p * loop.period / loop.sample_count);
      for (int node = 0; node < 3; ++node) {
        missing += (at - displacements.col(p)).segment<3>(6 * node).squaredNorm();
        all += displacements.col(p).segment<3>(6 * node).squaredNorm();
      }
    }
    EXPECT_LE(found.left_out, tolerance);
    EXPECT_NEAR(std::sqrt(missing / all), found.left_out, 1e-7);
  }
}

TEST(PrincipalMotion, OfOneHarmonicHasItsFrequency) {
  Eigen::MatrixXd displacements(6, loop.sample_count);
  for (int p = 0; p < loop.sample_count; ++p)
    displacements.col(p).setConstant(std::cos(two_pi * 0.5 * p * loop.period / loop.sample_count));
  const PrincipalMotion found = principal_motion(Eigen::VectorXd::Zero(6), loop, displacements);
  ASSERT_EQ(found.motion.basis.count(), 2);
  EXPECT_NEAR(found.motion.basis.frequency[1], 0.5, 1e-3);
}

TEST(PrincipalMotion, OfNoMotionIsTheLeanAlone) {
  const PrincipalMotion found =
      principal_motion(Eigen::VectorXd::Ones(6), loop, Eigen::MatrixXd::Zero(6, loop.sample_count));
  EXPECT_EQ(found.motion.basis.count(), 1);
  EXPECT_EQ(found.left_out, 0);
}

TEST(PrincipalMotion, RefusesWhatDoesNotFit) {
  const Eigen::VectorXd lean = Eigen::VectorXd::Zero(6);
  EXPECT_THROW(principal_motion(lean, loop, Eigen::MatrixXd::Zero(12, 200)), InputError);
  EXPECT_THROW(principal_motion(lean, loop, Eigen::MatrixXd::Zero(6, 100)), InputError);
  EXPECT_THROW(principal_motion(lean, loop, Eigen::MatrixXd::Zero(6, 200), {.tolerance = 1}), InputError);
}

}  // namespace
}  // namespace tremula
