// The keys of the joints that fit_rig chose. Internal to the deformation.
#pragma once

#include "tremula/deformation/bent_pose.hpp"
#include "tremula/deformation/rig.hpp"
#include "tremula/deformation/rig_joints.hpp"

#include <memory>
#include <vector>

namespace tremula::rig {

// The segments in the order of their joints, joint 0 the root excepted, and the axis of each.
struct Joints {
  std::vector<const Segment*> segments;
  std::vector<int> axis;
};

// How all joints turn at every sample of a motion: (M x joints), of joint 0 nothing.
struct SampledTurns {
  std::vector<std::vector<Eigen::Quaterniond>> turn;  // by joint, of every sample, against its parent
  std::vector<std::vector<Vec3>> position;            // of those that travel, against the parent's joint [m]
};
SampledTurns sample_turns(const BentLean& lean, const Motion& motion, const Places& places, const Axes& axes,
                          const Joints& joints);

// The shapes of a motion, and how they turn the joints: by differences about the lean.
RigShapes sample_shapes(const BentLean& lean, const Motion& motion, const Places& places, const Axes& axes,
                        const Joints& joints);

// Stored and thinned: as few keys as keep the angle times `extent` (of what hangs on the joint [m]) below the
// tolerance [m].
RigClip thin_turns(const SampledTurns& sampled, const std::vector<RigJoint>& joints,
                   const std::vector<double>& extent, double tolerance, bool repeats = true);

}  // namespace tremula::rig
