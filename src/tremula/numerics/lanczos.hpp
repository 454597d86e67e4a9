// The largest eigenvalues of a symmetric operator, by Lanczos with partial reorthogonalisation.
//
// What costs is not the operator but keeping the basis orthogonal: every reorthogonalisation reads the whole
// basis. Simon (1984, Math. Comp. 42) showed that eigenvalues keep all their digits as long as the basis is
// orthogonal to the square root of the machine precision, and how to estimate its loss by a recurrence on
// scalars. So the basis is read only when the estimate says so: every five to ten steps for structures.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <limits>

namespace tremula {

// out = A in, both of the given size, A symmetric; returns in . out, which the operator has at hand and the
// iteration needs.
using SymmetricOperator =
    std::function<double(Eigen::Ref<const Eigen::VectorXd> in, Eigen::Ref<Eigen::VectorXd> out)>;

struct LanczosOptions {
  int count = 1;             // how many of the largest eigenvalues
  double tolerance = 1e-12;  // |A x - lambda x| / lambda of every eigenpair wanted
  // For the vectors of the basis; where they do not fit, the iteration restarts from its best vectors
  // (thick restart), which takes more steps.
  std::size_t memory_limit = std::numeric_limits<std::size_t>::max();  // [bytes]
  std::uint64_t start = 0;  // address of the random starting vector; another one for another try
  std::function<void(double done)> progress = {};  // 0 … 1; throw to cancel
};

struct LanczosResult {
  Eigen::VectorXd values;    // (k) descending; k = count when converged, else 0
  Eigen::MatrixXd vectors;   // (n x k) orthonormal
  Eigen::VectorXd residual;  // (k) estimate of |A x - lambda x|
  double next_value = 0;     // estimate of the next eigenvalue below, or 0
  bool converged = false;
  int operator_count = 0, reorthogonalisation_count = 0, restart_count = 0;
};

// `deflated` (n x d): orthonormal eigenvectors already known; the search stays orthogonal to them. Throws
// InputError for a memory limit that does not hold the smallest basis.
LanczosResult largest_eigenpairs(const SymmetricOperator& apply, Eigen::Index size,
                                 const LanczosOptions& options, const Eigen::MatrixXd& deflated = {});

// Bytes of memory that the basis of a search without restarts is likely to take, and the fewest it can do
// with.
struct LanczosMemory {
  std::size_t likely, least;
};
LanczosMemory lanczos_memory(Eigen::Index size, int count);

}  // namespace tremula
