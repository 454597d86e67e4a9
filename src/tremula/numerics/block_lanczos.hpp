// The largest eigenvalues of a symmetric operator, many vectors at a time: what finds all members of a
// cluster.
//
// A Krylov sequence of one vector has one vector of every multiple eigenvalue, and one of a tight cluster for
// long. A block of b vectors has b of them. It costs more where eigenvalues are single (every vector is made
// orthogonal to every other), so lanczos.hpp searches first, and this finds what it is known to have missed.
#pragma once

#include "tremula/numerics/lanczos.hpp"

namespace tremula {

// As largest_eigenpairs, in rounds of up to 32 eigenpairs by block Lanczos with thick restarts (Golub &
// Underwood 1977; Wu & Simon 2000). `deflated` (n x d): orthonormal eigenvectors already known, that of the
// largest eigenvalue first. `values` come in the order in which they were found. Throws InputError for a
// memory limit that holds too few vectors beside those known and wanted (16).
LanczosResult largest_eigenpairs_in_blocks(const SymmetricOperator& apply, Eigen::Index size,
                                           const LanczosOptions& options,
                                           const Eigen::MatrixXd& deflated = {});

}  // namespace tremula
