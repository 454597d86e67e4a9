#include "tremula/dynamics/basis.hpp"

#include <gtest/gtest.h>

#include "tremula/base/error.hpp"

namespace tremula {
namespace {

struct Case {
  Modes modes;
  Motion motion{3, Eigen::MatrixXd::Random(7, 5), Eigen::VectorXd::Random(12)};
  Case() {
    modes.frequency = Eigen::Vector3d(1, 2, 3);
    modes.shapes = Eigen::MatrixXd::Random(12, 3);
    motion.static_shapes = {Eigen::Vector2d(8, 9), Eigen::MatrixXd::Random(12, 2)};
  }
};

TEST(Basis, HoldsLeanModesAndStaticShapesInTheOrderOfTheWeights) {
  const Case c;
  const Basis basis = all_shapes(c.modes, c.motion);
  EXPECT_EQ(basis.kind, (std::vector{ShapeKind::lean, ShapeKind::mode, ShapeKind::mode, ShapeKind::mode,
                                     ShapeKind::static_shape, ShapeKind::static_shape}));
  EXPECT_EQ(basis.frequency, (Eigen::VectorXd(6) << 0, 1, 2, 3, 8, 9).finished());
  const Eigen::MatrixXd samples = basis.columns * weights(c.motion).transpose();
  for (int p = 0; p < 7; ++p) {
    const Eigen::VectorXd y = c.motion.coordinates.row(p);
    const Eigen::VectorXd wanted =
        c.motion.lean + c.modes.shapes * y.head(3) + c.motion.static_shapes.shapes * y.tail(2);
    EXPECT_LT((samples.col(p) - wanted).norm(), 1e-14);
  }
}

TEST(Basis, GivesTheBytesThatModesAndMotionGiveWithoutIt) {
  const Case c;
  const Basis basis = all_shapes(c.modes, c.motion);
  for (const double time : {0.0, 1.234, -7.0}) {
    const Eigen::VectorXd now = weights_at(c.motion, time, Interpolation::cubic);
    EXPECT_EQ(superpose(basis, now), superpose(c.modes, c.motion, now));
  }
}

TEST(Basis, RefusesTheModesOfAnotherPlant) {
  const Case c;
  Modes other = c.modes;
  other.shapes.conservativeResize(6, Eigen::NoChange);
  EXPECT_THROW(all_shapes(other, c.motion), InputError);
  other = c.modes;
  other.frequency.conservativeResize(2);
  EXPECT_THROW(superpose(other, c.motion, Eigen::VectorXd::Ones(6)), InputError);
  EXPECT_THROW(superpose(c.modes, c.motion, Eigen::VectorXd::Ones(5)), InputError);
}

}  // namespace
}  // namespace tremula
