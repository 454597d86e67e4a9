// One branch as a beam: 3-D Euler–Bernoulli, round section, solid or hollow, radii that may differ at the two
// ends.
//
// A round section has no preferred direction across the branch, so nothing here needs local y and z axes.
// With the unit vector d along the branch, a displacement splits into a part along d, twist about d, and,
// across d, the deflection v and the slope phi = theta x d (the derivative of v along the branch). Along,
// twist and bending are uncoupled; bending is the same in all directions. So 12 x 12 matrices shrink to 2 x
// 2, 2 x 2 and 4 x 4 scalars.
#pragma once

#include "tremula/geometry/skeleton.hpp"
#include "tremula/structure/material.hpp"

#include <vector>

#include <Eigen/Core>

namespace tremula {

enum class Section {
  exact,  // linear taper, A = pi r^2, I = pi r^4/4, J = pi r^4/2
  paper,  // S appendix A as printed: mean radius, I = pi r^4 (errata S1)
};

// What the start of a beam gives way by before the beam itself bends: the inverse of an isotropic spring
// without mass between the start and what carries it. Zero: rigid.
struct BaseCompliance {
  double translation = 0;  // [m/N]
  double rotation = 0;     // [rad/(N m)]
};

// Of a tube, what there is of a disc; its bore narrows with its radius, so that these hold all along.
struct TubeShare {
  double area = 1;   // A / (pi r^2)
  double polar = 1;  // J / (pi r^4/2)
};
TubeShare tube_share(double wall);  // thickness over radius; 1: solid

// Compliance, shapes and mass below are those of the beam and the spring at its base in series: the start,
// end 0, is the far side of the spring. With a rigid base that is the beam alone, to the bit.
struct Beam {
  double length;                    // [m]
  double start_radius, end_radius;  // [m]
  double inertia_factor;            // I / r^4: of a disc pi/4, or pi as printed in S; of a tube its share
  Moduli material;
  BaseCompliance base = {};
  TubeShare tube = {};  // of a hollow one
};

Beam make_beam(const Branch& branch, const Material& material, Section section);

// Of the section at s (0 start … 1 end): EI [N m^2] and rho A [kg/m].
double bending_stiffness_at(const Beam& beam, double s);
double mass_per_length_at(const Beam& beam, double s);

// Displacements of the tip of the beam, clamped at its start, per unit force and moment at the tip.
// Closed forms of the integrals of flexibility; for equal radii L/EA, L/GJ, L^3/3EI, L^2/2EI, L/EI.
struct Compliance {
  double axial;             // along / force along [m/N]
  double torsion;           // twist / twisting moment [rad/(N m)]
  double deflection;        // v / force across [m/N]
  double deflection_slope;  // v / bending moment = phi / force across [1/N]
  double slope;             // phi / bending moment [rad/(N m)]
  double slope_held;  // the same while the deflection is held at 0: slope - deflection_slope^2 / deflection
                      // [rad/(N m)]
};
Compliance compliance(const Beam& beam);

// How the section at s (0 start … 1 end) moves when the ends move and nothing loads the beam between them:
// the exact static shape functions, Hermite's cubics for equal radii. v(s) = deflection . (v_0, phi_0, v_1,
// phi_1). On a compliant base the section at s = 0 moves too, although end 0 stands still.
struct Shape {
  Eigen::Vector2d axial;       // of (along_0, along_1)
  Eigen::Vector2d torsion;     // of (twist_0, twist_1)
  Eigen::Vector4d deflection;  // of (v_0, phi_0, v_1, phi_1) [1, m, 1, m]
  Eigen::Vector4d slope;       // of the same [1/m, 1, 1/m, 1]
};
Shape shape_at(const Beam& beam, double s);

// How strongly the section at s is stretched, twisted and bent when end 1 moves by 1 and end 0 stands: the
// derivatives along the branch of what Shape says of end 1, inside the beam (the spring's give is no strain).
struct Strain {
  double axial;               // of along_1 [1/m]
  double torsion;             // of twist_1 [1/m]
  Eigen::Vector2d curvature;  // of (v_1, phi_1) [1/m^2, 1/m]
};
Strain strain_at(const Beam& beam, const Compliance& compliance, double s);

// A point of the branch at s with its share of the volume, by the quadrature of the consistent mass.
struct VolumePoint {
  double s, length, volume;  // [-, m, m^3]
};
std::vector<VolumePoint> volume_points(const Beam& beam);

// Of the wood beyond s: its volume [m^3], and that times how far beyond s its centre lies [m^4].
struct VolumeBeyond {
  double volume, moment;
};
VolumeBeyond volume_beyond(const Beam& beam, double s);

// Consistent mass over the ends' displacements, in the same order as Shape. For equal radii it is
// Przemieniecki's matrix with torsional and, unless dropped, rotatory inertia. A beam shorter than a
// millionth of its radius has no rotatory inertia.
struct ElementMass {
  Eigen::Matrix2d axial = Eigen::Matrix2d::Zero();    // [kg]
  Eigen::Matrix2d torsion = Eigen::Matrix2d::Zero();  // [kg m^2]
  Eigen::Matrix4d bending = Eigen::Matrix4d::Zero();  // [kg, kg m, kg m^2]
};
ElementMass consistent_mass(const Beam& beam, bool rotatory_inertia);

// The mass of the fluid that moves with the branch across its axis: density times the volume, by the same
// shape functions, added to `element`. Nothing along the axis, nothing about it.
void add_fluid_mass(const Beam& beam, double density, ElementMass& element);

// A point mass on the axis at s, carried by the beam's shape functions.
void add_point_mass(const Beam& beam, double s, double mass, ElementMass& element);

}  // namespace tremula
