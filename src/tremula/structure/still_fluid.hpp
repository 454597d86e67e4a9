// The fluid that a thin flat rectangle must move when it moves across itself: its added mass. For cloth in
// air that is most of what moves.
//
// Ideal fluid at rest, small displacements, no wake. The potential jumps across the plate by mu(x), and the
// fluid goes through the plate's plane with -(1/4 pi) f.p. int mu(x') |x - x'|^-3 dx'; that has to be the
// speed of the plate (Katz & Plotkin 2001, Low-Speed Aerodynamics, section 4). The jump times -rho d/dt is
// the force on an area. Panels of constant mu (rings of vortices) that fall short of every edge by a quarter
// of themselves, as for lattices in a flow.
#pragma once

#include <Eigen/Core>

namespace tremula {

struct FluidPanels {
  Eigen::Matrix2Xd centres;   // (2 x P) from a corner of the rectangle [m]
  double area;                // of one panel [m^2]
  Eigen::MatrixXd influence;  // (P x P) speed at the centres for a jump of 1 m^2/s; positive definite [1/m]
};

// Some `count` panels, about square. With w the speeds at the centres, the kinetic energy is
// rho area w^T influence^-1 w / 2. Relative errors fall with 1 / count.
FluidPanels fluid_panels(double width, double height, int count = 400);

}  // namespace tremula
