// A loop as everybody after the cascade sees it, and nothing else: writers, the renderer, the page.
#pragma once

#include "tremula/base/types.hpp"
#include "tremula/deformation/pose.hpp"
#include "tremula/deformation/rig.hpp"
#include "tremula/dynamics/motion.hpp"
#include "tremula/geometry/surface.hpp"
#include "tremula/structure/structure.hpp"

#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace tremula {

// What a file says about the loop in it. The period and the frequencies are the loop's own.
struct LoopFacts {
  std::string name = "tree";
  double frames_per_second = 30;  // what the loop was made for; the samples are its frames
  double wind_speed = 0;          // mean, at its reference height [m/s]
  double heading = 0;             // of the mean wind, from x towards y [degrees]
  std::uint64_t seed = 0;
  bool scales = true;  // its motion grows with the loads of the wind; that of a flag that flaps does not
  bool under_water = false;  // the wind is then a current
};

// Where a copy of what moves stands, and when: it shows at time t what the loop has at t + time_shift,
// scaled, then turned about the vertical, then moved.
struct Instance {
  Vec3 position = Vec3::Zero();  // of the origin [m]
  double turn = 0;               // from x towards y [rad]
  double scale = 1;
  double time_shift = 0;  // [s]

  Mat3 rotation() const {
    Mat3 r = Mat3::Identity();
    r.topLeftCorner<2, 2>() << std::cos(turn), -std::sin(turn), std::sin(turn), std::cos(turn);
    return r;
  }
};

// Throws InputError where there are none, for a number that is not finite, and for a scale that is not above
// 0; and for a time shift in a clip, which has no other end to take it from.
void check_instances(const std::vector<Instance>& instances, bool repeats = true);

using NodePoses = Eigen::Matrix<double, 6, Eigen::Dynamic>;  // translation [m] and rotation vector [rad]

// M samples at equidistant instants of a loop that closes (sample M would equal sample 0), or of a clip that
// ends with its last sample (Motion::repeats).
struct Loop {
  LoopFacts facts;
  double period = 0;                    // [s]
  bool repeats = true;                  // false: a clip
  std::shared_ptr<const Surface> rest;  // the skin and its materials, at rest
  // A few shapes of the skin (c), and at every sample a weight of each. Their sum is what morph targets play:
  // skin_at itself where displacements superpose, and the same to first order in what moves about the lean
  // where poses bend.
  std::vector<ShapeKind> kind;
  Eigen::VectorXd frequency;    // (c) [Hz]; 0 for the lean
  Eigen::MatrixXd coordinates;  // (M x c) the weights; 1 for the lean
  std::function<SurfaceDelta(Eigen::Index shape, double weight)> shape_of_skin;
  // Where the skin and the nodes have gone, from rest, at any time [s]; coordinates are linear between
  // samples.
  std::function<SurfaceDelta(double time)> skin_at;
  std::shared_ptr<const Rig> rig;  // bones of the skin, where somebody fitted them (fit_rig.hpp); else null
  Eigen::Matrix3Xd nodes;          // at rest [m]
  std::function<NodePoses(double time)> nodes_at;
  std::vector<Instance> instances{Instance{}};  // one or more; all else is of a copy at the origin, unshifted

  int sample_count() const { return static_cast<int>(coordinates.rows()); }
};

// How a motion that bends far (Motion::lean_strains) is posed, or that of a sheet; the lean is bent in both.
// For other motions displacements superpose from rest, S eq. 1. The shapes of a bent sheet are those of
// principal_shapes.hpp.
enum class Poses {
  bent,    // by strains: every branch keeps its length (bent_pose.hpp)
  linear,  // displacements superpose on the bent lean, S eq. 1: what morph targets play
};

// Throws InputError where the surface or the motion is not one of this structure (check_motion, bend_lean).
Loop make_loop(const Structure& structure, Surface surface, Motion motion, const LoopFacts& facts,
               Poses poses = Poses::bent);

}  // namespace tremula
