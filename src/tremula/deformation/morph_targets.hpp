// A loop as morph targets: shapes of the skin that never change, and a small table of weights over time. Any
// engine that blends morph targets linearly then plays S eq. 1 exactly as displacement_at() gives it with
// linear interpolation.
#pragma once

#include "tremula/deformation/pose.hpp"
#include "tremula/dynamics/basis.hpp"

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
  int number = 0;  // column of Modes::shapes or of StaticShapes::shapes
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
  std::vector<double> frequencies;   // of all modes, also of those that got no target [Hz]
  int static_shape_count = 0;        // as many as the motion has
  std::vector<SurfaceDelta> shapes;  // what the targets add to the vertices [m]
  std::vector<MorphTarget> targets;  // the mean lean first, then modes in order, then static shapes
  std::vector<float> times;          // (K) [s] strictly increasing, first 0, last T
  std::vector<float> weights;        // (K x targets) by rows; the last row equals the first bit for bit

  std::size_t target_count() const { return targets.size(); }
  std::size_t key_count() const { return times.size(); }
  float weight(std::size_t key, std::size_t target) const { return weights[key * targets.size() + target]; }
};

// Throws Error when the stages do not fit together (numbers of modes or branches differ), when a value is not
// finite, or when single precision cannot tell the instants of the loop apart.
MorphTargets make_morph_targets(const Skeleton& skeleton, const Structure& structure, const Surface& surface,
                                const Modes& modes, const Motion& motion, MorphForm form);

}  // namespace tremula
