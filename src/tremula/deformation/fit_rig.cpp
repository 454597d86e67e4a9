#include "tremula/deformation/fit_rig.hpp"

#include "tremula/base/check.hpp"
#include "tremula/deformation/bent_pose.hpp"
#include "tremula/deformation/rig_joints.hpp"
#include "tremula/deformation/rig_tracks.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>

#include <tbb/parallel_for.h>

namespace tremula {
namespace {

using rig::Axes;
using rig::Axis;
using rig::AxisFit;
using rig::Mix;
using rig::PlacePoses;
using rig::Places;
using rig::Segment;
using rig::Term;

struct Instant {
  std::size_t clip;
  double time;
};

void check(const Structure& structure, const Surface& surface, std::span<const ClipSource> clips,
           const RigOptions& options) {
  if (clips.empty()) throw InputError("clips of the rig", "0", "1 or more");
  if (structure.tree == nullptr) throw InputError("structure that gets bones", "a frame", "a tree");
  if (!(options.tolerance > 0) || !std::isfinite(options.tolerance)) {
    throw InputError("tolerance of the rig", std::to_string(options.tolerance), "metres above 0");
  }
  if (options.max_joints < 0 || options.max_joints == 1) {
    throw InputError("most joints of the rig", std::to_string(options.max_joints),
                     "2 or more (0: as many as it takes)");
  }
  if (options.shapes_of < -1 || options.shapes_of >= static_cast<int>(clips.size())) {
    throw InputError("clip whose shapes the rig tells", std::to_string(options.shapes_of),
                     "-1 (none) to " + std::to_string(clips.size() - 1));
  }
  for (const ClipSource& clip : clips) {
    check_motion(*clip.motion);
    if (clip.motion->lean_strains.size() == 0) {
      throw InputError("motion of clip '" + clip.name + "'", "displacements that superpose",
                       "one that bends (Motion::lean_strains)");
    }
  }
  const auto vertices = static_cast<std::ptrdiff_t>(surface.vertex_count());
  check_equal("branches of the vertices", static_cast<std::ptrdiff_t>(surface.branch.size()), vertices);
  check_equal("places along the branches", static_cast<std::ptrdiff_t>(surface.along.size()), vertices);
  for (const std::int32_t k : surface.branch) {
    if (k < 0 || static_cast<std::size_t>(k) >= structure.members.size()) {
      throw InputError("branch of a vertex", std::to_string(k),
                       "0 to " + std::to_string(structure.members.size() - 1));
    }
  }
}

double time_of(const Motion& motion, double sample) { return motion.period * sample / motion.sample_count(); }

// So many samples, each as far as may be from all before it in what the shapes move, the first the farthest
// from the lean.
std::vector<double> telling_times(const Motion& motion, std::size_t most) {
  Eigen::MatrixXd coordinates = motion.coordinates;
  for (Eigen::Index c = 0; c < coordinates.cols(); ++c) {
    const bool lean = motion.basis.kind[index_of(c)] == ShapeKind::lean;
    coordinates.col(c) *= lean ? 0 : motion.basis.columns.col(c).lpNorm<Eigen::Infinity>();
  }
  Eigen::VectorXd distance = coordinates.rowwise().norm();
  std::vector<double> times;
  Eigen::Index farthest = 0;
  while (times.size() < most && (distance.maxCoeff(&farthest) > 0 || times.empty())) {
    times.push_back(time_of(motion, static_cast<double>(farthest)));
    const Eigen::VectorXd from = (coordinates.rowwise() - coordinates.row(farthest)).rowwise().norm();
    distance = times.size() == 1 ? from : Eigen::VectorXd(distance.cwiseMin(from));
  }
  return times;
}

// Others, most of them between samples.
std::vector<double> checking_times(const Motion& motion, std::size_t count) {
  std::vector<double> times = telling_times(motion, count / 4);
  const std::size_t rest = count - std::min(count, times.size());
  for (std::size_t i = 0; i < rest; ++i)
    times.push_back(motion.period * (static_cast<double>(i) + 0.618) / static_cast<double>(rest));
  return times;
}

template <class TimesOf>
std::vector<Instant> instants_of(std::span<const ClipSource> clips, const TimesOf& times_of) {
  std::vector<Instant> instants;
  for (std::size_t c = 0; c < clips.size(); ++c) {
    for (const double time : times_of(*clips[c].motion)) instants.push_back({c, time});
  }
  return instants;
}

// What is asked for, and what does not depend on the tolerance.
struct Task {
  const Structure& structure;
  const Surface& surface;
  std::span<const ClipSource> clips;
  std::vector<BentLean> leans;
  std::vector<double> tolerance;  // of every clip [m]
  Places places;
  Axes axes;
  std::vector<Instant> instants;  // that joints are chosen for
  PlacePoses poses;               // at these
  std::vector<Instant> checks;

  double largest_tolerance() const { return *std::max_element(tolerance.begin(), tolerance.end()); }
};

using Pose = std::vector<BentBranch>;

// bent_at for a few instants of one clip: the shapes, most of the memory there is to read, are read once.
std::vector<Pose> poses_at(const Task& task, std::span<const Instant> instants) {
  const std::size_t clip = instants.front().clip;
  const BentLean& lean = task.leans[clip];
  const Motion& motion = *task.clips[clip].motion;
  const auto count = static_cast<Eigen::Index>(instants.size());
  Eigen::MatrixXd coordinates(motion.basis.columns.cols(), count);
  for (Eigen::Index i = 0; i < count; ++i) {
    coordinates.col(i) = coordinates_at(motion, instants[index_of(i)].time);
    for (std::size_t c = 0; c < motion.basis.kind.size(); ++c) {
      if (motion.basis.kind[c] == ShapeKind::lean) coordinates(static_cast<Eigen::Index>(c), i) = 0;
    }
  }
  Eigen::MatrixXd displacement(motion.basis.columns.rows(), count);
  constexpr Eigen::Index together = 6 * 512;
  const Eigen::Index rows = displacement.rows();
  tbb::parallel_for(Eigen::Index{0}, (rows + together - 1) / together, [&](Eigen::Index block) {
    const Eigen::Index first = block * together, size = std::min(together, rows - first);
    displacement.middleRows(first, size).noalias() =
        motion.basis.columns.middleRows(first, size) * coordinates;
  });
  std::vector<Pose> poses(instants.size());
  tbb::parallel_for(std::size_t{0}, poses.size(), [&](std::size_t i) {
    const Eigen::VectorXd moved = displacement.col(static_cast<Eigen::Index>(i));
    poses[i] = bend(*lean.tree, lean.strains + strains_about(*lean.tree, lean.maps, moved));
  });
  return poses;
}

// Calls visit(first, poses) with the poses at instants from `first` on, a few at a time.
template <class Visit>
void for_poses(const Task& task, std::span<const Instant> instants, const Visit& visit) {
  constexpr std::size_t most = 4;
  for (std::size_t first = 0, end = 0; first < instants.size(); first = end) {
    for (end = first + 1; end < instants.size() && end - first < most;) {
      if (instants[end].clip != instants[first].clip) break;
      ++end;
    }
    visit(first, poses_at(task, instants.subspan(first, end - first)));
  }
}

// How far branches go in a clip, by its telling instants.
struct Survey {
  double sway = 0;  // of any end of a branch, from one side to the other; where none sways, from
                    // where it rests [m]
  std::vector<double> sag, turn;  // (N) of a branch between its ends, in its own frame [m], [rad]
};

Survey survey(const Task& task, std::size_t clip) {
  const BeamTree& tree = *task.structure.tree;
  const auto count = index_of(tree.branch_count());
  std::vector<Instant> instants;
  for (const double time : telling_times(*task.clips[clip].motion, 16)) instants.push_back({clip, time});
  constexpr double far = std::numeric_limits<double>::max();
  std::vector<Vec3> low(count, Vec3::Constant(far)), high(count, Vec3::Constant(-far));
  std::vector<double> lean(count);
  Survey seen{0, std::vector<double>(count), std::vector<double>(count)};
  for_poses(task, instants, [&](std::size_t, const std::vector<Pose>& poses) {
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t k) {
      for (const Pose& pose : poses) {
        const BentBranch& branch = pose[k];
        low[k] = low[k].cwiseMin(branch.end);
        high[k] = high[k].cwiseMax(branch.end);
        lean[k] = std::max(lean[k], (branch.end - tree.members[k].point(1)).norm());
        const double turned = std::sqrt(0.5) * (branch.end_frame - branch.start_frame).norm();
        const double leant = std::sqrt(0.5) * (branch.chord_frame - branch.start_frame).norm();
        seen.turn[k] = std::max(seen.turn[k], turned);
        seen.sag[k] = std::max(seen.sag[k], (0.5 * turned + leant) * tree.members[k].beam.length / 8);
      }
    });
  });
  for (std::size_t k = 0; k < count; ++k) seen.sway = std::max(seen.sway, (high[k] - low[k]).norm());
  if (seen.sway == 0) seen.sway = *std::max_element(lean.begin(), lean.end());
  return seen;
}

double tolerance_of(const Survey& seen, double tolerance) {
  constexpr double share_of_sway = 0.1, least_share = 0.05;  // of the sway, of the tolerance
  return std::clamp(share_of_sway * seen.sway, least_share * tolerance, tolerance);
}

// A branch that bends far between its ends gets places for joints on it.
std::vector<int> pieces_of(const Task& task, const std::vector<Survey>& surveys, double tolerance) {
  const BeamTree& tree = *task.structure.tree;
  constexpr double most_turn = 0.5;  // of what is blended (rad)
  std::vector<int> pieces(tree.members.size(), 1);
  const std::vector<double> reach = reach_of_branches(rig::find_places(tree, task.surface, pieces));
  for (std::size_t k = 0; k < pieces.size(); ++k) {
    double turned = 0, sag = 0;
    for (const Survey& seen : surveys) {
      turned = std::max(turned, seen.turn[k]);
      sag = std::max(sag, seen.sag[k]);
    }
    const double wanted =
        std::max({std::sqrt(2 * sag / tolerance), turned / most_turn, turned * reach[k] / tolerance});
    pieces[k] = static_cast<int>(std::clamp(std::ceil(wanted), 1.0, 8.0));
  }
  return pieces;
}

// How places move at these instants, after those that are known.
void add_poses(const Task& task, std::span<const Instant> instants, PlacePoses& known) {
  const auto count = index_of(task.places.count());
  const std::size_t before = known.instants, all = before + instants.size();
  PlacePoses poses{all, {}, {}};
  poses.position.resize(count * all);
  poses.frame.resize(count * all);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t p) {
    for (std::size_t t = 0; t < before; ++t) {
      poses.position[p * all + t] = known.position[p * before + t];
      poses.frame[p * all + t] = known.frame[p * before + t];
    }
  });
  for_poses(task, instants, [&](std::size_t first, const std::vector<Pose>& some) {
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t p) {
      for (std::size_t t = 0; t < some.size(); ++t) {
        const rig::PlacePose pose =
            rig::pose_of(*task.structure.tree, task.places, some[t], static_cast<int>(p));
        poses.position[p * all + before + first + t] = pose.position.cast<float>();
        poses.frame[p * all + before + first + t] = pose.frame.cast<float>();
      }
    });
  });
  known = std::move(poses);
}

Task make_task(const Structure& structure, const Surface& surface, std::span<const ClipSource> clips,
               double tolerance) {
  Task task{structure, surface, clips, {}, {}, {}, {}, {}, {}, {}};
  for (const ClipSource& clip : clips) task.leans.push_back(bend_lean(structure, *clip.motion));
  std::vector<Survey> surveys;
  for (std::size_t c = 0; c < clips.size(); ++c) {
    surveys.push_back(survey(task, c));
    task.tolerance.push_back(tolerance_of(surveys.back(), tolerance));
  }
  tolerance = task.largest_tolerance();
  // So many that a large scan fills neither the memory nor the time.
  const double room =
      2e6 / (static_cast<double>(structure.members.size()) * static_cast<double>(clips.size()));
  const auto each = static_cast<std::size_t>(std::clamp(room, 16.0, 48.0));
  task.places = rig::find_places(*structure.tree, surface, pieces_of(task, surveys, tolerance));
  task.axes = rig::find_axes(*structure.tree, task.places, surface);
  task.instants = instants_of(clips, [each](const Motion& motion) { return telling_times(motion, each); });
  add_poses(task, task.instants, task.poses);
  rig::release_bent_collars(task.poses, tolerance, task.axes);
  task.checks = instants_of(clips, [each](const Motion& motion) {
    return checking_times(motion, std::min<std::size_t>(each, 36));
  });
  return task;
}

// "0012" in a tree of 4979, so that names sort as their branches do.
std::string joint_name(const Places& places, const Axis& axis, const Segment& segment, int branch_count) {
  const auto width = static_cast<int>(std::to_string(branch_count - 1).size());
  const int place =
      segment.is_foot || segment.from < 0 ? axis.places.front() : axis.places[index_of(segment.from)];
  const int k = places.branch[index_of(place)];
  char text[64];
  if (segment.is_foot) {
    std::snprintf(text, sizeof text, "foot %0*d", width, k);
  } else if (segment.from < 0) {
    std::snprintf(text, sizeof text, "branch %0*d", width, k);
  } else {
    const auto hundredths = static_cast<int>(std::lround(100 * places.s[index_of(place)]));
    std::snprintf(text, sizeof text, "branch %0*d at %d.%02d", width, k, hundredths / 100, hundredths % 100);
  }
  return text;
}

// Numbers the segments and lists them as joints. Parents come first as axes do.
rig::Joints number_joints(const Task& task, std::vector<AxisFit>& fits, std::vector<RigJoint>& joints) {
  rig::Joints chosen;
  joints = {{.parent = -1, .position = Vec3::Zero(), .name = "root"}};
  const int branch_count = task.structure.tree->branch_count();
  const auto add = [&](std::size_t a, Segment& segment) {
    segment.joint = static_cast<int>(joints.size());
    joints.push_back({segment.parent() == nullptr ? 0 : segment.parent()->joint, segment.rest,
                      joint_name(task.places, task.axes.axes[a], segment, branch_count), segment.travels()});
    chosen.segments.push_back(&segment);
    chosen.axis.push_back(static_cast<int>(a));
  };
  for (std::size_t a = 0; a < fits.size(); ++a) {
    if (fits[a].foot) add(a, *fits[a].foot);
    for (Segment& segment : fits[a].segments) add(a, segment);
  }
  return chosen;
}

// In 255ths that add up: what rounding down leaves goes to the largest remainders.
JointShares shares_of(const Mix& mix) {
  JointShares shares;
  std::array<double, 4> rest{};
  int left = 255;
  for (std::size_t i = 0; i < mix.all().size(); ++i) {
    const Term& term = mix.all()[i];
    const double exact = 255 * term.weight;
    shares.joint[i] = static_cast<std::uint16_t>(term.segment == nullptr ? 0 : term.segment->joint);
    shares.share[i] = static_cast<std::uint8_t>(exact);
    rest[i] = exact - shares.share[i];
    left -= shares.share[i];
  }
  for (; left > 0; --left) {
    const auto most = std::max_element(rest.begin(), rest.end());
    ++shares.share[static_cast<std::size_t>(most - rest.begin())];
    *most = -1;
  }
  for (std::size_t i = 0; i < 4; ++i) {
    if (shares.share[i] == 0) shares.joint[i] = 0;
  }
  return shares;
}

std::vector<JointShares> share_skin(const Task& task, const std::vector<AxisFit>& fits) {
  const Surface& surface = task.surface;
  std::vector<JointShares> shares(surface.vertex_count());
  const std::vector<char> in_piece = rig::vertices_of_pieces(surface);
  for (std::size_t i = 0; i < shares.size(); ++i) {
    const auto k = index_of(surface.branch[i]);
    if (i > 0 && surface.branch[i - 1] == surface.branch[i] && surface.along[i - 1] == surface.along[i] &&
        in_piece[i - 1] == in_piece[i]) {
      shares[i] = shares[i - 1];
      continue;
    }
    const auto a = index_of(task.axes.of_branch[k]);
    const double way =
        task.axes.way[k] + static_cast<double>(surface.along[i]) * task.structure.members[k].beam.length;
    const Mix mix = rig::mix_at(task.axes.axes[a], fits[a], way);
    shares[i] = shares_of(in_piece[i] != 0 ? rig::stiffened(mix, task.poses.instants) : mix);
  }
  return shares;
}

// How far from a joint the skin goes that it moves, itself or by joints it carries [m].
std::vector<double> extents(const Rig& rig, const Surface& surface) {
  std::vector<double> extent(rig.joints.size());
  for (std::size_t i = 0; i < rig.shares.size(); ++i) {
    for (std::size_t n = 0; n < 4 && rig.shares[i].share[n] > 0; ++n) {
      const std::size_t j = rig.shares[i].joint[n];
      extent[j] = std::max(extent[j], (surface.position[i].cast<double>() - rig.joints[j].position).norm());
    }
  }
  for (std::size_t j = extent.size(); j-- > 1;) {
    const auto parent = index_of(rig.joints[j].parent);
    extent[parent] =
        std::max(extent[parent], extent[j] + (rig.joints[j].position - rig.joints[parent].position).norm());
  }
  return extent;
}

struct Measured {
  double error = 0;
  Eigen::Vector3f low = Eigen::Vector3f::Constant(std::numeric_limits<float>::max()), high = -low;
};

// All vertices at one instant.
Measured measure(const Task& task, const Rig& rig, const Instant& instant, const Pose& bent) {
  const std::vector<JointFrame> frames = joint_frames(rig, rig.clips[instant.clip], instant.time);
  const Surface& surface = task.surface;
  Measured measured;
  BlendedFrame here, off;
  BentCurve curve;
  for (std::size_t i = 0; i < surface.vertex_count(); ++i) {
    const bool same_branch = i > 0 && surface.branch[i - 1] == surface.branch[i];
    if (!same_branch || surface.along[i - 1] != surface.along[i]) {
      const Member& member = task.structure.members[index_of(surface.branch[i])];
      const auto s = static_cast<double>(surface.along[i]);
      if (!same_branch) curve = curve_of(member, bent[index_of(surface.branch[i])]);
      const BentPoint wanted = point_on(curve, s);
      here = blend(rig, frames, rig.shares[i]);
      off.turn = here.turn - wanted.frame;
      off.shift = here.shift - wanted.position + wanted.frame * member.point(s);
    }
    const Vec3 rest = surface.position[i].cast<double>();
    const Vec3 skinned = here.shift + here.turn * rest;
    measured.error = std::max(measured.error, (off.shift + off.turn * rest).squaredNorm());
    measured.low = measured.low.cwiseMin(skinned.cast<float>());
    measured.high = measured.high.cwiseMax(skinned.cast<float>());
  }
  measured.error = std::sqrt(measured.error);
  return measured;
}

// The error at each of the checks [m].
std::vector<double> measure(const Task& task, Rig& rig) {
  std::vector<Measured> all(task.checks.size());
  for_poses(task, task.checks, [&](std::size_t first, const std::vector<Pose>& poses) {
    tbb::parallel_for(std::size_t{0}, poses.size(), [&](std::size_t i) {
      all[first + i] = measure(task, rig, task.checks[first + i], poses[i]);
    });
  });
  Measured sum;
  std::vector<double> errors;
  for (const Measured& one : all) {
    errors.push_back(one.error);
    sum.error = std::max(sum.error, one.error);
    sum.low = sum.low.cwiseMin(one.low);
    sum.high = sum.high.cwiseMax(one.high);
  }
  rig.largest_error = sum.error;
  rig.low = sum.low.cast<double>();
  rig.high = sum.high.cast<double>();
  return errors;
}

// The keys of joints, within so much of the tolerance for each: of the clips that sway less, as much less.
void give_keys(const Task& task, const std::vector<rig::SampledTurns>& sampled, double tolerance, Rig& rig) {
  const std::vector<double> extent = extents(rig, task.surface);
  rig.clips.clear();
  for (std::size_t c = 0; c < task.clips.size(); ++c) {
    const double of_clip = tolerance * task.tolerance[c] / task.largest_tolerance();
    rig.clips.push_back(
        rig::thin_turns(sampled[c], rig.joints, extent, of_clip, task.clips[c].motion->repeats));
    rig.clips.back().name = task.clips[c].name;
    rig.clips.back().wind_speed = task.clips[c].wind_speed;
    rig.clips.back().period = task.clips[c].motion->period;
  }
}

// The joints for an inner tolerance, and as few keys as keep them within the outer one.
Rig fit_within(const Task& task, double inner, double outer, int shapes_of, std::vector<double>& errors) {
  std::vector<AxisFit> fits = rig::fit_axes(task.places, task.axes, task.poses, inner);
  Rig rig;
  const rig::Joints chosen = number_joints(task, fits, rig.joints);
  rig.shares = share_skin(task, fits);
  std::vector<rig::SampledTurns> sampled;
  for (std::size_t c = 0; c < task.clips.size(); ++c) {
    sampled.push_back(
        rig::sample_turns(task.leans[c], *task.clips[c].motion, task.places, task.axes, chosen));
  }
  if (shapes_of >= 0) {
    const auto c = index_of(shapes_of);
    rig.shapes = rig::sample_shapes(task.leans[c], *task.clips[c].motion, task.places, task.axes, chosen);
    rig.shapes.clip = shapes_of;
  }
  // Errors of joints on one path go the same way at a time: a few of these are the whole. Finer keys are kept
  // only where they, and not more joints, are what was wanting.
  give_keys(task, sampled, 0.1 * outer, rig);
  errors = measure(task, rig);
  if (rig.largest_error <= outer) return rig;
  Rig finer = rig;
  give_keys(task, sampled, 0.03 * outer, finer);
  const auto in_vain = [&](double error) { return error > 0.9 * rig.largest_error && error > outer; };
  // Most often one instant tells, and all the others of a large scan take seconds.
  const Instant worst =
      task.checks[index_of(std::max_element(errors.begin(), errors.end()) - errors.begin())];
  if (in_vain(measure(task, finer, worst, poses_at(task, {&worst, 1}).front()).error)) return rig;
  const std::vector<double> finer_errors = measure(task, finer);
  if (in_vain(finer.largest_error)) return rig;
  errors = finer_errors;
  return finer;
}

// The instants at which joints failed worst join those that they are chosen for.
void learn_from(const std::vector<double>& errors, double tolerance, Task& task) {
  constexpr std::size_t most = 8;
  std::vector<std::size_t> order(errors.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return errors[a] > errors[b]; });
  std::vector<Instant> more;
  for (std::size_t i = 0; i < std::min(most, order.size()) && errors[order[i]] > tolerance; ++i)
    more.push_back(task.checks[order[i]]);
  add_poses(task, more, task.poses);
}

// The least tolerance that so many joints are enough for, to a tenth, from one that wants more [m].
double tolerance_for(const Task& task, int max_joints, double tolerance) {
  const auto wants_more = [&](double within) {
    std::vector<AxisFit> fits = rig::fit_axes(task.places, task.axes, task.poses, within);
    std::vector<RigJoint> joints;
    number_joints(task, fits, joints);
    return static_cast<int>(joints.size()) > max_joints;
  };
  double low = tolerance, high = 2 * tolerance;
  for (; wants_more(high); high *= 2) low = high;
  while (high > 1.1 * low) {
    const double middle = std::sqrt(low * high);
    (wants_more(middle) ? low : high) = middle;
  }
  return high;
}

}  // namespace

Rig fit_rig(const Structure& structure, const Surface& surface, std::span<const ClipSource> clips,
            const RigOptions& options) {
  check(structure, surface, clips, options);
  Task task = make_task(structure, surface, clips, options.tolerance);
  const auto too_many = [&](const Rig& rig) {
    return options.max_joints > 0 && static_cast<int>(rig.joints.size()) > options.max_joints;
  };
  const double outer = task.largest_tolerance();
  double inner = 0.8 * outer;
  Rig rig;
  for (int round = 0; round < 4; ++round) {
    std::vector<double> errors;
    rig = fit_within(task, inner, outer, options.shapes_of, errors);
    if (rig.largest_error <= outer || too_many(rig)) break;
    learn_from(errors, outer, task);
    inner *= std::clamp(outer / rig.largest_error, 0.7, 0.9);
  }
  if (!too_many(rig)) return rig;
  inner = tolerance_for(task, options.max_joints, inner);
  std::vector<double> errors;
  return fit_within(task, inner, 1.25 * inner, options.shapes_of, errors);
}

double linear_pose_error(const Structure& structure, const Surface& surface, const Motion& motion) {
  const BentLean lean = bend_lean(structure, motion);
  const std::vector<double> reaches =
      reach_of_branches(rig::find_places(*lean.tree, surface, std::vector<int>(lean.bent.size(), 1)));
  double error = 0;
  for (const double time : telling_times(motion, 24)) {
    const Eigen::VectorXd displacement = displacement_about_lean(motion, time);
    const std::vector<BentBranch> bent = bent_at(lean, motion, time);
    for (std::size_t k = 0; k < bent.size(); ++k) {
      const Vec3 turned = displacement.segment<3>(static_cast<Eigen::Index>(6 * k + 3));
      const Vec3 linear = lean.bent[k].end + displacement.segment<3>(static_cast<Eigen::Index>(6 * k));
      const Mat3 frame = lean.bent[k].end_frame + cross_matrix(turned) * lean.bent[k].end_frame;
      error = std::max(error, (linear - bent[k].end).norm() +
                                  reaches[k] * std::sqrt(0.5) * (frame - bent[k].end_frame).norm());
    }
  }
  return error;
}

}  // namespace tremula
