#include "tremula/deformation/morph_targets.hpp"

#include "tremula/base/error.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

namespace tremula {
namespace {

void check_fit(const Skeleton& skeleton, const Structure& structure, const Surface& surface,
               const Modes& modes, const Motion& motion) {
  const Eigen::Index rows = 6 * Eigen::Index{skeleton.branch_count()};
  const auto fail = [](const std::string& what, Eigen::Index found, Eigen::Index wanted) {
    throw Error("morph targets: " + what + " is " + std::to_string(found) + ", wanted " +
                std::to_string(wanted));
  };
  if (structure.branch_count() != skeleton.branch_count())
    fail("the structure's number of branches", structure.branch_count(), skeleton.branch_count());
  for (const std::int32_t branch : surface.branch) {
    if (branch < 0 || branch >= skeleton.branch_count())
      fail("the branch of a vertex", branch, skeleton.branch_count() - 1);
  }
  if (motion.sample_count() < 1) throw Error("morph targets: the motion has no samples");
  if (motion.mode_count() != modes.count())
    fail("the motion's number of modes", motion.mode_count(), modes.count());
  if (modes.shapes.cols() != modes.count())
    fail("columns of mode shapes", modes.shapes.cols(), modes.count());
  if (modes.shapes.rows() != rows) fail("rows of mode shapes", modes.shapes.rows(), rows);
  const StaticShapes& more = motion.static_shapes;
  if (more.shapes.cols() != more.count()) fail("columns of static shapes", more.shapes.cols(), more.count());
  if (more.count() > 0 && more.shapes.rows() != rows) fail("rows of static shapes", more.shapes.rows(), rows);
  if (motion.lean.size() != rows) fail("rows of the mean lean", motion.lean.size(), rows);
  if (!(motion.period > 0) || !std::isfinite(motion.period)) {
    throw Error("morph targets: the period is " + std::to_string(motion.period) + ", wanted seconds above 0");
  }
  if (!motion.coordinates.allFinite() || !motion.lean.allFinite() || !modes.shapes.allFinite() ||
      !more.shapes.allFinite()) {
    throw Error("morph targets: the motion is not finite");
  }
}

// "0.572", in any locale.
std::string decimals(double value) {
  char text[400];
  const auto result = std::to_chars(text, text + sizeof text, value, std::chars_format::fixed, 3);
  return {text, result.ptr};
}

// Numbers are padded so that names sort in the order of the targets.
std::string padded(int number, std::size_t width) {
  const std::string text = std::to_string(number);
  return std::string(width - std::min(width, text.size()), '0') + text;
}

std::string mode_name(int mode, int mode_count, double frequency) {
  const std::size_t width = std::max<std::size_t>(2, std::to_string(mode_count).size());
  return "mode " + padded(mode + 1, width) + " " + decimals(frequency) + " Hz";
}

// An instant of the loop that gets a row of weights: a sample, or a zero between two of them.
struct Key {
  float time;
  Eigen::Index sample;  // p
  double part;          // 0 at sample p … 1 at sample p + 1
  int zero_of = -1;     // the coordinate that crosses zero here
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

// Adds a key wherever a coordinate changes its sign between two samples, found on the polyline through the
// keys as they are stored. A crossing that single precision cannot tell from a sample needs no key: it is off
// by rounding only.
std::vector<Key> with_zero_crossings(const std::vector<Key>& samples, const Motion& motion) {
  std::vector<Key> keys;
  for (std::size_t k = 0; k + 1 < samples.size(); ++k) {
    keys.push_back(samples[k]);
    const Eigen::Index p = samples[k].sample, next = (p + 1) % motion.coordinates.rows();
    const double begin = samples[k].time, step = samples[k + 1].time - begin;
    const std::size_t first = keys.size();
    for (int r = 0; r < motion.coordinates.cols(); ++r) {
      const double a = motion.coordinates(p, r), b = motion.coordinates(next, r);
      if (!((a < 0 && b > 0) || (a > 0 && b < 0))) continue;
      const auto time = static_cast<float>(begin + step * (a / (a - b)));
      if (samples[k].time < time && time < samples[k + 1].time) {
        keys.push_back({time, p, (time - begin) / step, r});
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

// How a target's weight comes from a coordinate y: (y - from) / (to - from), in the paired form not below 0.
struct Scale {
  Eigen::Index coordinate;
  double from, to;
  bool one_sided;

  double weight(double y) const {
    const double w = (y - from) / (to - from);
    return one_sided ? std::max(w, 0.0) : w;
  }
};

// The scales of one coordinate's targets, one or in the paired form up to two; none where nothing moves.
std::vector<Scale> scales_of(const Motion& motion, Eigen::Index coordinate, MorphForm form) {
  const double low = std::min(motion.coordinates.col(coordinate).minCoeff(), 0.0);
  const double high = std::max(motion.coordinates.col(coordinate).maxCoeff(), 0.0);
  const double span = high - low;
  if (!(span > 0)) return {};
  if (form == MorphForm::biased) return {{coordinate, low, high, false}};
  if (form == MorphForm::signed_weights) return {{coordinate, 0, span, false}};
  std::vector<Scale> pair;
  if (high > 0) pair.push_back({coordinate, 0, span, true});
  if (low < 0) pair.push_back({coordinate, 0, -span, true});
  return pair;
}

}  // namespace

MorphTargets make_morph_targets(const Skeleton& skeleton, const Structure& structure, const Surface& surface,
                                const Modes& modes, const Motion& motion, MorphForm form) {
  check_fit(skeleton, structure, surface, modes, motion);
  MorphTargets result;
  result.period = motion.period;
  result.frequencies.assign(modes.frequency.begin(), modes.frequency.end());
  result.static_shape_count = motion.static_shapes.count();

  // Shapes and targets. The lean has no scale: its weight is 1.
  const auto add_shape = [&](const Displacement& displacement) {
    result.shapes.push_back(deform_surface(skeleton, structure, surface, displacement));
    return static_cast<int>(result.shapes.size()) - 1;
  };
  std::vector<Scale> scales;
  if (!motion.lean.isZero(0)) {
    result.targets.push_back({.name = "mean lean", .shape = add_shape(motion.lean)});
  }
  const std::size_t lean_count = result.targets.size();
  for (int r = 0; r < motion.coordinates.cols(); ++r) {
    const std::vector<Scale> own = scales_of(motion, r, form);
    if (own.empty()) continue;
    MorphTarget target;
    if (r < modes.count()) {
      target = {mode_name(r, modes.count(), modes.frequency(r)), ShapeKind::mode, r};
    } else {
      target = {"static " + std::to_string(r - modes.count() + 1), ShapeKind::static_shape,
                r - modes.count()};
    }
    const double size = std::abs(own.front().to - own.front().from);
    target.shape = add_shape(size * shape_of(modes, motion, r + 1));
    for (const Scale& scale : own) {
      MorphTarget one = target;
      one.sign = scale.to > scale.from ? 1 : -1;
      if (form == MorphForm::paired) one.name += one.sign > 0 ? " +" : " -";
      one.rest = static_cast<float>(scale.weight(0)) + 0.0F;
      result.targets.push_back(one);
      scales.push_back(scale);
    }
  }

  // Keys, and the weights at each. Crossings that fall on one instant share a key, where each of them is
  // zero.
  std::vector<Key> keys = sample_keys(motion);
  if (form == MorphForm::paired) keys = with_zero_crossings(keys, motion);
  for (std::size_t begin = 0, end; begin < keys.size(); begin = end) {
    Eigen::VectorXd y = coordinates_at_key(motion, keys[begin]);
    for (end = begin; end < keys.size() && keys[end].time == keys[begin].time; ++end) {
      if (keys[end].zero_of >= 0) y(keys[end].zero_of) = 0;
    }
    result.times.push_back(keys[begin].time);
    result.weights.insert(result.weights.end(), lean_count, 1.0F);
    for (const Scale& scale : scales) {
      // Adding zero turns -0 into 0.
      result.weights.push_back(static_cast<float>(scale.weight(y(scale.coordinate))) + 0.0F);
    }
  }
  return result;
}

}  // namespace tremula
