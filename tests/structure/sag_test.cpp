#include "tremula/structure/sag.hpp"

#include "trees.hpp"
#include "tremula/structure/equilibrium.hpp"

#include <numbers>

#include <gtest/gtest.h>

namespace tremula {
namespace {

// A level rod droops by q L^4/(8 EI) while that is little.
TEST(Sagged, ALevelRodDroopsAsTheClosedFormSays) {
  const double length = 2, radius = 0.02;
  const Skeleton level = test::straight_stem(20, length, radius, radius, Vec3::UnitX());
  const StructureOptions options{.gravity = 0.1};
  const double area = std::numbers::pi * radius * radius, inertia = area * radius * radius / 4;
  const double wanted = options.material.density * area * options.gravity * std::pow(length, 4) /
                        (8 * options.material.youngs_modulus * inertia);
  EXPECT_NEAR(-sagged(level, options).branches.back().end.z() / wanted, 1, 1e-4);
}

TEST(Sagged, WithoutGravityIsTheSkeletonItself) {
  const Skeleton skeleton = test::awkward_tree(), same = sagged(skeleton, {.gravity = 0});
  for (std::size_t k = 0; k < skeleton.branches.size(); ++k)
    EXPECT_LT((same.branches[k].end - skeleton.branches[k].end).norm(), 1e-14);
}

TEST(Sagged, KeepsLengthsAndTheShapeOfLeaves) {
  const Skeleton skeleton = test::awkward_tree(), loaded = sagged(skeleton, {.gravity = 60});
  double moved = 0;
  for (std::size_t k = 0; k < skeleton.branches.size(); ++k) {
    EXPECT_NEAR(loaded.branches[k].length() / skeleton.branches[k].length(), 1, 1e-3);
    moved = std::max(moved, (loaded.branches[k].end - skeleton.branches[k].end).norm());
  }
  EXPECT_GT(moved, 1e-3);
  for (std::size_t i = 0; i < skeleton.leaves.size(); ++i) {
    EXPECT_NEAR(loaded.leaves[i].axis.norm(), 1, 1e-12);
    EXPECT_NEAR(loaded.leaves[i].axis.dot(loaded.leaves[i].normal), 0, 1e-9);
  }
}

}  // namespace
}  // namespace tremula
