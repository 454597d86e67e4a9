#include "tremula/deformation/rig_tracks.hpp"

#include "tremula/numerics/rotation.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <tbb/parallel_for.h>

namespace tremula::rig {
namespace {

// The part of a tree that some places stand on: their branches and all that carry those.
struct PartOfTree {
  BeamTree tree;            // parents and members alone
  std::vector<int> branch;  // of the whole
  std::vector<int> local;   // (N) -1 where it is not in the part
  Eigen::VectorXd strains;  // of the lean
  StrainMaps maps;
  Eigen::MatrixXd columns;  // what moves about the lean
};

PartOfTree part_below(const BentLean& lean, const Motion& motion, const std::vector<char>& wanted) {
  const BeamTree& whole = *lean.tree;
  std::vector<char> in_part = wanted;
  for (int k = whole.branch_count() - 1; k >= 0; --k) {
    const int parent = whole.parent[index_of(k)];
    if (in_part[index_of(k)] != 0 && parent >= 0) in_part[index_of(parent)] = 1;
  }
  PartOfTree part;
  part.local.assign(in_part.size(), -1);
  for (int k = 0; k < whole.branch_count(); ++k) {
    if (in_part[index_of(k)] == 0) continue;
    const int parent = whole.parent[index_of(k)];
    part.local[index_of(k)] = static_cast<int>(part.branch.size());
    part.branch.push_back(k);
    part.tree.parent.push_back(parent < 0 ? -1 : part.local[index_of(parent)]);
    part.tree.members.push_back(whole.members[index_of(k)]);
    part.maps.translation.push_back(lean.maps.translation[index_of(k)]);
    part.maps.rotation.push_back(lean.maps.rotation[index_of(k)]);
    part.maps.reach.push_back(lean.maps.reach[index_of(k)]);
  }
  const auto rows = static_cast<Eigen::Index>(6 * part.branch.size());
  part.strains.resize(rows);
  part.columns.resize(rows, motion.basis.columns.cols());
  for (std::size_t i = 0; i < part.branch.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(6 * i), from = Eigen::Index{6} * part.branch[i];
    part.strains.segment<6>(row) = lean.strains.segment<6>(from);
    part.columns.middleRows<6>(row) = motion.basis.columns.middleRows<6>(from);
  }
  for (std::size_t c = 0; c < motion.basis.kind.size(); ++c) {
    if (motion.basis.kind[c] == ShapeKind::lean) part.columns.col(static_cast<Eigen::Index>(c)).setZero();
  }
  return part;
}

std::vector<char> branches_of(const Places& places, const Axes& axes, const Joints& joints,
                              std::size_t branch_count) {
  std::vector<char> wanted(branch_count);
  for (std::size_t j = 0; j < joints.segments.size(); ++j) {
    const Axis& axis = axes.axes[index_of(joints.axis[j])];
    const Segment& segment = *joints.segments[j];
    wanted[index_of(places.branch[index_of(axis.base)])] = 1;
    if (segment.is_foot) continue;
    for (const int at : {segment.low, segment.high, segment.to}) {
      if (at >= 0) wanted[index_of(places.branch[index_of(axis.places[index_of(at)])])] = 1;
    }
  }
  return wanted;
}

std::vector<JointFrame> frames_at(const PartOfTree& part, const Places& places, const Axes& axes,
                                  const Joints& joints, const Eigen::VectorXd& coordinates) {
  const Eigen::VectorXd displacement = part.columns * coordinates;
  const std::vector<BentBranch> bent =
      bend(part.tree, part.strains + strains_about(part.tree, part.maps, displacement));
  const PoseOfPlace pose = [&](int place) -> PlacePose {
    const auto k = index_of(part.local[index_of(places.branch[index_of(place)])]);
    const double s = places.s[index_of(place)];
    if (s == 1) return {bent[k].end, bent[k].end_frame};
    const BentPoint point = point_on(part.tree.members[k], bent[k], s);
    return {point.position, point.frame};
  };
  std::vector<JointFrame> frames(joints.segments.size() + 1);
  for (std::size_t j = 0; j < joints.segments.size(); ++j) {
    const Segment& segment = *joints.segments[j];
    const Axis& axis = axes.axes[index_of(joints.axis[j])];
    if (segment.is_foot) {
      const PlacePose foot = pose(axis.base);
      frames[j + 1] = {foot.position, foot.frame};
      continue;
    }
    const BlendedFrame hook = blend_of(segment.hook, [&](const Segment* one) -> const JointFrame& {
      return frames[one == nullptr ? 0 : index_of(one->joint)];
    });
    frames[j + 1] = segment_frame(axis, segment, hook.shift + hook.turn * segment.rest, pose);
  }
  return frames;
}

Eigen::Quaterniond read_back(const StoredTurn& stored) {
  return Eigen::Quaterniond(stored[3], stored[0], stored[1], stored[2]).normalized();
}

StoredTurn stored(const Eigen::Quaterniond& turn) {
  const Eigen::Vector4d steps = 32767 * turn.coeffs();
  StoredTurn result{};
  for (std::size_t i = 0; i < 4; ++i)
    result[i] = static_cast<std::int16_t>(std::lround(steps[static_cast<Eigen::Index>(i)]));
  return result;
}

// The samples at which a track has keys.
std::vector<int> keys_of(int stride, int sample_count) {
  std::vector<int> keys;
  for (int p = 0; p < sample_count; p += stride) keys.push_back(p);
  keys.push_back(sample_count);
  return keys;
}

// Behind the last sample a loop goes on with its first, a clip stands still.
std::size_t wrapped(int key, int sample_count, bool repeats) {
  return index_of(repeats ? key % sample_count : std::min(key, sample_count - 1));
}

constexpr int strides[] = {1, 2, 3, 4, 5, 6, 8, 10, 12, 15, 20, 30, 60, 120, 300};

// Whether turns between these keys are off by no more than so much at the samples (rad). By cosines of half
// angles, and slerp by the recurrence of sin((n + 1) a) = 2 cos(a) sin(n a) - sin((n - 1) a).
bool enough_between(const std::vector<Eigen::Quaterniond>& turns, const std::vector<Eigen::Quaterniond>& read,
                    int stride, double most, bool repeats) {
  const int count = static_cast<int>(turns.size());
  const std::vector<int> keys = keys_of(stride, count);
  const double least = std::cos(0.5 * std::min(most, 3.0));
  for (std::size_t i = 0; i + 1 < keys.size(); ++i) {
    Eigen::Vector4d first = read[index_of(keys[i])].coeffs();
    const Eigen::Vector4d next = read[wrapped(keys[i + 1], count, repeats)].coeffs();
    const int steps = keys[i + 1] - keys[i];
    if (first.dot(next) < 0) first = -first;
    const double half = 2 * std::asin(std::min(1.0, 0.5 * (next - first).norm())), step = half / steps;
    const bool turned = half > 1e-7;
    // Unit and across the first, in the plane of both.
    const Eigen::Vector4d across =
        turned ? Eigen::Vector4d((next - first.dot(next) * first) / std::sin(half)) : Eigen::Vector4d::Zero();
    const double twice = 2 * std::cos(step);
    double cosine = 1, sine = 0, cosine_before = 0.5 * twice, sine_before = -std::sin(step);
    for (int p = keys[i]; p < keys[i + 1]; ++p) {
      if (std::abs(turns[index_of(p)].coeffs().dot(cosine * first + sine * across)) < least) return false;
      cosine_before = std::exchange(cosine, twice * cosine - cosine_before);
      sine_before = std::exchange(sine, twice * sine - sine_before);
    }
  }
  return true;
}

double error_between(const std::vector<Vec3>& positions, int stride, bool repeats) {
  const int count = static_cast<int>(positions.size());
  const std::vector<int> keys = keys_of(stride, count);
  double error = 0;
  for (std::size_t i = 0; i + 1 < keys.size(); ++i) {
    for (int p = keys[i]; p < keys[i + 1]; ++p) {
      const double part = static_cast<double>(p - keys[i]) / (keys[i + 1] - keys[i]);
      const Vec3 between =
          (1 - part) * positions[index_of(keys[i])] + part * positions[wrapped(keys[i + 1], count, repeats)];
      error = std::max(error, (positions[index_of(p)] - between).norm());
    }
  }
  return error;
}

JointTrack thin_track(const std::vector<Eigen::Quaterniond>& turns, const std::vector<Vec3>& positions,
                      double extent, double tolerance, bool repeats) {
  const int count = static_cast<int>(turns.size());
  const double most = tolerance / std::max(extent, 1e-9);
  std::vector<StoredTurn> all;
  std::vector<Eigen::Quaterniond> read;
  for (const Eigen::Quaterniond& turn : turns) {
    all.push_back(stored(turn));
    read.push_back(read_back(all.back()));
  }
  JointTrack track;
  for (const int stride : strides) {
    if (stride > count) break;
    if (stride > 1 && !enough_between(turns, read, stride, most, repeats)) continue;
    if (stride > 1 && !positions.empty() && error_between(positions, stride, repeats) > tolerance) continue;
    track.stride = stride;
  }
  for (const int key : keys_of(track.stride, count)) {
    const std::size_t sample = wrapped(key, count, repeats);
    track.turn.push_back(all[sample]);
    if (!positions.empty()) track.position.push_back(positions[sample].cast<float>());
  }
  return track;
}

}  // namespace

SampledTurns sample_turns(const BentLean& lean, const Motion& motion, const Places& places, const Axes& axes,
                          const Joints& joints) {
  const PartOfTree part =
      part_below(lean, motion, branches_of(places, axes, joints, lean.tree->members.size()));
  const auto samples = index_of(motion.sample_count());
  const std::size_t count = joints.segments.size() + 1;
  SampledTurns sampled;
  sampled.turn.assign(count, std::vector<Eigen::Quaterniond>(samples, Eigen::Quaterniond::Identity()));
  sampled.position.resize(count);
  for (std::size_t j = 1; j < count; ++j) {
    if (joints.segments[j - 1]->travels()) sampled.position[j].resize(samples);
  }
  tbb::parallel_for(std::size_t{0}, samples, [&](std::size_t p) {
    const std::vector<JointFrame> frames = frames_at(
        part, places, axes, joints, motion.coordinates.row(static_cast<Eigen::Index>(p)).transpose());
    for (std::size_t j = 1; j < count; ++j) {
      const Segment* parent = joints.segments[j - 1]->parent();
      const JointFrame& below = frames[parent == nullptr ? 0 : index_of(parent->joint)];
      sampled.turn[j][p] = Eigen::Quaterniond(Mat3(below.turn.transpose() * frames[j].turn)).normalized();
      if (!sampled.position[j].empty())
        sampled.position[j][p] = below.turn.transpose() * (frames[j].position - below.position);
    }
  });
  // The two quaternions of a turn are both right; neighbours shall be in one half of the sphere.
  for (std::vector<Eigen::Quaterniond>& turns : sampled.turn) {
    for (std::size_t p = 0; p < samples; ++p) {
      const bool flip = p == 0 ? turns[0].w() < 0 : turns[p].dot(turns[p - 1]) < 0;
      if (flip) turns[p].coeffs() *= -1;
    }
  }
  return sampled;
}

RigShapes sample_shapes(const BentLean& lean, const Motion& motion, const Places& places, const Axes& axes,
                        const Joints& joints) {
  const Eigen::Index shapes = motion.coordinates.cols();
  // The lean alone, and then every shape as far out as it goes to the one side and to the other.
  Motion posed = motion;
  posed.coordinates.setZero(1 + 2 * shapes, shapes);
  posed.period = 1;
  Eigen::VectorXd size = motion.coordinates.cwiseAbs().colwise().maxCoeff();
  for (Eigen::Index c = 0; c < shapes; ++c) {
    if (motion.basis.kind[index_of(c)] == ShapeKind::lean) {
      posed.coordinates.col(c).setOnes();
      size[c] = 0;
    } else {
      posed.coordinates(1 + 2 * c, c) = size[c];
      posed.coordinates(2 + 2 * c, c) = -size[c];
    }
  }
  const SampledTurns sampled = sample_turns(lean, posed, places, axes, joints);
  const auto count = static_cast<Eigen::Index>(sampled.turn.size());
  RigShapes result{.kind = motion.basis.kind,
                   .frequency = motion.basis.frequency,
                   .coordinates = motion.coordinates,
                   .turn = Eigen::MatrixXf::Zero(3 * count, shapes),
                   .travel = Eigen::MatrixXf::Zero(3 * count, shapes)};
  const auto vector_of = [](const Eigen::Quaterniond& turn) {
    return rotation_vector(turn.toRotationMatrix());
  };
  tbb::parallel_for(Eigen::Index{1}, count, [&](Eigen::Index j) {
    const std::vector<Eigen::Quaterniond>& turn = sampled.turn[index_of(j)];
    const std::vector<Vec3>& place = sampled.position[index_of(j)];
    const Segment& segment = *joints.segments[index_of(j - 1)];
    const Vec3 rest = segment.rest - (segment.parent() == nullptr ? Vec3::Zero() : segment.parent()->rest);
    for (Eigen::Index c = 0; c < shapes; ++c) {
      const bool is_lean = motion.basis.kind[index_of(c)] == ShapeKind::lean;
      if (!is_lean && size[c] == 0) continue;
      const auto out = index_of(1 + 2 * c), back = index_of(2 + 2 * c);
      const Eigen::Quaterniond undo = turn[0].conjugate();
      const Vec3 turned =
          is_lean ? vector_of(turn[0])
                  : Vec3((vector_of(undo * turn[out]) - vector_of(undo * turn[back])) / (2 * size[c]));
      result.turn.col(c).segment<3>(3 * j) = turned.cast<float>();
      if (place.empty()) continue;
      const Vec3 moved = is_lean ? Vec3(place[0] - rest) : Vec3((place[out] - place[back]) / (2 * size[c]));
      result.travel.col(c).segment<3>(3 * j) = moved.cast<float>();
    }
  });
  return result;
}

RigClip thin_turns(const SampledTurns& sampled, const std::vector<RigJoint>& joints,
                   const std::vector<double>& extent, double tolerance, bool repeats) {
  RigClip clip;
  clip.repeats = repeats;
  clip.sample_count = static_cast<int>(sampled.turn.front().size());
  clip.tracks.resize(joints.size());
  tbb::parallel_for(std::size_t{1}, joints.size(), [&](std::size_t j) {
    clip.tracks[j] = thin_track(sampled.turn[j], sampled.position[j], extent[j], tolerance, repeats);
  });
  return clip;
}

}  // namespace tremula::rig
