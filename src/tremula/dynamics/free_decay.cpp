#include "tremula/dynamics/free_decay.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/number_text.hpp"
#include "tremula/base/types.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace tremula {
namespace {

struct Peak {
  double time = 0, size = 0;  // in steps
};

// The farthest sample of first … last, and the top of the parabola through it and its neighbours.
Peak peak_between(const Eigen::VectorXd& record, Eigen::Index first, Eigen::Index last) {
  Eigen::Index at = 0;
  record.segment(first, last - first + 1).cwiseAbs().maxCoeff(&at);
  at = std::clamp<Eigen::Index>(first + at, 1, record.size() - 2);
  const double before = std::abs(record[at - 1]), here = std::abs(record[at]),
               after = std::abs(record[at + 1]);
  const double bend = before - 2 * here + after;
  const double aside = bend < 0 ? std::clamp(0.5 * (before - after) / bend, -0.5, 0.5) : 0;
  return {static_cast<double>(at) + aside, here - 0.25 * (before - after) * aside};
}

// Between the first crossing of zero and the last.
std::vector<Peak> peaks_of(const Eigen::VectorXd& record) {
  std::vector<Peak> peaks;
  Eigen::Index begin = -1;
  for (Eigen::Index i = 1; i < record.size(); ++i) {
    const bool crosses = (record[i - 1] < 0) != (record[i] < 0);
    if (!crosses) continue;
    if (begin >= 0) peaks.push_back(peak_between(record, begin, i - 1));
    begin = i;
  }
  return peaks;
}

struct Line {
  double slope = 0, scatter = 0;  // rms about it
};

Line line_through(const Eigen::VectorXd& values) {
  const Eigen::ArrayXd number =
      Eigen::ArrayXd::LinSpaced(values.size(), 0, static_cast<double>(values.size() - 1));
  const Eigen::ArrayXd about = values.array() - values.mean(), along = number - number.mean();
  const double slope = (along * about).sum() / along.square().sum();
  return {slope, std::sqrt((about - slope * along).square().mean())};
}

}  // namespace

FreeDecay evaluate_decay(const Eigen::VectorXd& record, double step, const DecayOptions& options) {
  check_at_least("samples of a decay", record.size(), 3);
  if (!(step > 0 && std::isfinite(step)))
    throw InputError("step of a decay", number_text(step) + " s", "above 0 s");
  if (!record.allFinite())
    throw InputError("record of a decay", "a number that is not finite", "finite numbers");
  std::vector<Peak> peaks = peaks_of(record);
  std::size_t count = 0;
  while (count < peaks.size() && count <= 2 * index_of(options.most_cycles) &&
         peaks[count].size > options.lowest * peaks[0].size)
    ++count;
  peaks.resize(count);
  if (count < 2 * index_of(options.fewest_cycles) + 1) {
    throw InputError("record of a decay",
                     number_text(count > 0 ? 0.5 * static_cast<double>(count - 1) : 0) + " cycles of it",
                     std::to_string(options.fewest_cycles) + " or more: a longer record, or less damping");
  }
  Eigen::VectorXd times(static_cast<Eigen::Index>(count)), logarithms(times.size());
  for (Eigen::Index k = 0; k < times.size(); ++k) {
    times[k] = peaks[index_of(k)].time * step;
    logarithms[k] = std::log(peaks[index_of(k)].size);
  }
  const Line of_time = line_through(times), of_size = line_through(logarithms);  // half a cycle each
  const double cycle = 2 * of_time.slope, decrement = -2 * of_size.slope;
  if (!(cycle >= 8 * step))
    throw InputError("record of a decay", number_text(cycle / step) + " samples a cycle", "8 or more");
  FreeDecay decay{.cycles = 0.5 * static_cast<double>(count - 1), .scatter = of_size.scatter};
  decay.damping_ratio = decrement / std::hypot(2 * std::numbers::pi, decrement);
  decay.frequency = 1 / (cycle * std::sqrt(1 - decay.damping_ratio * decay.damping_ratio));
  return decay;
}

}  // namespace tremula
