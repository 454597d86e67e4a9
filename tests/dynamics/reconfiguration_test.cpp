#include "tremula/dynamics/reconfiguration.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "trees.hpp"
#include "tremula/base/error.hpp"

namespace tremula {
namespace {

struct Windy {
  Skeleton skeleton = test::random_tree(60, 4);
  Structure structure;
  Loads loads;
  explicit Windy(double speed) {
    for (Branch& branch : skeleton.branches) {  // twigs, so that they bend
      branch.start_radius *= 0.1;
      branch.end_radius *= 0.1;
    }
    structure = assemble(skeleton, {});
    Eigen::Matrix3Xd wind = Eigen::Matrix3Xd::Zero(3, 60);
    wind.row(0).setConstant(speed);
    loads = linearise_loads(skeleton, structure, wind);
  }
};

double largest_rotation(const Eigen::VectorXd& lean) {
  double largest = 0;
  for (Eigen::Index k = 0; k < lean.size() / 6; ++k)
    largest = std::max(largest, lean.segment<3>(6 * k + 3).norm());
  return largest;
}

TEST(Reconfiguration, OfNoAngleIsTheLinearLean) {
  Windy windy(3);
  const Loads before = windy.loads;
  const Eigen::VectorXd lean = lean_and_reconfigure(windy.structure, {.angle = 0}, windy.loads);
  EXPECT_EQ(lean, solve_static(windy.structure, mean_force(windy.structure, before)));
  EXPECT_EQ(windy.loads.branches[5].mean, before.branches[5].mean);
}

TEST(Reconfiguration, InALightWindChangesNothingThatCounts) {
  Windy windy(0.05);
  const Eigen::VectorXd linear = solve_static(windy.structure, mean_force(windy.structure, windy.loads));
  const Eigen::VectorXd lean = lean_and_reconfigure(windy.structure, {}, windy.loads);
  ASSERT_LT(largest_rotation(linear), 0.003);
  EXPECT_LT((lean - linear).norm(), 1e-3 * linear.norm());
}

TEST(Reconfiguration, LeanIsTheEquilibriumUnderTheLoadsItLeaves) {
  Windy windy(8);
  const Loads before = windy.loads;
  const Eigen::VectorXd lean = lean_and_reconfigure(windy.structure, {.angle = 0.3}, windy.loads);
  const Eigen::VectorXd again = solve_static(windy.structure, mean_force(windy.structure, windy.loads));
  EXPECT_LT((lean - again).norm(), 1e-12 * lean.norm());
  for (int k = 0; k < 60; ++k) {
    const double theta = lean.segment<3>(6 * k + 3).norm();
    const double factor = 1 / std::pow(1 + theta * theta / 0.09, 2);
    const auto& now = windy.loads.branches[static_cast<std::size_t>(k)];
    const auto& then = before.branches[static_cast<std::size_t>(k)];
    EXPECT_LT((now.mean - factor * then.mean).norm(), 1e-8 * then.mean.norm()) << k;
  }
}

TEST(Reconfiguration, GustsGrowTheLoadAsALittleMoreMeanWindDoes) {
  // One twig across the wind: what a gust adds is the derivative of the reduced mean load, lean and all.
  const Skeleton twig = test::straight_stem(1, 0.8, 0.002, 0.002);
  const Structure structure = assemble(twig, {});
  const auto loads_at = [&](double speed) {
    Loads loads = linearise_loads(twig, structure, Vec3(speed, 0, 0));
    lean_and_reconfigure(structure, {}, loads);
    return loads.branches[0];
  };
  for (const double speed : {0.5, 3.0, 9.0, 20.0}) {
    const double h = 1e-3;
    const Eigen::Matrix<double, 12, 1> difference =
        (loads_at(speed + h).mean - loads_at(speed - h).mean) / (2 * h);
    EXPECT_LT((loads_at(speed).per_velocity.col(0) - difference).norm(), 1e-5 * difference.norm()) << speed;
  }
}

TEST(Reconfiguration, LeavesDampingTheDragAtTheAngleWithoutItsSlope) {
  Windy windy(8);
  const Loads before = windy.loads;
  const Eigen::VectorXd lean = lean_and_reconfigure(windy.structure, {.angle = 0.3}, windy.loads);
  for (int k = 0; k < 60; ++k) {
    const double x2 = lean.segment<3>(6 * k + 3).squaredNorm() / 0.09, factor = 1 / std::pow(1 + x2, 2);
    const auto& now = windy.loads.branches[static_cast<std::size_t>(k)];
    const auto& then = before.branches[static_cast<std::size_t>(k)];
    EXPECT_LT((now.drag_per_diameter - factor * then.drag_per_diameter).norm(),
              1e-8 * then.drag_per_diameter.norm());
    EXPECT_LT((now.per_velocity - factor / (1 + 4 * x2 / (1 + x2)) * then.per_velocity).norm(),
              1e-8 * then.per_velocity.norm());
  }
}

TEST(Reconfiguration, KeepsRotationsModestWhereTheLinearLeanTurnsTreesOver) {
  Windy windy(10);
  ASSERT_GT(largest_rotation(solve_static(windy.structure, mean_force(windy.structure, windy.loads))), 6);
  EXPECT_LT(largest_rotation(lean_and_reconfigure(windy.structure, {}, windy.loads)), 1);
}

TEST(Reconfiguration, MoreWindNeverLeansLess) {
  double before = 0;
  for (const double speed : {0.5, 1.0, 2.0, 4.0, 8.0, 16.0}) {
    Windy windy(speed);
    const double now = lean_and_reconfigure(windy.structure, {}, windy.loads).norm();
    EXPECT_GT(now, before) << speed;
    before = now;
  }
}

TEST(Reconfiguration, RefusesAnAngleBelowZero) {
  Windy windy(1);
  EXPECT_THROW(lean_and_reconfigure(windy.structure, {.angle = -0.1}, windy.loads), InputError);
  EXPECT_THROW(lean_and_reconfigure(windy.structure, {.angle = 1e-200}, windy.loads), InputError);
  EXPECT_THROW(
      lean_and_reconfigure(windy.structure, {.angle = std::numeric_limits<double>::quiet_NaN()}, windy.loads),
      InputError);
}

}  // namespace
}  // namespace tremula
