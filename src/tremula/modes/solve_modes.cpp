#include "tremula/modes/solve_modes.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <string>
#include <vector>

#include "tremula/base/error.hpp"
#include "tremula/modes/inertia.hpp"
#include "tremula/numerics/lanczos.hpp"

namespace tremula {
namespace {

// omega^-2, largest first, and the unit vectors of the compliance form that belong to them.
struct Eigenpairs {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
  int operator_count;
};

Eigenpairs solve_dense(const Structure& structure) {
  const Eigen::Index size = structure.size();
  Eigen::MatrixXd form(size, size);
  for (Eigen::Index i = 0; i < size; ++i) {
    form.col(i) = apply_compliance_form(structure, Eigen::VectorXd::Unit(size, i));
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(0.5 * (form + form.transpose()));
  if (solver.info() != Eigen::Success) throw Error("modes: the dense eigenvalue solver did not converge");
  return {solver.eigenvalues().reverse(), solver.eigenvectors().rowwise().reverse(), static_cast<int>(size)};
}

// A looser tolerance would leave the eigenvalues too uncertain to be counted.
double effective_tolerance(const ModeOptions& options) { return std::min(options.tolerance, 1e-6); }

Eigenpairs search(const Structure& structure, int count, std::uint64_t attempt, const ModeOptions& options,
                  const Eigen::MatrixXd& found) {
  const auto apply = [&](const Eigen::VectorXd& in, Eigen::VectorXd& out) {
    out = apply_compliance_form(structure, in);
  };
  LanczosResult result = largest_eigenpairs(apply, structure.size(),
                                            {.count = count,
                                             .tolerance = effective_tolerance(options),
                                             .start = attempt,
                                             .progress = options.progress},
                                            found);
  if (!result.converged) {
    throw Error("modes: " + std::to_string(result.values.size()) + " of " + std::to_string(count) +
                " modes converged; ask for fewer modes or a larger tolerance");
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

// Lanczos sees one vector of every multiple eigenvalue and may pass by members of a tight cluster. What the
// inertia says is missing is searched for at right angles to what is there, until nothing is missing.
void complete(const Structure& structure, int count, const ModeOptions& options, Eigenpairs& pairs) {
  for (std::uint64_t attempt = 1; attempt <= 20; ++attempt) {
    const double omega = omega_just_above(pairs.values[count - 1], options);
    const int missing = count_modes_below(structure, omega) - count_found_below(pairs, omega);
    if (missing <= 0) return;
    merge(pairs, search(structure, missing, attempt, options, pairs.vectors));
  }
  throw Error("modes: some of the " + std::to_string(count) +
              " lowest modes could not be found; ask for more or fewer modes");
}

Modes as_modes(const Structure& structure, const Eigenpairs& pairs, int count) {
  Modes modes;
  modes.operator_count = pairs.operator_count;
  modes.frequency.resize(count);
  modes.residual.resize(count);
  modes.error_bound.resize(count);
  modes.shapes.resize(structure.size(), count);
  for (int r = 0; r < count; ++r) {
    const double value = pairs.values[r];
    if (!(value > 0)) throw Error("modes: a mode is too stiff to be resolved; ask for fewer modes");
    const double omega = 1 / std::sqrt(value);
    const Eigen::VectorXd s = pairs.vectors.col(r);
    modes.frequency[r] = omega / (2 * std::numbers::pi);
    modes.residual[r] = (apply_compliance_form(structure, s) - value * s).norm() / value;
    // |lambda error| <= residual for a symmetric operator; half of it for the square root.
    modes.error_bound[r] = 0.5 * modes.residual[r];
    Eigen::VectorXd shape = omega * displacement_from_compliance_form(structure, s);
    Eigen::Index largest = 0;
    shape.cwiseAbs().maxCoeff(&largest);
    modes.shapes.col(r) = shape[largest] < 0 ? Eigen::VectorXd(-shape) : shape;
  }
  return modes;
}

bool dense_is_better(Eigen::Index size, int count) { return size <= 120 || 3 * count >= size; }

}  // namespace

Modes solve_modes(const Structure& structure, const ModeOptions& options) {
  const auto size = static_cast<int>(structure.size());
  const int count = options.count == all_modes ? size : options.count;
  if (count < 1 || count > size) {
    throw InputError("mode count", std::to_string(count),
                     "1 to " + std::to_string(size) + " (six for each of the " +
                         std::to_string(structure.branch_count()) + " branches)");
  }
  const bool dense = options.method == ModeMethod::dense ||
                     (options.method == ModeMethod::automatic && dense_is_better(structure.size(), count));
  Eigenpairs pairs = dense ? solve_dense(structure) : search(structure, count, 0, options, {});
  if (!dense) complete(structure, count, options, pairs);
  Modes modes = as_modes(structure, pairs, count);
  const double omega = omega_just_above(pairs.values[count - 1], options);
  modes.count_below = count_found_below(pairs, omega);
  modes.count_by_inertia = count_modes_below(structure, omega);
  return modes;
}

Modes solve_modes_up_to(const Structure& structure, double frequency, const ModeOptions& options) {
  if (!std::isfinite(frequency) || frequency <= 0) {
    throw InputError("highest frequency", std::to_string(frequency), "a frequency above 0 Hz");
  }
  ModeOptions counted = options;
  counted.count = count_modes_below(structure, 2 * std::numbers::pi * frequency);
  if (counted.count == 0) {
    throw InputError("highest frequency", std::to_string(frequency) + " Hz, below which there is no mode",
                     "a higher one");
  }
  return solve_modes(structure, counted);
}

}  // namespace tremula
