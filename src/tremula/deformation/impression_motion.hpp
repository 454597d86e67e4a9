// How impressionist trees stand in the wind (F section 5.3): the trunk bends, the crown's envelope is shifted
// by where the trunk is at its height, and the texture of the leaves trembles.
#pragma once

#include "tremula/deformation/loop.hpp"
#include "tremula/dynamics/trunk_sway.hpp"
#include "tremula/wind/travelling_field.hpp"

#include <memory>
#include <vector>

#include <Eigen/Core>

namespace tremula {

// How the trees of one kind move, wherever they stand.
struct ImpressionMotion {
  double heading = 0;  // what along is [degrees]
  // Of the trunk, as in TrunkSway; empty: it stands still.
  std::vector<double> heights = {};  // [m]
  std::vector<Eigen::Vector2d> lean = {}, share = {};
  std::shared_ptr<const TravellingField> sway = {};     // displacement of the top about the lean [m]
  std::shared_ptr<const TravellingField> tremble = {};  // of the texture [m]; null: it keeps still
};

// How leaves tremble: an oscillator as a twig of a metre is, which swings at 2 Hz (F section 6.1), but damped
// as leaves are, and that draws on its neighbours (F eq. 5). By what gusts move: `give` [m s/m].
FieldResponse tremble_response(double give = 0.012);

// The motion of a sway in gusts on a plane with the layer sway.gust_height. Throws as respond does.
ImpressionMotion impression_motion(const TrunkSway& sway, const TravellingField& gusts,
                                   const FieldResponse& tremble = tremble_response());

// Throws InputError for a motion whose parts do not belong together.
void check_motion(const ImpressionMotion& motion);

// How a trunk stands, by height: lean along and across the wind [m], and the shares of the motion of the top
// along and across. Piecewise cubic through equidistant heights, clamped at the foot, straight on above.
struct TrunkCurve {
  float step = 1;                              // between two knots [m]
  std::vector<Eigen::Vector4f> knots, slopes;  // by height; none: it stands still

  bool moves() const { return !knots.empty(); }
  void at(float height, Eigen::Vector4f& value, Eigen::Vector4f& slope) const;
};
TrunkCurve trunk_curve(const ImpressionMotion& motion);

// Where the top of a copy is about its lean, along and across, in metres of the tree: its time shift counts.
Eigen::Vector2f top_of(const ImpressionMotion& motion, const Instance& instance, double time);

// Where a place of the resting tree [m] is, in the world.
Vec3 place_in_wind(const ImpressionMotion& motion, const TrunkCurve& curve, const Instance& instance,
                   const Vec3& resting, double time);

}  // namespace tremula
