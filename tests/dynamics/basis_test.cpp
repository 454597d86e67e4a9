#include "tremula/dynamics/basis.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "tremula/base/error.hpp"

namespace tremula {
namespace {

struct Case {
  Eigen::VectorXd lean = Eigen::VectorXd::Random(12);
  Modes modes;
  StaticShapes more{Eigen::Vector2d(8, 9), Eigen::MatrixXd::Random(12, 2)};
  Case() {
    modes.frequency = Eigen::Vector3d(1, 2, 3);
    modes.shapes = Eigen::MatrixXd::Random(12, 3);
  }
};

TEST(Basis, HoldsLeanModesAndStaticShapesInTheOrderOfTheCoordinates) {
  const Case c;
  const Basis basis = join(c.lean, c.modes, c.more);
  EXPECT_EQ(basis.kind, (std::vector{ShapeKind::lean, ShapeKind::mode, ShapeKind::mode, ShapeKind::mode,
                                     ShapeKind::static_shape, ShapeKind::static_shape}));
  EXPECT_EQ(basis.frequency, (Eigen::VectorXd(6) << 0, 1, 2, 3, 8, 9).finished());
  EXPECT_EQ(basis.count(ShapeKind::lean), 1);
  EXPECT_EQ(basis.count(ShapeKind::mode), 3);
  EXPECT_EQ(basis.count(ShapeKind::static_shape), 2);
  EXPECT_EQ(lean_of(basis), c.lean);
  const Eigen::VectorXd y = Eigen::VectorXd::Random(6);
  const Eigen::VectorXd wanted = y[0] * c.lean + c.modes.shapes * y.segment(1, 3) + c.more.shapes * y.tail(2);
  EXPECT_LT((superpose(basis, y) - wanted).norm(), 1e-14);
}

TEST(Basis, OfModesAloneHasTheLeanBeforeThem) {
  const Case c;
  const Basis basis = join(c.lean, c.modes, {Eigen::VectorXd(0), Eigen::MatrixXd(12, 0)});
  EXPECT_EQ(basis.count(), 4);
  EXPECT_EQ(basis.columns.rightCols(3), c.modes.shapes);
}

TEST(Basis, RefusesTheModesOfAnotherPlant) {
  const Case c;
  Modes other = c.modes;
  other.shapes.conservativeResize(6, Eigen::NoChange);
  EXPECT_THROW(join(c.lean, other, c.more), InputError);
  other = c.modes;
  other.frequency.conservativeResize(2);
  EXPECT_THROW(join(c.lean, other, c.more), InputError);
  StaticShapes half = c.more;
  half.shapes.conservativeResize(Eigen::NoChange, 1);
  EXPECT_THROW(join(c.lean, c.modes, half), InputError);
  half = c.more;
  half.shapes.conservativeResize(6, Eigen::NoChange);
  EXPECT_THROW(join(c.lean, c.modes, half), InputError);
  EXPECT_THROW(superpose(join(c.lean, c.modes, c.more), Eigen::VectorXd::Ones(5)), InputError);
}

TEST(Basis, IsNoneWithAKindTooFewOrANumberThatIsNotFinite) {
  const Case c;
  Basis basis = join(c.lean, c.modes, c.more);
  EXPECT_NO_THROW(check_basis(basis));
  basis.kind.pop_back();
  EXPECT_THROW(check_basis(basis), InputError);
  basis = join(c.lean, c.modes, c.more);
  basis.columns(3, 2) = std::numeric_limits<double>::infinity();
  EXPECT_THROW(check_basis(basis), InputError);
}

}  // namespace
}  // namespace tremula
