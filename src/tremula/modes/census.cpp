#include "tremula/modes/census.hpp"

#include <algorithm>
#include <cmath>

namespace tremula {
namespace {

struct Counts {
  int found, by_inertia;
  int missing() const { return std::max(0, by_inertia - found); }
};

}  // namespace

Census take_census(const std::function<int(double omega)>& count_below, const Eigen::VectorXd& values,
                   int count, double within) {
  const auto counts_at = [&](Eigen::Index mode, double factor) {
    const double omega = factor / std::sqrt(values[mode]);
    return Counts{static_cast<int>((values.array() > 1 / (omega * omega)).count()), count_below(omega)};
  };
  const auto just_above = [&](Eigen::Index mode) { return counts_at(mode, 1 + within); };

  Eigen::Index last = count - 1;
  Counts above = just_above(last);
  if (above.by_inertia <= count) return {above.missing(), above.found, above.by_inertia};
  // The first mode up to which there are as many as are wanted.
  if (above.missing() > 0) {
    for (Eigen::Index low = 0; low < last;) {
      const Eigen::Index middle = (low + last) / 2;
      const Counts counts = just_above(middle);
      if (counts.by_inertia >= count) {
        last = middle;
        above = counts;
      } else {
        low = middle + 1;
      }
    }
  }
  // All those before it are wanted, and of its equals as many as make up the count.
  const Counts below = counts_at(last, 1 - within);
  const int missing_below = std::max(0, std::min(count, below.by_inertia) - below.found);
  const int equals_found = above.found - below.found;
  const int equals_wanted = std::max(0, count - below.by_inertia);
  return {missing_below + std::max(0, equals_wanted - equals_found), below.found, below.by_inertia,
          above.by_inertia - below.by_inertia, above.by_inertia - count};
}

}  // namespace tremula
