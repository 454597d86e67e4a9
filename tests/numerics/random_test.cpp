#include "tremula/numerics/random.hpp"

#include <cmath>
#include <set>

#include <gtest/gtest.h>

namespace tremula {
namespace {

TEST(Random, GivesTheSameNumberForTheSameAddressAndOthersForOthers) {
  const RandomAddress address{7, RandomStream::test, 11, 13};
  EXPECT_EQ(uniform(address), uniform(address));
  std::set<double> values{uniform(address)};
  values.insert(uniform({8, RandomStream::test, 11, 13}));
  values.insert(uniform({7, RandomStream::wind_u, 11, 13}));
  values.insert(uniform({7, RandomStream::test, 12, 13}));
  values.insert(uniform({7, RandomStream::test, 11, 14}));
  values.insert(uniform({7, RandomStream::test, 11, 13 + (std::uint64_t{1} << 32)}));
  values.insert(uniform({7 + (std::uint64_t{1} << 32), RandomStream::test, 11, 13}));
  EXPECT_EQ(values.size(), 7U);
}

TEST(Random, UniformHasTheMomentsOfTheUnitInterval) {
  constexpr int count = 100000;
  double sum = 0, squares = 0;
  for (int i = 0; i < count; ++i) {
    const double value = uniform({1, RandomStream::test, 0, static_cast<std::uint64_t>(i)});
    ASSERT_GE(value, 0);
    ASSERT_LT(value, 1);
    sum += value;
    squares += value * value;
  }
  EXPECT_NEAR(sum / count, 0.5, 4 * std::sqrt(1.0 / 12 / count));
  EXPECT_NEAR(squares / count, 1.0 / 3, 4 * std::sqrt((1.0 / 5 - 1.0 / 9) / count));
}

TEST(Random, ComplexGaussianHasUnitVarianceAndNoPreferredPhase) {
  constexpr int count = 100000;
  std::complex<double> sum = 0, pseudo = 0;
  double power = 0, fourth = 0;
  for (int i = 0; i < count; ++i) {
    const auto w = complex_gaussian({2, RandomStream::test, 5, static_cast<std::uint64_t>(i)});
    sum += w;
    pseudo += w * w;
    power += std::norm(w);
    fourth += std::norm(w) * std::norm(w);
  }
  const double n = count;
  EXPECT_LT(std::abs(sum) / n, 4 / std::sqrt(n));
  EXPECT_LT(std::abs(pseudo) / n, 4 * std::sqrt(2 / n));
  EXPECT_NEAR(power / n, 1, 4 / std::sqrt(n));        // |w|^2 is exponential: variance 1
  EXPECT_NEAR(fourth / n, 2, 4 * std::sqrt(20 / n));  // E|w|^4 = 2, variance 24 - 4
}

}  // namespace
}  // namespace tremula
