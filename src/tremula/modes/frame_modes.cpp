#include "tremula/modes/frame_modes.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include <Eigen/Eigenvalues>

#include "tremula/base/error.hpp"
#include "tremula/modes/eigen_problem.hpp"

namespace tremula {
namespace {

struct Pairs {
  Eigen::VectorXd values;  // omega^-2, largest first
  Eigen::MatrixXd vectors;
  int operator_count = 0;
};

Pairs solve_dense(const EigenProblem& problem) {
  Eigen::MatrixXd form(problem.size, problem.size);
  for (Eigen::Index i = 0; i < problem.size; ++i) {
    problem.apply(Eigen::VectorXd::Unit(problem.size, i), form.col(i));
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(0.5 * (form + form.transpose()));
  if (solver.info() != Eigen::Success) throw Error("modes: the dense eigenvalue solver did not converge");
  return {solver.eigenvalues().reverse(), solver.eigenvectors().rowwise().reverse(),
          static_cast<int>(problem.size)};
}

void add_pairs(const EigenProblem& problem, int count, std::uint64_t attempt, const ModeOptions& options,
               Pairs& pairs) {
  const LanczosResult more = largest_eigenpairs(problem.apply, problem.size,
                                                {.count = count,
                                                 .tolerance = std::min(options.tolerance, 1e-6),
                                                 .memory_limit = options.memory_limit,
                                                 .start = attempt,
                                                 .progress = options.progress},
                                                pairs.vectors);
  if (!more.converged) {
    throw Error("modes: the search for " + std::to_string(count) + " modes did not converge in " +
                std::to_string(more.operator_count) + " steps; ask for fewer modes or a larger tolerance");
  }
  const Eigen::Index before = pairs.values.size();
  pairs.values.conservativeResize(before + count);
  pairs.vectors.conservativeResize(problem.size, before + count);
  // From the back, each into its place among those that are there.
  for (Eigen::Index i = before + count - 1, a = before - 1, b = count - 1; b >= 0; --i) {
    const bool from_before = a >= 0 && pairs.values[a] < more.values[b];
    pairs.values[i] = from_before ? pairs.values[a] : more.values[b];
    if (from_before) {
      pairs.vectors.col(i) = pairs.vectors.col(a--);
    } else {
      pairs.vectors.col(i) = more.vectors.col(b--);
    }
  }
  pairs.operator_count += more.operator_count;
}

}  // namespace

Modes solve_modes(const FrameMatrices& matrices, const ModeOptions& options) {
  const auto size = static_cast<int>(matrices.size());
  const int count = options.count == all_modes ? size : options.count;
  if (count < 1 || count > size) {
    throw InputError("mode count", std::to_string(count),
                     "1 to " + std::to_string(size) + " (six for each free node)");
  }
  const EigenProblem problem = eigen_problem(matrices);
  const bool dense =
      options.method == ModeMethod::dense || (options.method == ModeMethod::automatic && 2 * count >= size);
  const auto omega_just_above_last = [&](const Pairs& pairs) {
    return (1 + std::max(1e-8, 10 * std::min(options.tolerance, 1e-6))) / std::sqrt(pairs.values[count - 1]);
  };
  const auto found_below = [](const Pairs& pairs, double omega) {
    return static_cast<int>((pairs.values.array() > 1 / (omega * omega)).count());
  };
  Pairs pairs;
  Modes modes;
  if (dense) {
    pairs = solve_dense(problem);
  } else {
    add_pairs(problem, count, 0, options, pairs);
  }
  for (std::uint64_t attempt = 1;; ++attempt) {
    const double omega = omega_just_above_last(pairs);
    modes.count_below = found_below(pairs, omega);
    modes.count_by_inertia = problem.count_below(omega);
    const int missing = modes.count_by_inertia - modes.count_below;
    if (dense || missing <= 0) break;
    if (attempt > 20) {
      throw Error("modes: some of the " + std::to_string(count) +
                  " lowest modes could not be found; ask for more or fewer modes");
    }
    add_pairs(problem, missing, attempt, options, pairs);
  }

  modes.operator_count = pairs.operator_count;
  modes.frequency.resize(count);
  modes.residual.resize(count);
  modes.shapes.resize(size, count);
  Eigen::VectorXd image(size);
  for (int r = 0; r < count; ++r) {
    const Eigen::VectorXd s = pairs.vectors.col(r).normalized();
    const double value = problem.apply(s, image);  // Rayleigh's quotient
    if (!(value > 0)) throw Error("modes: a mode is too stiff to be resolved; ask for fewer modes");
    modes.frequency[r] = 1 / (2 * std::numbers::pi * std::sqrt(value));
    modes.residual[r] = (image - value * s).norm() / value;
    const Eigen::VectorXd shape = problem.displacement(s) / std::sqrt(value);
    Eigen::Index largest = 0;
    shape.cwiseAbs().maxCoeff(&largest);
    modes.shapes.col(r) = shape[largest] < 0 ? Eigen::VectorXd(-shape) : shape;
  }
  modes.error_bound = 0.5 * modes.residual;
  return modes;
}

}  // namespace tremula
