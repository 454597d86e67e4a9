#include "tremula/structure/independent_parts.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "trees.hpp"

namespace tremula {
namespace {

TEST(IndependentParts, HaveEveryBranchOnceAndNoParentOutside) {
  const BeamTree tree = assemble_tree(test::awkward_tree(), {});
  const auto parts = independent_parts(tree);
  EXPECT_EQ(parts.size(), 2U);  // of its two roots
  std::vector<int> times(tree.parent.size());
  for (const std::vector<int>& part : parts) {
    for (const int branch : part) {
      ++times[static_cast<std::size_t>(branch)];
      const int parent = tree.parent[static_cast<std::size_t>(branch)];
      EXPECT_EQ(parent < 0, branch == part.front());
      EXPECT_TRUE(parent < 0 || std::ranges::count(part, parent) == 1);
    }
  }
  EXPECT_EQ(times, std::vector<int>(tree.parent.size(), 1));
}

// What the parts do side by side is what the whole does.
TEST(PartOf, MovesAsItDoesInTheWhole) {
  const BeamTree tree = assemble_tree(test::awkward_tree(), {});
  const Eigen::VectorXd force = Eigen::VectorXd::LinSpaced(tree.size(), -1, 2);
  const Eigen::VectorXd whole = solve_static(tree, force), inertia = apply_mass(tree, force);
  for (const std::vector<int>& branches : independent_parts(tree)) {
    const BeamTree part = part_of(tree, branches);
    Eigen::VectorXd own_force(part.size());
    for (int i = 0; i < part.branch_count(); ++i)
      own_force.segment<6>(6 * i) = force.segment<6>(6 * branches[static_cast<std::size_t>(i)]);
    const Eigen::VectorXd own = solve_static(part, own_force), own_inertia = apply_mass(part, own_force);
    for (int i = 0; i < part.branch_count(); ++i) {
      const int branch = branches[static_cast<std::size_t>(i)];
      EXPECT_EQ(own.segment<6>(6 * i), whole.segment<6>(6 * branch));
      EXPECT_EQ(own_inertia.segment<6>(6 * i), inertia.segment<6>(6 * branch));
    }
  }
}

}  // namespace
}  // namespace tremula
