#include "tremula/modes/census.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace tremula {
namespace {

// omega of a structure that was never built: clusters of several sizes.
const std::vector<double> all = {1, 2, 2, 2, 3, 4, 4, 5, 6, 6, 6, 6, 7};

Census census(const std::vector<double>& found, int count) {
  Eigen::VectorXd values(static_cast<Eigen::Index>(found.size()));
  for (std::size_t i = 0; i < found.size(); ++i) {
    values[static_cast<Eigen::Index>(i)] = 1 / (found[i] * found[i]);
  }
  const auto count_below = [](double omega) {
    return static_cast<int>(std::ranges::count_if(all, [&](double x) { return x < omega; }));
  };
  return take_census(count_below, values, count, 1e-8);
}

TEST(TakeCensus, MissesNothingOfWhatIsThere) {
  for (int count = 1; count <= static_cast<int>(all.size()); ++count) {
    const Census whole = census({all.begin(), all.begin() + count}, count);
    EXPECT_EQ(whole.missing, 0) << count;
    EXPECT_EQ(whole.found, whole.by_inertia) << count;
    // What is equal to the last one and comes after it.
    EXPECT_EQ(whole.equal_left_out,
              std::count(all.begin() + count, all.end(), all[static_cast<std::size_t>(count - 1)]))
        << count;
  }
}

TEST(TakeCensus, SaysHowLargeTheClusterIsThatTheListEndsIn) {
  const Census cut = census({1, 2, 2, 2, 3, 4, 4, 5, 6, 6}, 10);
  EXPECT_EQ(cut.equal_to_last, 4);
  EXPECT_EQ(cut.equal_left_out, 2);
  EXPECT_EQ(cut.found, 8) << "those below the cluster";
  EXPECT_EQ(cut.by_inertia, 8);
  const Census uncut = census({1, 2, 2, 2, 3}, 5);
  EXPECT_EQ(uncut.equal_to_last, 0);
  EXPECT_EQ(uncut.equal_left_out, 0);
  EXPECT_EQ(uncut.found, 5);
}

TEST(TakeCensus, AsksForWhatIsMissingBelowTheCountAndForNoMore) {
  EXPECT_EQ(census({2, 2, 2, 3}, 4).missing, 1);           // the 1; then the 3 is one too many
  EXPECT_EQ(census({1, 2, 3, 4}, 4).missing, 2);           // of the 2, not of the 4
  EXPECT_EQ(census({1, 2, 3, 4, 5, 6, 7}, 3).missing, 1);  // two of three 2 will do
  EXPECT_EQ(census({1, 2, 3, 4, 5, 6, 7}, 2).missing, 0);
  EXPECT_EQ(census({1, 2, 3, 4, 5, 6, 7}, 7).missing, 3);  // 1 2 2 2 3 4 4
  EXPECT_EQ(census({6, 7}, 2).missing, 2);                 // 1 2: none of the first two is here
  EXPECT_EQ(census({7}, 1).missing, 1);
}

}  // namespace
}  // namespace tremula
