#include "tremula/structure/beam.hpp"

#include "tremula/numerics/quadrature.hpp"

#include <algorithm>
#include <cmath>
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

double bending_stiffness(const Beam& beam) { return beam.material.youngs_modulus * beam.inertia_factor; }

// Of the beam alone, its base rigid. slope_held is worked out by hand: as a difference it would lose its
// digits where the end is the thick one.
Compliance own_compliance(const Beam& beam) {
  const Flexibility f = flexibility(beam.length, beam.start_radius, beam.end_radius);
  const double bending = bending_stiffness(beam);
  return {
      f.axial / (beam.material.youngs_modulus * pi * beam.tube.area),
      f.torsion / (beam.material.shear_modulus * pi / 2 * beam.tube.polar),
      f.deflection / bending,
      f.deflection_slope / bending,
      f.slope / bending,
      beam.length / (4 * bending * beam.start_radius * beam.end_radius * beam.end_radius * beam.end_radius)};
}

Shape own_shape_at(const Beam& beam, double s) {
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

// The start of the beam moves with end 0 and, in the ratio of the spring's compliance to the whole, with what
// end 1 does beyond that. The entries of the ratio are written out so that a soft spring cancels nothing.
Shape on_compliant_base(const Beam& beam, const Shape& own) {
  const Compliance whole = compliance(beam);
  const auto [translation, rotation] = beam.base;
  const double length = beam.length, a = beam.start_radius, b = beam.end_radius;
  const double along = translation / whole.axial, twist = rotation / whole.torsion;
  // int x dx/EI and int x (L - x) dx/EI, x from the start.
  const double lever = length * length * (2 * a + b) / (6 * bending_stiffness(beam) * a * a * b * b * b);
  const double levers = length * length * length / (6 * bending_stiffness(beam) * a * a * b * b);
  const double v = translation / whole.deflection / whole.slope_held;
  const double phi = rotation / whole.deflection / whole.slope_held;
  Eigen::Matrix2d share;  // of (v_1 - v_0 - L phi_0, phi_1 - phi_0)
  share << v * whole.slope, -v * whole.deflection_slope, phi * lever, phi * (translation - levers);
  Eigen::Matrix<double, 2, 4> relative;
  relative << -1, -length, 1, 0, 0, -1, 0, 1;

  Shape shape;
  shape.axial = own.axial[0] * Eigen::Vector2d(1 - along, along) + own.axial[1] * Eigen::Vector2d(0, 1);
  shape.torsion = own.torsion[0] * Eigen::Vector2d(1 - twist, twist) + own.torsion[1] * Eigen::Vector2d(0, 1);
  const auto with_start = [&](const Eigen::Vector4d& of_ends) -> Eigen::Vector4d {
    return of_ends + relative.transpose() * (share.transpose() * of_ends.head<2>());
  };
  shape.deflection = with_start(own.deflection);
  shape.slope = with_start(own.slope);
  return shape;
}

}  // namespace

Beam make_beam(const Branch& branch, const Material& material, Section section) {
  Beam beam{branch.length(), branch.start_radius, branch.end_radius, pi / 4, material};
  if (section == Section::paper) {
    beam.start_radius = beam.end_radius = 0.5 * (branch.start_radius + branch.end_radius);
    beam.inertia_factor = pi;
  }
  beam.tube = tube_share(branch.wall);
  beam.inertia_factor *= beam.tube.polar;
  return beam;
}

// With the bore 1 - wall of the radius: 1 - bore^2 and 1 - bore^4, without differences of what is nearly 1.
TubeShare tube_share(double wall) {
  const double bore = 1 - wall, area = wall * (1 + bore);
  return {area, area * (1 + bore * bore)};
}

double bending_stiffness_at(const Beam& beam, double s) {
  const double r = radius_at(beam, s);
  return bending_stiffness(beam) * r * r * r * r;
}

double mass_per_length_at(const Beam& beam, double s) {
  const double r = radius_at(beam, s);
  return beam.material.density * pi * r * r * beam.tube.area;
}

Compliance compliance(const Beam& beam) {
  const Compliance own = own_compliance(beam);
  const auto [translation, rotation] = beam.base;
  const double length = beam.length;
  const double deflection = own.deflection + translation + rotation * length * length;
  const double slope = own.slope + rotation;
  // slope - deflection_slope^2/deflection with all that cancels left out; seen_from_tip is the deflection of
  // the beam under a force at its start, were its end clamped.
  const double seen_from_tip =
      length * length * length /
      (3 * bending_stiffness(beam) * beam.start_radius * std::pow(beam.end_radius, 3));
  const double slope_held = own.slope_held * (own.deflection / deflection) +
                            (translation / deflection) * slope + (rotation / deflection) * seen_from_tip;
  return {own.axial + translation,
          own.torsion + rotation,
          deflection,
          own.deflection_slope + rotation * length,
          slope,
          slope_held};
}

Shape shape_at(const Beam& beam, double s) {
  const Shape own = own_shape_at(beam, s);
  return beam.base.translation > 0 || beam.base.rotation > 0 ? on_compliant_base(beam, own) : own;
}

// The wrench that moves end 1 by 1, over the stiffness of the section.
Strain strain_at(const Beam& beam, const Compliance& c, double s) {
  const double r = radius_at(beam, s), r2 = r * r, rest = (1 - s) * beam.length;
  const double bending = c.deflection * c.slope_held * bending_stiffness(beam) * r2 * r2;
  return {1 / (c.axial * beam.material.youngs_modulus * pi * r2 * beam.tube.area),
          1 / (c.torsion * beam.material.shear_modulus * (pi / 2) * r2 * r2 * beam.tube.polar),
          Eigen::Vector2d(rest * c.slope - c.deflection_slope, c.deflection - rest * c.deflection_slope) /
              bending};
}

std::vector<VolumePoint> volume_points(const Beam& beam) {
  std::vector<VolumePoint> points;
  for (const QuadraturePoint& point : quadrature_for(beam)) {
    const double r = radius_at(beam, point.position), length = point.weight * beam.length;
    points.push_back({point.position, length, length * pi * r * r * beam.tube.area});
  }
  return points;
}

VolumeBeyond volume_beyond(const Beam& beam, double s) {
  const double a = radius_at(beam, s), b = beam.end_radius, rest = (1 - s) * beam.length;
  return {pi * rest * (a * a + a * b + b * b) / 3 * beam.tube.area,
          pi * rest * rest * (a * a / 12 + a * b / 6 + b * b / 4) * beam.tube.area};
}

ElementMass consistent_mass(const Beam& beam, bool rotatory_inertia) {
  // Their terms grow with 1/length while what they say of a disc vanishes: in double precision they would
  // bury the masses beside it.
  constexpr double thinnest = 1e-6;
  const bool is_disc = beam.length < thinnest * std::max(beam.start_radius, beam.end_radius);
  const double area = pi * beam.tube.area, polar = pi / 2 * beam.tube.polar;  // times r^2, r^4
  ElementMass mass;
  for (const QuadraturePoint& point : quadrature_for(beam)) {
    const Shape shape = shape_at(beam, point.position);
    const double r = radius_at(beam, point.position), r2 = r * r;
    const double per_length = beam.material.density * beam.length * point.weight;
    mass.axial += per_length * area * r2 * shape.axial * shape.axial.transpose();
    mass.torsion += per_length * polar * r2 * r2 * shape.torsion * shape.torsion.transpose();
    mass.bending += per_length * area * r2 * shape.deflection * shape.deflection.transpose();
    if (rotatory_inertia && !is_disc) {
      mass.bending += per_length * beam.inertia_factor * r2 * r2 * shape.slope * shape.slope.transpose();
    }
  }
  return mass;
}

void add_fluid_mass(const Beam& beam, double density, ElementMass& element) {
  if (density == 0) return;
  for (const QuadraturePoint& point : quadrature_for(beam)) {
    const Shape shape = shape_at(beam, point.position);
    const double r = radius_at(beam, point.position);
    element.bending +=
        density * beam.length * point.weight * pi * r * r * shape.deflection * shape.deflection.transpose();
  }
}

void add_point_mass(const Beam& beam, double s, double mass, ElementMass& element) {
  const Shape shape = shape_at(beam, s);
  element.axial += mass * shape.axial * shape.axial.transpose();
  element.bending += mass * shape.deflection * shape.deflection.transpose();
}

}  // namespace tremula
