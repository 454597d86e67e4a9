#include "tremula/geometry/turtle.hpp"

#include "tremula/numerics/random.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>
#include <Eigen/Geometry>
#include "trees.hpp"

namespace tremula {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double degree = pi / 180;

#define EXPECT_VECTOR(found, wanted) EXPECT_LT(((found) - (wanted)).norm(), 1e-14) << (found).transpose()

Turtle ready() {
  Turtle turtle;
  turtle.set_radius(0.1);
  return turtle;
}

double angle_between(const Vec3& a, const Vec3& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) / degree;
}

TEST(Turtle, BeginsUprightWithItsLeftAlongXAndItsUpAlongY) {
  const Turtle turtle;
  EXPECT_EQ(turtle.heading(), Vec3::UnitZ());
  EXPECT_EQ(turtle.left(), Vec3::UnitX());
  EXPECT_EQ(turtle.up(), Vec3::UnitY());
  EXPECT_EQ(turtle.heading().cross(turtle.left()), turtle.up());
  EXPECT_TRUE(turtle.on_ground());
}

TEST(Turtle, TurnsLeftDownAndRollsRightHandedAboutTheVectorItKeeps) {
  Turtle turtle = ready();
  turtle.yaw(90);
  EXPECT_VECTOR(turtle.heading(), Vec3::UnitX());
  EXPECT_VECTOR(turtle.left(), -Vec3::UnitZ());
  EXPECT_VECTOR(turtle.up(), Vec3::UnitY());

  turtle = ready();
  turtle.pitch(90);
  EXPECT_VECTOR(turtle.heading(), -Vec3::UnitY());
  EXPECT_VECTOR(turtle.left(), Vec3::UnitX());
  EXPECT_VECTOR(turtle.up(), Vec3::UnitZ());

  turtle = ready();
  turtle.roll(90);
  EXPECT_VECTOR(turtle.heading(), Vec3::UnitZ());
  EXPECT_VECTOR(turtle.left(), Vec3::UnitY());
  EXPECT_VECTOR(turtle.up(), -Vec3::UnitX());
}

TEST(Turtle, TurnsAsRotationMatricesAboutItsOwnAxesDo) {
  Turtle turtle = ready();
  Mat3 frame;  // columns: heading, left, up
  frame << turtle.heading(), turtle.left(), turtle.up();
  for (std::uint64_t i = 0; i < 200; ++i) {
    const double angle = 720 * uniform({1, RandomStream::test, 0, i}) - 360;
    const int which = static_cast<int>(3 * uniform({1, RandomStream::test, 1, i}));
    if (which == 0) turtle.yaw(angle);
    if (which == 1) turtle.pitch(angle);
    if (which == 2) turtle.roll(angle);
    // On the right: a rotation about an axis of the frame itself
    const Vec3 axis = which == 0 ? Vec3::UnitZ() : which == 1 ? Vec3::UnitY() : Vec3::UnitX();
    frame *= Eigen::AngleAxisd(angle * degree, axis).toRotationMatrix();
    ASSERT_LT((turtle.heading() - frame.col(0)).norm(), 1e-12);
    ASSERT_LT((turtle.left() - frame.col(1)).norm(), 1e-12);
    ASSERT_LT((turtle.up() - frame.col(2)).norm(), 1e-12);
  }
}

TEST(Turtle, DrawsABranchFromWhereItIsToWhereItGoes) {
  Turtle turtle = ready();
  turtle.draw(2, 0.08);
  turtle.yaw(90);
  turtle.draw(1, 0.05);
  turtle.pitch(90);
  turtle.draw(0.5, 0.05);
  const Skeleton skeleton = turtle.finish();
  ASSERT_EQ(skeleton.branch_count(), 3);
  ASSERT_EQ(skeleton.root_count(), 1);
  EXPECT_EQ(skeleton.roots[0], Vec3::Zero());
  EXPECT_VECTOR(skeleton.branches[0].end, Vec3(0, 0, 2));
  EXPECT_VECTOR(skeleton.branches[1].end, Vec3(1, 0, 2));
  EXPECT_VECTOR(skeleton.branches[2].end, Vec3(1, -0.5, 2));
  EXPECT_EQ(skeleton.branches[0].start_radius, 0.1);
  EXPECT_EQ(skeleton.branches[0].end_radius, 0.08);
  EXPECT_EQ(skeleton.branches[1].start_radius, 0.08);
  EXPECT_EQ(skeleton.branches[1].start, skeleton.branches[0].end);
  EXPECT_EQ(skeleton.parent(0), -1);
  EXPECT_EQ(skeleton.parent(1), 0);
  EXPECT_EQ(skeleton.parent(2), 1);
}

TEST(Turtle, GoesOnFromTheForkAfterAPop) {
  Turtle turtle = ready();
  turtle.draw(1, 0.1);
  turtle.push();
  turtle.yaw(45);
  turtle.draw(1, 0.02);
  turtle.draw(1, 0.02);
  turtle.pop();
  EXPECT_EQ(turtle.radius(), 0.1);
  EXPECT_EQ(turtle.heading(), Vec3::UnitZ());
  turtle.draw(1, 0.1);
  const Skeleton skeleton = turtle.finish();
  EXPECT_EQ(skeleton.parent(1), 0);
  EXPECT_EQ(skeleton.parent(2), 1);
  EXPECT_EQ(skeleton.parent(3), 0);
  EXPECT_VECTOR(skeleton.branches[3].end, Vec3(0, 0, 2));
}

TEST(Turtle, MakesARootOfEveryPlaceOnTheGroundWhereItBeginsToDraw) {
  Turtle turtle = ready();
  for (int i = 0; i < 3; ++i) {
    turtle.push();
    turtle.pitch(90);
    turtle.move(0.5 * i);
    turtle.pitch(-90);
    turtle.draw(1, 0.1);
    turtle.pop();
  }
  turtle.draw(2, 0.1);  // from the first place again
  const Skeleton skeleton = turtle.finish();
  ASSERT_EQ(skeleton.root_count(), 3);
  ASSERT_EQ(skeleton.branch_count(), 4);
  for (int i = 0; i < 3; ++i) {
    EXPECT_VECTOR(skeleton.roots[static_cast<std::size_t>(i)], Vec3(0, -0.5 * i, 0));
    EXPECT_EQ(skeleton.branches[static_cast<std::size_t>(i)].start_node, i);
  }
  EXPECT_EQ(skeleton.branches[3].start_node, 0);
}

TEST(Turtle, LevelsItsLeftVectorAndKeepsItsHeading) {
  for (std::uint64_t i = 0; i < 50; ++i) {
    Turtle turtle = ready();
    turtle.yaw(360 * uniform({2, RandomStream::test, 0, i}));
    turtle.pitch(360 * uniform({2, RandomStream::test, 1, i}));
    turtle.roll(360 * uniform({2, RandomStream::test, 2, i}));
    const Vec3 heading = turtle.heading();
    turtle.level();
    EXPECT_EQ(turtle.heading(), heading);
    EXPECT_NEAR(turtle.left().z(), 0, 1e-15);
    EXPECT_GE(turtle.up().z(), 0);
    EXPECT_LT((heading.cross(turtle.left()) - turtle.up()).norm(), 1e-12);
  }
}

TEST(Turtle, LeavesAVerticalFrameAsItIsWhenLevelled) {
  Turtle turtle = ready();
  turtle.roll(30);
  const Vec3 left = turtle.left();
  turtle.level();
  EXPECT_EQ(turtle.left(), left);
}

TEST(Turtle, BendsByStrengthTimesTheSineTowardsTheTropism) {
  for (const double tilt : {20.0, 45.0, 90.0, 130.0}) {
    Turtle turtle = ready();
    turtle.yaw(tilt);  // heading and vertical now span the x-z plane
    turtle.set_tropism(12, -Vec3::UnitZ());
    turtle.draw(1, 0.1);
    // Further from the vertical by e |H x T|, T down
    EXPECT_NEAR(angle_between(turtle.heading(), Vec3::UnitZ()), tilt + 12 * std::sin(tilt * degree), 1e-10);
    EXPECT_NEAR(turtle.heading().y(), 0, 1e-15);
    EXPECT_LT((turtle.heading().cross(turtle.left()) - turtle.up()).norm(), 1e-14);
  }
}

TEST(Turtle, BendsAwayWhereTheStrengthIsNegative) {
  Turtle turtle = ready();
  turtle.yaw(60);
  turtle.set_tropism(-10, Vec3(0, 0, -3));  // only the direction of the vector counts
  turtle.draw(1, 0.1);
  EXPECT_NEAR(angle_between(turtle.heading(), Vec3::UnitZ()), 60 - 10 * std::sin(60 * degree), 1e-10);
}

TEST(Turtle, NeverBendsPastTheTropism) {
  Turtle turtle = ready();
  turtle.yaw(100);
  turtle.set_tropism(1000, -Vec3::UnitZ());
  for (int i = 0; i < 5; ++i) turtle.draw(1, 0.1);
  EXPECT_VECTOR(turtle.heading(), -Vec3::UnitZ());
  turtle.yaw(30);
  turtle.set_tropism(-1000, -Vec3::UnitZ());
  for (int i = 0; i < 5; ++i) turtle.draw(1, 0.1);
  EXPECT_VECTOR(turtle.heading(), Vec3::UnitZ());
}

TEST(Turtle, KeepsItsFrameOrthonormalOverThousandsOfTurns) {
  Turtle turtle = ready();
  turtle.set_tropism(3, Vec3(1, 2, -1));
  for (std::uint64_t i = 0; i < 20000; ++i) {
    turtle.yaw(100 * uniform({3, RandomStream::test, 0, i}));
    turtle.pitch(100 * uniform({3, RandomStream::test, 1, i}));
    turtle.roll(100 * uniform({3, RandomStream::test, 2, i}));
    turtle.draw(0.01, 0.1);
  }
  EXPECT_NEAR(turtle.heading().norm(), 1, 1e-14);
  EXPECT_LT((turtle.heading().cross(turtle.left()) - turtle.up()).norm(), 1e-14);
}

TEST(Turtle, HangsALeafWhereItIsToldTo) {
  Turtle turtle({.leaf_shape_factor = 0.6, .leaf_mass_per_area = 0.3});
  turtle.set_radius(0.01);
  turtle.draw(1, 0.01);
  turtle.draw(2, 0.01);
  turtle.yaw(90);
  turtle.leaf(0.1, 0.05, 0.02, 0.25);
  const Skeleton skeleton = turtle.finish();
  ASSERT_EQ(skeleton.leaves.size(), 1U);
  const Leaf& leaf = skeleton.leaves[0];
  EXPECT_EQ(leaf.branch, 1);
  EXPECT_EQ(leaf.position, 0.25);
  EXPECT_VECTOR(leaf.base, Vec3(0.02, 0, 1.5));
  EXPECT_VECTOR(leaf.axis, Vec3::UnitX());
  EXPECT_VECTOR(leaf.normal, Vec3::UnitY());
  EXPECT_EQ(leaf.length, 0.1);
  EXPECT_EQ(leaf.width, 0.05);
  EXPECT_DOUBLE_EQ(leaf.area, 0.6 * 0.1 * 0.05);
  EXPECT_DOUBLE_EQ(leaf.mass, 0.3 * 0.6 * 0.1 * 0.05);
}

TEST(Turtle, SpreadsARibbonAlongTheBranchDrawnLastHoweverItHasTurnedSince) {
  Turtle turtle({.leaf_mass_per_area = 2});
  turtle.set_radius(0.01);
  turtle.set_tropism(40, Vec3::UnitX());
  turtle.draw(0.5, 0.01);
  turtle.ribbon(0.2, 0.1);
  const Skeleton skeleton = turtle.finish();
  ASSERT_EQ(skeleton.leaves.size(), 1U);
  const Leaf& ribbon = skeleton.leaves[0];
  EXPECT_TRUE(ribbon.is_ribbon);
  EXPECT_LT((ribbon.axis - Vec3::UnitZ()).norm(), 1e-12);
  EXPECT_NEAR(ribbon.normal.dot(ribbon.axis), 0, 1e-12);
  EXPECT_NEAR(ribbon.area, 0.5 * 0.15, 1e-12);
  EXPECT_NEAR(ribbon.mass, 2 * ribbon.area, 1e-12);
  EXPECT_NO_THROW(check_skeleton(skeleton, "ribbon"));
}

TEST(PipeRadii, FollowLeonardosRuleAtEveryForkOfARandomTree) {
  for (const double exponent : {1.8, 2.0, 2.49}) {
    Skeleton skeleton = test::random_tree(400, 11);
    const Skeleton before = skeleton;
    const double taper = 0.004;
    set_pipe_radii(skeleton, {.exponent = exponent, .taper = taper});
    std::vector<double> pipes(skeleton.branches.size(), 0.0);
    for (int k = 0; k < skeleton.branch_count(); ++k) {
      const Branch& branch = skeleton.branches[static_cast<std::size_t>(k)];
      EXPECT_DOUBLE_EQ(branch.start_radius, branch.end_radius + taper * branch.length());
      if (skeleton.parent(k) >= 0) {
        pipes[static_cast<std::size_t>(skeleton.parent(k))] += std::pow(branch.start_radius, exponent);
      }
    }
    int forks = 0;
    for (std::size_t k = 0; k < pipes.size(); ++k) {
      const double radius = skeleton.branches[k].end_radius;
      if (pipes[k] == 0) {
        EXPECT_EQ(radius, before.branches[k].end_radius);  // a tip
      } else {
        EXPECT_NEAR(std::pow(radius, exponent) / pipes[k], 1, 1e-13);
        ++forks;
      }
    }
    EXPECT_GT(forks, 100);
  }
}

TEST(PipeRadii, GiveATreeOfEqualTipsTheRadiusOfTheirNumber) {
  Turtle turtle = ready();  // nine tips of radius 0.1 on three limbs on one trunk
  turtle.draw(1, 0.1);
  for (int limb = 0; limb < 3; ++limb) {
    turtle.push();
    turtle.draw(1, 0.1);
    for (int twig = 0; twig < 3; ++twig) {
      turtle.push();
      turtle.draw(1, 0.1);
      turtle.pop();
    }
    turtle.pop();
  }
  Skeleton skeleton = turtle.finish();
  set_pipe_radii(skeleton, {.exponent = 2});
  EXPECT_NEAR(skeleton.branches[0].start_radius, 0.3, 1e-15);
}

}  // namespace
}  // namespace tremula
