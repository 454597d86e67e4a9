// Trees under dead loads: forces that stay what they are while the plant moves, such as its weight.
//
// The shape given is the shape under the loads, so they bend nothing; but when the plant moves they do work,
// and to second order that is geometric stiffness. A branch has strains theta'(s) (twist and bending) and
// epsilon(s) (stretch), and turns by theta(s) against the rotation Theta of its carrier. The exact potential
// of a force f at q beyond s is of second order
//
//   -sum over branches of int (Theta + theta)^T A(s) theta' ds + int F(s) . ((Theta + theta) x d) epsilon ds,
//   A(s) = W(s) - tr(W(s)) I,  W(s) = sum over the forces beyond s of (x - x(s)) f^T,  F(s) their sum,
//
// with the shape functions of the beam for theta and epsilon. The elastic energy is a quadratic in the
// strains whatever the loads, so K_t = K + K_G with K as before, and K_G from each branch by itself: of its
// end relative to its rigidly carried start, and of Theta. A force within a branch is a force at its place.
//
// K_t is not assembled either. Elimination from the tips to the roots gives every branch a pivot
// P = I + S^T E S = L L^T (E: all geometric stiffness on its end), and with it a carry and a root that stand
// in for its own in all sweeps: K_t^-1 = B^-1 S S^T B^-T again.
#pragma once

#include "tremula/structure/beam_tree.hpp"

#include <vector>

namespace tremula {

struct PointForce {
  int branch = 0;
  double position = 1;        // 0 start … 1 end
  Vec3 force = Vec3::Zero();  // [N]
};

struct DeadLoads {
  std::vector<Vec3> per_volume;    // (N) on the wood of each branch [N/m^3]
  std::vector<PointForce> points;  // in any order
};

// Throws InputError for loads on other branches than there are, or places outside them.
void check_dead_loads(const BeamTree& tree, const DeadLoads& loads);

// Gravity on wood and leaves. In a fluid (StructureOptions::added_mass_density) wood weighs less by as much
// fluid, and a tube, whose bore is full of gas and sealed, by all of what it displaces: what is lighter is
// pulled up, and so are the floats of kelp. The volume of leaves is not known, and is taken to be that of as
// much water.
DeadLoads weight(const Skeleton& skeleton, const StructureOptions& options);

// The second-order potential of the loads on a tree without (its own `geometric` counts for nothing). (N)
// Throws as check_dead_loads does.
std::vector<GeometricStiffness> geometric_stiffness(const BeamTree& tree, const DeadLoads& loads);

// The tree under the loads, in place of any that it was under. Throws InputError where it cannot stand under
// them: a pivot is not positive.
BeamTree under_load(BeamTree tree, const DeadLoads& loads);

// The same from what geometric_stiffness gives. False, and the tree not fit for use, where it cannot stand.
// given_up: what share of the branches may be freed of their loads instead, a twig that gives way with all
// that it carries.
bool take_load(std::vector<GeometricStiffness> geometric, BeamTree& tree, double given_up = 0);

}  // namespace tremula
