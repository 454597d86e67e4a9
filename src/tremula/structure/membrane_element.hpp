// A rectangle of a thin flat plate in its plane: plane stress, bilinear in both displacements (Turner et al.
// 1956; Przemieniecki 1968, section 5.5), and a rotation about the normal of its own.
//
// The rotation theta_z is bilinear, too, and tied to that of the displacements, omega = (dv/dx - du/dy) / 2,
// by the energy 1/2 G h int (omega - theta_z)^2 (Hughes & Brezzi 1989, Comput. Methods Appl. Mech. Eng. 72).
// So a beam that is joined to a corner turns the plate about its normal. Where stretch and shear are even it
// is 0, and what it adds elsewhere vanishes with the size of the elements.
#pragma once

#include "tremula/structure/plate_element.hpp"

#include <Eigen/Core>

namespace tremula {

// What the plate is made of, for its plane.
struct MembraneSection {
  double stretch_stiffness;  // E h [N/m]
  double poisson_ratio;
  double mass_per_area;     // [kg/m^2]
  double inertia_per_area;  // of theta_z, rho h^3 / 12 as of the other two rotations [kg]

  double shear_stiffness() const { return stretch_stiffness / (2 * (1 + poisson_ratio)); }  // G h
};
MembraneSection membrane_section(double thickness, double youngs_modulus, double poisson_ratio,
                                 double density);

// What a bilinear function takes of the corners at (s, t) (0 … 1), in the order of plate_element.hpp.
Eigen::Vector4d corner_shares(double s, double t);

// Stretches along x and y and shear (gamma) at (s, t) are the products with (u, v) of the corners.
Eigen::Matrix<double, 3, 8> membrane_strains(const PlateElement& element, double s, double t);

// Forces N_x, N_y, N_xy per E h from these strains.
Eigen::Matrix3d plane_stress(double poisson_ratio);

// Over (u, v, theta_z) of the corners [m, m, rad]. rotation_stiffness: of omega - theta_z, in parts of G h.
// Integrated exactly, with 2 x 2 points.
PlateMatrix membrane_stiffness(const PlateElement& element, const MembraneSection& section,
                               double rotation_stiffness = 1);
PlateMatrix membrane_mass(const PlateElement& element, const MembraneSection& section);

}  // namespace tremula
