// Flags that flap by themselves, and hang where the wind is too weak to: what happens above the speed of
// flutter.hpp, where nothing about rest is small.
//
// Woven cloth shears easily and does not stretch, so the threads that run from the hoist to the fly stay as
// long as they are and go alike, one above the other. At s from the hoist a thread runs at theta(s, t) out of
// the plane of rest and, where an upright hoist holds it, at delta(s, t) down from the level,
//
//   dr/ds = (cos delta cos theta, cos delta sin theta, -sin delta),
//
// theta of a few sines (clamped) or cosines (pinned), delta of a few cosines; a plate does not shear, delta
// = 0. The equations are Lagrange's, exact for any angle. The air is Lighthill's for large amplitudes: with u
// and w the speed of the sheet along itself and across itself through the air and p = A w the momentum of the
// air, the force along the normal is -(dp/dt - (u p)' + kappa w p / 2) (Candelier, Boyer & Leroyer 2011, J.
// Fluid Mech. 674; Michelin & Doare 2013, J. Fluid Mech. 714), and of the flow that leaves it
// -1/2 rho C_d |w| w. A is that of sections (rho pi b/4 on an area) for long waves and that of an endless
// plane (2 rho/k) for short ones, 1/A their sum.
//
// What keeps real flags from rippling finely (Alben 2022 finds wavenumbers that go with the bending stiffness
// to -1/4, some 20 cm for cloth) is not in such a theory. fluid_damping stands for it: a moment against the
// rate of the curvature, rho U L^3 times it, chosen so that frequency, amplitude and drag are those of flags
// (tests/dynamics/flapping_test.cpp).
#pragma once

#include "tremula/dynamics/damping.hpp"
#include "tremula/numerics/time_axis.hpp"
#include "tremula/structure/structure.hpp"
#include "tremula/wind/point_wind.hpp"

#include <array>
#include <functional>
#include <optional>

#include <Eigen/Core>

namespace tremula {

struct Flag {
  double length = 0, span = 0;   // along its threads and across them [m]
  double mass_per_area = 0;      // [kg/m^2]
  double bending_stiffness = 0;  // of a strip of 1 m [N m]
  bool pinned = false;           // turns at the hoist
  bool shears = false;           // woven
  Vec3 onwards = Vec3::UnitX();  // from the hoist along the threads
  Vec3 side = Vec3::UnitY();     // out of its plane, edge x onwards
  Vec3 edge = Vec3::UnitZ();     // along the hoist; upwards, if it is upright

  bool is_hung() const { return onwards.z() < -0.99; }
};

// A sheet that is held on one edge alone, an upright one or the level one that it hangs from, and not pulled;
// none for others.
std::optional<Flag> flag_of(const Sheet& sheet);
// Whether the wind [m/s] blows along it, from the hoist within 60 degrees, or not at all.
bool blows_along(const Flag& flag, const Vec3& wind);

// Whether a motion about rest would be wrong for it in this mean wind [m/s]: the wind blows along the flag,
// and either it is woven, hanging where the wind is too weak, or it is above its flutter speed (options:
// without pull); or it is cloth that hangs, and three times its weight blows at it, so that it would stand
// off at 60 degrees and more.
bool flaps(const Sheet& sheet, const SheetOptions& options, const Vec3& wind);

struct FlappingOptions {
  int modes = 6, droop_modes = 2;      // coordinates of theta, and of delta where it shears; 1 to 8, 0 to 4
  double fluid_density = 1.2;          // [kg/m^3]
  double gravity = 9.81;               // [m/s^2]
  double normal_coefficient = 1.8;     // C_d (Michelin & Doare 2013)
  double friction_coefficient = 0.02;  // along it, both sides together
  double fluid_damping = 1e-4;         // see above
  // c_j of damping.hpp, of such waves as natural_omega has [1/s]
  std::array<double, 8> damping_rates = {};
};

// omega of waves with the wavenumbers k of theta's coordinates, without air: k^2 sqrt(B/m). (modes) [rad/s]
Eigen::VectorXd natural_omega(const Flag& flag, const FlappingOptions& options);

// The angles of a flag and how fast they change: coordinates of theta, then of delta.
struct FlappingState {
  Eigen::VectorXd angles, rates;  // (n) [rad], [rad/s]
};

// Wind along onwards, side and edge at a time [m/s].
using WindInTime = std::function<Vec3(double time)>;

// `steps` + 1 states, `step` [s] apart, in columns; each step is divided as the equations need it. Runge and
// Kutta's fourth order. Throws InputError for options and sizes out of range, Error where numbers run away.
struct FlappingCourse {
  Eigen::MatrixXd angles;  // (n x steps + 1)
  Eigen::VectorXd pull;    // at the hoist along the flag at rest, of 1 m of span (steps + 1) [N/m]
  FlappingState last;
};
FlappingCourse integrate_flapping(const Flag& flag, const FlappingOptions& options,
                                  const FlappingState& start, const WindInTime& wind, double step, int steps);

// A little off rest, the fly hanging halfway where it shears.
FlappingState flapping_start(const Flag& flag, const FlappingOptions& options);

// Kinetic energy with that of the air, and potential energy, of 1 m of span [J/m].
double flapping_energy(const Flag& flag, const FlappingOptions& options, const FlappingState& state);

// (3 x count + 1) where a thread runs: (onwards, side, edge) from its hoist at equal steps along it [m].
Eigen::Matrix3Xd thread(const Flag& flag, const FlappingOptions& options, const Eigen::VectorXd& angles,
                        int count);

// A loop of M samples in a wind that repeats (3 x M) [m/s]. What flaps by itself repeats at its own time: of
// a long run, the piece is taken that is as long as the loop but for half a cycle, 10 % at most, and ends
// most nearly as it began; it is played in the time of the loop, and its last fifth fades into what went
// before its first instant. Lengths stay, since angles fade.
struct FlappingLoop {
  Eigen::MatrixXd angles;  // (n x M)
  double stretch = 1;      // how much longer the piece was
  double seam = 0;         // how far its end was from its beginning, of the motion itself
  double pull = 0;         // mean at the hoist, of 1 m of span [N/m]
};
FlappingLoop flap(const Flag& flag, const FlappingOptions& options, const TimeAxis& loop,
                  const Eigen::Matrix3Xd& wind);

// A clip instead, which ends as it ends: on from rest in still air, or from what the first wind keeps up.
// stretch is 1, seam 0.
FlappingLoop flap_through(const Flag& flag, const FlappingOptions& options, const TimeAxis& clip,
                          const Eigen::Matrix3Xd& wind, bool from_rest);

// The mean over all points of a wind as a loop has it: along onwards, side and edge (3 x M) [m/s].
// change, where given, is what becomes of it by and by (gust_script.hpp).
Eigen::Matrix3Xd wind_on(const Flag& flag, const PointWind& wind, const TimeAxis& loop,
                         const std::function<Mat3(double time)>& change = nullptr);

// FlappingOptions::damping_rates of a damping; what only turns has none. [1/s]
std::array<double, 8> damping_rates(const Flag& flag, const FlappingOptions& options, const Damping& damping);

// Where angles (n x M) put the nodes of the flag's sheet: translations of its rows (rows x M) [m].
Eigen::MatrixXd node_displacements(const Structure& sheet, const Flag& flag, const FlappingOptions& options,
                                   const Eigen::MatrixXd& angles);

}  // namespace tremula
