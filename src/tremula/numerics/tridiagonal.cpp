#include "tremula/numerics/tridiagonal.hpp"

#include "tremula/base/simd.hpp"
#include "tremula/base/types.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include <Eigen/Eigenvalues>

namespace tremula {
namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();
constexpr int points = 8;

// How many eigenvalues lie at or above each of eight numbers: the pivots of T - x that are not negative.
TREMULA_CLONES void count_above(const double* diagonal, const double* off_diagonal, Eigen::Index n,
                                const double* x, double smallest_pivot, double* counts) {
  double pivot[points], count[points];
  for (int i = 0; i < points; ++i) {
    pivot[i] = diagonal[0] - x[i];
    count[i] = pivot[i] < 0 ? 0 : 1;
  }
  for (Eigen::Index row = 1; row < n; ++row) {
    const double square = off_diagonal[row - 1] * off_diagonal[row - 1];
    for (int i = 0; i < points; ++i) {
      const double safe = std::abs(pivot[i]) < smallest_pivot ? smallest_pivot : pivot[i];
      pivot[i] = (diagonal[row] - x[i]) - square / safe;
      count[i] += pivot[i] < 0 ? 0 : 1;
    }
  }
  for (int i = 0; i < points; ++i) counts[i] = count[i];
}

double norm_bound(const Tridiagonal& matrix) {
  double bound = 0;
  const Eigen::Index n = matrix.size();
  for (Eigen::Index i = 0; i < n; ++i) {
    const double left = i > 0 ? std::abs(matrix.off_diagonal[index_of(i - 1)]) : 0;
    const double right = i + 1 < n ? std::abs(matrix.off_diagonal[index_of(i)]) : 0;
    bound = std::max(bound, std::abs(matrix.diagonal[index_of(i)]) + left + right);
  }
  return bound;
}

// LU with row exchanges of T - shift; solves in place.
class ShiftedSolver {
 public:
  ShiftedSolver(const Tridiagonal& matrix, double shift, double smallest_pivot)
      : pivot_(matrix.size()),
        above_(matrix.size()),
        second_above_(matrix.size()),
        factor_(matrix.size()),
        exchanged_(index_of(matrix.size())) {
    const Eigen::Index n = matrix.size();
    double diagonal = matrix.diagonal[0] - shift, above = n > 1 ? matrix.off_diagonal[0] : 0;
    for (Eigen::Index i = 0; i + 1 < n; ++i) {
      const double below = matrix.off_diagonal[index_of(i)];
      const double next = matrix.diagonal[index_of(i + 1)] - shift;
      const double next_above = i + 2 < n ? matrix.off_diagonal[index_of(i + 1)] : 0;
      exchanged_[index_of(i)] = std::abs(below) > std::abs(diagonal);
      if (exchanged_[index_of(i)]) {
        pivot_[i] = below, above_[i] = next, second_above_[i] = next_above;
        factor_[i] = diagonal / below;
        diagonal = above - factor_[i] * next;
        above = -factor_[i] * next_above;
      } else {
        pivot_[i] = std::abs(diagonal) < smallest_pivot ? smallest_pivot : diagonal;
        above_[i] = above, second_above_[i] = 0;
        factor_[i] = below / pivot_[i];
        diagonal = next - factor_[i] * above;
        above = next_above;
      }
    }
    pivot_[n - 1] = std::abs(diagonal) < smallest_pivot ? smallest_pivot : diagonal;
    inverse_pivot_ = pivot_.cwiseInverse();
  }

  void solve(Eigen::Ref<Eigen::VectorXd> x) const {
    const Eigen::Index n = x.size();
    for (Eigen::Index i = 0; i + 1 < n; ++i) {
      if (exchanged_[index_of(i)]) std::swap(x[i], x[i + 1]);
      x[i + 1] -= factor_[i] * x[i];
    }
    for (Eigen::Index i = n - 1; i >= 0; --i) {
      double value = x[i];
      if (i + 1 < n) value -= above_[i] * x[i + 1];
      if (i + 2 < n) value -= second_above_[i] * x[i + 2];
      x[i] = value * inverse_pivot_[i];
    }
  }

 private:
  Eigen::VectorXd pivot_, above_, second_above_, factor_, inverse_pivot_{};
  std::vector<char> exchanged_;
};

}  // namespace

double kth_largest_eigenvalue(const Tridiagonal& matrix, Eigen::Index k, double floor) {
  const double bound = norm_bound(matrix);
  double low = std::max(floor, -bound) - 4 * epsilon * bound, high = bound * (1 + 4 * epsilon);
  const double smallest_pivot = std::max(epsilon * epsilon * bound, std::numeric_limits<double>::min());
  std::array<double, points> x{}, counts{};
  while (high - low > 4 * epsilon * (std::abs(low) + std::abs(high)) + smallest_pivot) {
    for (int i = 0; i < points; ++i) x[index_of(i)] = low + (high - low) * (i + 1) / (points + 1);
    count_above(matrix.diagonal.data(), matrix.off_diagonal.data(), matrix.size(), x.data(), smallest_pivot,
                counts.data());
    double next_low = low, next_high = high;
    for (std::size_t i = 0; i < points; ++i) {
      if (counts[i] > static_cast<double>(k)) next_low = x[i];
    }
    for (std::size_t i = points; i-- > 0;) {
      if (counts[i] <= static_cast<double>(k)) next_high = x[i];
    }
    if (next_low == low && next_high == high) break;
    low = next_low;
    high = next_high;
  }
  return 0.5 * (low + high);
}

double last_component(const Tridiagonal& matrix, double value) {
  const Eigen::Index n = matrix.size();
  const double smallest_pivot = epsilon * epsilon * std::max(norm_bound(matrix), 1e-290);
  const auto safe = [&](double pivot) { return std::abs(pivot) < smallest_pivot ? smallest_pivot : pivot; };
  const auto off = [&](Eigen::Index i) { return matrix.off_diagonal[index_of(i)]; };
  std::vector<double> from_top(index_of(n)), from_bottom(index_of(n));
  for (Eigen::Index i = 0; i < n; ++i) {
    from_top[index_of(i)] = matrix.diagonal[index_of(i)] - value;
    if (i > 0) from_top[index_of(i)] -= off(i - 1) * off(i - 1) / safe(from_top[index_of(i - 1)]);
  }
  for (Eigen::Index i = n - 1; i >= 0; --i) {
    from_bottom[index_of(i)] = matrix.diagonal[index_of(i)] - value;
    if (i + 1 < n) from_bottom[index_of(i)] -= off(i) * off(i) / safe(from_bottom[index_of(i + 1)]);
  }
  Eigen::Index twist = 0;
  double smallest = std::numeric_limits<double>::infinity();
  for (Eigen::Index i = 0; i < n; ++i) {
    const double gamma =
        std::abs(from_top[index_of(i)] + from_bottom[index_of(i)] - (matrix.diagonal[index_of(i)] - value));
    if (gamma < smallest) smallest = gamma, twist = i;
  }
  double square = 1, last = 1, component = 1;
  for (Eigen::Index i = twist; i > 0; --i) {
    component *= -off(i - 1) / safe(from_top[index_of(i - 1)]);
    square += component * component;
  }
  for (Eigen::Index i = twist + 1; i < n; ++i) {
    last *= -off(i - 1) / safe(from_bottom[index_of(i)]);
    square += last * last;
  }
  return std::abs(last) / std::sqrt(square);
}

TridiagonalEigenpairs largest_eigenpairs(const Tridiagonal& matrix, Eigen::Index count) {
  const Eigen::Index n = matrix.size();
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver;
  solver.computeFromTridiagonal(Eigen::VectorXd::Map(matrix.diagonal.data(), n),
                                Eigen::VectorXd::Map(matrix.off_diagonal.data(), n - 1),
                                Eigen::EigenvaluesOnly);
  TridiagonalEigenpairs pairs{solver.eigenvalues().reverse().head(count), Eigen::MatrixXd(n, count)};

  const double norm = norm_bound(matrix), smallest_pivot = epsilon * std::max(norm, 1e-290);
  double shift = 0;
  for (Eigen::Index k = 0; k < count; ++k) {
    // Equal shifts would give equal vectors.
    const double separation = 10 * epsilon * std::abs(pairs.values[k]);
    shift = k > 0 ? std::min(pairs.values[k], shift - separation) : pairs.values[k];
    Eigen::Index first = k;  // of the cluster: vectors that inverse iteration cannot tell apart
    while (first > 0 && pairs.values[first - 1] - pairs.values[k] < 1e-3 * norm) --first;
    const ShiftedSolver solve(matrix, shift, smallest_pivot);
    auto vector = pairs.vectors.col(k);
    // Any start that is not orthogonal to the eigenvector; another one for each member of a cluster.
    std::uint32_t noise = static_cast<std::uint32_t>(k + 1);
    for (Eigen::Index i = 0; i < n; ++i) {
      noise = noise * 1664525U + 1013904223U;
      vector[i] = 0.5 + static_cast<double>(noise) * 0x1p-32;
    }
    for (int iteration = 0; iteration < 2; ++iteration) {
      vector /= vector.cwiseAbs().maxCoeff();
      solve.solve(vector);
      if (first < k) {
        const auto cluster = pairs.vectors.middleCols(first, k - first);
        vector /= vector.norm();
        vector -= cluster * (cluster.transpose() * vector).eval();
        vector -= cluster * (cluster.transpose() * vector).eval();
      }
      vector /= vector.norm();
    }
  }
  return pairs;
}

}  // namespace tremula
