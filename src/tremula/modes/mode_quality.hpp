// What each mode is: how strongly the ground and even loads move it (participation and effective mass), and
// which part of the plant bends or twists in it (kind).
#pragma once

#include "tremula/geometry/skeleton.hpp"
#include "tremula/modes/modes.hpp"
#include "tremula/structure/structure.hpp"

#include <string_view>
#include <vector>

#include <Eigen/Core>

namespace tremula {

enum class ModeKind {
  trunk,    // neither of the two below, and the trunk stores more than the branches in bending
  branch,   // neither of the two below, and the trunk does not
  bending,  // neither of the two below, in a structure that has no trunk
  torsion,  // more than half of the elastic energy is twist, of whatever branch
  axial,    // more than half of it is stretch along the branches
};
std::string_view name_of(ModeKind kind);

// Shares of the elastic energy e^T C^-1 e / 2, with e the displacement of a branch's end relative to its
// rigidly carried start. They add up to 1. By Rayleigh's principle each is also the relative change of
// omega^2 with that stiffness: torsion = d ln omega^2 / d ln G. A sheet has no members: all of it counts as
// bending, as does that of panels.
struct EnergyShares {
  double trunk;    // bending of the trunk; 0 where there is none
  double branch;   // bending of all other members
  double torsion;  // twist, everywhere
  double axial;    // stretch, everywhere
};

// Gamma_rd = q_r^T M_fa 1_d: 1_d is the rigid translation of all nodes, clamped ones included, by 1 m along
// world axis d, and M_fa holds the rows of the free nodes. Gamma_rd^2 is the effective modal mass: what the
// mode sets against ground that moves along d (Clough & Penzien, Dynamics of Structures). Over all 6N modes
// it adds up to 1_d^T M_af M_ff^-1 M_fa 1_d, which is the total mass but for what the consistent masses of
// the root branches hang on the clamped nodes; that vanishes as those branches are cut finer. Of modes with
// equal frequency only the sum means something, for they can be turned among themselves.
struct ModeQuality {
  Eigen::MatrixX3d participation;    // (m x 3) x, y, z [sqrt(kg)]
  double total_mass;                 // of wood and leaves [kg]
  std::vector<EnergyShares> energy;  // (m)
  std::vector<ModeKind> kind;        // (m)

  Eigen::MatrixX3d effective_mass() const { return participation.cwiseAbs2(); }            // (m x 3) [kg]
  Eigen::MatrixX3d effective_mass_share() const { return effective_mass() / total_mass; }  // (m x 3) 0 … 1
};

// Which branches are trunk: the axes (branch_continuations) that begin at a root. (N)
std::vector<bool> trunk_branches(const Skeleton& skeleton);

// `trunk`: which members are trunk, for a tree as trunk_branches gives it; a frame has none. One pass over
// the shapes.
ModeQuality assess_modes(const Structure& structure, const Modes& modes, const std::vector<bool>& trunk);

}  // namespace tremula
