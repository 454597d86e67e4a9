#include "tremula/dynamics/static_correction.hpp"

#include "tremula/dynamics/loads.hpp"

#include "tremula/modes/solve_modes.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "trees.hpp"

namespace tremula {
namespace {

struct Case {
  BeamTree tree;  // the same, for what only a tree can be asked
  Structure structure;
  Sites sites;
  Loads loads;
};

// Modes and static shapes side by side.
struct Joined {
  Eigen::MatrixXd shapes;
  Eigen::VectorXd frequency;
  Joined(const Modes& modes, const StaticShapes& more)
      : shapes(modes.shapes.rows(), modes.count() + more.count()), frequency(shapes.cols()) {
    shapes << modes.shapes, more.shapes;
    frequency << modes.frequency, more.frequency;
  }
  Eigen::VectorXd squares() const { return (2 * std::numbers::pi * frequency).cwiseAbs2(); }
};

Case tree_in_wind() {
  const Skeleton skeleton = test::awkward_tree();
  const Structure structure = assemble(skeleton, test::weightless());
  Eigen::Matrix3Xd wind = Eigen::Matrix3Xd::Zero(3, skeleton.branch_count());
  wind.row(0).setConstant(6);
  wind.row(1).setConstant(1);
  const Sites sites = structure.find_sites();
  return {assemble_tree(skeleton, {}), structure, sites, linearise_loads(sites, wind)};
}

TEST(StaticShapes, WithOneModeGiveTheExactDeflectionUnderWaterThatSpeedsUpTheSameEverywhere) {
  Skeleton skeleton = test::awkward_tree();
  for (Leaf& leaf : skeleton.leaves) {
    leaf.length = 0.4;
    leaf.width = 0.2;
    leaf.area = 0.06;
  }
  const Structure structure = assemble(skeleton, test::weightless({.added_mass_density = 1000}));
  const Sites sites = structure.find_sites();
  const Loads loads = linearise_loads(sites, Vec3(0.4, 0.1, 0).replicate(1, sites.point_count()),
                                      {.fluid_density = 1000, .inertia_coefficient = 2});
  const Modes one = solve_modes(structure, {.count = 1});
  const StaticShapes shapes = static_shapes(structure, sites, loads, one);
  EXPECT_EQ(shapes.count(), 6);
  const Joined all(one, shapes);
  for (const Vec3& rate : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0.3, -0.2, 1)}) {
    for (const bool of_inertia : {true, false}) {
      const Eigen::Matrix3Xd everywhere = rate.replicate(1, sites.point_count());
      const Eigen::VectorXd force =
          of_inertia ? inertia_force(sites, loads, everywhere) : fluctuating_force(sites, loads, everywhere);
      const Eigen::VectorXd exact = structure.flexibility(force);
      const Eigen::VectorXd coordinates = (all.shapes.transpose() * force).cwiseQuotient(all.squares());
      EXPECT_LT((all.shapes * coordinates - exact).norm(), 1e-7 * exact.norm());
    }
  }
}

TEST(StaticShapes, WithOneModeGiveTheExactDeflectionUnderAnyGustThatIsTheSameEverywhere) {
  const auto [tree, structure, sites, loads] = tree_in_wind();
  const Modes one = solve_modes(structure, {.count = 1});
  const StaticShapes shapes = static_shapes(structure, sites, loads, one);
  ASSERT_EQ(shapes.count(), 3);
  const Joined all(one, shapes);
  for (const Vec3& gust : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0.3, -0.2, 1)}) {
    const Eigen::VectorXd force = fluctuating_force(sites, loads, gust.replicate(1, sites.point_count()));
    const Eigen::VectorXd exact = structure.flexibility(force);
    const Eigen::VectorXd coordinates = (all.shapes.transpose() * force).cwiseQuotient(all.squares());
    EXPECT_LT((all.shapes * coordinates - exact).norm(), 1e-9 * exact.norm());
    // One mode alone is far off.
    const Eigen::VectorXd by_one = one.shapes.col(0) * coordinates[0];
    EXPECT_GT((by_one - exact).norm(), 0.05 * exact.norm());
  }
}

TEST(StaticShapes, AreAtRightAnglesToTheModesInMassAndStiffness) {
  const auto [tree, structure, sites, loads] = tree_in_wind();
  const Modes modes = solve_modes(structure, {.count = 6});
  const Joined all(modes, static_shapes(structure, sites, loads, modes));
  const Eigen::Index count = all.frequency.size();
  Eigen::MatrixXd mass(count, count), stiffness(count, count);
  for (Eigen::Index r = 0; r < count; ++r) {
    mass.col(r) = all.shapes.transpose() * structure.mass(all.shapes.col(r));
    stiffness.col(r) = all.shapes.transpose() * apply_stiffness(tree, all.shapes.col(r));
  }
  EXPECT_LT((mass - Eigen::MatrixXd::Identity(count, count)).cwiseAbs().maxCoeff(), 1e-6);
  const Eigen::VectorXd squares = all.squares();
  for (Eigen::Index r = 0; r < count; ++r) {
    for (Eigen::Index s = 0; s < count; ++s) {
      EXPECT_NEAR(stiffness(r, s), r == s ? squares[r] : 0, 1e-5 * std::sqrt(squares[r] * squares[s]));
    }
  }
  EXPECT_GT(all.frequency.tail(3).minCoeff(), modes.frequency[5]);
}

TEST(StaticShapes, AreNoneWhereTheModesAreAll) {
  const auto [tree, structure, sites, loads] = tree_in_wind();
  const Modes modes = solve_modes(structure, {.count = all_modes});
  EXPECT_EQ(static_shapes(structure, sites, loads, modes).count(), 0);
}

TEST(StaticShapes, AreNoneWithoutWind) {
  const Skeleton skeleton = test::random_tree(10, 1);
  const Structure structure = assemble(skeleton, test::weightless());
  const Sites sites = structure.find_sites();
  const Loads calm = linearise_loads(sites, Eigen::Matrix3Xd::Zero(3, 10));
  EXPECT_EQ(static_shapes(structure, sites, calm, solve_modes(structure, {.count = 2})).count(), 0);
}

}  // namespace
}  // namespace tremula
