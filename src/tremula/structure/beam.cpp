#include "tremula/structure/beam.hpp"

#include "tremula/numerics/quadrature.hpp"

#include <algorithm>
#include <numbers>
#include <vector>

#include <Eigen/LU>

namespace tremula {
namespace {

using std::numbers::pi;

// Lengths and section only: the moduli divide out of shapes, and multiply compliances.
struct Flexibility {
  double axial, torsion, deflection, deflection_slope, slope;
};

// Integrals over the first x of the beam, r linear from a to b, xi the distance from the section at x:
// int dx/r^2 = x/(ab); int dx/r^4 = x (a^2+ab+b^2)/(3 a^3 b^3); int xi dx/r^4 = x^2 (a+2b)/(6 a^3 b^2);
// int xi^2 dx/r^4 = x^3/(3 a^3 b).
Flexibility flexibility(double x, double a, double b) {
  const double a3 = a * a * a;
  const double fourth = x * (a * a + a * b + b * b) / (3 * a3 * b * b * b);
  return {x / (a * b), fourth, x * x * x / (3 * a3 * b), x * x * (a + 2 * b) / (6 * a3 * b * b), fourth};
}

double radius_at(const Beam& beam, double s) {
  return beam.start_radius + s * (beam.end_radius - beam.start_radius);
}

const std::vector<QuadraturePoint>& quadrature_for(const Beam& beam) {
  // Equal radii: the integrands are polynomials of degree 6, four points are exact. Tapered: rational
  // functions, smooth as long as the radii are of one order of magnitude.
  static const std::vector<QuadraturePoint> uniform = gauss_legendre(4), gentle = gauss_legendre(12),
                                            strong = gauss_legendre(64);
  const double ratio = std::max(beam.start_radius / beam.end_radius, beam.end_radius / beam.start_radius);
  return ratio == 1 ? uniform : ratio < 3 ? gentle : strong;
}

}  // namespace

Beam make_beam(const Branch& branch, const Material& material, Section section) {
  Beam beam{branch.length(), branch.start_radius, branch.end_radius, pi / 4, material};
  if (section == Section::paper) {
    beam.start_radius = beam.end_radius = 0.5 * (branch.start_radius + branch.end_radius);
    beam.inertia_factor = pi;
  }
  return beam;
}

// slope_held is worked out by hand: as a difference it would lose its digits where the end is the thick one.
Compliance compliance(const Beam& beam) {
  const Flexibility f = flexibility(beam.length, beam.start_radius, beam.end_radius);
  const double bending = beam.material.youngs_modulus * beam.inertia_factor;
  return {
      f.axial / (beam.material.youngs_modulus * pi),
      f.torsion / (beam.material.shear_modulus * pi / 2),
      f.deflection / bending,
      f.deflection_slope / bending,
      f.slope / bending,
      beam.length / (4 * bending * beam.start_radius * beam.end_radius * beam.end_radius * beam.end_radius)};
}

Shape shape_at(const Beam& beam, double s) {
  const double length = beam.length, x = s * length;
  const Flexibility whole = flexibility(length, beam.start_radius, beam.end_radius);
  const Flexibility part = flexibility(x, beam.start_radius, radius_at(beam, s));

  // The tip's deflection and slope relative to the rigidly carried start give the end force P and moment M;
  // the section at x is the tip of a shorter beam under P and M + P (L - x).
  Eigen::Matrix2d whole_bending, part_bending, carry;
  whole_bending << whole.deflection, whole.deflection_slope, whole.deflection_slope, whole.slope;
  part_bending << part.deflection, part.deflection_slope, part.deflection_slope, part.slope;
  carry << 1, 0, length - x, 1;
  const Eigen::Matrix2d relative = part_bending * carry * whole_bending.inverse();

  Shape shape;
  shape.axial << 1 - part.axial / whole.axial, part.axial / whole.axial;
  shape.torsion << 1 - part.torsion / whole.torsion, part.torsion / whole.torsion;
  shape.deflection << 1 - relative(0, 0), x - length * relative(0, 0) - relative(0, 1), relative(0, 0),
      relative(0, 1);
  shape.slope << -relative(1, 0), 1 - length * relative(1, 0) - relative(1, 1), relative(1, 0),
      relative(1, 1);
  return shape;
}

ElementMass consistent_mass(const Beam& beam, bool rotatory_inertia) {
  ElementMass mass;
  for (const QuadraturePoint& point : quadrature_for(beam)) {
    const Shape shape = shape_at(beam, point.position);
    const double r = radius_at(beam, point.position), r2 = r * r;
    const double per_length = beam.material.density * beam.length * point.weight;
    mass.axial += per_length * pi * r2 * shape.axial * shape.axial.transpose();
    mass.torsion += per_length * (pi / 2) * r2 * r2 * shape.torsion * shape.torsion.transpose();
    mass.bending += per_length * pi * r2 * shape.deflection * shape.deflection.transpose();
    if (rotatory_inertia) {
      mass.bending += per_length * beam.inertia_factor * r2 * r2 * shape.slope * shape.slope.transpose();
    }
  }
  return mass;
}

void add_point_mass(const Beam& beam, double s, double mass, ElementMass& element) {
  const Shape shape = shape_at(beam, s);
  element.axial += mass * shape.axial * shape.axial.transpose();
  element.bending += mass * shape.deflection * shape.deflection.transpose();
}

}  // namespace tremula
