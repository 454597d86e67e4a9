// Plants that stand side by side and all bend alike, as one bent space: a 3-D texture of them need not be
// made anew for every frame (F section 5.4), it is looked up where a place was before the space bent.
//
// A plant bends as a uniform beam does in its first mode, by the polynomial that F section 4.3 offers, and
// keeps its length: not the displacement goes by the mode but the angle of its tangent from the vertical,
//
//   theta(s) = alpha phi'(s)/phi'(1) = alpha (1 - (1 - s)^3),   phi = (s^4 - 4 s^3 + 6 s^2)/3,
//
// s = z/h at rest, and the plant is the integral of (sin theta, cos theta). For small angles that is F's
// shape, with 3/4 alpha h at the top.
#pragma once

#include "tremula/geometry/strands.hpp"

#include <functional>
#include <vector>

#include <Eigen/Core>

namespace tremula {

// A linear response knows no end; the angle does: alpha nears this [rad].
inline constexpr double most_tip_angle = 1.35;

// alpha [rad] of a plant whose top would be displaced so far, by its height, in linear theory: 4/3 of it
// while that is small.
double tip_angle(double displacement_by_height);

inline float angle_at(float tip_angle, float s) {
  const float rest = 1 - s;
  return tip_angle * (1 - rest * rest * rest);
}

// Where the plant is at s, by its height, and how far it has turned there [rad].
struct BentStation {
  double along = 0, up = 0, angle = 0;
};
BentStation station_at(double tip_angle, double s);

// The same asked from where it is: in a table, for the many places that a ray looks up. tip_angle from 0 to
// most_tip_angle; up: height of the place by that of the plant. False above the top of the bent plant.
struct UnbentStation {
  float s = 0, along = 0, angle = 0;
};
class UnbentTable {
 public:
  UnbentTable();
  bool find(float tip_angle, float up, UnbentStation& station) const;

 private:
  static constexpr int angles = 64, heights = 64;
  std::vector<float> top_;                    // (angles + 1)
  std::vector<Eigen::Vector2f> s_and_along_;  // (angles + 1) x (heights + 1), by height under the top
};

// How a wind moves the tops of plants that stand at a place [m], at a time [s]: linear, in metres.
using TopSway = std::function<Eigen::Vector2d(const Eigen::Vector2d& place, double time)>;

// How a plant stands whose top would be displaced so far [m] in linear theory.
struct Bend {
  Eigen::Vector2d along{1, 0};  // unit, to where it bends
  double tip_angle = 0;         // [rad]
};
Bend bend_of(const Eigen::Vector2d& displacement, double height);

// Where a point of a bent plant goes. Of a stem (`held` below 0) it bends as above; what a stem holds at a
// height [m] turns with it as it is. `height`: of what bends so; `tallness`: of the plant by that, which
// presses heights together and not what is across.
Vec3 bent_point(const Bend& bend, const Vec3& point, const Eigen::Vector2d& foot, double held, double height,
                double tallness = 1);

// F's way: the shape model itself is bent, for scan_convert to make the texture of. Stems bend as above, by
// `displacement` [m] where their plant stands; what a stem holds turns with it as it is. `height`: of what
// bends so [m], that of the patch.
StrandPatch bend_strands(const StrandPatch& patch,
                         const std::function<Eigen::Vector2d(const Eigen::Vector2d& foot)>& displacement);

}  // namespace tremula
