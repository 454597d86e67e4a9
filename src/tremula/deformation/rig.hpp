// A skin on bones: joints on the axes of a plant that turn, each on the one that carries it, and at most four
// of them to move a vertex. Linear blend skinning, as every engine has it: bends where morph targets stretch.
//
//   x(t) = sum over i of share_i / 255 * (position_i(t) + turn_i(t) (x_rest - joint_i at rest))
#pragma once

#include "tremula/base/types.hpp"
#include "tremula/dynamics/basis.hpp"
#include "tremula/geometry/surface.hpp"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace tremula {

struct RigJoint {
  int parent = -1;               // comes before; -1: carried by nothing
  Vec3 position = Vec3::Zero();  // at rest [m], where its frame is that of the world
  std::string name;              // "root", "branch 0012", "branch 0012 at 0.50": where it sits; no two alike
  bool travels = false;          // on a spring of the ground: moves as well as turns
};

// What moves a vertex. Shares are in 255ths and add up to 255, the largest first; what has none is joint 0.
struct JointShares {
  std::array<std::uint16_t, 4> joint{};
  std::array<std::uint8_t, 4> share{};
};

// A quaternion x y z w in whole numbers of 1/32767, as files store it.
using StoredTurn = std::array<std::int16_t, 4>;

// How a joint turns against its parent, in the axes at rest. Key i stands at sample min(i * stride,
// sample_count) of its clip; of a loop the last key is the first, bit for bit, of a clip with an end it is
// the last sample again. Neighbours are in one half of the sphere, so that any interpolation goes the short
// way.
struct JointTrack {
  int stride = 1;
  std::vector<StoredTurn> turn;
  std::vector<Eigen::Vector3f> position = {};  // against the parent's [m], of a joint that travels
};

// One loop of all joints, or one clip with an end.
struct RigClip {
  std::string name;
  double wind_speed = 0;  // that made it, mean at its reference height [m/s]
  double period = 0;      // [s]
  int sample_count = 0;   // M samples at equidistant instants
  bool repeats = true;
  std::vector<JointTrack> tracks;  // of every joint
};

// What the shapes of one clip do to the joints, to look at them one by one. Small turns about the lean, to
// first order in the coordinates: against its parent a joint turns by
//
//   exp(turn_lean) exp(sum over c of y_c turn_c),   and one that travels moves by travel_lean + sum y_c
//   travel_c
struct RigShapes {
  int clip = -1;                 // whose they are; -1: nobody asked
  std::vector<ShapeKind> kind;   // (c) the lean first
  Eigen::VectorXd frequency;     // (c) [Hz]; 0 for the lean
  Eigen::MatrixXd coordinates;   // (M x c) y at every sample of the clip; 1 for the lean
  Eigen::MatrixXf turn, travel;  // (3 joints x c) for a coordinate of 1 [rad, m]
};

struct Rig {
  std::vector<RigJoint> joints;     // parents before children; the first is the root and stands still
  std::vector<JointShares> shares;  // (V) of every vertex of the surface
  std::vector<RigClip> clips;
  RigShapes shapes = {};
  double largest_error = 0;             // that was measured, of any vertex against the bent pose [m]
  Vec3 low = Vec3::Zero(), high = low;  // bounds of the skin over all that was measured [m]

  std::size_t key_count() const;
};

// Where a joint is and how it has turned from rest.
struct JointFrame {
  Vec3 position = Vec3::Zero();  // [m]
  Mat3 turn = Mat3::Identity();
};

// (joints) At any time [s], as a player has them: turns even between keys (slerp), positions linear.
std::vector<JointFrame> joint_frames(const Rig& rig, const RigClip& clip, double time);

// What moves a vertex: x = shift + turn x_rest, by shares of the joints' frames. `turn` is no rotation where
// joints blend.
struct BlendedFrame {
  Vec3 shift = Vec3::Zero();  // [m]
  Mat3 turn = Mat3::Zero();
};
BlendedFrame blend(const Rig& rig, const std::vector<JointFrame>& frames, const JointShares& shares);

// (V) The skin at any time. [m]
std::vector<Eigen::Vector3f> skin_on_rig(const Rig& rig, const RigClip& clip, const Surface& surface,
                                         double time);

}  // namespace tremula
