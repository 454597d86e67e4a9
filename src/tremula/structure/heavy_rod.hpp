// A blade or a stem as a rod: clamped at its foot, heavy, with a mass at its tip if it bears an ear, and bent
// by a wind as far as that likes. It bends and does not stretch or twist, and is as stiff to all sides.
//
// A chain of rigid pieces stands for it. Where it is small that is the linear beam-column, where it is large
// the elastica; both to second order in the length of a piece.
#pragma once

#include "tremula/base/types.hpp"

#include <vector>

#include <Eigen/Core>

namespace tremula {

struct HeavyRod {
  double length = 1;             // [m]
  double bending_stiffness = 1;  // EI [N m^2]
  double mass = 1;               // of a metre [kg/m]
  double tip_mass = 0;           // [kg]
  double gravity = 9.81;         // [m/s^2]
  int pieces = 20;
};

// What a wind would do to it if it stood upright: force on a metre at its tip, which fades below as the
// square of a wind U(h) exp(-a (1 - z/h)) does, and on the tip itself.
struct RodDrag {
  double along = 0;  // [N/m]
  double tip = 0;    // [N]
  double decay = 0;  // a
};

// Throw InputError for lengths, stiffnesses and masses that are not above 0, fewer than 4 pieces, numbers
// that are not finite, and for a rod that its weight would buckle (Greenhill 1881: q L^3/EI = 7.837).
void check_rod(const HeavyRod& rod);

// EI with which the rod, upright and under its weight, has this first natural frequency [Hz]. The stiffness
// in `rod` is not asked.
double stiffness_of_frequency(const HeavyRod& rod, double frequency);
double first_frequency(const HeavyRod& rod);  // [Hz]

// The angle of the tip of an upright rod under so much drag, as if all were linear [rad].
double linear_tip_angle(const HeavyRod& rod, const RodDrag& drag);

// The rate [1/s] at which a force on the velocity, c on a metre [N s/m^2] (fading as the wind itself, once)
// and c_tip on the tip [N s/m], damps the first mode: 2 zeta omega.
double damping_rate(const HeavyRod& rod, const RodDrag& per_velocity);

// The directions (unit, z up) of its pieces, from the foot, in a wind to `heading` (unit, horizontal). The
// drag is that of the wind's part across the rod, p |u_n| u_n. rest: the directions that the rod has under
// its weight alone (3 x pieces), unit; its curvature at rest is its own and bears no moment but that of the
// weight. Throws InputError as check_rod, and for sizes that do not agree; Error where it does not come to
// rest.
Eigen::Matrix3Xd bend_rod(const HeavyRod& rod, const Eigen::Matrix3Xd& rest, const RodDrag& drag,
                          const Vec3& heading);

// The same many times, from one load to a near one: starts at the shape of the load before. tolerance: of the
// turn between two pieces [rad]. A rod that leans against a strong wind may find no rest, for drag is no
// potential: then it is left where it has come to.
class RodBender {
 public:
  RodBender(const HeavyRod& rod, const Eigen::Matrix3Xd& rest, double tolerance = 1e-9);
  const Eigen::Matrix3Xd& bend(const RodDrag& drag, const Vec3& heading);
  bool is_at_rest() const { return at_rest_; }  // under the last load

 private:
  using Moments = std::vector<Vec3>;
  void find_moments(const Eigen::VectorXd& drags, const Vec3& heading);
  void stand();  // directions and frames from the strains

  HeavyRod rod_;
  double tolerance_;
  bool at_rest_ = true;
  Moments moments_;                              // of what is above a joint, about it
  std::vector<Mat3> rest_turns_, frames_;        // of a piece against the one before, and of the piece
  std::vector<Eigen::Vector2d> rest_, strains_;  // moments at rest, and turns beyond it; of the joints' axes
  Eigen::Matrix3Xd directions_;
};

}  // namespace tremula
