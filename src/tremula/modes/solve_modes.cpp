#include "tremula/modes/solve_modes.hpp"

#include "tremula/base/error.hpp"
#include "tremula/modes/inertia.hpp"
#include "tremula/modes/solve_problem.hpp"
#include "tremula/structure/compliance_operator.hpp"
#include "tremula/structure/independent_parts.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

namespace tremula {
namespace {

// The compliance form in the structure's own order: 6N numbers and no lanes that stay empty.
EigenProblem plain_problem(const Structure& structure) {
  return {.size = structure.size(),
          .degrees_of_freedom = structure.size(),
          .apply =
              [&structure](Eigen::Ref<const Eigen::VectorXd> in, Eigen::Ref<Eigen::VectorXd> out) {
                out = apply_compliance_form(structure, in);
                return in.dot(out);
              },
          .displacement =
              [&structure](Eigen::Ref<const Eigen::VectorXd> s) {
                return displacement_from_compliance_form(structure, s);
              },
          .count_below = [&structure](double omega) { return count_modes_below(structure, omega); }};
}

Modes solve_connected(const Structure& structure, const ModeOptions& options) {
  const bool dense = dense_is_better(options, structure.size(), options.count);
  return solve_problem(dense ? plain_problem(structure) : eigen_problem(structure), options.count, dense,
                       options);
}

// How many modes each part has below one frequency, that for all of them together are `count` or somewhat
// more.
std::vector<int> share_out(const Structure& structure, const std::vector<std::vector<int>>& parts,
                           int count) {
  const auto size = static_cast<int>(structure.size());
  std::vector<int> shares;
  for (const std::vector<int>& part : parts)
    shares.push_back(std::min(count, 6 * static_cast<int>(part.size())));
  if (count == size) return shares;

  const auto try_at = [&](double log_omega) {
    const std::vector<int> pivots = negative_pivots(structure, std::exp2(log_omega));
    std::vector<int> below;
    for (const std::vector<int>& part : parts) {
      below.push_back(0);
      for (const int branch : part) below.back() += pivots[static_cast<std::size_t>(branch)];
    }
    if (std::accumulate(below.begin(), below.end(), 0) < count) return false;
    for (std::size_t p = 0; p < parts.size(); ++p) shares[p] = std::min(below[p], count);
    return true;
  };
  const int most = count + count / 2 + static_cast<int>(parts.size());
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
  while (high - low > 1e-6 && std::accumulate(shares.begin(), shares.end(), 0) > most) {
    const double middle = 0.5 * (low + high);
    (try_at(middle) ? high : low) = middle;
  }
  return shares;
}

// Parts that share nothing are problems of their own: each is smaller, and modes that are equal because one
// part is a copy of another do not meet. The parts' lowest modes together are those of the whole.
Modes solve_by_parts(const Structure& structure, const std::vector<std::vector<int>>& parts, int count,
                     const ModeOptions& options) {
  const std::size_t shapes = sizeof(double) * static_cast<std::size_t>(structure.size() * count);
  check_memory({shapes, shapes}, count, structure.size(), options);
  const std::vector<int> shares = share_out(structure, parts, count);
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
    if (share.count > 0) solved[p] = solve_connected(part_of(structure, parts[p]), share);
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
    for (std::size_t i = 0; i < parts[p].size(); ++i)
      modes.shapes.block<6, 1>(6 * parts[p][i], r) =
          solved[p].shapes.block<6, 1>(6 * static_cast<Eigen::Index>(i), q);
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
  keep_census(take_census([&](double omega) { return count_modes_below(structure, omega); }, values, count,
                          equal_within(options)),
              modes);
  return modes;
}

}  // namespace

EigenProblem eigen_problem(const Structure& structure) {
  EigenProblem problem = plain_problem(structure);
  const auto compliance_operator = std::make_shared<ComplianceOperator>(structure);
  problem.size = compliance_operator->size();
  problem.apply = [compliance_operator](Eigen::Ref<const Eigen::VectorXd> in,
                                        Eigen::Ref<Eigen::VectorXd> out) {
    return compliance_operator->apply(in, out);
  };
  problem.displacement = [compliance_operator, &structure](Eigen::Ref<const Eigen::VectorXd> s) {
    return displacement_from_compliance_form(structure, compliance_operator->unpacked(s));
  };
  return problem;
}

Modes solve_modes(const Structure& structure, const ModeOptions& options) {
  const int count =
      mode_count(options, structure.size(),
                 "six for each of the " + std::to_string(structure.branch_count()) + " branches");
  const std::vector<std::vector<int>> parts = independent_parts(structure);
  if (parts.size() > 1) return solve_by_parts(structure, parts, count, options);
  ModeOptions counted = options;
  counted.count = count;
  return solve_connected(structure, counted);
}

Modes solve_modes_up_to(const Structure& structure, double frequency, const ModeOptions& options) {
  char hertz[40];
  std::snprintf(hertz, sizeof hertz, "%g Hz", frequency);
  if (!(frequency > 0 && frequency <= 1e100)) {
    throw InputError("highest frequency", hertz, "a frequency above 0 Hz, up to 1e+100 Hz");
  }
  ModeOptions counted = options;
  counted.count = count_modes_below(structure, 2 * std::numbers::pi * frequency);
  if (counted.count == 0) {
    throw InputError("highest frequency", std::string(hertz) + ", below which there is no mode",
                     "a higher one");
  }
  return solve_modes(structure, counted);
}

}  // namespace tremula
