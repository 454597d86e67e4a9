#include "tremula/dynamics/motion_statistics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "trees.hpp"
#include "tremula/base/error.hpp"

namespace tremula {
namespace {

struct Case {
  Structure structure = assemble(test::straight_stem(4, 2, 0.02, 0.01), {});
  Modes modes;
  Motion motion{2, Eigen::MatrixXd::Random(50, 3), Eigen::VectorXd::Random(24)};
  Case() {
    modes.frequency = Eigen::VectorXd::Ones(2);
    modes.shapes = Eigen::MatrixXd::Random(24, 2);
    motion.static_shapes = {Eigen::VectorXd::Ones(1), Eigen::MatrixXd::Random(24, 1)};
  }
  Eigen::MatrixXd shapes() const {
    Eigen::MatrixXd all(24, 3);
    all << modes.shapes, motion.static_shapes.shapes;
    return all;
  }
};

Sway sway_frame_by_frame(const Case& c, const Eigen::RowVectorXd& about) {
  Sway sway;
  for (int k = 0; k < 4; ++k) {
    double squares = 0, rotation_squares = 0;
    for (int p = 0; p < 50; ++p) {
      const Eigen::VectorXd u = c.shapes() * (c.motion.coordinates.row(p) - about).transpose();
      squares += u.segment<3>(6 * k).squaredNorm() / 50;
      rotation_squares += u.segment<3>(6 * k + 3).squaredNorm() / 50;
    }
    if (std::sqrt(squares) > sway.displacement) sway.branch = k;
    sway.displacement = std::max(sway.displacement, std::sqrt(squares));
    sway.rotation = std::max(sway.rotation, std::sqrt(rotation_squares));
  }
  return sway;
}

TEST(MotionStatistics, AreTheRootMeanSquaresOfTheDisplacementsAboutTheLeanAndAboutTheLoopsOwnMean) {
  Case c;
  c.motion.coordinates.rowwise() += Eigen::RowVector3d(0.5, -1, 2);
  const Eigen::RowVectorXd mean = c.motion.coordinates.colwise().mean();
  const MotionStatistics found = motion_statistics(c.structure, c.modes, c.motion);
  const Sway lean = sway_frame_by_frame(c, Eigen::RowVector3d::Zero()), own = sway_frame_by_frame(c, mean);
  EXPECT_NEAR(found.about_lean.displacement, lean.displacement, 1e-12);
  EXPECT_NEAR(found.about_lean.rotation, lean.rotation, 1e-12);
  EXPECT_EQ(found.about_lean.branch, lean.branch);
  EXPECT_NEAR(found.about_mean.displacement, own.displacement, 1e-12);
  EXPECT_NEAR(found.about_mean.rotation, own.rotation, 1e-12);
  EXPECT_LT(found.about_mean.displacement, 0.8 * found.about_lean.displacement);
  for (int r = 0; r < 3; ++r) {
    // The mean square about the lean is that about the mean and the square of the mean.
    EXPECT_NEAR(std::hypot(found.about_mean.coordinates[r], mean[r]), found.about_lean.coordinates[r], 1e-13);
  }
}

TEST(MotionStatistics, HaveTheLargestLean) {
  const Case c;
  double largest = 0, largest_rotation = 0;
  for (int k = 0; k < 4; ++k) {
    largest = std::max(largest, c.motion.lean.segment<3>(6 * k).norm());
    largest_rotation = std::max(largest_rotation, c.motion.lean.segment<3>(6 * k + 3).norm());
  }
  const MotionStatistics found = motion_statistics(c.structure, c.modes, c.motion);
  EXPECT_EQ(found.largest_lean, largest);
  EXPECT_EQ(found.largest_lean_rotation, largest_rotation);
}

// A stem whose one mode turns it about its foot by a radian, without bending it.
Case turning_stem(double root_stiffness) {
  Case c;
  c.structure = assemble(test::straight_stem(4, 2, 0.02, 0.01), {.root = {.rotation = root_stiffness}});
  c.modes.frequency = Eigen::VectorXd::Ones(1);
  c.modes.shapes = Eigen::MatrixXd::Zero(24, 1);
  for (int k = 0; k < 4; ++k) {
    c.modes.shapes(6 * k, 0) = 0.5 * (k + 1);
    c.modes.shapes(6 * k + 4, 0) = 1;
  }
  c.motion = {2, Eigen::MatrixXd::Zero(40, 1), Eigen::VectorXd::Zero(24)};
  return c;
}

TEST(MotionStatistics, OfAStemTurnedByAnAngleStretchItByTheTangentInsteadOfTheArc) {
  Case c = turning_stem(std::numeric_limits<double>::infinity());
  c.motion.coordinates(13, 0) = -0.6;
  c.motion.coordinates(20, 0) = 0.3;
  const MotionStatistics found = motion_statistics(c.structure, c.modes, c.motion);
  EXPECT_NEAR(found.largest_stretch, std::hypot(1, 0.6) - 1, 1e-12);
  // The lean adds to it.
  c.motion.lean = -0.4 * c.modes.shapes.col(0);
  EXPECT_NEAR(motion_statistics(c.structure, c.modes, c.motion).largest_stretch, std::sqrt(2) - 1, 1e-12);
}

TEST(MotionStatistics, OfAStemThatSlidesOnItsRootHaveNoStretch) {
  Case c = turning_stem(1);
  c.structure = assemble(test::straight_stem(4, 2, 0.02, 0.01), {.root = {.translation = 1e-9}});
  c.modes.shapes.setZero();
  for (int k = 0; k < 4; ++k) c.modes.shapes(6 * k, 0) = 1;
  c.motion.coordinates(7, 0) = 3;
  EXPECT_LT(motion_statistics(c.structure, c.modes, c.motion).largest_stretch, 1e-6);
}

TEST(MotionStatistics, RefuseWhatIsNoNumberAndWhatBelongsToAnotherPlant) {
  Case c;
  c.motion.coordinates(31, 2) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(motion_statistics(c.structure, c.modes, c.motion), InputError);
  Case infinite;
  infinite.motion.lean[5] = std::numeric_limits<double>::infinity();
  EXPECT_THROW(motion_statistics(infinite.structure, infinite.modes, infinite.motion), InputError);
  const Case other;
  EXPECT_THROW(
      motion_statistics(assemble(test::straight_stem(3, 2, 0.02, 0.01), {}), other.modes, other.motion),
      InputError);
  Modes fewer = other.modes;
  fewer.frequency.conservativeResize(1);
  fewer.shapes.conservativeResize(Eigen::NoChange, 1);
  EXPECT_THROW(motion_statistics(other.structure, fewer, other.motion), InputError);
  Motion empty = other.motion;
  empty.coordinates.resize(0, 3);
  EXPECT_THROW(motion_statistics(other.structure, other.modes, empty), InputError);
}

}  // namespace
}  // namespace tremula
