// The eigenproblem K q = omega^2 M q of any structure in the form that the solver works on.
//
// With a root R of the inverse stiffness, K^-1 = R R^T, and q = R s it is the standard symmetric problem
// R^T M R s = omega^-2 s: the lowest modes have the largest eigenvalues.
#pragma once

#include <functional>

#include <Eigen/Core>

#include "tremula/numerics/lanczos.hpp"
#include "tremula/structure/frame.hpp"

namespace tremula {

struct EigenProblem {
  Eigen::Index size;
  SymmetricOperator apply;                                                // s -> R^T M R s
  std::function<Eigen::VectorXd(const Eigen::VectorXd& s)> displacement;  // s -> R s
  std::function<int(double omega)> count_below;  // modes below omega [rad/s], by another method: inertia
};

// K = P^T L L^T P by sparse Cholesky, R = P^T L^-T. `matrices` must outlive the problem. count_below counts
// the negative pivots of the LDL^T of K - omega^2 M; it takes no pivots out of turn, so where one comes out
// too small for the rest to be trusted, omega is moved up by a few parts in 1e9. Throws Error where K is not
// positive definite to working precision.
EigenProblem eigen_problem(const FrameMatrices& matrices);

}  // namespace tremula
