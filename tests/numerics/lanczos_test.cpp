#include "tremula/numerics/lanczos.hpp"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <cmath>
#include <stdexcept>

#include "tremula/base/error.hpp"
#include "tremula/numerics/random.hpp"

namespace tremula {
namespace {

// A symmetric matrix with the given eigenvalues and random eigenvectors.
Eigen::MatrixXd with_eigenvalues(const Eigen::VectorXd& values) {
  Eigen::MatrixXd random(values.size(), values.size());
  for (Eigen::Index i = 0; i < random.size(); ++i) {
    random.data()[i] = complex_gaussian({3, RandomStream::test, 1, static_cast<std::uint64_t>(i)}).real();
  }
  const Eigen::MatrixXd q = Eigen::HouseholderQR<Eigen::MatrixXd>(random).householderQ();
  return q * values.asDiagonal() * q.transpose();
}

LanczosResult solve(const Eigen::MatrixXd& matrix, const LanczosOptions& options,
                    const Eigen::MatrixXd& deflated = {}) {
  const auto apply = [&](Eigen::Ref<const Eigen::VectorXd> in, Eigen::Ref<Eigen::VectorXd> out) {
    out.noalias() = matrix * in;
    return in.dot(out);
  };
  return largest_eigenpairs(apply, matrix.rows(), options, deflated);
}

// Like those of a structure: omega^-2 over many orders of magnitude.
Eigen::VectorXd steep_spectrum(Eigen::Index size) {
  Eigen::VectorXd values(size);
  for (Eigen::Index i = 0; i < size; ++i) values[i] = std::pow(static_cast<double>(i + 1), -3);
  return values;
}

TEST(LargestEigenpairs, AreThoseTheMatrixWasMadeOf) {
  const Eigen::VectorXd wanted = steep_spectrum(300);
  const Eigen::MatrixXd matrix = with_eigenvalues(wanted);
  const LanczosResult result = solve(matrix, {.count = 20});
  ASSERT_TRUE(result.converged);
  for (Eigen::Index r = 0; r < 20; ++r) {
    EXPECT_NEAR(result.values[r], wanted[r], 4e-15) << r;  // the matrix itself is rounded
    const Eigen::VectorXd x = result.vectors.col(r);
    EXPECT_LT((matrix * x - result.values[r] * x).norm(), std::max(2e-12 * result.values[r], 1e-15)) << r;
  }
  EXPECT_LT((result.vectors.transpose() * result.vectors - Eigen::MatrixXd::Identity(20, 20)).norm(), 1e-11);
}

TEST(LargestEigenpairs, ReadTheBasisFarLessOftenThanEveryStep) {
  const LanczosResult result = solve(with_eigenvalues(steep_spectrum(400)), {.count = 20, .tolerance = 1e-8});
  ASSERT_TRUE(result.converged);
  EXPECT_GT(result.reorthogonalisation_count, 0);
  EXPECT_LT(result.reorthogonalisation_count, result.operator_count / 2);
}

TEST(LargestEigenpairs, StayAtRightAnglesToWhatIsKnown) {
  const Eigen::VectorXd wanted = steep_spectrum(120);
  const Eigen::MatrixXd matrix = with_eigenvalues(wanted);
  const LanczosResult first = solve(matrix, {.count = 5});
  const LanczosResult next = solve(matrix, {.count = 5, .start = 1}, first.vectors);
  for (Eigen::Index r = 0; r < 5; ++r) EXPECT_NEAR(next.values[r], wanted[r + 5], 1e-14) << r;
  EXPECT_LT((first.vectors.transpose() * next.vectors).cwiseAbs().maxCoeff(), 1e-11);
}

TEST(LargestEigenpairs, FindTheOtherCopyOfADoubleValueOnASecondSearch) {
  Eigen::VectorXd wanted = steep_spectrum(100);
  wanted[1] = wanted[0];
  const Eigen::MatrixXd matrix = with_eigenvalues(wanted);
  const LanczosResult first = solve(matrix, {.count = 1});
  const LanczosResult second = solve(matrix, {.count = 1, .start = 1}, first.vectors);
  EXPECT_NEAR(first.values[0], 1, 1e-14);
  EXPECT_NEAR(second.values[0], 1, 1e-14);
  EXPECT_NEAR(first.vectors.col(0).dot(second.vectors.col(0)), 0, 1e-11);
}

TEST(LargestEigenpairs, GiveAllOfASmallMatrix) {
  const Eigen::VectorXd wanted = steep_spectrum(6);
  const LanczosResult result = solve(with_eigenvalues(wanted), {.count = 6});
  ASSERT_TRUE(result.converged);
  for (Eigen::Index r = 0; r < 6; ++r) EXPECT_NEAR(result.values[r], wanted[r], 1e-14) << r;
}

TEST(LargestEigenpairs, OfTheIdentityAreOneAfterAFewSteps) {
  const LanczosResult result = solve(Eigen::MatrixXd::Identity(10, 10), {.count = 1});
  ASSERT_TRUE(result.converged);
  EXPECT_NEAR(result.values[0], 1, 1e-14);
  EXPECT_LE(result.operator_count, 10);  // the first look at the values is after nine
}

TEST(LargestEigenpairs, AreTheSameWithRestartsInASmallBasis) {
  const Eigen::VectorXd wanted = steep_spectrum(300);
  const Eigen::MatrixXd matrix = with_eigenvalues(wanted);
  const LanczosResult free = solve(matrix, {.count = 20});
  const std::size_t columns = 36;
  const LanczosResult bounded = solve(matrix, {.count = 20, .memory_limit = columns * 300 * sizeof(double)});
  ASSERT_TRUE(bounded.converged);
  EXPECT_GT(free.operator_count, static_cast<int>(columns));  // or the bound would not bind
  EXPECT_EQ(free.restart_count, 0);
  EXPECT_GT(bounded.restart_count, 0);
  EXPECT_GE(bounded.operator_count, free.operator_count);
  for (Eigen::Index r = 0; r < 20; ++r) {
    EXPECT_NEAR(bounded.values[r], wanted[r], 1e-14) << r;
    const Eigen::VectorXd x = bounded.vectors.col(r);
    EXPECT_LT((matrix * x - bounded.values[r] * x).norm(), std::max(2e-12 * bounded.values[r], 1e-15)) << r;
  }
}

TEST(LargestEigenpairs, RefuseAMemoryLimitThatHoldsNoBasis) {
  const Eigen::MatrixXd matrix = with_eigenvalues(steep_spectrum(300));
  EXPECT_THROW(solve(matrix, {.count = 20, .memory_limit = 20 * 300 * sizeof(double)}), InputError);
  EXPECT_TRUE(solve(matrix, {.count = 20, .memory_limit = lanczos_memory(300, 20).least}).converged);
}

TEST(LargestEigenpairs, GoOnBeyondAnInvariantSubspace) {
  // A starting vector sees one direction of each multiple value: three dimensions, and the iteration is at
  // its end before ten values are found.
  Eigen::VectorXd wanted(12);
  wanted << 1, 1, 1, 1, 0.5, 0.5, 0.5, 0.5, 0.25, 0.25, 0.25, 0.25;
  const LanczosResult result = solve(with_eigenvalues(wanted), {.count = 10});
  ASSERT_TRUE(result.converged);
  for (Eigen::Index r = 0; r < 10; ++r) EXPECT_NEAR(result.values[r], wanted[r], 1e-13) << r;
}

TEST(LargestEigenpairs, CanBeCancelled) {
  struct Cancelled : std::runtime_error {
    using std::runtime_error::runtime_error;
  };
  const LanczosOptions options{.count = 20, .progress = [](double) { throw Cancelled("enough"); }};
  EXPECT_THROW(solve(with_eigenvalues(steep_spectrum(300)), options), Cancelled);
}

}  // namespace
}  // namespace tremula
