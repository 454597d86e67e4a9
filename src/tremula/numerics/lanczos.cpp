#include "tremula/numerics/lanczos.hpp"

#include "tremula/base/error.hpp"
#include "tremula/numerics/columns.hpp"
#include "tremula/numerics/random.hpp"
#include "tremula/numerics/tridiagonal.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <Eigen/Eigenvalues>

namespace tremula {
namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();

// Simon's recurrence: an estimate of q_k^T q_{j+1} for every k, from the coefficients of the tridiagonal
// matrix.
class OrthogonalityEstimate {
 public:
  explicit OrthogonalityEstimate(Eigen::Index size)
      : level_(epsilon * std::sqrt(static_cast<double>(size))) {}

  // After step j (from 0) with alpha_0 … alpha_j and beta_0 … beta_j, beta_j the norm of what becomes
  // q_{j+1}. Returns what is likely the largest |q_k^T q_{j+1}|.
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
    current_largest_ = largest;
    return largest / calibration_;
  }
  // q_j and q_{j+1} have been made orthogonal to all before them. `found`: the largest |q_k^T q_{j+1}| that
  // there was before. The recurrence supposes that rounding errors add up; that they do not makes it a
  // thousand times too large. So what it says is set right by what was found, less a factor of ten.
  void reset(double found) {
    const double excess = current_largest_ / std::max(found, epsilon);
    calibration_ = std::clamp(0.1 * excess, 1.0, 30 * calibration_);
    std::fill(current_.begin(), current_.end() - 1, level_);
    std::fill(previous_.begin(), previous_.end() - 2, level_);
  }
  // q_{j+1} is a new vector, made orthogonal to the `count` before it.
  void restart(std::size_t count) {
    previous_.assign(count + 1, level_);
    current_.assign(count + 1, level_);
    current_.back() = 1;
  }

 private:
  double level_, calibration_ = 1, current_largest_ = 0;
  std::vector<double> previous_{}, current_{1.0};
};

// A search that takes more steps than this has gone wrong.
Eigen::Index most_steps(Eigen::Index wanted) { return 2000 + 10 * wanted; }

// What a search works on: the operator, what it must stay orthogonal to, and what it is to find.
struct Search {
  const SymmetricOperator& apply;
  Eigen::Index size;
  const LanczosOptions& options;
  const Columns& deflated;
  Eigen::Index wanted;
  Eigen::Index most_columns;  // that memory allows

  // The residual at which an eigenpair is done; rounding leaves one of the size of the largest eigenvalue's.
  double enough(double value, double largest) const {
    return std::max(options.tolerance * value, epsilon * largest);
  }
  double norm_that_is_zero(double largest) const {
    return epsilon * std::abs(largest) * std::sqrt(static_cast<double>(size));
  }
};

// The basis V and the projection V^T A V, a tridiagonal matrix, after as many steps as there are alphas. The
// basis has one column more: where the next step goes.
struct Krylov {
  Columns basis;
  std::vector<double> alpha{}, beta{};  // beta[j] joins j and j + 1
  LanczosResult result{};

  Eigen::Index steps() const { return static_cast<Eigen::Index>(alpha.size()); }
  Tridiagonal tridiagonal() const { return {alpha, beta}; }
};

// A random column at the end of the basis, orthogonal to all before it. False where there is no room left.
bool append_random(const Search& search, std::uint32_t address, Krylov& krylov) {
  const Eigen::Index j = krylov.basis.count();
  krylov.basis.append();
  auto column = krylov.basis.column(j);
  for (Eigen::Index i = 0; i < search.size; ++i) {
    column[i] =
        uniform({search.options.start, RandomStream::lanczos_start, address, static_cast<std::uint64_t>(i)}) -
        0.5;
  }
  const double before = column.norm();
  for (int pass = 0; pass < 2; ++pass) {
    remove_projection(search.deflated, search.deflated.count(), column.data(), nullptr);
    remove_projection(krylov.basis, j, column.data(), nullptr);
  }
  const double norm = column.norm();
  krylov.basis.scale.back() = 1 / norm;
  return norm > 1e-12 * before;
}

// Column j + 1 = A q_j - beta_{j-1} q_{j-1} - alpha_j q_j. Returns its norm.
double expand(const Search& search, Krylov& krylov) {
  const Eigen::Index j = krylov.steps();
  Columns& basis = krylov.basis;
  basis.append();
  auto next = basis.column(j + 1);
  const double scale = basis.scale[static_cast<std::size_t>(j)];
  double product = search.apply(basis.column(j), next);
  ++krylov.result.operator_count;
  if (search.deflated.count() > 0) {
    remove_projection(search.deflated, search.deflated.count(), next.data(), nullptr);
    product = dot(basis.data(j), next.data(), search.size);
  }
  const double alpha = scale * scale * product;
  krylov.alpha.push_back(alpha);
  const double before = j > 0 ? krylov.beta.back() * basis.scale[static_cast<std::size_t>(j - 1)] : 0.0;
  return std::sqrt(three_term_step(next.data(), basis.data(j), j > 0 ? basis.data(j - 1) : nullptr,
                                   search.size, scale, alpha * scale, before));
}

// The recurrence looks two steps back, so q_j and what becomes q_{j+1} are both mended; together, so that the
// basis is read once for both. Returns the norm of column j + 1.
double mend(const Search& search, Krylov& krylov, OrthogonalityEstimate& estimate) {
  const Eigen::Index j = krylov.steps() - 1;
  Columns& basis = krylov.basis;
  estimate.reset(remove_projection(basis, j, basis.data(j), basis.data(j + 1)) / krylov.beta.back());
  ++krylov.result.reorthogonalisation_count;
  const double square = dot(basis.data(j), basis.data(j), search.size);
  basis.scale[static_cast<std::size_t>(j)] = 1 / std::sqrt(square);
  const double share = dot(basis.data(j), basis.data(j + 1), search.size) / square;
  return std::sqrt(three_term_step(basis.data(j + 1), basis.data(j), nullptr, search.size, 1, share, 0));
}

// When to look at the Ritz values again: where the residual of the last one wanted, that falls by a steady
// factor a step, will reach the tolerance.
class ConvergenceForecast {
 public:
  explicit ConvergenceForecast(Eigen::Index first_look) : next_(first_look) {}
  Eigen::Index next() const { return next_; }
  void look(Eigen::Index step, double residual, double tolerance) {
    const double height = std::log(std::max(residual, 1e-300) / tolerance);
    double wait = 0.08 * static_cast<double>(step);
    if (last_step_ > 0 && height < last_height_) {
      wait = 0.9 * height * static_cast<double>(step - last_step_) / (last_height_ - height);
    }
    last_step_ = step;
    last_height_ = height;
    const double longest = 0.15 * static_cast<double>(step);
    next_ = step + std::max<Eigen::Index>(1, std::lround(std::min(wait, longest)));
  }

 private:
  Eigen::Index next_, last_step_ = 0;
  double last_height_ = 0;
};

// Takes the eigenvectors of the projection (steps x k, of its largest eigenvalues) as the result, if all that
// are wanted have converged.
bool accept(const Search& search, Krylov& krylov, const Eigen::VectorXd& values,
            const Eigen::MatrixXd& vectors, double last_beta) {
  const Eigen::VectorXd residual =
      std::abs(last_beta) * vectors.row(vectors.rows() - 1).cwiseAbs().transpose();
  const Eigen::Index wanted = search.wanted;
  for (Eigen::Index r = 0; r < wanted; ++r) {
    if (residual[r] > search.enough(values[r], values[0])) return false;
  }
  krylov.result.values = values.head(wanted);
  krylov.result.residual = residual.head(wanted);
  krylov.result.next_value = values.size() > wanted ? values[wanted] : 0;
  krylov.result.converged = true;
  rotate(krylov.basis, vectors.leftCols(wanted));
  return true;
}

void report(const Search& search, double residual, double value) {
  if (!search.options.progress) return;
  const double left = std::log(std::clamp(residual / value, search.options.tolerance, 1.0));
  search.options.progress(std::clamp(left / std::log(search.options.tolerance), 0.0, 1.0));
}

// Steps without restarts. True when converged.
bool iterate(const Search& search, Krylov& krylov) {
  // Eigenvalues are good to all digits below sqrt(epsilon); vectors are as good as the basis is orthogonal.
  const double threshold = std::clamp(0.5 * search.options.tolerance, 1e-11, std::sqrt(epsilon));
  const Eigen::Index room = search.size - search.deflated.count();
  const Eigen::Index limit = std::min({room, search.most_columns - 1, most_steps(search.wanted)});
  OrthogonalityEstimate estimate(search.size);
  ConvergenceForecast forecast(search.wanted + search.wanted / 4 + 6);
  double floor = -std::numeric_limits<double>::infinity();
  double largest = 0;  // of the alphas: the size of the operator
  std::uint32_t random_address = 0;
  if (!append_random(search, random_address++, krylov)) return false;
  while (krylov.steps() < limit) {
    double norm = expand(search, krylov);
    krylov.beta.push_back(norm);
    largest = std::max(largest, krylov.alpha.back());
    const double zero = search.norm_that_is_zero(largest);
    bool full = krylov.steps() == limit;
    if (norm > zero && estimate.advance(krylov.alpha, krylov.beta) > threshold) {
      norm = mend(search, krylov, estimate);
      krylov.beta.back() = norm;
    }
    if (norm <= zero) {
      // An invariant subspace, as multiple eigenvalues make them: on from a new vector, not joined to it.
      krylov.beta.back() = norm = 0;
      krylov.basis.drop_from(krylov.steps());
      if (!full) full = !append_random(search, random_address++, krylov);
      estimate.restart(krylov.alpha.size());
    }
    if (norm > 0) krylov.basis.scale.back() = 1 / norm;
    if (krylov.steps() < search.wanted || (krylov.steps() < forecast.next() && !full)) continue;

    const double value = kth_largest_eigenvalue(krylov.tridiagonal(), search.wanted - 1, floor);
    const double residual = norm * last_component(krylov.tridiagonal(), value);
    floor = value;
    report(search, residual, value);
    const double enough = search.enough(value, largest);
    forecast.look(krylov.steps(), residual, enough);
    if (residual > enough && !full) continue;
    const TridiagonalEigenpairs pairs =
        largest_eigenpairs(krylov.tridiagonal(), std::min(search.wanted + 1, krylov.steps()));
    if (accept(search, krylov, pairs.values, pairs.vectors, norm)) return true;
    if (full) return false;
  }
  return false;
}

// Thick restarts (Wu & Simon 2000, SIAM J. Matrix Anal. 22), for when no more columns fit: the best Ritz
// vectors stay, joined to the next vector by a border of the projection; every vector is made orthogonal to
// all others, which a small basis affords.
bool iterate_with_restarts(const Search& search, Krylov& krylov) {
  const Eigen::Index most = krylov.steps();
  Columns& basis = krylov.basis;
  Eigen::MatrixXd projection = Eigen::MatrixXd::Zero(most, most);
  for (Eigen::Index j = 0; j < most; ++j) {
    projection(j, j) = krylov.alpha[static_cast<std::size_t>(j)];
    if (j + 1 < most) projection(j, j + 1) = projection(j + 1, j) = krylov.beta[static_cast<std::size_t>(j)];
  }
  double last_beta = krylov.beta.back();
  for (; krylov.result.restart_count < 1000; ++krylov.result.restart_count) {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(projection);
    const Eigen::VectorXd values = solver.eigenvalues().reverse();
    const Eigen::MatrixXd vectors = solver.eigenvectors().rowwise().reverse();
    if (accept(search, krylov, values, vectors, last_beta)) return true;
    report(search, last_beta * std::abs(vectors(most - 1, search.wanted - 1)), values[search.wanted - 1]);

    const Eigen::Index kept = search.wanted + (most - search.wanted) / 2;
    Eigen::MatrixXd coefficients = Eigen::MatrixXd::Zero(most + 1, kept + 1);
    coefficients.topLeftCorner(most, kept) = vectors.leftCols(kept);
    coefficients(most, kept) = 1;
    rotate(basis, coefficients);
    projection.setZero();
    for (Eigen::Index i = 0; i < kept; ++i) {
      projection(i, i) = values[i];
      projection(i, kept) = projection(kept, i) = last_beta * vectors(most - 1, i);
    }
    for (Eigen::Index j = kept; j < most; ++j) {
      basis.append();
      auto next = basis.column(j + 1);
      const double scale = basis.scale[static_cast<std::size_t>(j)];
      projection(j, j) = scale * scale * search.apply(basis.column(j), next);
      ++krylov.result.operator_count;
      next *= scale;
      for (int pass = 0; pass < 2; ++pass) {
        remove_projection(search.deflated, search.deflated.count(), next.data(), nullptr);
        remove_projection(basis, j + 1, next.data(), nullptr);
      }
      ++krylov.result.reorthogonalisation_count;
      last_beta = std::sqrt(dot(next.data(), next.data(), search.size));
      basis.scale.back() = last_beta > 0 ? 1 / last_beta : 0;
      if (j + 1 < most) projection(j, j + 1) = projection(j + 1, j) = last_beta;
    }
  }
  return false;
}

constexpr Eigen::Index fewest_columns(Eigen::Index wanted) { return wanted + 8 + wanted / 4; }

std::size_t column_bytes(Eigen::Index size, Eigen::Index columns) {
  return static_cast<std::size_t>(size) * static_cast<std::size_t>(columns) * sizeof(double);
}

}  // namespace

LanczosMemory lanczos_memory(Eigen::Index size, int count) {
  const Eigen::Index likely = std::min<Eigen::Index>(size, 4 * count + 40);
  return {column_bytes(size, std::max(likely, fewest_columns(count))),
          column_bytes(size, fewest_columns(count))};
}

LanczosResult largest_eigenpairs(const SymmetricOperator& apply, Eigen::Index size,
                                 const LanczosOptions& options, const Eigen::MatrixXd& deflated) {
  const std::size_t columns = options.memory_limit / column_bytes(size, 1);
  const Eigen::Index wanted = std::min<Eigen::Index>(options.count, size - deflated.cols());
  LanczosResult result;
  if (wanted <= 0) {
    result.converged = true;
    result.vectors.resize(size, 0);
    return result;
  }
  const Eigen::Index room = size - deflated.cols();
  const auto most_columns = static_cast<Eigen::Index>(std::min<std::size_t>(columns, 1U << 30U));
  if (most_columns < std::min(room, fewest_columns(wanted))) {
    throw InputError("memory limit",
                     std::to_string(options.memory_limit / 1000000) + " MB for the vectors of the search",
                     "at least " + std::to_string(lanczos_memory(size, options.count).least / 1000000 + 1) +
                         " MB, or fewer modes");
  }
  Columns known(size);
  for (Eigen::Index i = 0; i < deflated.cols(); ++i) {
    known.append();
    known.column(i) = deflated.col(i);
  }
  const Search search{apply, size, options, known, wanted, most_columns};
  Krylov krylov{.basis = Columns(size)};
  bool found = iterate(search, krylov);
  if (!found && krylov.steps() == most_columns - 1 && krylov.steps() < room) {
    found = iterate_with_restarts(search, krylov);
  }
  result = std::move(krylov.result);
  if (found) {
    result.vectors.resize(size, wanted);
    for (Eigen::Index i = 0; i < wanted; ++i) result.vectors.col(i) = krylov.basis.column(i);
  }
  return result;
}

}  // namespace tremula
