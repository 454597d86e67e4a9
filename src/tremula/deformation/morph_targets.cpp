#include "tremula/deformation/morph_targets.hpp"

#include "tremula/base/error.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

namespace tremula {
namespace {

void check_fit(const Skeleton& skeleton, const Modes& modes, const Motion& motion) {
  const Eigen::Index rows = 6 * Eigen::Index{skeleton.branch_count()};
  const auto fail = [](const std::string& what, Eigen::Index found, Eigen::Index wanted) {
    throw Error("morph targets: " + what + " is " + std::to_string(found) + ", wanted " +
                std::to_string(wanted));
  };
  if (motion.sample_count() < 1) throw Error("morph targets: the motion has no samples");
  if (motion.mode_count() != modes.count())
    fail("the motion's number of modes", motion.mode_count(), modes.count());
  if (modes.shapes.cols() != modes.count())
    fail("columns of mode shapes", modes.shapes.cols(), modes.count());
  if (modes.shapes.rows() != rows) fail("rows of mode shapes", modes.shapes.rows(), rows);
  if (motion.lean.size() != rows) fail("rows of the mean lean", motion.lean.size(), rows);
  if (!(motion.period > 0) || !std::isfinite(motion.period)) {
    throw Error("morph targets: the period is " + std::to_string(motion.period) + ", wanted seconds above 0");
  }
  if (!motion.coordinates.allFinite() || !motion.lean.allFinite() || !modes.shapes.allFinite()) {
    throw Error("morph targets: the motion is not finite");
  }
}

// "0.572", in any locale.
std::string decimals(double value) {
  char text[400];
  const auto result = std::to_chars(text, text + sizeof text, value, std::chars_format::fixed, 3);
  return {text, result.ptr};
}

// Numbers are padded so that names sort in the order of the modes.
std::string mode_name(int mode, int mode_count, double frequency) {
  const std::size_t width = std::max<std::size_t>(2, std::to_string(mode_count).size());
  std::string number = std::to_string(mode + 1);
  number.insert(0, width - std::min(width, number.size()), '0');
  return "mode " + number + " " + decimals(frequency) + " Hz";
}

// An instant of the loop that gets a row of weights: a sample, or a zero between two of them.
struct Key {
  float time;
  Eigen::Index sample;  // p
  double part;          // 0 at sample p … 1 at sample p + 1
  int zero_of = -1;     // the mode that crosses zero here
};

std::vector<Key> sample_keys(const Motion& motion) {
  // Floats are furthest apart at the end. Two steps of theirs between samples, and rounding keeps samples
  // apart.
  const auto end = static_cast<float>(motion.period);
  const double float_step = std::nextafter(end, std::numeric_limits<float>::infinity()) - end;
  const auto sample_count = static_cast<double>(motion.coordinates.rows());
  if (!(motion.period / sample_count >= 2 * float_step)) {
    throw Error("morph targets: " + std::to_string(motion.sample_count()) + " samples in " +
                decimals(motion.period) + " s cannot be told apart in single precision");
  }
  std::vector<Key> keys;
  for (Eigen::Index p = 0; p <= motion.coordinates.rows(); ++p) {
    keys.push_back({static_cast<float>(motion.period * (static_cast<double>(p) / sample_count)), p, 0});
  }
  return keys;
}

// Adds a key wherever a mode changes its sign between two samples, found on the polyline through the keys as
// they are stored. A crossing that single precision cannot tell from a sample needs no key: it is off by
// rounding only.
std::vector<Key> with_zero_crossings(const std::vector<Key>& samples, const Motion& motion) {
  std::vector<Key> keys;
  for (std::size_t k = 0; k + 1 < samples.size(); ++k) {
    keys.push_back(samples[k]);
    const Eigen::Index p = samples[k].sample, next = (p + 1) % motion.coordinates.rows();
    const double begin = samples[k].time, step = samples[k + 1].time - begin;
    const std::size_t first = keys.size();
    for (int mode = 0; mode < motion.mode_count(); ++mode) {
      const double a = motion.coordinates(p, mode), b = motion.coordinates(next, mode);
      if (!((a < 0 && b > 0) || (a > 0 && b < 0))) continue;
      const auto time = static_cast<float>(begin + step * (a / (a - b)));
      if (samples[k].time < time && time < samples[k + 1].time) {
        keys.push_back({time, p, (time - begin) / step, mode});
      }
    }
    std::sort(keys.begin() + static_cast<std::ptrdiff_t>(first), keys.end(), [](const Key& x, const Key& y) {
      return x.time != y.time ? x.time < y.time : x.zero_of < y.zero_of;
    });
  }
  keys.push_back(samples.back());
  return keys;
}

Eigen::VectorXd coordinates_at_key(const Motion& motion, const Key& key) {
  const Eigen::Index samples = motion.coordinates.rows();
  const Eigen::VectorXd y = motion.coordinates.row(key.sample % samples);
  if (!(key.part > 0)) return y;
  const Eigen::VectorXd next = motion.coordinates.row((key.sample + 1) % samples);
  return y + key.part * (next - y);
}

}  // namespace

MorphTargets make_morph_targets(const Skeleton& skeleton, const Surface& surface, const Modes& modes,
                                const Motion& motion, MorphForm form, const Structure* structure) {
  check_fit(skeleton, modes, motion);
  const bool paired = form == MorphForm::paired;
  MorphTargets result;
  result.period = motion.period;

  result.frequencies.assign(modes.frequency.begin(), modes.frequency.end());

  // Shapes and targets.
  const auto add_shape = [&](const Displacement& displacement) {
    result.shapes.push_back(deform_surface(skeleton, surface, displacement, structure));
    return static_cast<int>(result.shapes.size()) - 1;
  };
  if (!motion.lean.isZero(0)) result.targets.push_back({"mean lean", -1, add_shape(motion.lean), 1});
  const Eigen::VectorXd largest = motion.coordinates.cwiseAbs().colwise().maxCoeff();
  for (int mode = 0; mode < modes.count(); ++mode) {
    if (!(largest(mode) > 0)) continue;
    const int shape = add_shape(modes.shapes.col(mode) * largest(mode));
    const std::string name = mode_name(mode, modes.count(), modes.frequency(mode));
    if (!paired) {
      result.targets.push_back({name, mode, shape, 1});
      continue;
    }
    if (motion.coordinates.col(mode).maxCoeff() > 0) result.targets.push_back({name + " +", mode, shape, 1});
    if (motion.coordinates.col(mode).minCoeff() < 0) result.targets.push_back({name + " -", mode, shape, -1});
  }

  // Keys, and the weights at each. Crossings that fall on one instant share a key, where each of them is
  // zero.
  std::vector<Key> keys = sample_keys(motion);
  if (paired) keys = with_zero_crossings(keys, motion);
  for (std::size_t begin = 0, end; begin < keys.size(); begin = end) {
    Eigen::VectorXd y = coordinates_at_key(motion, keys[begin]);
    for (end = begin; end < keys.size() && keys[end].time == keys[begin].time; ++end) {
      if (keys[end].zero_of >= 0) y(keys[end].zero_of) = 0;
    }
    result.times.push_back(keys[begin].time);
    for (const MorphTarget& target : result.targets) {
      const double weight = target.mode < 0 ? 1 : target.sign * y(target.mode) / largest(target.mode);
      // Adding zero turns -0 into 0.
      result.weights.push_back(static_cast<float>(paired ? std::max(weight, 0.0) : weight) + 0.0F);
    }
  }
  return result;
}

}  // namespace tremula
