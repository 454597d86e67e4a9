// Counting modes by the signs of pivots, where K and M are assembled.
#pragma once

#include <Eigen/SparseCholesky>

namespace tremula {

// How many eigenvalues K q = omega^2 M q has below omega^2: the negative pivots of the L D L^T of K - omega^2
// M, which takes none out of turn. So where one comes out too small for the rest to be trusted, omega is
// moved up by a few parts in 1e9; it is left at what was used. `factors` have been given the pattern of K + M
// (analyzePattern). Throws InputError where K and M lie too far apart to be counted.
int count_below(Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>& factors,
                const Eigen::SparseMatrix<double>& stiffness, const Eigen::SparseMatrix<double>& mass,
                double& omega);

}  // namespace tremula
