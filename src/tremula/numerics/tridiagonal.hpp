// Eigenpairs of symmetric tridiagonal matrices: what a Lanczos iteration asks for, again and again, while it
// runs.
#pragma once

#include <Eigen/Core>
#include <span>

namespace tremula {

// diagonal (n), off_diagonal (at least n - 1; entry i joins i and i + 1).
struct Tridiagonal {
  std::span<const double> diagonal, off_diagonal;
  Eigen::Index size() const { return static_cast<Eigen::Index>(diagonal.size()); }
};

// The k-th largest eigenvalue, k = 0 … n-1, by Sturm counts at eight points at a time: O(n), where all
// eigenvalues would be O(n^2). `floor`: a number that it is known not to lie below, or -infinity.
double kth_largest_eigenvalue(const Tridiagonal& matrix, Eigen::Index k, double floor);

// The size of the last component of the unit eigenvector that belongs to the eigenvalue `value`: times the
// last beta, it is the residual of a Ritz vector. By a twisted factorisation (Parlett & Dhillon 1997, Linear
// Algebra Appl. 267), which keeps the digits of components however small; O(n).
double last_component(const Tridiagonal& matrix, double value);

struct TridiagonalEigenpairs {
  Eigen::VectorXd values;   // (count) descending
  Eigen::MatrixXd vectors;  // (n x count), orthonormal also inside clusters
};
// The `count` largest, by implicit QL for the values and inverse iteration for the vectors; O(n^2 + n
// count^2).
TridiagonalEigenpairs largest_eigenpairs(const Tridiagonal& matrix, Eigen::Index count);

}  // namespace tremula
