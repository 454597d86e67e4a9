// The slow way to the motion of a tree that bends as far as it likes: the whole tree, integrated in time,
// with its weight and with the drag of the wind that its branches meet where they are. What the frequency
// domain leaves out (drag that grows with the square of the wind, branches that turn out of it and sweep
// through it, bending beyond small angles) is all in it.
//
// Every node has a place and a frame of its own, so the equations are those of a system on (R^3 x SO(3))^N
// without constraints, and every instant is an equilibrium (equilibrium.hpp) with inertia among the loads.
// The scheme is the generalised-alpha method on that group (Chung & Hulbert 1993, J. Appl. Mech. 60; Bruls &
// Cardona 2010, J. Comput. Nonlinear Dyn. 5; rotations of a step and angular velocities in world axes): of
// second order in the step, stable at any step, and what is too fast for the step dies by a factor of the
// caller's choice every step.
//
// Inertia is the consistent mass of a branch, turned with its chord, times the accelerations of its ends:
// exact for a branch that moves rigidly, up to what a spin about its own axis brings (the gyroscopic terms of
// the sections, and the Coriolis acceleration of tangents, omega_along times omega_across, on the slopes).
#pragma once

#include "tremula/structure/equilibrium.hpp"
#include "tremula/structure/sites.hpp"

#include <cstddef>
#include <functional>
#include <vector>

#include <Eigen/Core>

namespace tremula {

// The wind [m/s] that a site meets at a time [s] where it stands [m]. Sites are numbered as find_sites does.
using WindAtSite = std::function<Vec3(std::size_t site, double time, const Vec3& position)>;

// What acts on a tree from outside. With v the wind relative to the site, the force is 1/2 rho C A |v_n| v_n
// at four Gauss points of every branch, v_n across its axis there; and 1/2 rho C(|v|) A |v| v on leaves, at
// the point of the axis that carries them.
struct WeightAndDrag {
  Vec3 gravity = {0, 0, -9.81};  // [m/s^2], of all of BeamTree::masses
  double fluid_density = 1.2;    // [kg/m^3]; 0: no drag
  double branch_drag_coefficient = 1.2;
  std::vector<BladeSite> leaves = {};
  std::function<double(double speed)> leaf_drag_coefficient = {};  // C(|v|); empty: leaves feel no wind
  WindAtSite wind = {};                                            // empty: still air
};

// The same on a tree that stands still at a time [s]: where the motion comes to rest in a steady wind. Keeps
// a reference to the tree. Throws InputError for leaves that no branch carries, and densities or coefficients
// below 0.
BranchLoads loads_at_rest(const BeamTree& tree, const WeightAndDrag& surroundings, double time = 0);

// Rayleigh's damping, mass M + stiffness K: a force against the velocity, in proportion to mass, and stress
// in proportion to the rate of the strains (Kelvin-Voigt). A mode of omega has the damping ratio
// (mass/omega + stiffness omega)/2.
struct RayleighDamping {
  double mass = 0;       // [1/s]
  double stiffness = 0;  // [s]
};
// The one that gives modes of two frequencies [Hz] a damping ratio; modes between have less, those outside
// more. Throws InputError for frequencies that are not above 0 or equal, and a ratio below 0.
RayleighDamping rayleigh_damping(double ratio, double frequency, double other_frequency);

struct LargeMotionState {
  Eigen::VectorXd strains;       // (6N)
  Eigen::VectorXd velocity;      // (6N) of the nodes, angular velocities behind; world axes [m/s, rad/s]
  std::vector<BentBranch> bent;  // (N)
  Wrenches wrenches;             // with inertia: what the ground really carries, to the first order in the
                                 // step at step 0
  int iterations = 0;            // of Newton's method in this step
};

struct LargeMotionSettings {
  double step = 0;  // [s]
  int step_count = 0;
  // By what the fastest motions are multiplied every step: 1 keeps them all (and may blow them up), 0 leaves
  // nothing.
  double high_frequency_radius = 0.7;
  RayleighDamping damping = {};
  Eigen::VectorXd at_rest = {};   // as EquilibriumOptions::at_rest
  Eigen::VectorXd strains = {};   // to start with (6N); empty: the shape at rest
  Eigen::VectorXd velocity = {};  // of the nodes, to start with (6N); empty: still
  // As EquilibriumOptions::tolerance. The shorter the steps, the larger must it be: forces of inertia are
  // differences of places over the square of the step, and rounding tells.
  double tolerance = 1e-9;
};

// Is told every state, that at step 0 too.
using LargeMotionObserver = std::function<void(int step, const LargeMotionState& state)>;

// The state at the last instant. Throws InputError for settings, sizes and numbers that are none, and Error
// where a step finds no equilibrium.
LargeMotionState integrate_large_motion(const BeamTree& tree, const WeightAndDrag& surroundings,
                                        const LargeMotionSettings& settings,
                                        const LargeMotionObserver& observer = {});

}  // namespace tremula
