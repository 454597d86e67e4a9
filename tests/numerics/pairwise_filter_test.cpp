#include "tremula/numerics/pairwise_filter.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tremula/numerics/random.hpp"

namespace tremula {
namespace {

struct Case {
  Eigen::Matrix3Xd points;
  PairwiseFilter::Channels noise;
};

Case random_case(int count, double size) {
  Case c{Eigen::Matrix3Xd(3, count), PairwiseFilter::Channels(count, PairwiseFilter::channels)};
  for (Eigen::Index i = 0; i < c.points.size(); ++i) {
    c.points.data()[i] = size * uniform({1, RandomStream::test, 0, static_cast<std::uint64_t>(i)});
  }
  for (Eigen::Index i = 0; i < c.noise.size(); ++i) {
    c.noise.data()[i] = static_cast<float>(
        complex_gaussian({1, RandomStream::test, 1, static_cast<std::uint64_t>(i)}).real());
  }
  return c;
}

TEST(PairwiseFilter, IsTheSumOverAllPairsForAnyNumberOfPoints) {
  for (const int count : {1, 2, 63, 64, 65, 200, 777}) {
    const Case c = random_case(count, 5);
    for (const double decay : {0.0, 0.3, 4.0, 100.0}) {
      const auto result = PairwiseFilter(c.points).apply(decay, 0, c.noise);
      Eigen::MatrixXd weights(count, count);
      for (int k = 0; k < count; ++k) {
        for (int l = 0; l < count; ++l)
          weights(k, l) = std::exp(-decay * (c.points.col(k) - c.points.col(l)).norm());
      }
      const Eigen::MatrixXd wanted = weights * c.noise.cast<double>();
      EXPECT_LT((result.filtered.cast<double>() - wanted).norm(), 3e-6 * (wanted.norm() + 1))
          << count << ", " << decay;
      const Eigen::VectorXd squares = weights.array().square().rowwise().sum();
      EXPECT_LT((result.squared_weights.cast<double>() - squares).norm(), 3e-6 * squares.norm())
          << count << ", " << decay;
    }
  }
}

TEST(PairwiseFilter, LeavesOutOnlyWhatIsBelowTheCutOff) {
  const Case c = random_case(2000, 80);
  const PairwiseFilter filter(c.points);
  const auto all = filter.apply(0.1, 0, c.noise), near = filter.apply(0.1, 0.2, c.noise);
  EXPECT_GT((all.squared_weights - near.squared_weights).norm(), 0);
  EXPECT_LT((all.squared_weights - near.squared_weights).maxCoeff(), 2000 * 0.04);
}

}  // namespace
}  // namespace tremula
