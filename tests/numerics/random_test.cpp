#include "tremula/numerics/random.hpp"

#include <cmath>
#include <numbers>
#include <set>
#include <vector>

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

TEST(Random, TwoUniformsAreTheOneAndAnotherThatKnowsNothingOfIt) {
  constexpr int count = 100000;
  double sum = 0, product = 0;
  for (int i = 0; i < count; ++i) {
    const RandomAddress address{1, RandomStream::test, 0, static_cast<std::uint64_t>(i)};
    const auto [first, second] = two_uniforms(address);
    ASSERT_EQ(first, uniform(address));
    sum += second - 0.5;
    product += (first - 0.5) * (second - 0.5);
  }
  EXPECT_NEAR(sum / count, 0, 4 * std::sqrt(1.0 / 12 / count));
  EXPECT_NEAR(product / count, 0, 4 / (12 * std::sqrt(count)));
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

TEST(Random, ManyGaussiansAreTheSamePhiloxWordsThroughLogarithmAndSineOfTheLibrary) {
  // Reads the words of Philox through uniform(): its 53 bits hold words 0 and 1 of a block, so magnitude and
  // phase of the first number of each pair.
  constexpr std::size_t count = 1000, run = 64;
  std::vector<std::complex<float>> values(count);
  complex_gaussians(77, RandomStream::test, 9, count, values.data());
  for (std::size_t i = 0; i < count; ++i) {
    if (i / run % 2 != 0) continue;  // made of words 2 and 3
    const std::size_t block = i / (2 * run) * run + i % run;
    const auto bits = static_cast<std::uint64_t>(uniform({77, RandomStream::test, 9, block}) * 0x1p53) << 11;
    const double phase = static_cast<double>(bits >> 32) * 0x1p-32;
    // Of word 0 the last 11 bits are lost.
    const double u = (static_cast<double>(static_cast<std::uint32_t>(bits)) + 1024) * 0x1p-32;
    const double magnitude = std::sqrt(-std::log(u));
    const auto wanted = std::polar(magnitude, 2 * std::numbers::pi * phase);
    EXPECT_LT(std::abs(std::complex<double>(values[i]) - wanted), 2e-6 + 0x1p-22 / (u * magnitude)) << i;
  }
}

TEST(Random, ManyGaussiansHaveTheMomentsOfOneComplexGaussian) {
  constexpr std::size_t count = 400000;
  std::vector<std::complex<float>> values(count);
  complex_gaussians(5, RandomStream::test, 1, count, values.data());
  std::complex<double> sum = 0, pseudo = 0, next = 0, half_run = 0;
  double power = 0, fourth = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::complex<double> w = values[i];
    sum += w;
    pseudo += w * w;
    power += std::norm(w);
    fourth += std::norm(w) * std::norm(w);
    next += w * std::conj(std::complex<double>(values[(i + 1) % count]));
    half_run += w * std::conj(std::complex<double>(values[(i + 64) % count]));
  }
  const double n = count;
  EXPECT_LT(std::abs(sum) / n, 4 / std::sqrt(n));
  EXPECT_LT(std::abs(pseudo) / n, 4 * std::sqrt(2 / n));
  EXPECT_LT(std::abs(next) / n, 4 / std::sqrt(n));
  EXPECT_LT(std::abs(half_run) / n, 4 / std::sqrt(n)) << "the two numbers of a block";
  EXPECT_NEAR(power / n, 1, 4 / std::sqrt(n));
  EXPECT_NEAR(fourth / n, 2, 4 * std::sqrt(20 / n));
}

TEST(Random, ManyGaussiansDoNotDependOnHowManyAreAskedFor) {
  std::vector<std::complex<float>> few(37), many(300);
  complex_gaussians(5, RandomStream::test, 1, few.size(), few.data());
  complex_gaussians(5, RandomStream::test, 1, many.size(), many.data());
  EXPECT_TRUE(std::equal(few.begin(), few.end(), many.begin()));
}

TEST(Random, UnitPhasesAreTheGaussiansWithoutTheirMagnitudes) {
  std::vector<std::complex<float>> phases(1000), gaussians(1000);
  unit_phases(5, RandomStream::test, 1, phases.size(), phases.data());
  complex_gaussians(5, RandomStream::test, 1, gaussians.size(), gaussians.data());
  for (std::size_t i = 0; i < phases.size(); ++i) {
    EXPECT_NEAR(std::abs(phases[i]), 1, 3e-7);
    EXPECT_LT(std::abs(phases[i] * std::abs(gaussians[i]) - gaussians[i]), 1e-6);
  }
}

}  // namespace
}  // namespace tremula
