#include "tremula/dynamics/motion_statistics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "trees.hpp"
#include "tremula/base/error.hpp"
#include "tremula/structure/bent_tree.hpp"

namespace tremula {
namespace {

// A lean and three shapes, modes and a static one, that move at random.
struct Case {
  Structure structure = assemble(test::straight_stem(4, 2, 0.02, 0.01), test::weightless());
  Motion motion{2,
                {{ShapeKind::lean, ShapeKind::mode, ShapeKind::mode, ShapeKind::static_shape},
                 Eigen::VectorXd::Ones(4),
                 Eigen::MatrixXd::Random(24, 4)},
                Eigen::MatrixXd::Random(50, 4)};
  Case() { motion.coordinates.col(0).setOnes(); }
  Eigen::VectorXd lean() const { return motion.basis.columns.col(0); }
};

Sway sway_frame_by_frame(const Case& c, const Eigen::RowVectorXd& about) {
  Sway sway;
  for (int k = 0; k < 4; ++k) {
    double squares = 0, rotation_squares = 0;
    for (int p = 0; p < 50; ++p) {
      const Eigen::VectorXd u =
          c.motion.basis.columns.rightCols(3) * (c.motion.coordinates.row(p).tail(3) - about).transpose();
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
  c.motion.coordinates.rightCols(3).rowwise() += Eigen::RowVector3d(0.5, -1, 2);
  const Eigen::RowVectorXd mean = c.motion.coordinates.rightCols(3).colwise().mean();
  const MotionStatistics found = motion_statistics(c.structure, c.motion);
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
    largest = std::max(largest, c.lean().segment<3>(6 * k).norm());
    largest_rotation = std::max(largest_rotation, c.lean().segment<3>(6 * k + 3).norm());
  }
  const MotionStatistics found = motion_statistics(c.structure, c.motion);
  EXPECT_EQ(found.largest_lean, largest);
  EXPECT_EQ(found.largest_lean_rotation, largest_rotation);
}

// A stem whose one mode turns it about its foot by a radian, without bending it.
Case turning_stem(double root_stiffness) {
  Case c;
  c.structure = assemble(test::straight_stem(4, 2, 0.02, 0.01),
                         test::weightless({.root = {.rotation = root_stiffness}}));
  c.motion = {2,
              {{ShapeKind::lean, ShapeKind::mode}, Eigen::VectorXd::Ones(2), Eigen::MatrixXd::Zero(24, 2)},
              Eigen::MatrixXd::Zero(40, 2)};
  c.motion.coordinates.col(0).setOnes();
  for (int k = 0; k < 4; ++k) {
    c.motion.basis.columns(6 * k, 1) = 0.5 * (k + 1);
    c.motion.basis.columns(6 * k + 4, 1) = 1;
  }
  return c;
}

TEST(MotionStatistics, OfAStemTurnedByAnAngleStretchItByTheTangentInsteadOfTheArc) {
  Case c = turning_stem(std::numeric_limits<double>::infinity());
  c.motion.coordinates(13, 1) = -0.6;
  c.motion.coordinates(20, 1) = 0.3;
  const MotionStatistics found = motion_statistics(c.structure, c.motion);
  EXPECT_NEAR(found.largest_stretch, std::hypot(1, 0.6) - 1, 1e-12);
  // The lean adds to it.
  c.motion.basis.columns.col(0) = -0.4 * c.motion.basis.columns.col(1);
  EXPECT_NEAR(motion_statistics(c.structure, c.motion).largest_stretch, std::sqrt(2) - 1, 1e-12);
}

// The same stem, turned far by its lean and a little by its mode.
TEST(MotionStatistics, OfALeanThatBendsFarCountTheStretchOfWhatIsSuperposedOnIt) {
  for (const double root : {std::numeric_limits<double>::infinity(), 1e4}) {
    Case c = turning_stem(root);
    const double length = 0.5, turn = 1.1;
    c.motion.lean_strains = Eigen::VectorXd::Zero(24);
    c.motion.lean_strains.segment<6>(0) << length * turn, 0, 0, 0, turn, 0;
    const BeamTree& tree = *c.structure.tree;
    const std::vector<BentBranch> bent = bend(tree, c.motion.lean_strains);
    c.motion.basis.columns.col(0) = displacement_of(tree, bent);
    c.motion.basis.columns.col(1).setZero();
    EXPECT_LT(motion_statistics(c.structure, c.motion).largest_stretch, 1e-3);
    // The last three pieces turn about the end of the first, which stands still.
    for (int k = 1; k < 4; ++k) {
      const Vec3 arm = bent[static_cast<std::size_t>(k)].end - bent[0].end;
      c.motion.basis.columns.col(1).segment<3>(6 * k) = Vec3::UnitY().cross(arm);
      c.motion.basis.columns(6 * k + 4, 1) = 1;
    }
    c.motion.coordinates(13, 1) = -0.6;
    EXPECT_NEAR(motion_statistics(c.structure, c.motion).largest_stretch, std::hypot(1, 0.6) - 1, 1e-12);
  }
}

TEST(MotionStatistics, OfAStemThatSlidesOnItsRootHaveNoStretch) {
  Case c = turning_stem(1);
  c.structure =
      assemble(test::straight_stem(4, 2, 0.02, 0.01), test::weightless({.root = {.translation = 1e-9}}));
  c.motion.basis.columns.setZero();
  for (int k = 0; k < 4; ++k) c.motion.basis.columns(6 * k, 1) = 1;
  c.motion.coordinates(7, 1) = 3;
  EXPECT_LT(motion_statistics(c.structure, c.motion).largest_stretch, 1e-6);
}

TEST(MotionStatistics, RefuseWhatIsNoNumberAndWhatBelongsToAnotherPlant) {
  Case c;
  c.motion.coordinates(31, 2) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(motion_statistics(c.structure, c.motion), InputError);
  Case infinite;
  infinite.motion.basis.columns(5, 0) = std::numeric_limits<double>::infinity();
  EXPECT_THROW(motion_statistics(infinite.structure, infinite.motion), InputError);
  const Case other;
  EXPECT_THROW(
      motion_statistics(assemble(test::straight_stem(3, 2, 0.02, 0.01), test::weightless()), other.motion),
      InputError);
  Motion fewer = other.motion;
  fewer.basis.columns.conservativeResize(Eigen::NoChange, 3);
  EXPECT_THROW(motion_statistics(other.structure, fewer), InputError);
  Motion empty = other.motion;
  empty.coordinates.resize(0, 4);
  EXPECT_THROW(motion_statistics(other.structure, empty), InputError);
}

}  // namespace
}  // namespace tremula
