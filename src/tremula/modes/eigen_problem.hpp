// What the eigensolver needs to know of a structure, whatever its kind.
#pragma once

#include "tremula/numerics/lanczos.hpp"
#include "tremula/structure/frame.hpp"
#include "tremula/structure/structure.hpp"

#include <functional>

#include <Eigen/Core>

namespace tremula {

// K q = omega^2 M q as a standard symmetric problem A s = omega^-2 s, and what goes with it.
struct EigenProblem {
  Eigen::Index size = 0;                // of s, at least the degrees of freedom
  Eigen::Index degrees_of_freedom = 0;  // as many eigenvalues are of interest; the others, if any, are 0
  SymmetricOperator apply = {};
  std::function<Eigen::VectorXd(Eigen::Ref<const Eigen::VectorXd> s)> displacement = {};  // q / omega of s
  std::function<int(double omega)> count_below = {};  // eigenvalues omega_r^2 below omega^2, by inertia
};

// By the compliance form. `structure` must live as long as the problem does.
EigenProblem eigen_problem(const Structure& structure);

// By sparse Cholesky: K = P^T L L^T P, q = P^T L^-T s. `matrices` must live as long as the problem does.
// count_below counts the negative pivots of the LDL^T of K - omega^2 M; it takes no pivots out of turn, so
// where one comes out too small for the rest to be trusted, omega is moved up by a few parts in 1e9. Throws
// Error where K is not positive definite to working precision.
EigenProblem eigen_problem(const FrameMatrices& matrices);

}  // namespace tremula
