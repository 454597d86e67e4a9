#include "tremula/numerics/block_lanczos.hpp"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>

#include "tremula/base/error.hpp"
#include "tremula/numerics/random.hpp"

namespace tremula {
namespace {

Eigen::MatrixXd random_orthogonal(Eigen::Index size) {
  Eigen::MatrixXd random(size, size);
  for (Eigen::Index i = 0; i < random.size(); ++i) {
    random.data()[i] = complex_gaussian({5, RandomStream::test, 1, static_cast<std::uint64_t>(i)}).real();
  }
  return Eigen::HouseholderQR<Eigen::MatrixXd>(random).householderQ();
}

struct Problem {
  Eigen::VectorXd values;   // descending
  Eigen::MatrixXd vectors;  // of them, in the same order

  LanczosResult solve(const LanczosOptions& options, const Eigen::MatrixXd& deflated = {}) const {
    const Eigen::MatrixXd matrix = vectors * values.asDiagonal() * vectors.transpose();
    const auto apply = [&](Eigen::Ref<const Eigen::VectorXd> in, Eigen::Ref<Eigen::VectorXd> out) {
      out.noalias() = matrix * in;
      return in.dot(out);
    };
    return largest_eigenpairs_in_blocks(apply, matrix.rows(), options, deflated);
  }

  // Eigenpairs that hold, at right angles to each other, with the values from `first` on.
  void expect(const LanczosResult& result, Eigen::Index first, Eigen::Index count) const {
    ASSERT_TRUE(result.converged);
    ASSERT_EQ(result.values.size(), count);
    Eigen::VectorXd sorted = result.values;
    std::sort(sorted.begin(), sorted.end(), std::greater<>());
    for (Eigen::Index r = 0; r < count; ++r) EXPECT_NEAR(sorted[r], values[first + r], 1e-13) << r;
    const Eigen::MatrixXd& x = result.vectors;
    const Eigen::MatrixXd left =
        vectors * (values.asDiagonal() * (vectors.transpose() * x)) - x * result.values.asDiagonal();
    EXPECT_LT(left.colwise().norm().maxCoeff(), 1e-12);
    EXPECT_LT((x.transpose() * x - Eigen::MatrixXd::Identity(count, count)).norm(), 1e-12);
  }
};

// Three large values, then `cluster` of them from 0.1 down to 0.1 (1 - spread), then a tail.
Problem with_cluster(Eigen::Index size, Eigen::Index cluster, double spread) {
  Problem problem{Eigen::VectorXd(size), random_orthogonal(size)};
  problem.values.head(3) << 1, 0.5, 0.2;
  for (Eigen::Index i = 3; i < size; ++i) {
    const double place = static_cast<double>(i - 3) / static_cast<double>(cluster);
    problem.values[i] = i < 3 + cluster ? 0.1 * (1 - spread * place) : 0.08 * std::pow(place, -3);
  }
  return problem;
}

TEST(LargestEigenpairsInBlocks, FindEveryMemberOfAClusterLargerThanABlock) {
  const Problem problem = with_cluster(400, 100, 0);
  problem.expect(problem.solve({.count = 110}), 0, 110);
}

TEST(LargestEigenpairsInBlocks, TellTheMembersOfATightClusterApart) {
  const Problem problem = with_cluster(400, 60, 1e-7);
  problem.expect(problem.solve({.count = 63}), 0, 63);
}

TEST(LargestEigenpairsInBlocks, StayAtRightAnglesToWhatIsKnown) {
  const Problem problem = with_cluster(300, 40, 0);
  const Eigen::MatrixXd known = problem.vectors.leftCols(13);
  const LanczosResult rest = problem.solve({.count = 33}, known);
  problem.expect(rest, 13, 33);
  EXPECT_LT((known.transpose() * rest.vectors).cwiseAbs().maxCoeff(), 1e-13);
}

TEST(LargestEigenpairsInBlocks, AreTheSameInASmallMemory) {
  const Problem problem = with_cluster(400, 20, 1e-3);
  const std::size_t columns = 140;
  const LanczosResult small = problem.solve({.count = 25, .memory_limit = columns * 400 * sizeof(double)});
  EXPECT_GT(small.restart_count, 0);
  problem.expect(small, 0, 25);
  EXPECT_THROW(problem.solve({.count = 25, .memory_limit = std::size_t{30} * 400 * sizeof(double)}),
               InputError);
}

TEST(LargestEigenpairsInBlocks, GiveAllOfASmallMatrix) {
  Problem problem{Eigen::VectorXd(7), random_orthogonal(7)};
  problem.values << 3, 1, 1, 1, 0.5, 0.5, 0.25;
  problem.expect(problem.solve({.count = 7}), 0, 7);
  problem.expect(problem.solve({.count = 3}, problem.vectors.leftCols(4)), 4, 3);
}

TEST(LargestEigenpairsInBlocks, CanBeCancelled) {
  struct Cancelled : std::runtime_error {
    using std::runtime_error::runtime_error;
  };
  const LanczosOptions options{.count = 40, .progress = [](double) { throw Cancelled("enough"); }};
  EXPECT_THROW(with_cluster(200, 50, 0).solve(options), Cancelled);
}

}  // namespace
}  // namespace tremula
