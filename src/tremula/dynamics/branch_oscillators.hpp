// A tree as F section 6.1 has it: every branch a beam with a clamp at its foot that swings in its own first
// mode, and pulls at what carries it.
//
// A branch here is an axis of the skeleton (geometry/surface.hpp), the whole culm of a bamboo and not one of
// its internodes. Its shapes are sums of V_r of the uniform beam (Ritz), so that taper, walls and leaves
// count; of a uniform axis they are V_r. What drives it is the wind on itself, across it, and what its
// children hand on: the wind along them, and the shear force at their feet, which is the inertia of the
// child, omega^2 int rho A V dx q = -EI V'''(0) q (F eq. 10). A child goes where its parent takes it.
//
// So it differs from the tree of beam_tree.hpp in that a branch does not feel that its foot moves, nor the
// parent the moments of its children and, unless asked, their mass; and one mode hands on only 61 % of a
// steady load. Stems are clamped, and feel no weight.
#pragma once

#include "tremula/dynamics/damping.hpp"
#include "tremula/dynamics/loads.hpp"
#include "tremula/dynamics/oscillators.hpp"
#include "tremula/structure/structure.hpp"

#include <array>
#include <vector>

#include <Eigen/Core>
#include <Eigen/SparseCore>

namespace tremula {

struct BranchOscillatorOptions {
  int modes = 1;              // of every branch, 1 to 8; F has one
  bool carried_mass = false;  // a branch swings with the mass of what it carries; F leaves it out
};

// Places along an axis run from 0, its foot, to 1, its tip.
struct OscillatorAxis {
  std::vector<int> members;                                     // from foot to tip
  std::vector<double> begin;                                    // place at which each begins
  int parent = -1;                                              // axis that carries it; -1: the ground
  double attachment = 0;                                        // place on that
  double length = 0;                                            // along its members [m]
  Vec3 direction = Vec3::UnitZ();                               // unit vector from foot to tip
  std::array<Vec3, 2> across = {Vec3::UnitX(), Vec3::UnitY()};  // unit vectors in which it swings
  Eigen::VectorXd omega;                                        // (modes) [rad/s]
  Eigen::MatrixXd shape;                 // (V_1, V_2, … x modes) [1/sqrt(kg)]: int rho A V^2 dx = 1
  Eigen::MatrixXd end_value, end_slope;  // (members x modes) of V and dV/dx where each member ends
  Eigen::VectorXd momentum;              // (modes) int rho A V dx [sqrt(kg)]
};

struct BranchOscillators {
  std::vector<OscillatorAxis> axes;  // parents before children
  int modes = 1;
  OscillatorNetwork network;  // one-way; masses 1, coordinates in m sqrt(kg), in the order of index()
  // From the wind at the points of the sites (3P) to the forces on the coordinates (n).
  Eigen::SparseMatrix<double, Eigen::RowMajor> participation;

  Eigen::Index index(int axis, int mode, int direction) const {
    return 2 * (static_cast<Eigen::Index>(modes) * axis + mode) + direction;
  }
};

// loads: on the sites of the structure. Throws InputError for a frame, for sites that are not those of the
// structure, options out of range, and damping as structural_damping does.
BranchOscillators branch_oscillators(const Structure& structure, const Sites& sites, const Loads& loads,
                                     const Damping& damping, const BranchOscillatorOptions& options = {});

// Where the coordinates (n) take the nodes of the structure: (rows) [m, rad].
Eigen::VectorXd displacement_of(const BranchOscillators& oscillators, const Structure& structure,
                                const Eigen::VectorXd& coordinates);

}  // namespace tremula
