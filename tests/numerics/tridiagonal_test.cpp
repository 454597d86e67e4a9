#include "tremula/numerics/tridiagonal.hpp"

#include "tremula/numerics/random.hpp"

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

namespace tremula {
namespace {

struct Matrix {
  std::vector<double> diagonal, off_diagonal;
  operator Tridiagonal() const { return {diagonal, off_diagonal}; }  // NOLINT
  Eigen::MatrixXd dense() const {
    const auto n = static_cast<Eigen::Index>(diagonal.size());
    Eigen::MatrixXd result = Eigen::MatrixXd::Zero(n, n);
    for (Eigen::Index i = 0; i < n; ++i) {
      result(i, i) = diagonal[static_cast<std::size_t>(i)];
      if (i + 1 < n) result(i, i + 1) = result(i + 1, i) = off_diagonal[static_cast<std::size_t>(i)];
    }
    return result;
  }
};

// 2 and -1: eigenvalues 2 - 2 cos(k pi/(n+1)), eigenvectors sines.
Matrix second_difference(int n) {
  return {std::vector<double>(static_cast<std::size_t>(n), 2.0),
          std::vector<double>(static_cast<std::size_t>(n), -1.0)};
}

// Wilkinson's W+ of odd size: its largest eigenvalues are pairs that agree to all digits.
Matrix wilkinson(int n) {
  Matrix matrix{{}, std::vector<double>(static_cast<std::size_t>(n), 1.0)};
  for (int i = 0; i < n; ++i) matrix.diagonal.push_back(std::abs(i - n / 2));
  return matrix;
}

TEST(KthLargestEigenvalue, IsTheClosedFormOfTheSecondDifference) {
  const int n = 57;
  for (const int k : {0, 1, 28, 55, 56}) {
    const double exact = 2 - 2 * std::cos((n - k) * std::numbers::pi / (n + 1));
    EXPECT_NEAR(kth_largest_eigenvalue(second_difference(n), k, -1e300), exact, 1e-14) << k;
    EXPECT_NEAR(kth_largest_eigenvalue(second_difference(n), k, exact - 0.01), exact, 1e-14) << k;
  }
}

TEST(KthLargestEigenvalue, CountsBothOfAPair) {
  const Matrix matrix = wilkinson(21);
  const double first = kth_largest_eigenvalue(matrix, 0, -1e300);
  EXPECT_NEAR(first, 10.746194182903393, 1e-13);  // Wilkinson 1965, p. 309
  EXPECT_NEAR(kth_largest_eigenvalue(matrix, 1, -1e300), first, 1e-13);
  EXPECT_LT(kth_largest_eigenvalue(matrix, 2, -1e300), first - 0.5);
}

TEST(LastComponent, IsTheClosedFormOfTheSecondDifference) {
  const int n = 40;
  for (const int k : {1, 7, 40}) {
    const double value = 2 - 2 * std::cos(k * std::numbers::pi / (n + 1));
    const double exact = std::sqrt(2.0 / (n + 1)) * std::abs(std::sin(k * n * std::numbers::pi / (n + 1)));
    EXPECT_NEAR(last_component(second_difference(n), value), exact, 1e-12) << k;
  }
}

TEST(LastComponent, KeepsItsDigitsWhenItIsTiny) {
  // Steeply falling diagonal: the vector of the largest value decays by a known factor a step.
  Matrix matrix;
  const int n = 12;
  for (int i = 0; i < n; ++i) {
    matrix.diagonal.push_back(i == 0 ? 1.0 : 0.0);
    matrix.off_diagonal.push_back(0.01);
  }
  const double value = kth_largest_eigenvalue(matrix, 0, -1e300);
  // (value - 0) x_i = 0.01 (x_{i-1} + x_{i+1}) below the first row, x_{n} = 0: backwards by the recurrence.
  std::vector<double> x(n, 0.0);
  x[n - 1] = 1;
  for (int i = n - 1; i > 0; --i) {
    const auto at = static_cast<std::size_t>(i);
    x[at - 1] = value / 0.01 * x[at] - (i + 1 < n ? x[at + 1] : 0);
  }
  double square = 0;
  for (const double component : x) square += component * component;
  const double exact = 1 / std::sqrt(square);
  EXPECT_LT(exact, 1e-21);
  EXPECT_NEAR(last_component(matrix, value) / exact, 1, 1e-10);
}

TEST(LargestEigenpairsOfATridiagonal, AgreeWithADenseSolver) {
  Matrix matrix;
  for (std::uint64_t i = 0; i < 80; ++i) {
    matrix.diagonal.push_back(uniform({1, RandomStream::test, 0, i}) * std::pow(0.9, static_cast<double>(i)));
    matrix.off_diagonal.push_back(uniform({1, RandomStream::test, 1, i}) *
                                  std::pow(0.9, static_cast<double>(i)));
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(matrix.dense());
  const TridiagonalEigenpairs pairs = largest_eigenpairs(matrix, 30);
  for (Eigen::Index k = 0; k < 30; ++k) {
    EXPECT_NEAR(pairs.values[k], solver.eigenvalues()[79 - k], 1e-14) << k;
    const double along = std::abs(pairs.vectors.col(k).dot(solver.eigenvectors().col(79 - k)));
    EXPECT_NEAR(along, 1, 1e-10) << k;
  }
}

TEST(LargestEigenpairsOfATridiagonal, AreOrthonormalInsidePairsThatAgreeToAllDigits) {
  const Matrix matrix = wilkinson(41);
  const TridiagonalEigenpairs pairs = largest_eigenpairs(matrix, 20);
  const Eigen::MatrixXd gram = pairs.vectors.transpose() * pairs.vectors;
  EXPECT_LT((gram - Eigen::MatrixXd::Identity(20, 20)).cwiseAbs().maxCoeff(), 1e-13);
  const Eigen::MatrixXd rest = matrix.dense() * pairs.vectors - pairs.vectors * pairs.values.asDiagonal();
  EXPECT_LT(rest.cwiseAbs().maxCoeff(), 1e-12);
}

TEST(LargestEigenpairsOfATridiagonal, AreFoundInAMatrixThatFallsApart) {
  Matrix matrix{{3, 1, 3, 1, 3}, {0.5, 0, 0.5, 0, 0}};
  const TridiagonalEigenpairs pairs = largest_eigenpairs(matrix, 5);
  const Eigen::MatrixXd rest = matrix.dense() * pairs.vectors - pairs.vectors * pairs.values.asDiagonal();
  EXPECT_LT(rest.cwiseAbs().maxCoeff(), 1e-13);
  const Eigen::MatrixXd gram = pairs.vectors.transpose() * pairs.vectors;
  EXPECT_LT((gram - Eigen::MatrixXd::Identity(5, 5)).cwiseAbs().maxCoeff(), 1e-13);
}

}  // namespace
}  // namespace tremula
