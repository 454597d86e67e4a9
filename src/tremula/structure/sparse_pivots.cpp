#include "tremula/structure/sparse_pivots.hpp"

#include "tremula/base/error.hpp"

#include <cmath>
#include <limits>

namespace tremula {
namespace {

using Matrix = Eigen::SparseMatrix<double>;

struct Pivots {
  int negative;
  double growth;  // of the largest sum |l_ij^2 d_j| over a row, beside the diagonal of K
};

// Without exchange of rows the factors of an indefinite matrix can grow without bound and take the digits of
// the matrix with them: growth tells.
Pivots count_pivots(Eigen::SimplicialLDLT<Matrix>& factors, const Matrix& stiffness, const Matrix& mass,
                    double omega) {
  factors.factorize(stiffness - omega * omega * mass);
  if (factors.info() != Eigen::Success) return {0, std::numeric_limits<double>::infinity()};
  const Eigen::VectorXd pivots = factors.vectorD();
  Eigen::VectorXd sum = pivots.cwiseAbs();
  const auto& lower = factors.matrixL().nestedExpression();
  for (Eigen::Index column = 0; column < lower.outerSize(); ++column) {
    for (Matrix::InnerIterator entry(lower, column); entry; ++entry) {
      if (entry.row() > column) sum[entry.row()] += entry.value() * entry.value() * std::abs(pivots[column]);
    }
  }
  const Eigen::VectorXd scale = factors.permutationP() * Eigen::VectorXd(stiffness.diagonal());
  return {static_cast<int>((pivots.array() < 0).count()), (sum.array() / scale.array()).maxCoeff()};
}

}  // namespace

int count_below(Eigen::SimplicialLDLT<Matrix>& factors, const Matrix& stiffness, const Matrix& mass,
                double& omega) {
  Pivots best{0, std::numeric_limits<double>::infinity()};
  const double asked = omega;
  double best_omega = asked;
  for (int nudge = 0; nudge < 5; ++nudge) {
    omega = asked * (1 + 1e-9 * nudge);
    const Pivots pivots = count_pivots(factors, stiffness, mass, omega);
    if (pivots.growth < best.growth) {
      best = pivots;
      best_omega = omega;
    }
    if (best.growth < 1e3) return best.negative;
  }
  if (!std::isfinite(best.growth)) {
    throw InputError("modes",
                     "stiffness and mass so far apart that the modes below a frequency cannot be counted",
                     "parts and masses nearer to each other in size");
  }
  if (omega != best_omega) {  // the factors are to be those of what is counted
    omega = best_omega;
    count_pivots(factors, stiffness, mass, omega);
  }
  return best.negative;
}

}  // namespace tremula
