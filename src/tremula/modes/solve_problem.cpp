#include "tremula/modes/solve_problem.hpp"

#include "tremula/base/error.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

#include <Eigen/Eigenvalues>

namespace tremula {
namespace {

using Clock = std::chrono::steady_clock;

// omega^-2, largest first, and the unit vectors of the symmetric problem that belong to them.
struct Eigenpairs {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
  int operator_count;
};

Eigenpairs solve_dense(const EigenProblem& problem) {
  const Eigen::Index size = problem.size;
  Eigen::MatrixXd form(size, size);
  for (Eigen::Index i = 0; i < size; ++i) {
    problem.apply(Eigen::VectorXd::Unit(size, i), form.col(i));
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(0.5 * (form + form.transpose()));
  if (solver.info() != Eigen::Success) throw Error("modes: the dense eigenvalue solver did not converge");
  return {solver.eigenvalues().reverse(), solver.eigenvectors().rowwise().reverse(), static_cast<int>(size)};
}

// A looser tolerance would leave the eigenvalues too uncertain to be counted.
double effective_tolerance(const ModeOptions& options) { return std::min(options.tolerance, 1e-6); }

Eigenpairs search(const EigenProblem& problem, int count, std::uint64_t attempt, const ModeOptions& options,
                  const Eigen::MatrixXd& found) {
  LanczosResult result = largest_eigenpairs(problem.apply, problem.size,
                                            {.count = count,
                                             .tolerance = effective_tolerance(options),
                                             .memory_limit = options.memory_limit,
                                             .start = attempt,
                                             .progress = options.progress},
                                            found);
  if (!result.converged) {
    throw Error("modes: the search for " + std::to_string(count) + " modes did not converge in " +
                std::to_string(result.operator_count) + " steps; ask for fewer modes or a larger tolerance");
  }
  return {std::move(result.values), std::move(result.vectors), result.operator_count};
}

void merge(Eigenpairs& pairs, const Eigenpairs& more) {
  const Eigen::Index old_count = pairs.values.size(), count = old_count + more.values.size();
  const auto value = [&](Eigen::Index i) {
    return i < old_count ? pairs.values[i] : more.values[i - old_count];
  };
  std::vector<Eigen::Index> order(static_cast<std::size_t>(count));
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](Eigen::Index a, Eigen::Index b) { return value(a) > value(b); });
  Eigenpairs merged{Eigen::VectorXd(count), Eigen::MatrixXd(pairs.vectors.rows(), count),
                    pairs.operator_count + more.operator_count};
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Index from = order[static_cast<std::size_t>(i)];
    merged.values[i] = value(from);
    if (from < old_count) {
      merged.vectors.col(i) = pairs.vectors.col(from);
    } else {
      merged.vectors.col(i) = more.vectors.col(from - old_count);
    }
  }
  pairs = std::move(merged);
}

// Just above the frequency of the given eigenvalue: far enough for its own error, near enough for its
// neighbours.
double omega_just_above(double value, const ModeOptions& options) {
  return (1 + std::max(1e-8, 10 * effective_tolerance(options))) / std::sqrt(value);
}

int count_found_below(const Eigenpairs& pairs, double omega) {
  return static_cast<int>((pairs.values.array() > 1 / (omega * omega)).count());
}

struct Counts {
  int found, by_inertia;
};

Counts complete(const EigenProblem& problem, int count, const ModeOptions& options, Eigenpairs& pairs) {
  for (std::uint64_t attempt = 1; attempt <= 20; ++attempt) {
    const double omega = omega_just_above(pairs.values[count - 1], options);
    const Counts counts{count_found_below(pairs, omega), problem.count_below(omega)};
    if (counts.by_inertia <= counts.found) return counts;
    merge(pairs, search(problem, counts.by_inertia - counts.found, attempt, options, pairs.vectors));
  }
  throw Error("modes: some of the " + std::to_string(count) +
              " lowest modes could not be found; ask for more or fewer modes");
}

Modes as_modes(const EigenProblem& problem, Eigenpairs& pairs, int count) {
  Modes modes;
  modes.operator_count = pairs.operator_count;
  modes.frequency.resize(count);
  modes.residual.resize(count);
  modes.error_bound.resize(count);
  modes.shapes.resize(problem.degrees_of_freedom, count);
  Eigen::VectorXd image(problem.size);
  for (int r = 0; r < count; ++r) {
    const auto s = pairs.vectors.col(r);
    // Rayleigh's quotient: its error is of the order of the residual's square.
    const double value = problem.apply(s, image) / s.squaredNorm();
    if (!(value > 0)) throw Error("modes: a mode is too stiff to be resolved; ask for fewer modes");
    const double omega = 1 / std::sqrt(value);
    modes.frequency[r] = omega / (2 * std::numbers::pi);
    modes.residual[r] = (image - value * s).norm() / (value * s.norm());
    // |lambda error| <= residual for a symmetric operator; half of it for the square root.
    modes.error_bound[r] = 0.5 * modes.residual[r];
    Eigen::VectorXd shape = omega / s.norm() * problem.displacement(s);
    Eigen::Index largest = 0;
    shape.cwiseAbs().maxCoeff(&largest);
    modes.shapes.col(r) = shape[largest] < 0 ? Eigen::VectorXd(-shape) : shape;
  }
  return modes;
}

std::size_t bytes_of(Eigen::Index rows, Eigen::Index columns) {
  return static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns) * sizeof(double);
}

// The shapes, and the vectors they are made from.
void check_memory(const EigenProblem& problem, int count, const ModeOptions& options) {
  const std::size_t least =
      std::max(bytes_of(problem.size, 2 * count), lanczos_memory(problem.size, count).least);
  if (options.memory_limit < least) {
    throw InputError("memory limit",
                     std::to_string(options.memory_limit / 1000000) + " MB for " + std::to_string(count) +
                         " modes of " + std::to_string(problem.degrees_of_freedom) + " degrees of freedom",
                     "at least " + std::to_string(least / 1000000 + 1) + " MB, or fewer modes");
  }
}

}  // namespace

int mode_count(const ModeOptions& options, Eigen::Index degrees_of_freedom, const std::string& explanation) {
  const auto size = static_cast<int>(degrees_of_freedom);
  const int count = options.count == all_modes ? size : options.count;
  if (count < 1 || count > size) {
    throw InputError("mode count", std::to_string(count),
                     "1 to " + std::to_string(size) + " (" + explanation + ")");
  }
  return count;
}

bool dense_is_better(const ModeOptions& options, Eigen::Index degrees_of_freedom, int count) {
  return options.method == ModeMethod::dense ||
         (options.method == ModeMethod::automatic && 2 * count >= degrees_of_freedom);
}

Modes solve_problem(const EigenProblem& problem, int count, bool dense, const ModeOptions& options) {
  if (!dense) check_memory(problem, count, options);
  Eigenpairs pairs = dense ? solve_dense(problem) : search(problem, count, 0, options, {});
  const auto begun = Clock::now();
  Counts counts{};
  if (dense) {
    const double omega = omega_just_above(pairs.values[count - 1], options);
    counts = {count_found_below(pairs, omega), problem.count_below(omega)};
  } else {
    counts = complete(problem, count, options, pairs);
  }
  const double check_seconds = std::chrono::duration<double>(Clock::now() - begun).count();
  Modes modes = as_modes(problem, pairs, count);
  modes.count_below = counts.found;
  modes.count_by_inertia = counts.by_inertia;
  modes.check_seconds = check_seconds;
  return modes;
}

}  // namespace tremula
