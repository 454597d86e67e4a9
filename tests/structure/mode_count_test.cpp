#include "tremula/structure/mode_count.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "trees.hpp"
#include "tremula/modes/solve_modes.hpp"

namespace tremula {
namespace {

const Material wood{"wood", 9e9, 7e8, 950, ""};

// Between every two frequencies that can be told apart, the count is the number of those below.
void expect_counts_match(const Skeleton& skeleton) {
  const BeamTree tree = assemble_tree(skeleton, {.material = wood});
  const Modes modes =
      solve_modes(assemble(skeleton, test::weightless({.material = wood})), {.count = all_modes});
  EXPECT_EQ(count_modes_below(tree, 0), 0);
  int compared = 0;
  for (int r = 0; r + 1 < modes.count(); ++r) {
    const double below = modes.omega()[r], above = modes.omega()[r + 1];
    if (above / below - 1 < 1e-9) continue;
    EXPECT_EQ(count_modes_below(tree, std::sqrt(below * above)), r + 1)
        << "between modes " << r << ", " << r + 1;
    ++compared;
  }
  EXPECT_GT(compared, modes.count() / 3);
}

TEST(CountModesBelow, IsTheNumberOfFrequenciesBelowForEveryGapOfARandomTree) {
  expect_counts_match(test::random_tree(30, 7));
}

TEST(CountModesBelow, CountsBothOfEveryPairOfAStraightStem) {
  expect_counts_match(test::straight_stem(12, 2, 0.02, 0.01));
}

TEST(CountModesBelow, HoldsForLeavesSeveralRootsAndStartsBesideTheirNodes) {
  Skeleton skeleton = test::awkward_tree();
  skeleton.leaves.front().mass = 0.5;
  expect_counts_match(skeleton);
}

TEST(CountModesBelow, KeepsItsDigitsWhereBranchesAreCutIntoManyPieces) {
  // The gap between the third and fourth pair is wide; an assembled K of 640 pieces has lost half of its
  // digits.
  const Skeleton stem = test::straight_stem(640, 2, 0.02, 0.01);
  const BeamTree tree = assemble_tree(stem, {.material = wood});
  const Modes modes = solve_modes(assemble(stem, test::weightless({.material = wood})), {.count = 8});
  for (const int r : {1, 3, 5}) {
    EXPECT_EQ(count_modes_below(tree, modes.omega()[r] * (1 + 1e-9)), r + 1);
    EXPECT_EQ(count_modes_below(tree, modes.omega()[r - 1] * (1 - 1e-9)), r - 1);
  }
}

}  // namespace
}  // namespace tremula
