// Bones for a tree that bends: where to put joints and how they turn, so that the skin on them follows the
// bent poses (bent_pose.hpp) within a tolerance, on few joints.
//
// Along an axis joints stand at knots and each turns the chord from its knot to the next. Blended by the
// quadratic B-splines on these knots, chords through points of a parabola give the parabola (Marsden's
// identity), so the error goes with the change of curvature alone. An axis starts in the frame of what
// carries it; twigs that need no joint ride on that.
#pragma once

#include "tremula/deformation/rig.hpp"
#include "tremula/dynamics/motion.hpp"
#include "tremula/geometry/surface.hpp"
#include "tremula/structure/structure.hpp"

#include <span>
#include <string>

namespace tremula {

struct RigOptions {
  // How far off a vertex may be [m]; above 0. A clip that sways less than ten times that has a tenth of its
  // sway, so that it does not stand still, and a twentieth of the tolerance at least.
  double tolerance = 0.05;
  int max_joints = 0;  // at most so many, whatever error that costs; 0: as many as the tolerance takes
  int shapes_of = -1;  // the clip whose shapes are told (Rig::shapes); -1: none
};

// A motion of the tree that becomes a clip.
struct ClipSource {
  std::string name;
  const Motion* motion = nullptr;
  double wind_speed = 0;  // that made it [m/s]
};

// One rig for all clips. Rig::largest_error is measured on all vertices at instants of every clip, on and
// between samples, from the numbers that are stored; above the tolerance only where max_joints or the length
// of the branches keeps it there. The same arguments give the same rig on any number of threads. Throws
// InputError for a structure that is no tree, a motion that does not bend (Motion::lean_strains) or is not of
// this structure, a surface that is not, a tolerance that is not above 0, max_joints below 0 or 1, and
// shapes of a clip that is not there.
Rig fit_rig(const Structure& structure, const Surface& surface, std::span<const ClipSource> clips,
            const RigOptions& options);

// How far off linear poses are (Poses::linear, what morph targets play), of any end of a branch and what
// reaches from it, at the instants where the coordinates go farthest [m].
double linear_pose_error(const Structure& structure, const Surface& surface, const Motion& motion);

}  // namespace tremula
