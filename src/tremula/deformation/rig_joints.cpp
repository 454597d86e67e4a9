#include "tremula/deformation/rig_joints.hpp"

#include "tremula/numerics/rotation.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

#include <tbb/parallel_for.h>
#include <Eigen/Geometry>

namespace tremula::rig {
namespace {

// The root stands still.
const JointFrame& still() {
  static const JointFrame frame{};
  return frame;
}

const JointFrame& frame_of(const Segment* segment, std::size_t t) {
  return segment == nullptr ? still() : segment->at[t];
}

// What moves a cross section at one instant: x -> shift + turn x.
BlendedFrame blended(const Mix& mix, std::size_t t) {
  return blend_of(mix, [t](const Segment* segment) -> const JointFrame& { return frame_of(segment, t); });
}

double way_of(const Axis& axis, int at) { return at < 0 ? axis.held : axis.reached[index_of(at)]; }

// So many of them, the heaviest first, that add up to 1.
Mix heaviest(std::span<Term> terms, int most) {
  std::stable_sort(terms.begin(), terms.end(),
                   [](const Term& a, const Term& b) { return a.weight > b.weight; });
  Mix mix{.count = 0};
  double sum = 0;
  for (const Term& term : terms) {
    if (mix.count == most || !(term.weight > 1e-6)) break;
    mix.terms[index_of(mix.count++)] = term;
    sum += term.weight;
  }
  for (int i = 0; i < mix.count; ++i) mix.terms[index_of(i)].weight /= sum;
  return mix;
}

// Quadratic B-splines on the knots: those of the segment, of the one before (the base, for the first) and of
// the one after. The last goes straight on.
Mix mix_of(const Axis& axis, const Mix& base, std::span<const Segment> segments, double way) {
  if (segments.empty() || way <= axis.held) return base;
  std::size_t i = 0;
  while (i + 1 < segments.size() && way > way_of(axis, segments[i].to)) ++i;
  const double from = way_of(axis, segments[i].from), to = way_of(axis, segments[i].to);
  const double before = i == 0 ? from : way_of(axis, segments[i - 1].from);
  const bool last = i + 1 == segments.size();
  const double after = last ? to : way_of(axis, segments[i + 1].to);
  const double left = std::max(to - way, 0.0), gone = way - from, length = to - from;
  double back = 1, on = 0;
  if (length > 0) {
    back = left * left / (length * (to - before));
    on = last ? 0 : gone * gone / (length * (after - from));
  }
  std::array<Term, 6> terms{};
  std::size_t count = 0;
  terms[count++] = {&segments[i], 1 - back - on};
  if (!last) terms[count++] = {&segments[i + 1], on};
  if (i > 0) {
    terms[count++] = {&segments[i - 1], back};
  } else {
    for (const Term& term : base.all()) terms[count++] = {term.segment, back * term.weight};
  }
  return heaviest({terms.data(), count}, 4);
}

// What an axis with joints of its own is blended into, so that it has room for two of these.
Mix two_of(Mix mix) { return heaviest({mix.terms.data(), mix.all().size()}, 2); }

// A segment between two places of the axis, and where its middle is.
Segment make_segment(const Places& places, const Axis& axis, int from, int to) {
  Segment segment;
  segment.rest = from < 0 ? axis.start : places.rest[index_of(axis.places[index_of(from)])];
  segment.chord = places.rest[index_of(axis.places[index_of(to)])] - segment.rest;
  segment.from = from;
  segment.to = to;
  const double middle = 0.5 * (way_of(axis, from) + way_of(axis, to));
  segment.high = from < 0 ? axis.free : from + 1;
  while (segment.high < to && way_of(axis, segment.high) < middle) ++segment.high;
  segment.low = segment.high == axis.free ? -1 : segment.high - 1;
  const double low = way_of(axis, segment.low), high = way_of(axis, segment.high);
  segment.part = high > low ? std::clamp((middle - low) / (high - low), 0.0, 1.0) : 0;
  return segment;
}

// Turned from the middle between two frames so that it takes the chord at rest to where the next knot is.
JointFrame aimed(const Segment& segment, const Vec3& knot, const Mat3& middle, const Vec3& next) {
  const Vec3 chord = next - knot;
  if (!(segment.chord.norm() > 0) || !(chord.norm() > 0)) return {knot, middle};
  return {knot, shortest_turn(middle * segment.chord.normalized(), chord.normalized()) * middle};
}

Mat3 between(const Mat3& low, const Mat3& high, double part) {
  return low * rotation_matrix(part * rotation_vector(low.transpose() * high));
}

constexpr double any_error = std::numeric_limits<double>::infinity();

// What the skin may be stretched by blending, 2 % with what bends rightly do to it.
constexpr double most_stretch = 0.0115;

// How far a place that carries joints may turn from where it should be (rad): blending from there to another
// turn stretches the skin by a quarter of the square of the difference.
constexpr double most_turn = 0.15;

// What an axis with joints may be off the skin that it springs from, as a part of the tolerance.
constexpr double most_gap = 0.1;

// The fit of one axis, given what carries it.
class AxisFitter {
 public:
  AxisFitter(const Places& places, const PlacePoses& poses, const std::vector<char>& carries_joints,
             const Axis& axis, const Mix& carrier, double tolerance)
      : places_(places),
        poses_(poses),
        carries_joints_(carries_joints),
        axis_(axis),
        carrier_(carrier),
        base_(two_of(carrier)),
        tolerance_(tolerance) {}

  // Within the tolerance first; then, as far as more joints help, without stretching the skin.
  std::vector<Segment> fit() {
    if (worst_place({}, tolerance_).error <= tolerance_) return {};
    const auto at_places = [this](Segments segments, const auto& visit) { for_places(segments, visit); };
    const auto stretches = [this](Segments segments, const auto& visit) { for_stretches(segments, visit); };
    std::vector<int> knots = refined({last()}, tolerance_, at_places, 6);
    if (!within_tolerance(knots)) knots = halved(knots, tolerance_, at_places);
    leave_out(knots);
    std::vector<int> more = refined(knots, most_stretch, stretches, 4);
    if (worst_of(stretches, segments_of(more), most_stretch).error > most_stretch)
      more = halved(more, most_stretch, stretches);
    // A leaf on a new knot may be worse off between two joints than it was on one.
    if (!within_tolerance(more) && within_tolerance(knots)) {
      more = refined(more, tolerance_, at_places, 6);
      if (!within_tolerance(more)) more = knots;
    }
    return segments_of(more);
  }

 private:
  using Segments = std::span<const Segment>;
  struct Trial {
    double error = 0;
    int at = 0;  // where it is worst, by the order of places
  };

  int last() const { return static_cast<int>(axis_.places.size()) - 1; }

  // More knots until no error is more than so much, or they stop to help. for_errors(segments, visit) calls
  // visit(place by its order, error) for all errors, as long as that returns true.
  template <class ForErrors>
  std::vector<int> refined(std::vector<int> knots, double most, const ForErrors& for_errors, int patience) {
    Trial trial = worst_of(for_errors, segments_of(knots), any_error);
    std::vector<int> best = knots;
    double least = trial.error;
    for (int in_vain = 0; trial.error > most && in_vain < patience;) {
      if (static_cast<int>(knots.size()) > last() - axis_.free) break;
      trial = with_one_more(knots, trial, for_errors);
      ++in_vain;
      if (trial.error > 0.95 * least) continue;
      in_vain = 0;
      least = trial.error;
      best = knots;
    }
    return best;
  }

  std::vector<Segment> segments_of(const std::vector<int>& knots) {
    std::vector<Segment> segments;
    int from = -1;
    for (const int to : knots) {
      segments.push_back(make_segment(places_, axis_, from, to));
      from = to;
    }
    hook(segments.front());
    for (std::size_t i = 1; i < segments.size(); ++i) segments[i].hook.terms[0].segment = &segments[i - 1];
    for (Segment& segment : segments) {
      segment.at.resize(poses_.instants);
      const std::vector<Mat3>& middle = middles_of(segment);
      const int next = axis_.places[index_of(segment.to)];
      for (std::size_t t = 0; t < poses_.instants; ++t) {
        const BlendedFrame frame = blended(segment.hook, t);
        segment.at[t] =
            aimed(segment, frame.shift + frame.turn * segment.rest, middle[t], poses_.position_of(next, t));
      }
    }
    return segments;
  }

  // (T) Trials have the same pieces of the axis over and over.
  const std::vector<Mat3>& middles_of(const Segment& segment) {
    std::vector<Mat3>& middles = middles_[{segment.from, segment.to}];
    const auto frame_at = [&](int at, std::size_t t) {
      return poses_.frame_of(at < 0 ? axis_.base : axis_.places[index_of(at)], t);
    };
    for (std::size_t t = middles.size(); t < poses_.instants; ++t)
      middles.push_back(between(frame_at(segment.low, t), frame_at(segment.high, t), segment.part));
    return middles;
  }

  // The first joint hangs on one segment where that takes it nearly along with the skin there, and otherwise
  // travels with the skin: so near that blending one into the other stretches nothing.
  void hook(Segment& first) const {
    constexpr double share_of_tolerance = 0.05, stretch = 0.002;
    const Mix alone{.terms = {Term{base_.terms[0].segment, 1}}};
    const double most = std::min(share_of_tolerance * tolerance_, stretch * way_of(axis_, first.to));
    double off = 0;
    for (std::size_t t = 0; t < poses_.instants && base_.count > 1; ++t) {
      const BlendedFrame skin = blended(base_, t), hung = blended(alone, t);
      off = std::max(off, (skin.shift - hung.shift + (skin.turn - hung.turn) * first.rest).norm());
    }
    first.hook = off > most ? base_ : alone;
  }

  // How far off a place is at worst, with what reaches from it.
  double error_at(int place, const Mix& mix) const {
    const Vec3& rest = places_.rest[index_of(place)];
    const double reach = places_.reach[index_of(place)];
    double error = 0;
    for (std::size_t t = 0; t < poses_.instants; ++t) {
      const BlendedFrame frame = blended(mix, t);
      const double off = (frame.shift + frame.turn * rest - poses_.position_of(place, t)).norm();
      const double turned = std::sqrt(0.5) * (frame.turn - poses_.frame_of(place, t)).norm();
      error = std::max(error, off + reach * turned);
      if (carries_joints_[index_of(place)] == 0) continue;
      error = std::max(error, tolerance_ / most_turn * turned);
      if (mix.count < 3) continue;
      const BlendedFrame near = blended(two_of(mix), t);
      const Vec3 gap = frame.shift - near.shift + (frame.turn - near.turn) * rest;
      error = std::max(error, gap.norm() / most_gap);
    }
    return error;
  }

  // Calls visit(place by its order, error) for all places and leaves, as long as it returns true.
  template <class Visit>
  void for_places(Segments segments, const Visit& visit) const {
    const Mix& base = segments.empty() ? carrier_ : base_;
    for (int i = 0; i <= last(); ++i) {
      const Mix mix = mix_of(axis_, base, segments, way_of(axis_, i));
      if (!visit(i, error_at(axis_.places[index_of(i)], mix))) return;
    }
    for (std::size_t i = 0; i < axis_.leaves.size(); ++i) {
      const Mix mix = stiffened(mix_of(axis_, base, segments, axis_.leaf_way[i]), poses_.instants);
      if (!visit(place_beyond(axis_.leaf_way[i]), error_at(axis_.leaves[i], mix))) return;
    }
  }

  // Any that is too bad is bad enough.
  template <class ForErrors>
  Trial worst_of(const ForErrors& for_errors, Segments segments, double too_bad) const {
    Trial trial;
    for_errors(segments, [&](int at, double error) {
      if (error > trial.error) trial = {error, at};
      return trial.error <= too_bad;
    });
    return trial;
  }
  Trial worst_place(Segments segments, double too_bad) const {
    return worst_of([this](Segments all, const auto& visit) { for_places(all, visit); }, segments, too_bad);
  }

  bool within_tolerance(const std::vector<int>& knots) {
    return worst_place(segments_of(knots), tolerance_).error <= tolerance_;
  }

  int place_beyond(double way) const {
    const auto at = std::lower_bound(axis_.reached.begin(), axis_.reached.end(), way);
    return std::min(last(), static_cast<int>(at - axis_.reached.begin()));
  }

  template <class Visit>
  void for_stretches(Segments segments, const Visit& visit) const {
    for (int i = 0; i <= last(); ++i) {
      if (!visit(i, stretch_before(i, segments))) return;
    }
  }

  // By how much, at worst, the skin is stretched between a place and the one before, as a part of its length;
  // and what shares in whole 255ths add to that.
  double stretch_before(int at, Segments segments) const {
    static constexpr std::array<double, 5> on_first{0, 0.125, 0.25, 0.5, 1};
    static constexpr std::array<double, 3> later{0, 0.5, 1};
    constexpr double for_rounded = most_stretch / 0.018;
    const std::span<const double> parts = at == 0 ? std::span<const double>(on_first) : later;
    const Vec3 from = at == 0 ? axis_.foot : places_.rest[index_of(axis_.places[index_of(at - 1)])];
    const Vec3 way = places_.rest[index_of(axis_.places[index_of(at)])] - from;
    const double begin = at == 0 ? 0 : way_of(axis_, at - 1), length = way_of(axis_, at) - begin;
    if (!(length > 1e-4)) return 0;
    std::array<Mix, on_first.size()> mixes;
    for (std::size_t i = 0; i < parts.size(); ++i)
      mixes[i] = mix_of(axis_, base_, segments, begin + parts[i] * length);
    double most = 0;
    constexpr std::size_t every = 2;  // instants are many and much alike
    for (std::size_t t = 0; t < poses_.instants; t += every) {
      Vec3 last = Vec3::Zero();
      for (std::size_t i = 0; i < parts.size(); ++i) {
        const Moved here = moved(mixes[i], from + parts[i] * way, t);
        const Vec3 edge = here.to - last;
        last = here.to;
        if (i == 0) continue;
        const double rest = (parts[i] - parts[i - 1]) * way.norm();
        const double rounded = std::max((edge + here.step).norm(), (edge - here.step).norm());
        most = std::max({most, edge.norm() / rest - 1, for_rounded * (rounded / rest - 1)});
      }
    }
    return most;
  }

  // Where a mix takes a point at rest, and how much farther where a share is larger by its smallest step.
  struct Moved {
    Vec3 to = Vec3::Zero(), step = Vec3::Zero();
  };
  static Moved moved(const Mix& mix, const Vec3& rest, std::size_t t) {
    Moved sum;
    Vec3 by_first = Vec3::Zero();
    for (const Term& term : mix.all()) {
      const JointFrame& frame = frame_of(term.segment, t);
      const Vec3 joint = term.segment == nullptr ? Vec3::Zero() : term.segment->rest;
      const Vec3 there = frame.position + frame.turn * (rest - joint);
      if (&term == mix.terms.data()) by_first = there;
      sum.to += term.weight * there;
      const Vec3 step = (there - by_first) / 255;
      if (step.squaredNorm() > sum.step.squaredNorm()) sum.step = step;
    }
    return sum;
  }

  // The place nearest to the middle between two, itself neither; -1 where there is none.
  int middle(int from, int to) const {
    int best = -1;
    const double wanted = 0.5 * (way_of(axis_, from) + way_of(axis_, to));
    for (int i = from < 0 ? axis_.free : from + 1; i < to; ++i) {
      if (best < 0 || std::abs(way_of(axis_, i) - wanted) < std::abs(way_of(axis_, best) - wanted)) best = i;
    }
    return best;
  }

  // Splits where that helps most: at the worst place, or in the middle of its segment or of a neighbour.
  template <class ForErrors>
  Trial with_one_more(std::vector<int>& knots, const Trial& before, const ForErrors& for_errors) {
    const auto i = static_cast<int>(std::lower_bound(knots.begin(), knots.end(), before.at) - knots.begin());
    std::vector<int> candidates{std::max(before.at, axis_.free)};
    for (const int k : {i, i - 1, i + 1}) {
      if (k >= 0 && k < static_cast<int>(knots.size())) candidates.push_back(middle_of(knots, k));
    }
    Trial best{.error = -1};
    std::vector<int> chosen;
    const auto consider = [&](int candidate) {
      if (candidate < 0 || std::binary_search(knots.begin(), knots.end(), candidate)) return;
      std::vector<int> more = knots;
      more.insert(std::lower_bound(more.begin(), more.end(), candidate), candidate);
      const Trial trial = worst_of(for_errors, segments_of(more), best.error < 0 ? any_error : best.error);
      if (best.error >= 0 && trial.error >= best.error) return;
      best = trial;
      chosen = more;
    };
    for (const int candidate : candidates) consider(candidate);
    // Where nothing is left to split there, anywhere.
    for (int k = axis_.free; best.error < 0 && k <= last(); ++k) consider(k);
    knots = chosen;
    return best;
  }

  // The place nearest to the middle of a segment, neither of its ends; -1 where there is none.
  int middle_of(const std::vector<int>& knots, int segment) const {
    return middle(segment == 0 ? -1 : knots[index_of(segment - 1)], knots[index_of(segment)]);
  }

  // Where no knot helps alone, as on an axis that winds, or where a place that nothing helps hides the
  // others: halves all segments that have too large an error, again and again, as long as there are any.
  template <class ForErrors>
  std::vector<int> halved(std::vector<int> knots, double most, const ForErrors& for_errors) {
    std::vector<int> best = knots;
    double least = any_error;
    for (std::vector<int> more;; knots = more) {
      more = knots;
      double excess = 0;
      for_errors(segments_of(knots), [&](int at, double error) {
        if (error <= most) return true;
        excess += error - most;
        const auto i = std::lower_bound(knots.begin(), knots.end(), at) - knots.begin();
        const int between = middle_of(knots, static_cast<int>(i));
        const auto place = std::lower_bound(more.begin(), more.end(), between);
        if (between >= 0 && (place == more.end() || *place != between)) more.insert(place, between);
        return true;
      });
      if (excess < 0.95 * least) {
        least = excess;
        best = knots;
      }
      if (more.size() == knots.size()) return best;
    }
  }

  // Knots that later ones made idle.
  void leave_out(std::vector<int>& knots) {
    for (std::size_t k = 0; k + 1 < knots.size();) {
      std::vector<int> fewer;
      for (const int knot : knots) {
        if (knot != knots[k]) fewer.push_back(knot);
      }
      if (keeps(segments_of(fewer), knots[k])) {
        knots = fewer;
      } else {
        ++k;
      }
    }
  }

  // Within the tolerance, most likely not at this place.
  bool keeps(Segments segments, int doubtful) const {
    const Mix mix = mix_of(axis_, base_, segments, way_of(axis_, doubtful));
    return error_at(axis_.places[index_of(doubtful)], mix) <= tolerance_ &&
           worst_place(segments, tolerance_).error <= tolerance_;
  }

  const Places& places_;
  const PlacePoses& poses_;
  const std::vector<char>& carries_joints_;
  const Axis& axis_;
  Mix carrier_, base_;
  double tolerance_;
  std::map<std::pair<int, int>, std::vector<Mat3>> middles_;  // by the places where a segment starts and ends
};

// Whether a place stays where its carrier's own frame would take it.
bool rides(const Places& places, const PlacePoses& poses, int place, int on, double tolerance) {
  const Vec3 arm = places.rest[index_of(place)] - places.rest[index_of(on)];
  const double reach = places.reach[index_of(place)];
  for (std::size_t t = 0; t < poses.instants; ++t) {
    const Mat3 frame = poses.frame_of(on, t);
    const double off = (poses.position_of(on, t) + frame * arm - poses.position_of(place, t)).norm();
    const double turned = std::sqrt(0.5) * (frame - poses.frame_of(place, t)).norm();
    if (off + reach * turned > tolerance) return false;
  }
  return true;
}

// (P) The places that carry axes which will have joints, or others that will.
std::vector<char> joint_carriers(const Places& places, const Axes& axes, const PlacePoses& poses,
                                 double tolerance) {
  const std::size_t count = axes.axes.size();
  std::vector<char> bends(count), carries(places.branch.size());
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t a) {
    const Axis& axis = axes.axes[a];
    for (const std::vector<int>* some : {&axis.places, &axis.leaves}) {
      for (auto it = some->rbegin(); it != some->rend() && bends[a] == 0; ++it)
        bends[a] = rides(places, poses, *it, axis.base, tolerance) ? 0 : 1;
    }
  });
  for (std::size_t a = count; a-- > 0;) {
    if (bends[a] == 0) continue;
    const Axis& axis = axes.axes[a];
    carries[index_of(axis.base)] = 1;
    if (!axis.is_stem) bends[index_of(axes.of_branch[index_of(places.branch[index_of(axis.base)])])] = 1;
  }
  return carries;
}

std::vector<JointFrame> frames_of_place(const PlacePoses& poses, int place) {
  std::vector<JointFrame> frames(poses.instants);
  for (std::size_t t = 0; t < poses.instants; ++t)
    frames[t] = {poses.position_of(place, t), poses.frame_of(place, t)};
  return frames;
}

bool moves(const std::vector<JointFrame>& frames, const Vec3& rest) {
  return std::any_of(frames.begin(), frames.end(), [&](const JointFrame& frame) {
    return (frame.position - rest).norm() > 1e-6 || (frame.turn - Mat3::Identity()).norm() > 1e-6;
  });
}

// A stem stands on the root, or on a joint of its own where the ground gives way.
void stand(const Places& places, const Axis& axis, const PlacePoses& poses, AxisFit& fit) {
  const Vec3& rest = places.rest[index_of(axis.base)];
  std::vector<JointFrame> frames = frames_of_place(poses, axis.base);
  if (!moves(frames, rest)) return;
  fit.foot = std::make_unique<Segment>(Segment{.rest = rest, .is_foot = true, .at = std::move(frames)});
  fit.base.terms[0].segment = fit.foot.get();
}

}  // namespace

Mix mix_at(const Axis& axis, const AxisFit& fit, double way) {
  return mix_of(axis, fit.base, fit.segments, way);
}

Mix stiffened(const Mix& mix, std::size_t instants) {
  constexpr double most_lost = 0.007;  // of the area
  if (mix.count < 2) return mix;
  // A blend of rotations keeps lengths along their common axis, and shrinks those across it by a factor whose
  // square is (|turn|^2 - 1) / 2: a parabola in the share of the mix, 1 where the heaviest moves all.
  double share = 1;
  for (std::size_t t = 0; t < instants; t += 2) {
    const Mat3& first = frame_of(mix.terms[0].segment, t).turn;
    const Mat3 others = blended(mix, t).turn - first;
    const double falls = -first.cwiseProduct(others).sum(), square = others.squaredNorm();
    if (share * (falls - 0.5 * share * square) <= most_lost) continue;
    share = 2 * most_lost / (falls + std::sqrt(std::max(0.0, falls * falls - 2 * most_lost * square)));
  }
  if (share == 1) return mix;
  Mix result = mix;
  for (int i = 0; i < mix.count; ++i) result.terms[index_of(i)].weight *= share;
  result.terms[0].weight += 1 - share;
  return result;
}

void release_bent_collars(const PlacePoses& poses, double tolerance, Axes& axes) {
  constexpr double most_turn = 0.1, share_of_tolerance = 0.3;  // (rad)
  for (Axis& axis : axes.axes) {
    if (axis.held == 0) continue;
    const int beyond = axis.places[index_of(axis.free)];
    double turned = 0;
    for (std::size_t t = 0; t < poses.instants; ++t) {
      const Mat3 difference = poses.frame_of(beyond, t) - poses.frame_of(axis.base, t);
      turned = std::max(turned, std::sqrt(0.5) * difference.norm());
    }
    turned *= axis.held / axis.reached[index_of(axis.free)];
    if (turned < most_turn && turned * axis.held < share_of_tolerance * tolerance) continue;
    axis.held = 0;
    axis.free = 0;
    axis.start = axis.foot;
  }
}

JointFrame segment_frame(const Axis& axis, const Segment& segment, const Vec3& knot,
                         const PoseOfPlace& pose) {
  const auto frame_at = [&](int at) { return pose(at < 0 ? axis.base : axis.places[index_of(at)]).frame; };
  const Mat3 middle = between(frame_at(segment.low), frame_at(segment.high), segment.part);
  return aimed(segment, knot, middle, pose(axis.places[index_of(segment.to)]).position);
}

std::vector<AxisFit> fit_axes(const Places& places, const Axes& axes, const PlacePoses& poses,
                              double tolerance) {
  const std::vector<char> carries = joint_carriers(places, axes, poses, tolerance);
  std::vector<AxisFit> fits(axes.axes.size());
  std::vector<std::vector<std::size_t>> levels;
  for (std::size_t a = 0; a < fits.size(); ++a) {
    const auto depth = index_of(axes.axes[a].depth);
    if (levels.size() <= depth) levels.resize(depth + 1);
    levels[depth].push_back(a);
  }
  for (const std::vector<std::size_t>& level : levels) {
    tbb::parallel_for(std::size_t{0}, level.size(), [&](std::size_t i) {
      const Axis& axis = axes.axes[level[i]];
      AxisFit& fit = fits[level[i]];
      if (axis.is_stem) {
        stand(places, axis, poses, fit);
      } else {
        const int k = places.branch[index_of(axis.base)];
        const auto carrier = index_of(axes.of_branch[index_of(k)]);
        const Axis& below = axes.axes[carrier];
        const auto at = std::lower_bound(below.places.begin(), below.places.end(), axis.base);
        fit.base = mix_at(below, fits[carrier], below.reached[index_of(at - below.places.begin())]);
      }
      const Mix carrier = fit.base;
      fit.segments = AxisFitter(places, poses, carries, axis, carrier, tolerance).fit();
      if (!fit.segments.empty()) fit.base = two_of(carrier);
    });
  }
  return fits;
}

}  // namespace tremula::rig
