#include "tremula/modes/solve_problem.hpp"

#include "tremula/base/error.hpp"
#include "tremula/base/memory.hpp"
#include "tremula/numerics/block_lanczos.hpp"

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

// Holds two matrices of all modes at a time, the form and what becomes its vectors (dense_memory).
Eigenpairs solve_dense(const EigenProblem& problem, int count) {
  const Eigen::Index size = problem.size;
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver;
  {
    Eigen::MatrixXd form(size, size);
    for (Eigen::Index i = 0; i < size; ++i) problem.apply(Eigen::VectorXd::Unit(size, i), form.col(i));
    for (Eigen::Index i = 0; i < size; ++i) {  // the solver reads what is below the diagonal
      for (Eigen::Index j = i + 1; j < size; ++j) form(j, i) = 0.5 * (form(j, i) + form(i, j));
    }
    solver.compute(form);
  }
  if (solver.info() != Eigen::Success) throw Error("modes: the dense eigenvalue solver did not converge");
  // What is smaller than this is rounding, and may be below 0.
  const double least = 1e-32 * solver.eigenvalues()[size - 1];
  return {solver.eigenvalues().reverse().cwiseMax(least),
          solver.eigenvectors().rightCols(count).rowwise().reverse(), static_cast<int>(size)};
}

// A looser tolerance would leave the eigenvalues too uncertain to be counted.
double effective_tolerance(const ModeOptions& options) { return std::min(options.tolerance, 1e-6); }

// By one vector at a time: finds single eigenvalues with the fewest steps. Gives what it is sure of.
Eigenpairs search(const EigenProblem& problem, int count, const ModeOptions& options) {
  LanczosResult result = largest_eigenpairs(problem.apply, problem.size,
                                            {.count = count,
                                             .tolerance = effective_tolerance(options),
                                             .memory_limit = options.memory_limit,
                                             .start = 0,
                                             .progress = options.progress});
  // None at all has no rows either.
  if (result.values.size() == 0) result.vectors.resize(problem.size, 0);
  return {std::move(result.values), std::move(result.vectors), result.operator_count};
}

// By blocks, at right angles to what was found: finds what the first search passed by.
Eigenpairs search_more(const EigenProblem& problem, int count, std::uint64_t attempt,
                       const ModeOptions& options, const Eigen::MatrixXd& found) {
  LanczosResult result = largest_eigenpairs_in_blocks(problem.apply, problem.size,
                                                      {.count = count,
                                                       .tolerance = effective_tolerance(options),
                                                       .memory_limit = options.memory_limit,
                                                       .start = attempt,
                                                       .progress = options.progress},
                                                      found);
  if (!result.converged) {
    throw Error("modes: the search for " + std::to_string(count) + " more modes than " +
                std::to_string(found.cols()) + " did not converge in " +
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

Census census_of(const EigenProblem& problem, const Eigenpairs& pairs, int count,
                 const ModeOptions& options) {
  return take_census(problem.count_below, pairs.values, count, equal_within(options));
}

// Rayleigh-Ritz: a search at right angles to vectors that have errors takes these errors over, and they are
// large beside a small eigenvalue. In the space of all of them they go away again.
void settle(const EigenProblem& problem, Eigenpairs& pairs) {
  Eigen::MatrixXd image(pairs.vectors.rows(), pairs.vectors.cols());
  for (Eigen::Index r = 0; r < image.cols(); ++r) problem.apply(pairs.vectors.col(r), image.col(r));
  // Of two searches with few digits to spare, the vectors are not quite at right angles.
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(
      pairs.vectors.transpose() * image, pairs.vectors.transpose() * pairs.vectors);
  image.noalias() = pairs.vectors * solver.eigenvectors().rowwise().reverse();
  pairs.vectors.swap(image);
  pairs.values = solver.eigenvalues().reverse();
  pairs.operator_count += static_cast<int>(image.cols());
}

// Searches for what is missing until nothing is.
Census complete(const EigenProblem& problem, int count, const ModeOptions& options, Eigenpairs& pairs) {
  for (std::uint64_t attempt = 1; attempt <= 50; ++attempt) {
    Census census{.missing = count - static_cast<int>(pairs.values.size())};
    if (census.missing <= 0) census = census_of(problem, pairs, count, options);
    if (census.missing == 0) return census;
    merge(pairs, search_more(problem, census.missing, attempt, options, pairs.vectors));
    settle(problem, pairs);
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
  Eigen::VectorXd image(problem.size);
  for (int r = 0; r < count; ++r) {
    const auto s = pairs.vectors.col(r);
    // Rayleigh's quotient: its error is of the order of the residual's square.
    const double value = problem.apply(s, image) / s.squaredNorm();
    if (!(value > 0 && std::isfinite(value))) {
      throw Error("modes: a mode is too stiff to be resolved; ask for fewer modes");
    }
    const double omega = 1 / std::sqrt(value);
    modes.frequency[r] = omega / (2 * std::numbers::pi);
    modes.residual[r] = (image - value * s).norm() / (value * s.norm());
    // |lambda error| <= residual for a symmetric operator; half of it for the square root.
    modes.error_bound[r] = 0.5 * modes.residual[r];
    Eigen::VectorXd shape = omega / s.norm() * problem.displacement(s);
    Eigen::Index largest = 0;
    shape.cwiseAbs().maxCoeff(&largest);
    if (r == 0) modes.shapes.resize(shape.size(), count);
    modes.shapes.col(r) = shape[largest] < 0 ? Eigen::VectorXd(-shape) : shape;
  }
  return modes;
}

std::size_t bytes_of(Eigen::Index rows, Eigen::Index columns) {
  return static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns) * sizeof(double);
}

std::string megabytes(std::size_t bytes) { return std::to_string(bytes / 1000000 + 1) + " MB"; }

}  // namespace

int mode_count(const ModeOptions& options, Eigen::Index degrees_of_freedom, const std::string& explanation) {
  if (!(options.tolerance > 0)) {
    throw InputError("tolerance", std::to_string(options.tolerance), "a number above 0");
  }
  const auto size = static_cast<int>(degrees_of_freedom);
  const int count = options.count == all_modes ? size : options.count;
  if (count < 1 || count > size) {
    throw InputError("mode count", std::to_string(count),
                     "1 to " + std::to_string(size) + " (" + explanation + ")");
  }
  return count;
}

double equal_within(const ModeOptions& options) { return std::max(1e-8, 10 * effective_tolerance(options)); }

bool dense_is_better(const ModeOptions& options, Eigen::Index degrees_of_freedom, int count) {
  return options.method == ModeMethod::dense ||
         (options.method == ModeMethod::automatic && 2 * count >= degrees_of_freedom);
}

void keep_census(const Census& census, Modes& modes) {
  modes.count_below = census.found;
  modes.count_by_inertia = census.by_inertia;
  modes.equal_to_last = census.equal_to_last;
  modes.equal_left_out = census.equal_left_out;
}

ModeMemory mode_memory(Eigen::Index size, int count, bool dense) {
  const std::size_t vectors_and_shapes = bytes_of(size, 2 * count);
  if (dense) {
    const std::size_t two_matrices = std::max(bytes_of(size, 2 * size), vectors_and_shapes);
    return {two_matrices, two_matrices};
  }
  const LanczosMemory basis = lanczos_memory(size, count);
  return {std::max(vectors_and_shapes, basis.likely), std::max(vectors_and_shapes, basis.least)};
}

void check_memory(const ModeMemory& memory, int count, Eigen::Index degrees_of_freedom,
                  const ModeOptions& options) {
  const std::string what =
      std::to_string(count) + " modes of " + std::to_string(degrees_of_freedom) + " degrees of freedom";
  if (options.memory_limit < memory.least) {
    throw InputError("memory limit", std::to_string(options.memory_limit / 1000000) + " MB for " + what,
                     "at least " + megabytes(memory.least) + ", or fewer modes");
  }
  const std::size_t needed = std::min(options.memory_limit, memory.likely);
  if (needed < 100'000'000) return;  // to ask takes longer than small structures do
  const std::uint64_t available = available_memory();
  if (needed <= available) return;
  throw Error("modes: " + what + " take " + megabytes(needed) + " of memory, of which the machine has " +
              megabytes(available) + " left; ask for fewer modes" +
              (memory.least < available ? " or limit the memory to " + megabytes(memory.least) + " or more"
                                        : std::string()));
}

Modes solve_problem(const EigenProblem& problem, int count, bool dense, const ModeOptions& options) {
  check_memory(mode_memory(problem.size, count, dense), count, problem.degrees_of_freedom, options);
  Eigenpairs pairs = dense ? solve_dense(problem, count) : search(problem, count, options);
  const auto begun = Clock::now();
  const Census census =
      dense ? census_of(problem, pairs, count, options) : complete(problem, count, options, pairs);
  if (census.found > census.by_inertia) {
    throw InputError("modes",
                     std::to_string(census.found) + " found where " + std::to_string(census.by_inertia) +
                         " are counted: double precision does not hold them",
                     "sizes and stiffnesses that lie closer together, or the dense method");
  }
  const double check_seconds = std::chrono::duration<double>(Clock::now() - begun).count();
  Modes modes = as_modes(problem, pairs, count);
  keep_census(census, modes);
  modes.check_seconds = check_seconds;
  return modes;
}

}  // namespace tremula
