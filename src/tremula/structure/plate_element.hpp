// A rectangle of a thin flat plate: Kirchhoff's theory, 12 degrees of freedom (Adini & Clough 1961, Melosh
// 1963; Przemieniecki 1968, Theory of Matrix Structural Analysis, sections 5.8, 11.8 and 15.5).
//
// The plate lies in the plane of x and y and moves by w along z. A corner has three degrees of freedom: w and
// the parts of its rotation vector about x and y, theta_x = dw/dy and theta_y = -dw/dx. Corners go round as
// (0, 0), (1, 0), (1, 1), (0, 1) in s = x / width and t = y / height. w is a cubic along each edge and
// continuous from one element to the next; the slope across an edge is so only at its ends, so frequencies
// need not come from above. They converge as the square of the element's size.
#pragma once

#include <Eigen/Core>

namespace tremula {

using PlateVector = Eigen::Matrix<double, 12, 1>;
using PlateMatrix = Eigen::Matrix<double, 12, 12>;

struct PlateElement {
  double width, height;  // along x and y [m]
};

// What the plate is made of.
struct PlateSection {
  double bending_stiffness;  // D = E h^3 / (12 (1 - nu^2)) [N m]
  double poisson_ratio;
  double mass_per_area;  // [kg/m^2]
};
PlateSection plate_section(double thickness, double youngs_modulus, double poisson_ratio, double density);

// Forces in the plane of the plate, per length of a cut; pull is above 0 [N/m].
struct MembraneForce {
  double x = 0, y = 0, xy = 0;
};

// How the point at (s, t) (0 … 1) follows the corners: the products with the displacements of the element are
// w [m], its derivatives and its second derivatives.
struct PlateShape {
  PlateVector deflection;             // [1, m, m]
  PlateVector slope_x, slope_y;       // dw/dx, dw/dy [1/m, 1, 1]
  PlateVector bend_x, bend_y, twist;  // d2w/dx2, d2w/dy2, d2w/dxdy [1/m^2, 1/m, 1/m]
};
PlateShape plate_shape_at(const PlateElement& element, double s, double t);

// The integrals of the strain energy of bending, of rho h w^2 and of N (grad w)^2, all by Gauss points that
// are exact. The mass has no rotatory inertia, which thin plates do without. The membrane force is even.
PlateMatrix plate_stiffness(const PlateElement& element, const PlateSection& section);
PlateMatrix plate_mass(const PlateElement& element, double mass_per_area);
PlateMatrix plate_geometric_stiffness(const PlateElement& element, const MembraneForce& force);

}  // namespace tremula
