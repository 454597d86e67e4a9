#include "tremula/modes/eigen_problem.hpp"

#include <cmath>
#include <limits>
#include <memory>

#include <Eigen/SparseCholesky>

#include "tremula/base/error.hpp"

namespace tremula {
namespace {

using Matrix = Eigen::SparseMatrix<double>;

struct Pivots {
  int negative;
  double growth;  // of the largest sum |l_ij^2 d_j| over a row, beside the diagonal of K
};

// Without exchange of rows the factors of an indefinite matrix can grow without bound and take the digits of
// the matrix with them: growth tells.
Pivots count_pivots(Eigen::SimplicialLDLT<Matrix>& factors, const FrameMatrices& matrices, double omega) {
  factors.factorize(matrices.stiffness - omega * omega * matrices.mass);
  if (factors.info() != Eigen::Success) return {0, std::numeric_limits<double>::infinity()};
  const Eigen::VectorXd pivots = factors.vectorD();
  Eigen::VectorXd sum = pivots.cwiseAbs();
  const auto& lower = factors.matrixL().nestedExpression();
  for (Eigen::Index column = 0; column < lower.outerSize(); ++column) {
    for (Matrix::InnerIterator entry(lower, column); entry; ++entry) {
      if (entry.row() > column) sum[entry.row()] += entry.value() * entry.value() * std::abs(pivots[column]);
    }
  }
  const Eigen::VectorXd scale = factors.permutationP() * Eigen::VectorXd(matrices.stiffness.diagonal());
  return {static_cast<int>((pivots.array() < 0).count()), (sum.array() / scale.array()).maxCoeff()};
}

int count_below(Eigen::SimplicialLDLT<Matrix>& factors, const FrameMatrices& matrices, double omega) {
  Pivots best{0, std::numeric_limits<double>::infinity()};
  for (int nudge = 0; nudge < 5; ++nudge) {
    const Pivots pivots = count_pivots(factors, matrices, omega * (1 + 1e-9 * nudge));
    if (pivots.growth < best.growth) best = pivots;
    if (best.growth < 1e3) return best.negative;
  }
  if (!std::isfinite(best.growth)) throw Error("modes: the modes below a frequency could not be counted");
  return best.negative;
}

}  // namespace

EigenProblem eigen_problem(const FrameMatrices& matrices) {
  const auto cholesky = std::make_shared<Eigen::SimplicialLLT<Matrix>>(matrices.stiffness);
  if (cholesky->info() != Eigen::Success) {
    throw Error("modes: the stiffness of the frame is not positive definite to working precision");
  }
  const auto indefinite = std::make_shared<Eigen::SimplicialLDLT<Matrix>>();
  indefinite->analyzePattern(matrices.stiffness + matrices.mass);
  const auto displacement = [cholesky](Eigen::Ref<const Eigen::VectorXd> s) -> Eigen::VectorXd {
    return cholesky->permutationPinv() * Eigen::VectorXd(cholesky->matrixU().solve(s));
  };
  return {.size = matrices.size(),
          .degrees_of_freedom = matrices.size(),
          .apply =
              [cholesky, displacement, &matrices](Eigen::Ref<const Eigen::VectorXd> in,
                                                  Eigen::Ref<Eigen::VectorXd> out) {
                const Eigen::VectorXd inertia = matrices.mass * displacement(in);
                out = cholesky->matrixL().solve(Eigen::VectorXd(cholesky->permutationP() * inertia));
                return in.dot(out);
              },
          .displacement = displacement,
          .count_below = [indefinite,
                          &matrices](double omega) { return count_below(*indefinite, matrices, omega); }};
}

}  // namespace tremula
