#include "tremula/modes/solve_modes.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/error.hpp"
#include "tremula/modes/solve_problem.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

namespace tremula {
namespace {

int sum(const std::vector<int>& counts) { return std::accumulate(counts.begin(), counts.end(), 0); }

Modes solve_part(const Structure& structure, std::size_t part, const ModeOptions& options) {
  const Eigen::Index size = structure.eigen.degrees_of(part);
  const bool dense = dense_is_better(options, size, options.count);
  return solve_problem(structure.eigen.problem(part, dense), options.count, dense, options);
}

// How many modes each part has below one frequency, that for all of them together are `count` or somewhat
// more.
std::vector<int> share_out(const Structure& structure, int count) {
  std::vector<int> shares;
  for (std::size_t part = 0; part < structure.eigen.rows.size(); ++part)
    shares.push_back(std::min(count, static_cast<int>(structure.eigen.degrees_of(part))));
  if (count == static_cast<int>(structure.eigen.all_degrees())) return shares;

  const auto try_at = [&](double log_omega) {
    const std::vector<int> below = structure.eigen.count_below(std::exp2(log_omega));
    if (sum(below) < count) return false;
    for (std::size_t p = 0; p < shares.size(); ++p) shares[p] = std::min(below[p], count);
    return true;
  };
  const int most = count + count / 2 + static_cast<int>(shares.size());
  constexpr double farthest = 400;
  double low = 0, high = 0, step = 1;
  if (try_at(high)) {
    do {
      high = low, low -= step, step *= 2;
    } while (low > -farthest && try_at(low));
  } else {
    do {
      low = high, high += step, step *= 2;
    } while (high < farthest && !try_at(high));
  }
  while (high - low > 1e-6 && sum(shares) > most) {
    const double middle = 0.5 * (low + high);
    (try_at(middle) ? high : low) = middle;
  }
  return shares;
}

// Parts that share nothing are problems of their own: each is smaller, and modes that are equal because one
// part is a copy of another do not meet. The parts' lowest modes together are those of the whole.
Modes solve_by_parts(const Structure& structure, int count, const ModeOptions& options) {
  const std::vector<std::vector<int>>& parts = structure.eigen.rows;
  const std::size_t shapes = sizeof(double) * static_cast<std::size_t>(structure.size() * count);
  check_memory({shapes, shapes}, count, structure.size(), options);
  const std::vector<int> shares = share_out(structure, count);
  std::vector<Modes> solved(parts.size());
  std::vector<std::pair<std::size_t, Eigen::Index>> order;  // part and mode
  for (std::size_t p = 0; p < parts.size(); ++p) {
    ModeOptions share = options;
    share.count = shares[p];
    if (options.progress) {
      share.progress = [&](double done) {
        options.progress((static_cast<double>(p) + done) / static_cast<double>(parts.size()));
      };
    }
    if (share.count > 0) solved[p] = solve_part(structure, p, share);
    for (Eigen::Index r = 0; r < share.count; ++r) order.emplace_back(p, r);
  }
  const auto frequency = [&](const auto& at) { return solved[at.first].frequency[at.second]; };
  std::ranges::stable_sort(order, {}, frequency);

  Modes modes;
  modes.frequency.resize(count);
  modes.residual.resize(count);
  modes.error_bound.resize(count);
  modes.shapes = Eigen::MatrixXd::Zero(structure.size(), count);
  for (Eigen::Index r = 0; r < count; ++r) {
    const auto& [p, q] = order[static_cast<std::size_t>(r)];
    modes.frequency[r] = solved[p].frequency[q];
    modes.residual[r] = solved[p].residual[q];
    modes.error_bound[r] = solved[p].error_bound[q];
    modes.shapes.col(r)(parts[p]) = solved[p].shapes.col(q);
  }
  for (const Modes& part : solved) {
    modes.operator_count += part.operator_count;
    modes.check_seconds += part.check_seconds;
  }
  Eigen::VectorXd values(static_cast<Eigen::Index>(order.size()));
  for (Eigen::Index r = 0; r < values.size(); ++r) {
    const double omega = 2 * std::numbers::pi * frequency(order[static_cast<std::size_t>(r)]);
    values[r] = 1 / (omega * omega);
  }
  keep_census(take_census([&](double omega) { return sum(structure.eigen.count_below(omega)); }, values,
                          count, equal_within(options)),
              modes);
  return modes;
}

}  // namespace

Modes solve_modes(const Structure& structure, const ModeOptions& options) {
  check_at_least("rows of the structure", structure.size(), 1);
  const int count = mode_count(options, structure.eigen.all_degrees(), structure.eigen.rows_explained);
  if (structure.eigen.rows.size() > 1) return solve_by_parts(structure, count, options);
  ModeOptions counted = options;
  counted.count = count;
  return solve_part(structure, 0, counted);
}

Modes solve_modes_up_to(const Structure& structure, double frequency, const ModeOptions& options) {
  char hertz[40];
  std::snprintf(hertz, sizeof hertz, "%g Hz", frequency);
  if (!(frequency > 0 && frequency <= 1e100)) {
    throw InputError("highest frequency", hertz, "a frequency above 0 Hz, up to 1e+100 Hz");
  }
  check_at_least("rows of the structure", structure.size(), 1);
  ModeOptions counted = options;
  counted.count = sum(structure.eigen.count_below(2 * std::numbers::pi * frequency));
  if (counted.count == 0) {
    throw InputError("highest frequency", std::string(hertz) + ", below which there is no mode",
                     "a higher one");
  }
  return solve_modes(structure, counted);
}

}  // namespace tremula
