#include "tremula/numerics/lanczos.hpp"

#include <tbb/parallel_for.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "tremula/numerics/random.hpp"

namespace tremula {
namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();

using Vector = Eigen::VectorXd;
using Columns = Eigen::Ref<const Eigen::MatrixXd>;

// Rows are worked on in tiles of one size, and tiles are added up in order: the sums are the same on any
// number of threads, and a tile of the vector stays in the first-level cache while the basis streams by.
constexpr Eigen::Index tile_rows = 1024;
constexpr Eigen::Index parallel_rows = 60000;  // below, one thread is faster

Eigen::Index tile_count(Eigen::Index rows) { return (rows + tile_rows - 1) / tile_rows; }

template <class Work>
void for_each_tile(Eigen::Index rows, const Work& work) {
  const auto tile = [&](Eigen::Index t) {
    const Eigen::Index first = t * tile_rows;
    work(t, first, std::min(tile_rows, rows - first));
  };
  if (rows < parallel_rows) {
    for (Eigen::Index t = 0; t < tile_count(rows); ++t) tile(t);
  } else {
    tbb::parallel_for(Eigen::Index{0}, tile_count(rows), tile);
  }
}

// x -= Q Q^T x for a few vectors at a time. In a tile, four columns of the basis are read once for all of
// them; Eigen's general product would spend more on packing than such thin factors take.
void orthogonalise(const Columns& basis, Eigen::Ref<Eigen::MatrixXd> x) {
  if (basis.cols() == 0) return;
  const Eigen::Index grouped = basis.cols() / 4 * 4;
  std::vector<Eigen::MatrixXd> partial(static_cast<std::size_t>(tile_count(basis.rows())));
  for_each_tile(basis.rows(), [&](Eigen::Index t, Eigen::Index first, Eigen::Index rows) {
    Eigen::MatrixXd& products = partial[static_cast<std::size_t>(t)];
    products.resize(basis.cols(), x.cols());
    for (Eigen::Index c = 0; c < basis.cols(); ++c) {
      for (Eigen::Index v = 0; v < x.cols(); ++v) {
        products(c, v) = basis.col(c).segment(first, rows).dot(x.col(v).segment(first, rows));
      }
    }
  });
  Eigen::MatrixXd coefficients = Eigen::MatrixXd::Zero(basis.cols(), x.cols());
  for (const Eigen::MatrixXd& part : partial) coefficients += part;
  for_each_tile(basis.rows(), [&](Eigen::Index, Eigen::Index first, Eigen::Index rows) {
    const auto column = [&](Eigen::Index c) { return basis.col(c).segment(first, rows); };
    for (Eigen::Index c = 0; c < grouped; c += 4) {
      for (Eigen::Index v = 0; v < x.cols(); ++v) {
        x.col(v).segment(first, rows) -=
            (coefficients(c, v) * column(c) + coefficients(c + 1, v) * column(c + 1)) +
            (coefficients(c + 2, v) * column(c + 2) + coefficients(c + 3, v) * column(c + 3));
      }
    }
    for (Eigen::Index c = grouped; c < basis.cols(); ++c) {
      for (Eigen::Index v = 0; v < x.cols(); ++v)
        x.col(v).segment(first, rows) -= coefficients(c, v) * column(c);
    }
  });
}

Eigen::MatrixXd combine(const Columns& basis, const Eigen::MatrixXd& coefficients) {
  Eigen::MatrixXd result(basis.rows(), coefficients.cols());
  for_each_tile(basis.rows(), [&](Eigen::Index, Eigen::Index first, Eigen::Index rows) {
    result.middleRows(first, rows).noalias() = basis.middleRows(first, rows) * coefficients;
  });
  return result;
}

Vector random_vector(Eigen::Index size, std::uint64_t start) {
  Vector vector(size);
  for (Eigen::Index i = 0; i < size; ++i) {
    vector[i] = uniform({start, RandomStream::lanczos_start, 0, static_cast<std::uint64_t>(i)}) - 0.5;
  }
  return vector;
}

// Eigenvalues of a symmetric tridiagonal matrix, ascending, and the last component of each eigenvector: all
// that the residuals of Ritz values need. Implicit QL as in EISPACK's tql2, but with one row of the vectors:
// O(j^2).
void tridiagonal_spectrum(Vector diagonal, Vector off_diagonal, Vector& values, Vector& last_components) {
  const Eigen::Index n = diagonal.size();
  Vector& d = diagonal;
  Vector e = Vector::Zero(n);
  e.head(n - 1) = off_diagonal.head(n - 1);
  Vector z = Vector::Zero(n);
  z[n - 1] = 1;
  for (Eigen::Index l = 0; l < n; ++l) {
    for (int iteration = 0; iteration < 60; ++iteration) {
      Eigen::Index m = l;
      while (m < n - 1 && std::abs(e[m]) > epsilon * (std::abs(d[m]) + std::abs(d[m + 1]))) ++m;
      if (m == l) break;
      double g = (d[l + 1] - d[l]) / (2 * e[l]);
      double r = std::hypot(g, 1.0);
      g = d[m] - d[l] + e[l] / (g + std::copysign(r, g));
      double s = 1, c = 1, p = 0;
      Eigen::Index i = m - 1;
      for (; i >= l; --i) {
        double f = s * e[i];
        const double b = c * e[i];
        r = std::hypot(f, g);
        e[i + 1] = r;
        if (r == 0) {
          d[i + 1] -= p;
          e[m] = 0;
          break;
        }
        s = f / r;
        c = g / r;
        g = d[i + 1] - p;
        r = (d[i] - g) * s + 2 * c * b;
        p = s * r;
        d[i + 1] = g + p;
        g = c * r - b;
        f = z[i + 1];
        z[i + 1] = s * z[i] + c * f;
        z[i] = c * z[i] - s * f;
      }
      if (r == 0 && i >= l) continue;
      d[l] -= p;
      e[l] = g;
      e[m] = 0;
    }
  }
  std::vector<Eigen::Index> order(static_cast<std::size_t>(n));
  for (Eigen::Index i = 0; i < n; ++i) order[static_cast<std::size_t>(i)] = i;
  std::sort(order.begin(), order.end(), [&](Eigen::Index a, Eigen::Index b) { return d[a] < d[b]; });
  values.resize(n);
  last_components.resize(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    values[i] = d[order[static_cast<std::size_t>(i)]];
    last_components[i] = z[order[static_cast<std::size_t>(i)]];
  }
}

// Simon's recurrence: an estimate of q_k^T q_{j+1} for every k, from the coefficients of the tridiagonal
// matrix.
class OrthogonalityEstimate {
 public:
  explicit OrthogonalityEstimate(Eigen::Index size)
      : level_(epsilon * std::sqrt(static_cast<double>(size))) {}

  // After step j (from 0) with alpha_0 … alpha_j and beta_0 … beta_j, beta_j the norm of what becomes
  // q_{j+1}. Returns the largest |q_k^T q_{j+1}|.
  double advance(const std::vector<double>& alpha, const std::vector<double>& beta) {
    const std::size_t j = alpha.size() - 1;
    std::vector<double> next(j + 2);
    double largest = 0;
    for (std::size_t k = 0; k < j; ++k) {
      double sum = beta[k] * current_[k + 1] + (alpha[k] - alpha[j]) * current_[k];
      if (k > 0) sum += beta[k - 1] * current_[k - 1];
      if (j > 0) sum -= beta[j - 1] * previous_[k];
      next[k] = (sum + std::copysign(epsilon * (beta[k] + beta[j]) * 0.5, sum)) / beta[j];
      largest = std::max(largest, std::abs(next[k]));
    }
    next[j] = level_;
    next[j + 1] = 1;
    previous_ = std::move(current_);
    previous_.push_back(0);
    current_ = std::move(next);
    return largest;
  }
  // q_j and q_{j+1} have been made orthogonal to all before them.
  void reset() {
    std::fill(current_.begin(), current_.end() - 1, level_);
    std::fill(previous_.begin(), previous_.end() - 2, level_);
  }

 private:
  double level_;
  std::vector<double> previous_{}, current_{1.0};
};

}  // namespace

LanczosResult largest_eigenpairs(const SymmetricOperator& apply, Eigen::Index size,
                                 const LanczosOptions& options, const Eigen::MatrixXd& deflated) {
  const Eigen::Index room = size - deflated.cols();
  const Eigen::Index wanted = std::min<Eigen::Index>(options.count, room);
  const Eigen::Index limit =
      std::min<Eigen::Index>(room, std::max<Eigen::Index>(options.largest_basis, wanted + 2));
  // Eigenvalues are good to all digits below sqrt(epsilon); vectors are as good as the basis is orthogonal.
  const double threshold = std::clamp(10 * options.tolerance, 1e-11, std::sqrt(epsilon));

  LanczosResult result;
  if (wanted <= 0) {
    result.converged = true;
    result.vectors.resize(size, 0);
    return result;
  }
  Eigen::MatrixXd basis(size, std::min<Eigen::Index>(limit, 3 * wanted + 40) + 1);
  std::vector<double> alpha, beta;
  Vector values, last, work(size);
  Eigen::Index steps = 0, converged = 0;

  Vector start = random_vector(size, options.start);
  if (deflated.cols() > 0) orthogonalise(deflated, start);
  basis.col(0) = start.normalized();
  OrthogonalityEstimate estimate(size);
  Eigen::MatrixXd pair(size, 2);
  for (Eigen::Index next_check = wanted + wanted / 2 + 8; steps < limit;) {
    const Eigen::Index j = steps++;
    if (basis.cols() < j + 2)
      basis.conservativeResize(Eigen::NoChange, std::min(limit, basis.cols() * 3 / 2) + 1);
    apply(basis.col(j), work);
    ++result.operator_count;
    if (deflated.cols() > 0) orthogonalise(deflated, work);
    if (j > 0) work -= beta.back() * basis.col(j - 1);
    alpha.push_back(work.dot(basis.col(j)));
    work -= alpha.back() * basis.col(j);
    // Again against the last two, whose products are the largest.
    const double correction = work.dot(basis.col(j));
    alpha.back() += correction;
    work -= correction * basis.col(j);
    if (j > 0) work -= work.dot(basis.col(j - 1)) * basis.col(j - 1);
    double norm = work.norm();
    beta.push_back(norm);

    const bool exhausted = norm <= epsilon * std::abs(alpha.front()) * std::sqrt(static_cast<double>(size));
    if (!exhausted && estimate.advance(alpha, beta) > threshold) {
      // The recurrence looks two steps back, so q_j and what becomes q_{j+1} are both mended; together, so
      // that the basis is read once for both.
      pair.col(0) = basis.col(j);
      pair.col(1) = work;
      orthogonalise(basis.leftCols(j), pair);
      basis.col(j) = pair.col(0).normalized();
      work = pair.col(1) - pair.col(1).dot(basis.col(j)) * basis.col(j);
      norm = work.norm();
      beta.back() = norm;
      estimate.reset();
      ++result.reorthogonalisation_count;
    }
    const bool full = exhausted || steps == limit;
    if (!full) basis.col(j + 1) = work / norm;

    if (steps < next_check && !full) continue;
    tridiagonal_spectrum(Vector::Map(alpha.data(), steps), Vector::Map(beta.data(), steps), values, last);
    converged = 0;
    while (converged < std::min(wanted, steps) &&
           (exhausted || norm * std::abs(last[steps - 1 - converged]) <=
                             options.tolerance * values[steps - 1 - converged])) {
      ++converged;
    }
    if (options.progress) options.progress(static_cast<double>(converged) / static_cast<double>(wanted));
    if (converged == wanted || full) break;
    next_check = steps + std::max<Eigen::Index>(4, (wanted - converged) / 3);
  }

  const Eigen::Index kept = std::min(converged, steps);
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> tridiagonal;
  tridiagonal.computeFromTridiagonal(Vector::Map(alpha.data(), steps), Vector::Map(beta.data(), steps - 1));
  result.converged = converged == wanted;
  result.values = tridiagonal.eigenvalues().reverse().head(kept);
  result.vectors =
      combine(basis.leftCols(steps), tridiagonal.eigenvectors().rowwise().reverse().leftCols(kept));
  result.residual =
      beta.back() * tridiagonal.eigenvectors().row(steps - 1).reverse().head(kept).cwiseAbs().transpose();
  if (kept < steps) result.next_value = tridiagonal.eigenvalues()[steps - 1 - kept];
  return result;
}

}  // namespace tremula
