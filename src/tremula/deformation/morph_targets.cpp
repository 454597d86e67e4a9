#include "tremula/deformation/morph_targets.hpp"

#include "tremula/base/error.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace tremula {
namespace {

void check_fit(const Loop& loop) {
  const auto fail = [](const std::string& what, Eigen::Index found, Eigen::Index wanted) {
    throw Error("morph targets: " + what + " is " + std::to_string(found) + ", wanted " +
                std::to_string(wanted));
  };
  const Eigen::Index count = loop.coordinates.cols();
  if (loop.sample_count() < 1) throw Error("morph targets: the loop has no samples");
  if (static_cast<Eigen::Index>(loop.kind.size()) != count)
    fail("the number of kinds", static_cast<Eigen::Index>(loop.kind.size()), count);
  if (loop.frequency.size() != count) fail("the number of frequencies", loop.frequency.size(), count);
  if (!(loop.period > 0) || !std::isfinite(loop.period)) {
    throw Error("morph targets: the period is " + std::to_string(loop.period) + ", wanted seconds above 0");
  }
  check_instances(loop.instances, loop.repeats);
  if (!loop.coordinates.allFinite() || !loop.frequency.allFinite())
    throw Error("morph targets: the loop is not finite");
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

std::vector<Key> sample_keys(const Loop& loop) {
  // Floats are furthest apart at the end. Two steps of theirs between samples, and rounding keeps samples
  // apart.
  const auto end = static_cast<float>(loop.period);
  const double float_step = std::nextafter(end, std::numeric_limits<float>::infinity()) - end;
  const auto sample_count = static_cast<double>(loop.coordinates.rows());
  if (!(loop.period / sample_count >= 2 * float_step)) {
    throw Error("morph targets: " + std::to_string(loop.sample_count()) + " samples in " +
                decimals(loop.period) + " s cannot be told apart in single precision");
  }
  std::vector<Key> keys;
  for (Eigen::Index p = 0; p <= loop.coordinates.rows(); ++p) {
    keys.push_back({static_cast<float>(loop.period * (static_cast<double>(p) / sample_count)), p, 0});
  }
  return keys;
}

// Behind the last sample a loop goes on with its first, a clip stands still.
Eigen::Index wrapped(const Loop& loop, Eigen::Index sample) {
  const Eigen::Index count = loop.coordinates.rows();
  return loop.repeats ? sample % count : std::min(sample, count - 1);
}

// Adds a key wherever a coordinate changes its sign between two samples, found on the polyline through the
// keys as they are stored. A crossing that single precision cannot tell from a sample needs no key: it is off
// by rounding only.
std::vector<Key> with_zero_crossings(const std::vector<Key>& samples, const Loop& loop) {
  std::vector<Key> keys;
  for (std::size_t k = 0; k + 1 < samples.size(); ++k) {
    keys.push_back(samples[k]);
    const Eigen::Index p = samples[k].sample, next = wrapped(loop, p + 1);
    const double begin = samples[k].time, step = samples[k + 1].time - begin;
    const std::size_t first = keys.size();
    for (int r = 0; r < loop.coordinates.cols(); ++r) {
      if (loop.kind[static_cast<std::size_t>(r)] == ShapeKind::lean) continue;
      const double a = loop.coordinates(p, r), b = loop.coordinates(next, r);
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

Eigen::VectorXd coordinates_at_key(const Loop& loop, const Key& key) {
  const Eigen::VectorXd y = loop.coordinates.row(wrapped(loop, key.sample));
  if (!(key.part > 0)) return y;
  const Eigen::VectorXd next = loop.coordinates.row(wrapped(loop, key.sample + 1));
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
std::vector<Scale> scales_of(const Loop& loop, Eigen::Index coordinate, MorphForm form) {
  const double low = std::min(loop.coordinates.col(coordinate).minCoeff(), 0.0);
  const double high = std::max(loop.coordinates.col(coordinate).maxCoeff(), 0.0);
  const double span = high - low;
  if (!(span > 0)) return {};
  if (form == MorphForm::biased) return {{coordinate, low, high, false}};
  if (form == MorphForm::signed_weights) return {{coordinate, 0, span, false}};
  std::vector<Scale> pair;
  if (high > 0) pair.push_back({coordinate, 0, span, true});
  if (low < 0) pair.push_back({coordinate, 0, -span, true});
  return pair;
}

bool is_zero(const SurfaceDelta& delta) {
  const auto all_zero = [](const std::vector<Eigen::Vector3f>& changes) {
    return std::all_of(changes.begin(), changes.end(), [](const Eigen::Vector3f& v) { return v.isZero(0); });
  };
  return all_zero(delta.position) && all_zero(delta.normal);
}

}  // namespace

MorphTargets make_morph_targets(const Loop& loop, MorphForm form) {
  check_fit(loop);
  MorphTargets result;
  result.period = loop.period;
  result.repeats = loop.repeats;
  result.instances = loop.instances;
  const auto count_of = [&](ShapeKind kind) {
    return static_cast<int>(std::count(loop.kind.begin(), loop.kind.end(), kind));
  };
  const int mode_count = count_of(ShapeKind::mode);
  result.static_shape_count = count_of(ShapeKind::static_shape);
  for (std::size_t c = 0; c < loop.kind.size(); ++c) {
    if (loop.kind[c] == ShapeKind::mode)
      result.frequencies.push_back(loop.frequency[static_cast<Eigen::Index>(c)]);
  }

  // Shapes and targets. A lean has no scale: its weight is 1.
  std::vector<Scale> scales;
  std::map<ShapeKind, int> seen;
  std::size_t lean_count = 0;
  for (Eigen::Index c = 0; c < loop.coordinates.cols(); ++c) {
    const ShapeKind kind = loop.kind[static_cast<std::size_t>(c)];
    const int number = seen[kind]++;
    if (kind == ShapeKind::lean) {
      SurfaceDelta lean = loop.shape_of_skin(c, 1);
      if (is_zero(lean)) continue;
      result.targets.push_back({.name = "mean lean", .shape = static_cast<int>(result.shapes.size())});
      result.shapes.push_back(std::move(lean));
      ++lean_count;
      continue;
    }
    const std::vector<Scale> own = scales_of(loop, c, form);
    if (own.empty()) continue;
    MorphTarget target{.name = kind == ShapeKind::mode ? mode_name(number, mode_count, loop.frequency[c])
                                                       : "static " + std::to_string(number + 1),
                       .kind = kind,
                       .number = number,
                       .shape = static_cast<int>(result.shapes.size())};
    result.shapes.push_back(loop.shape_of_skin(c, std::abs(own.front().to - own.front().from)));
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
  std::vector<Key> keys = sample_keys(loop);
  if (form == MorphForm::paired) keys = with_zero_crossings(keys, loop);
  for (std::size_t begin = 0, end; begin < keys.size(); begin = end) {
    Eigen::VectorXd y = coordinates_at_key(loop, keys[begin]);
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

WeightTable weights_of(const MorphTargets& morphs, const Instance& instance) {
  const double period = morphs.period;
  const double shift = instance.time_shift - period * std::floor(instance.time_shift / period);
  const std::size_t keys = morphs.key_count(), count = morphs.target_count();
  if (!(shift > 0 && shift < period)) return {morphs.times, morphs.weights};

  WeightTable table;
  const auto append = [&](float time, std::size_t key, double part) {
    if (!table.times.empty() && !(time > table.times.back())) return;  // nearer than floats tell apart
    table.times.push_back(time);
    for (std::size_t t = 0; t < count; ++t) {
      const double before = static_cast<double>(morphs.weight(key, t));
      const double after = part > 0 ? static_cast<double>(morphs.weight(key + 1, t)) : before;
      table.weights.push_back(static_cast<float>(before + part * (after - before)));
    }
  };
  // The loop begins at `shift`, between the keys first - 1 and first.
  std::size_t first = 1;
  while (static_cast<double>(morphs.times[first]) <= shift) ++first;
  const double begin = static_cast<double>(morphs.times[first - 1]),
               end = static_cast<double>(morphs.times[first]);
  const auto last_time = morphs.times.back();
  append(0, first - 1, (shift - begin) / (end - begin));
  for (std::size_t k = first; k < keys; ++k)
    append(static_cast<float>(static_cast<double>(morphs.times[k]) - shift), k, 0);
  for (std::size_t k = 1; k < first; ++k) {
    const auto time = static_cast<float>(static_cast<double>(morphs.times[k]) - shift + period);
    if (time < last_time) append(time, k, 0);
  }
  table.times.push_back(last_time);
  table.weights.insert(table.weights.end(), table.weights.begin(),
                       table.weights.begin() + static_cast<std::ptrdiff_t>(count));
  return table;
}

}  // namespace tremula
