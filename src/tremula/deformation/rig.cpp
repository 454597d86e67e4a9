#include "tremula/deformation/rig.hpp"

#include "tremula/base/check.hpp"

#include <algorithm>
#include <cmath>

#include <tbb/parallel_for.h>
#include <Eigen/Geometry>

namespace tremula {
namespace {

Eigen::Quaterniond turn_of(const StoredTurn& stored) {
  return Eigen::Quaterniond(stored[3], stored[0], stored[1], stored[2]).normalized();
}

// Between which keys of a track a place on the clip is, in samples, and how far from the first to the second.
struct Between {
  std::size_t key;
  double part;
};
Between keys_around(const JointTrack& track, int sample_count, double sample) {
  const auto last = track.turn.size() - 2;
  const std::size_t key =
      std::min(static_cast<std::size_t>(sample) / static_cast<std::size_t>(track.stride), last);
  const double first = static_cast<double>(key) * track.stride;
  const double next = std::min<double>(first + track.stride, sample_count);
  return {key, (sample - first) / (next - first)};
}

}  // namespace

std::size_t Rig::key_count() const {
  std::size_t count = 0;
  for (const RigClip& clip : clips) {
    for (const JointTrack& track : clip.tracks) count += track.turn.size();
  }
  return count;
}

std::vector<JointFrame> joint_frames(const Rig& rig, const RigClip& clip, double time) {
  check_equal("tracks of the clip", static_cast<std::ptrdiff_t>(clip.tracks.size()),
              static_cast<std::ptrdiff_t>(rig.joints.size()));
  const double turns = time / clip.period;
  const double sample =
      (clip.repeats ? turns - std::floor(turns) : std::clamp(turns, 0.0, 1.0)) * clip.sample_count;
  std::vector<JointFrame> frames(rig.joints.size());
  for (std::size_t j = 0; j < frames.size(); ++j) {
    const RigJoint& joint = rig.joints[j];
    const JointTrack& track = clip.tracks[j];
    JointFrame local{joint.position, Mat3::Identity()};
    if (joint.parent >= 0) local.position -= rig.joints[index_of(joint.parent)].position;
    if (track.turn.size() > 1) {
      const Between at = keys_around(track, clip.sample_count, sample);
      local.turn =
          turn_of(track.turn[at.key]).slerp(at.part, turn_of(track.turn[at.key + 1])).toRotationMatrix();
      if (!track.position.empty()) {
        local.position = ((1 - at.part) * track.position[at.key].cast<double>() +
                          at.part * track.position[at.key + 1].cast<double>());
      }
    }
    const JointFrame carrier = joint.parent < 0 ? JointFrame{} : frames[index_of(joint.parent)];
    frames[j] = {carrier.position + carrier.turn * local.position, carrier.turn * local.turn};
  }
  return frames;
}

BlendedFrame blend(const Rig& rig, const std::vector<JointFrame>& frames, const JointShares& shares) {
  BlendedFrame sum;
  for (std::size_t i = 0; i < shares.joint.size(); ++i) {
    if (shares.share[i] == 0) continue;
    const double share = shares.share[i] / 255.0;
    const JointFrame& frame = frames[shares.joint[i]];
    sum.turn += share * frame.turn;
    sum.shift += share * (frame.position - frame.turn * rig.joints[shares.joint[i]].position);
  }
  return sum;
}

std::vector<Eigen::Vector3f> skin_on_rig(const Rig& rig, const RigClip& clip, const Surface& surface,
                                         double time) {
  check_equal("vertices of the rig", static_cast<std::ptrdiff_t>(rig.shares.size()),
              static_cast<std::ptrdiff_t>(surface.vertex_count()));
  const std::vector<JointFrame> frames = joint_frames(rig, clip, time);
  std::vector<Eigen::Vector3f> skin(surface.vertex_count());
  tbb::parallel_for(std::size_t{0}, skin.size(), [&](std::size_t i) {
    const BlendedFrame frame = blend(rig, frames, rig.shares[i]);
    skin[i] = (frame.shift + frame.turn * surface.position[i].cast<double>()).cast<float>();
  });
  return skin;
}

}  // namespace tremula
