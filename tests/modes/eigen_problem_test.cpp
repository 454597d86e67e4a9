#include "tremula/modes/eigen_problem.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/SparseCholesky>
#include <cmath>

#include "frames.hpp"

namespace tremula {
namespace {

const Material wood{"wood", 9e9, 7e8, 950, ""};

// Two triangles that share a side, clamped at one corner, with a mass at another: loops, and no symmetry.
Frame braced() {
  Frame frame;
  frame.nodes = {{0, 0, 0}, {1, 0.1, 0}, {0.4, 0, 0.9}, {1.3, 0.3, 1.1}};
  frame.clamped = {0};
  test::add_beam(frame, 0, 1, 2, 0.03, wood);
  test::add_beam(frame, 1, 2, 2, 0.02, wood);
  test::add_beam(frame, 2, 0, 2, 0.025, wood);
  test::add_beam(frame, 1, 3, 2, 0.015, wood);
  test::add_beam(frame, 3, 2, 2, 0.02, wood);
  frame.masses = {{3, 0.8}};
  return frame;
}

Eigen::VectorXd dense_omega(const FrameMatrices& matrices) {
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(
      Eigen::MatrixXd(matrices.stiffness), Eigen::MatrixXd(matrices.mass), Eigen::EigenvaluesOnly);
  return solver.eigenvalues().cwiseSqrt();
}

TEST(EigenProblem, OfAFrameIsSymmetricAndARootOfTheCompliance) {
  const FrameMatrices matrices = assemble_frame(braced());
  const EigenProblem problem = eigen_problem(matrices);
  const Eigen::VectorXd a = Eigen::VectorXd::Random(problem.size), b = Eigen::VectorXd::Random(problem.size);
  Eigen::VectorXd of_a(problem.size), of_b(problem.size);
  const double a_of_a = problem.apply(a, of_a);
  problem.apply(b, of_b);
  EXPECT_NEAR(a.dot(of_b), b.dot(of_a), 1e-12 * of_a.norm() * b.norm());
  EXPECT_NEAR(a_of_a / a.dot(of_a), 1, 1e-14);
  const Eigen::VectorXd q = problem.displacement(a);
  EXPECT_NEAR(q.dot(matrices.mass * q) / a.dot(of_a), 1, 1e-12);
  EXPECT_NEAR(q.dot(matrices.stiffness * q) / a.squaredNorm(), 1, 1e-9);
}

TEST(EigenProblem, CountsTheModesBelowEveryGapOfAFrame) {
  const FrameMatrices matrices = assemble_frame(braced());
  const EigenProblem problem = eigen_problem(matrices);
  const Eigen::VectorXd omega = dense_omega(matrices);
  EXPECT_EQ(problem.count_below(0), 0);
  for (Eigen::Index r = 0; r + 1 < omega.size(); ++r) {
    ASSERT_GT(omega[r + 1] / omega[r] - 1, 1e-6);
    EXPECT_EQ(problem.count_below(std::sqrt(omega[r] * omega[r + 1])), r + 1) << r;
  }
}

// Where omega is an eigenvalue of the part of the frame that is eliminated first, a pivot is zero.
TEST(EigenProblem, CountsRightWhereAPivotVanishes) {
  const FrameMatrices matrices = assemble_frame(braced());
  const EigenProblem problem = eigen_problem(matrices);
  const Eigen::VectorXd omega = dense_omega(matrices);
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> order(matrices.stiffness);
  const Eigen::MatrixXd stiffness =
      order.permutationP() * Eigen::MatrixXd(matrices.stiffness) * order.permutationPinv();
  const Eigen::MatrixXd mass =
      order.permutationP() * Eigen::MatrixXd(matrices.mass) * order.permutationPinv();
  int compared = 0;
  for (Eigen::Index part = 1; part < problem.size; ++part) {
    const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> first(
        stiffness.topLeftCorner(part, part), mass.topLeftCorner(part, part), Eigen::EigenvaluesOnly);
    for (const double square : first.eigenvalues()) {
      const double singular = std::sqrt(square);
      if ((omega.array() / singular - 1).abs().minCoeff() < 1e-5) continue;
      EXPECT_EQ(problem.count_below(singular), (omega.array() < singular).count()) << part;
      ++compared;
    }
  }
  EXPECT_GT(compared, 500);
}

}  // namespace
}  // namespace tremula
