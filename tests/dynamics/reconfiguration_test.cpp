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
  Sites sites;
  Loads loads;
  explicit Windy(double speed) {
    for (Branch& branch : skeleton.branches) {  // twigs, so that they bend
      branch.start_radius *= 0.1;
      branch.end_radius *= 0.1;
    }
    structure = assemble(skeleton, test::weightless());
    Eigen::Matrix3Xd wind = Eigen::Matrix3Xd::Zero(3, 60);
    wind.row(0).setConstant(speed);
    sites = structure.find_sites();
    loads = linearise_loads(sites, wind);
  }
  Lean lean(const Reconfiguration& reconfiguration = {}) const {
    return find_lean(structure, sites, loads, reconfiguration);
  }
  Eigen::VectorXd linear_lean() const { return structure.flexibility(mean_force(sites, loads)); }
};

double largest_rotation(const Eigen::VectorXd& lean) {
  double largest = 0;
  for (Eigen::Index k = 0; k < lean.size() / 6; ++k)
    largest = std::max(largest, lean.segment<3>(6 * k + 3).norm());
  return largest;
}

TEST(Reconfiguration, OfNoAngleIsTheLinearLean) {
  const Windy windy(3);
  const Lean lean = windy.lean({.angle = 0});
  EXPECT_EQ(lean.displacement, windy.linear_lean());
  EXPECT_EQ(lean.loads.sites[5].mean, windy.loads.sites[5].mean);
}

TEST(Reconfiguration, InALightWindChangesNothingThatCounts) {
  const Windy windy(0.05);
  const Eigen::VectorXd linear = windy.linear_lean(), lean = windy.lean().displacement;
  ASSERT_LT(largest_rotation(linear), 0.003);
  EXPECT_LT((lean - linear).norm(), 1e-3 * linear.norm());
}

TEST(Reconfiguration, LeanIsTheEquilibriumUnderTheLoadsItLeaves) {
  const Windy windy(8);
  const Lean lean = windy.lean({.angle = 0.3});
  const Eigen::VectorXd again = windy.structure.flexibility(mean_force(windy.sites, lean.loads));
  EXPECT_LT((lean.displacement - again).norm(), 1e-12 * again.norm());
  for (std::size_t s = 0; s < windy.sites.sites.size(); ++s) {
    const double theta = lean.displacement.segment<3>(6 * windy.sites.sites[s].point + 3).norm();
    const double factor = 1 / std::pow(1 + theta * theta / 0.09, 2);
    const Vec3 &now = lean.loads.sites[s].mean, &then = windy.loads.sites[s].mean;
    EXPECT_LT((now - factor * then).norm(), 1e-8 * then.norm()) << s;
  }
}

TEST(Reconfiguration, GustsGrowTheLoadAsALittleMoreMeanWindDoes) {
  // One twig across the wind: what a gust adds is the derivative of the reduced mean load, lean and all.
  const Skeleton twig = test::straight_stem(1, 0.8, 0.002, 0.002);
  const Structure structure = assemble(twig, test::weightless());
  const Sites sites = structure.find_sites();
  const auto loads_at = [&](double speed) {
    return find_lean(structure, sites, linearise_loads(sites, Vec3(speed, 0, 0)), {}).loads;
  };
  for (const double speed : {0.5, 3.0, 9.0, 20.0}) {
    const double h = 1e-3;
    const Eigen::VectorXd difference =
        (mean_force(sites, loads_at(speed + h)) - mean_force(sites, loads_at(speed - h))) / (2 * h);
    const Eigen::VectorXd found = fluctuating_force(sites, loads_at(speed), Vec3::UnitX());
    EXPECT_LT((found - difference).norm(), 1e-5 * difference.norm()) << speed;
  }
}

TEST(Reconfiguration, LeavesDampingTheDragAtTheAngleWithoutItsSlope) {
  const Windy windy(8);
  const Lean lean = windy.lean({.angle = 0.3});
  for (std::size_t s = 0; s < windy.sites.sites.size(); ++s) {
    const int point = windy.sites.sites[s].point;
    const double x2 = lean.displacement.segment<3>(6 * point + 3).squaredNorm() / 0.09;
    const Mat3 &now = lean.loads.sites[s].per_velocity, &then = windy.loads.sites[s].per_velocity;
    EXPECT_LT((now - then / std::pow(1 + x2, 2)).norm(), 1e-8 * then.norm());
    EXPECT_NEAR(lean.loads.gust_share[point], 1 / (1 + 4 * x2 / (1 + x2)), 1e-8);
  }
}

TEST(Reconfiguration, KeepsRotationsModestWhereTheLinearLeanTurnsTreesOver) {
  const Windy windy(10);
  ASSERT_GT(largest_rotation(windy.linear_lean()), 6);
  EXPECT_LT(largest_rotation(windy.lean().displacement), 1);
}

TEST(Reconfiguration, MoreWindNeverLeansLess) {
  double before = 0;
  for (const double speed : {0.5, 1.0, 2.0, 4.0, 8.0, 16.0}) {
    const double now = Windy(speed).lean().displacement.norm();
    EXPECT_GT(now, before) << speed;
    before = now;
  }
}

TEST(Reconfiguration, RefusesAnAngleBelowZero) {
  const Windy windy(1);
  EXPECT_THROW(windy.lean({.angle = -0.1}), InputError);
  EXPECT_THROW(windy.lean({.angle = 1e-200}), InputError);
  EXPECT_THROW(windy.lean({.angle = std::numeric_limits<double>::quiet_NaN()}), InputError);
}

}  // namespace
}  // namespace tremula
