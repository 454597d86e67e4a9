// A loop as morph targets: shapes of the skin that never change, and a small table of weights over time. Any
// engine that blends morph targets linearly then plays S eq. 1 exactly as displacement_at() gives it with
// linear interpolation.
#pragma once

#include "tremula/deformation/pose.hpp"

#include <string>
#include <vector>

namespace tremula {

enum class MorphForm {
  signed_weights,  // one target a mode, weights in [-1, 1], keys at the samples
  paired,  // a plus and a minus target a mode, weights in [0, 1] (Blender clamps negative ones); keys at
           // the zero crossings of every mode too, so that max(y, 0) and max(-y, 0) are linear between keys
};

struct MorphTarget {
  std::string name;  // "mean lean", "mode 03 0.572 Hz", in the paired form with " +" or " -" after it
  int mode = -1;     // column of Modes::shapes, or -1 for the mean lean
  int shape = 0;     // index into MorphTargets::shapes
  float sign = 1;    // the target is sign * shape
};

// Shapes are scaled so that the largest weight of a mode is 1; a mode that does not move, and a lean of zero,
// get no target. Row k of the weights belongs to times[k]; between two keys weights are linear.
struct MorphTargets {
  double period = 0;                 // T [s]
  std::vector<double> frequencies;   // of all modes, also of those that got no target [Hz]
  std::vector<SurfaceDelta> shapes;  // what the targets add to the vertices [m]
  std::vector<MorphTarget> targets;  // the mean lean first, then modes in order
  std::vector<float> times;          // (K) [s] strictly increasing, first 0, last T
  std::vector<float> weights;        // (K x targets) by rows; the last row equals the first bit for bit

  std::size_t target_count() const { return targets.size(); }
  std::size_t key_count() const { return times.size(); }
  float weight(std::size_t key, std::size_t target) const { return weights[key * targets.size() + target]; }
};

// structure: so that the feet of stems on springs move (branch_point); without it they stand still.
// Throws Error when the stages do not fit together (numbers of modes or branches differ), when a value is not
// finite, or when single precision cannot tell the instants of the loop apart.
MorphTargets make_morph_targets(const Skeleton& skeleton, const Surface& surface, const Modes& modes,
                                const Motion& motion, MorphForm form, const Structure* structure = nullptr);

}  // namespace tremula
