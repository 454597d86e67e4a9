// When a sheet flutters: a flag in a wind along itself is stable up to some speed, and flaps by itself
// beyond. What is synthesised about rest is then wrong.
//
// Ideal fluid, small displacements. The sheet pushes through the wind at w' + U dw/ds; the potential that
// jumps across it by mu makes up for that, and the force on an area is -rho (d/dt + U d/ds) mu: what the
// fluid is set in motion by, and carried along (Lighthill 1960; Eloy, Souilliez & Schouveiler 2007, J. Fluids
// Struct. 23). With a wake behind the trailing edge that carries the jump of that edge along, as in a steady
// flow (Katz & Plotkin 2001, section 12). For a narrow sheet this is M_a (d/dt + U d/ds)^2 w with the added
// mass of its sections, rho pi b^2 / 4.
#pragma once

#include "tremula/structure/structure.hpp"

#include <limits>

#include <Eigen/Core>

namespace tremula {

// The reactive forces between modes: q'' + C q' + Omega^2 q = -(mass q'' + U damping q' + U^2 stiffness q).
struct ReactiveForces {
  Eigen::MatrixXd mass, damping, stiffness;  // (m x m) [-, 1/m, 1/m^2]
};

// shapes (rows x m) of the sheet, which is one; flow: a unit vector, whose part in the sheet counts, along
// its width or along its height, whichever is nearer. Throws InputError for what is no sheet, other sizes and
// a flow through it.
ReactiveForces reactive_forces(const Structure& sheet, const Eigen::MatrixXd& shapes, double fluid_density,
                               const Vec3& flow);

struct FlutterOnset {
  double speed =
      std::numeric_limits<double>::infinity();  // [m/s]; infinite: none up to the fastest asked for
  double frequency = 0;                         // of what grows there; 0: it does not return [Hz]
};

// The lowest speed up to `fastest` at which something grows, to 1e-6. omega (m) [rad/s] of the modes without
// fluid; damping (m) their rates c_r [1/s], empty: none. Solves the quadratic eigenproblem at some speeds,
// then bisects.
FlutterOnset find_flutter(const ReactiveForces& forces, const Eigen::VectorXd& omega, double fastest,
                          const Eigen::VectorXd& damping = {});

// Of a sheet that is made anew without its fluid, with what the options say besides; by its first `modes`.
// Throws as assemble and solve_modes do.
FlutterOnset find_flutter(const Sheet& sheet, SheetOptions options, const Vec3& flow, double fastest,
                          int modes = 12);

}  // namespace tremula
