// A loop as morph targets: shapes of the skin that never change, and a small table of weights over time. Any
// engine that blends morph targets linearly then plays S eq. 1 exactly as Loop::skin_at gives it; where poses
// bend by strains (bent_pose.hpp), it plays the bent lean and S eq. 1 about it (Poses::linear).
#pragma once

#include "tremula/deformation/loop.hpp"

#include <string>
#include <vector>

namespace tremula {

enum class MorphForm {
  signed_weights,  // one target a mode over the plant at rest, weights of either sign, keys at the samples
  biased,  // one target a mode, weights in [0, 1] (Blender clamps negative ones), keys at the samples. Weight
           // 0 is the farthest that the mode goes to one side; the plant stands at rest at MorphTarget::rest
  paired,  // a plus and a minus target a mode over the plant at rest, weights in [0, 1]; keys at the zero
           // crossings of every mode too, so that max(y, 0) and max(-y, 0) are linear between keys
};

struct MorphTarget {
  std::string
      name;  // "mean lean", "mode 03 0.572 Hz", "static 1", in the paired form with " +" or " -" after it
  ShapeKind kind = ShapeKind::lean;
  int number = 0;  // the how manieth of its kind, from 0
  int shape = 0;   // index into MorphTargets::shapes
  float sign = 1;  // the target is sign * shape
  float rest = 0;  // its weight while the plant stands at rest
};

// A mode's shape has the size of its whole swing, from the farthest to one side to the farthest to the other
// (from rest where it goes to one side only): its weight, in the paired form the plus less the minus,
// spans 1. What does not move gets no target. Row k of the weights belongs to times[k]; between two keys
// weights are linear. The displacement from rest is the sum over the targets of (weight - rest) * sign *
// shape.
struct MorphTargets {
  double period = 0;                 // T [s]
  bool repeats = true;               // false: a clip, whose last row is its last sample
  std::vector<double> frequencies;   // of all modes, also of those that got no target [Hz]
  int static_shape_count = 0;        // as many as the motion has
  std::vector<SurfaceDelta> shapes;  // what the targets add to the vertices [m]
  std::vector<MorphTarget> targets;  // the mean lean first, then modes in order, then static shapes
  std::vector<float> times;          // (K) [s] strictly increasing, first 0, last T
  std::vector<float> weights;        // (K x targets) by rows; of a loop the last equals the first bit for bit
  std::vector<Instance> instances{Instance{}};

  std::size_t target_count() const { return targets.size(); }
  std::size_t key_count() const { return times.size(); }
  float weight(std::size_t key, std::size_t target) const { return weights[key * targets.size() + target]; }
};

// Throws Error when weights, kinds and frequencies do not fit together, when a value is not finite, or when
// single precision cannot tell the instants of the loop apart.
MorphTargets make_morph_targets(const Loop& loop, MorphForm form);

// The weights of an instance: those of the loop, turned round by its time shift. The same keys, and one where
// the loop now begins: times and weights as in MorphTargets.
struct WeightTable {
  std::vector<float> times, weights;
};
WeightTable weights_of(const MorphTargets& morphs, const Instance& instance);

}  // namespace tremula
