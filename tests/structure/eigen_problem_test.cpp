#include "tremula/structure/eigen_problem.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "frames.hpp"
#include "trees.hpp"
#include "tremula/structure/mode_count.hpp"
#include "tremula/structure/structure.hpp"

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

// A frame is one part.
EigenProblem whole_problem(const Frame& frame) {
  const EigenParts parts = assemble(frame).eigen;
  EXPECT_EQ(parts.rows.size(), 1U);
  return parts.problem(0, false);
}

TEST(EigenProblem, OfAFrameIsSymmetricAndARootOfTheCompliance) {
  const FrameMatrices matrices = assemble_frame(braced());
  const EigenProblem problem = whole_problem(braced());
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
  const EigenProblem problem = whole_problem(braced());
  const Eigen::VectorXd omega = test::dense_omega(matrices);
  EXPECT_EQ(problem.count_below(0), 0);
  for (Eigen::Index r = 0; r + 1 < omega.size(); ++r) {
    ASSERT_GT(omega[r + 1] / omega[r] - 1, 1e-6);
    EXPECT_EQ(problem.count_below(std::sqrt(omega[r] * omega[r + 1])), r + 1) << r;
  }
}

// Where omega is an eigenvalue of the part of the frame that is eliminated first, a pivot is zero.
TEST(EigenProblem, CountsRightWhereAPivotVanishes) {
  const FrameMatrices matrices = assemble_frame(braced());
  const EigenProblem problem = whole_problem(braced());
  const Eigen::VectorXd omega = test::dense_omega(matrices);
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

TEST(EigenParts, OfATreeOnTwoRootsShareOutItsRowsAndItsModes) {
  const Structure structure = assemble(test::awkward_tree(), test::weightless({.material = wood}));
  const EigenParts& parts = structure.eigen;
  EXPECT_EQ(parts.rows.size(), 2U);
  std::vector<int> times(static_cast<std::size_t>(structure.size()));
  for (const std::vector<int>& rows : parts.rows) {
    EXPECT_TRUE(std::ranges::is_sorted(rows));
    for (const Eigen::Index row : rows) ++times[static_cast<std::size_t>(row)];
  }
  EXPECT_EQ(times, std::vector<int>(times.size(), 1));
  const BeamTree tree = assemble_tree(test::awkward_tree(), {.material = wood});
  for (const double omega : {0.0, 30.0, 300.0, 3e3, 3e5}) {
    const std::vector<int> below = parts.count_below(omega);
    ASSERT_EQ(below.size(), 2U);
    EXPECT_EQ(below[0] + below[1], count_modes_below(tree, omega)) << omega;
    for (std::size_t part = 0; part < 2; ++part)
      EXPECT_EQ(parts.problem(part, true).count_below(omega), below[part]) << omega << ", part " << part;
  }
}

// Whatever forms the problem takes, its displacements are those of the part alone: q^T M q = s^T A s.
TEST(EigenParts, GiveDisplacementsInTheRowsOfThePart) {
  for (const Structure& structure :
       {assemble(test::awkward_tree(), test::weightless({.material = wood})), assemble(braced())}) {
    for (std::size_t part = 0; part < structure.eigen.rows.size(); ++part) {
      const std::vector<int>& rows = structure.eigen.rows[part];
      for (const bool plain : {true, false}) {
        const EigenProblem problem = structure.eigen.problem(part, plain);
        EXPECT_EQ(problem.degrees_of_freedom, static_cast<Eigen::Index>(rows.size()));
        EXPECT_TRUE(plain ? problem.size == problem.degrees_of_freedom
                          : problem.size >= problem.degrees_of_freedom);
        // A product of the operator, so that lanes without a branch are 0.
        Eigen::VectorXd s(problem.size), of_s(problem.size);
        problem.apply(Eigen::VectorXd::Random(problem.size), s);
        s.normalize();
        const double energy = problem.apply(s, of_s);
        Eigen::VectorXd q = Eigen::VectorXd::Zero(structure.size());
        const Eigen::VectorXd own = problem.displacement(s);
        ASSERT_EQ(own.size(), problem.degrees_of_freedom);
        q(rows) = own;
        const Eigen::VectorXd inertia = structure.mass(q);
        EXPECT_NEAR(q.dot(inertia) / energy, 1, 1e-12);
        // What moves no row of the other parts has no inertia there.
        EXPECT_NEAR(inertia(rows).norm() / inertia.norm(), 1, 1e-14);
        // And q is the flexibility's answer where it should be: A s = of_s means B^-1 S A s = K^-1 M q.
        const Eigen::VectorXd bent = structure.flexibility(inertia);
        EXPECT_LT((bent(rows) - problem.displacement(of_s)).norm(), 1e-10 * bent.norm());
      }
    }
  }
}

}  // namespace
}  // namespace tremula
