#include "tremula/geometry/skeleton.hpp"

#include "tremula/base/error.hpp"

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "complaint.hpp"

namespace tremula {
namespace {

Skeleton two_branches_and_a_leaf() {
  Skeleton skeleton;
  skeleton.roots = {Vec3(0, 0, 0)};
  skeleton.branches = {{0, {0, 0, 0}, {0, 0, 1}, 0.1, 0.08}, {1, {0, 0, 1}, {1, 0, 2}, 0.05, 0.04}};
  Leaf leaf;
  leaf.branch = 1;
  leaf.base = {1, 0, 2.1};
  leaf.length = leaf.width = leaf.area = leaf.mass = 0.01;
  skeleton.leaves = {leaf};
  return skeleton;
}

std::string complaint_about(const Skeleton& skeleton) {
  return test::complaint_of([&] { check_skeleton(skeleton, "oak"); });
}

TEST(CheckSkeleton, AcceptsAPlantWithALeaf) { EXPECT_EQ(complaint_about(two_branches_and_a_leaf()), ""); }

TEST(CheckSkeleton, NamesWhatItRejects) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  struct Case {
    std::function<void(Skeleton&)> damage;
    std::string complaint;
  };
  const std::vector<Case> cases = {
      {[](Skeleton& s) { s.roots.clear(); }, "oak: no root, wanted at least one"},
      {[](Skeleton& s) { s.branches.clear(); }, "oak: no branch, wanted at least one"},
      {[&](Skeleton& s) { s.roots[0].y() = nan; },
       "oak: root 0: coordinate y is nan, wanted a finite number"},
      {[&](Skeleton& s) { s.origin.x() = inf; }, "oak: the origin is not finite, wanted finite coordinates"},
      {[](Skeleton& s) { s.branches[1].start_node = 2; },
       "oak: branch 1: start node is 2, wanted a root or the end of an earlier branch (0 to 1)"},
      {[](Skeleton& s) { s.branches[0].start_node = -1; },
       "oak: branch 0: start node is -1, wanted a root or the end of an earlier branch (0 to 0)"},
      {[&](Skeleton& s) { s.branches[1].start.z() = nan; },
       "oak: branch 1: start z is nan, wanted a finite number"},
      {[&](Skeleton& s) { s.branches[1].end.x() = inf; },
       "oak: branch 1: end x is inf, wanted a finite number"},
      {[](Skeleton& s) { s.branches[0].start_radius = 0; },
       "oak: branch 0: start radius is 0, wanted a finite number above 0"},
      {[](Skeleton& s) { s.branches[0].end_radius = -0.25; },
       "oak: branch 0: end radius is -0.25, wanted a finite number above 0"},
      {[](Skeleton& s) { s.branches[1].end = s.branches[1].start; },
       "oak: branch 1: length is 0, wanted a finite number above 0"},
      {[](Skeleton& s) { s.leaves[0].branch = 2; }, "oak: leaf 0: branch is 2, wanted one of 0 to 1"},
      {[](Skeleton& s) { s.leaves[0].branch = -1; }, "oak: leaf 0: branch is -1, wanted one of 0 to 1"},
      {[](Skeleton& s) { s.leaves[0].position = 1.5; },
       "oak: leaf 0: position is 1.5, wanted 0 (start of the branch) to 1 (end)"},
      {[&](Skeleton& s) { s.leaves[0].base.z() = nan; },
       "oak: leaf 0: base z is nan, wanted a finite number"},
      {[](Skeleton& s) {
         s.leaves[0].axis = {2, 0, 0};
       },
       "oak: leaf 0: axis has length 2, wanted a unit vector"},
      {[&](Skeleton& s) { s.leaves[0].normal.x() = nan; },
       "oak: leaf 0: normal has length nan, wanted a unit vector"},
      {[](Skeleton& s) {
         s.leaves[0].normal = {-1, 0, 0};
       },
       "oak: leaf 0: cosine between axis and normal is -1, wanted 0"},
      {[](Skeleton& s) { s.leaves[0].length = 0; },
       "oak: leaf 0: length is 0, wanted a finite number above 0"},
      {[&](Skeleton& s) { s.leaves[0].width = inf; },
       "oak: leaf 0: width is inf, wanted a finite number above 0"},
      {[](Skeleton& s) { s.leaves[0].area = -1; }, "oak: leaf 0: area is -1, wanted a finite number above 0"},
      {[&](Skeleton& s) { s.leaves[0].mass = nan; },
       "oak: leaf 0: mass is nan, wanted a finite number above 0"},
  };
  for (const Case& c : cases) {
    Skeleton skeleton = two_branches_and_a_leaf();
    c.damage(skeleton);
    EXPECT_EQ(complaint_about(skeleton), c.complaint);
  }
}

TEST(Extent, HoldsRootsStartsEndsAndLeaves) {
  Skeleton skeleton = two_branches_and_a_leaf();
  EXPECT_EQ(extent(skeleton).low, Vec3(0, 0, 0));
  EXPECT_EQ(extent(skeleton).high, Vec3(1, 0, 2.1));  // the leaf is the highest
  skeleton.roots.push_back({0, 0, -1});
  skeleton.branches[1].start = {-3, 0, 1};
  skeleton.leaves[0].base.y() = 4;
  EXPECT_EQ(extent(skeleton).low, Vec3(-3, 0, -1));
  EXPECT_EQ(extent(skeleton).high, Vec3(1, 4, 2.1));
}

TEST(CheckSkeleton, RefusesAWallThickerThanTheRadiusInOneLine) {
  Skeleton skeleton;
  skeleton.roots.push_back(Vec3::Zero());
  skeleton.branches.push_back({.start_node = 0,
                               .start = Vec3::Zero(),
                               .end = Vec3::UnitZ(),
                               .start_radius = 0.01,
                               .end_radius = 0.01,
                               .wall = 0.2});
  check_skeleton(skeleton, "culm");
  for (const double wall : {0.0, -0.1, 1.2}) {
    skeleton.branches[0].wall = wall;
    EXPECT_THROW(check_skeleton(skeleton, "culm"), InputError) << wall;
  }
  EXPECT_EQ(test::complaint_of([&] { check_skeleton(skeleton, "culm"); }),
            "culm: branch 0: its wall is 1.2 of the radius, wanted above 0, and no thicker than the radius "
            "(1: solid)");
}

}  // namespace
}  // namespace tremula
