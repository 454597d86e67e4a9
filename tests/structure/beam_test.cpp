#include "tremula/structure/beam.hpp"

#include "tremula/numerics/quadrature.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>
#include <Eigen/LU>
#include "trees.hpp"

namespace tremula {
namespace {

using std::numbers::pi;

const Material wood{"wood", 9e9, 7e8, 950, ""};

Beam beam_of(double length, double start_radius, double end_radius, Section section = Section::exact) {
  return make_beam(test::make_branch(0, Vec3::Zero(), length * Vec3::UnitX(), start_radius, end_radius), wood,
                   section);
}

TEST(Compliance, IsTheClosedFormOfAUniformBeam) {
  const double L = 1.7, r = 0.03, A = pi * r * r, I = pi * std::pow(r, 4) / 4, J = 2 * I;
  const Compliance c = compliance(beam_of(L, r, r));
  EXPECT_NEAR(c.axial * wood.youngs_modulus * A / L, 1, 1e-14);
  EXPECT_NEAR(c.torsion * wood.shear_modulus * J / L, 1, 1e-14);
  EXPECT_NEAR(c.deflection * 3 * wood.youngs_modulus * I / (L * L * L), 1, 1e-14);
  EXPECT_NEAR(c.deflection_slope * 2 * wood.youngs_modulus * I / (L * L), 1, 1e-14);
  EXPECT_NEAR(c.slope * wood.youngs_modulus * I / L, 1, 1e-14);
}

TEST(Compliance, OfATaperedBeamIsTheIntegralOfItsFlexibility) {
  for (const double tip : {0.029, 0.02, 0.005, 0.04}) {
    const double L = 1.3, base = 0.03;
    const Compliance c = compliance(beam_of(L, base, tip));
    double axial = 0, torsion = 0, deflection = 0, cross = 0, slope = 0;
    for (const QuadraturePoint& q : gauss_legendre(200)) {
      const double r = base + q.position * (tip - base), arm = (1 - q.position) * L, w = q.weight * L;
      const double EI = wood.youngs_modulus * pi * std::pow(r, 4) / 4;
      axial += w / (wood.youngs_modulus * pi * r * r);
      torsion += w / (wood.shear_modulus * pi * std::pow(r, 4) / 2);
      deflection += w * arm * arm / EI;
      cross += w * arm / EI;
      slope += w / EI;
    }
    EXPECT_NEAR(c.axial / axial, 1, 1e-12) << tip;
    EXPECT_NEAR(c.torsion / torsion, 1, 1e-12) << tip;
    EXPECT_NEAR(c.deflection / deflection, 1, 1e-12) << tip;
    EXPECT_NEAR(c.deflection_slope / cross, 1, 1e-12) << tip;
    EXPECT_NEAR(c.slope / slope, 1, 1e-12) << tip;
  }
}

TEST(Compliance, HeldSlopeIsTheDifferenceItStandsForAndStaysPositiveForAThickEnd) {
  for (const double tip : {0.03, 0.01, 0.06}) {
    const Compliance c = compliance(beam_of(1.2, 0.03, tip));
    EXPECT_NEAR(c.slope_held / (c.slope - c.deflection_slope * c.deflection_slope / c.deflection), 1, 1e-11)
        << tip;
  }
  EXPECT_GT(compliance(beam_of(1.2, 1e-8, 0.03)).slope_held, 0);
}

TEST(Compliance, OfThePaperSectionTakesTheMeanRadiusAndFourTimesTheInertia) {
  const Compliance printed = compliance(beam_of(1, 0.04, 0.02, Section::paper));
  const Compliance mean = compliance(beam_of(1, 0.03, 0.03));
  EXPECT_NEAR(printed.deflection / mean.deflection, 0.25, 1e-14);
  EXPECT_NEAR(printed.slope / mean.slope, 0.25, 1e-14);
  EXPECT_NEAR(printed.torsion / mean.torsion, 1, 1e-14);
  EXPECT_NEAR(printed.axial / mean.axial, 1, 1e-14);
}

Beam tube_of(double length, double start_radius, double end_radius, double wall) {
  Branch branch = test::make_branch(0, Vec3::Zero(), length * Vec3::UnitX(), start_radius, end_radius);
  branch.wall = wall;
  return make_beam(branch, wood, Section::exact);
}

// By a quadrature over sections of the outer radius less those of the bore.
TEST(Tube, HasTheComplianceAndTheMassOfAStemLessItsBore) {
  const double L = 1.3, base = 0.03, tip = 0.02;
  for (const double wall : {0.05, 0.2, 0.7}) {
    const Beam tube = tube_of(L, base, tip, wall);
    const Compliance c = compliance(tube);
    double axial = 0, torsion = 0, deflection = 0, slope = 0, mass = 0;
    for (const QuadraturePoint& q : gauss_legendre(100)) {
      const double r = base + q.position * (tip - base), bore = r * (1 - wall), w = q.weight * L;
      const double A = pi * (r * r - bore * bore), I = pi / 4 * (std::pow(r, 4) - std::pow(bore, 4));
      axial += w / (wood.youngs_modulus * A);
      torsion += w / (wood.shear_modulus * 2 * I);
      deflection += w * std::pow((1 - q.position) * L, 2) / (wood.youngs_modulus * I);
      slope += w / (wood.youngs_modulus * I);
      mass += w * wood.density * A;
      EXPECT_NEAR(bending_stiffness_at(tube, q.position) / (wood.youngs_modulus * I), 1, 1e-12);
      EXPECT_NEAR(mass_per_length_at(tube, q.position) / (wood.density * A), 1, 1e-12);
    }
    EXPECT_NEAR(c.axial / axial, 1, 1e-12) << wall;
    EXPECT_NEAR(c.torsion / torsion, 1, 1e-12) << wall;
    EXPECT_NEAR(c.deflection / deflection, 1, 1e-12) << wall;
    EXPECT_NEAR(c.slope / slope, 1, 1e-12) << wall;
    EXPECT_NEAR(consistent_mass(tube, true).axial.sum() / mass, 1, 1e-12) << wall;
    EXPECT_NEAR(volume_beyond(tube, 0).volume * wood.density / mass, 1, 1e-12) << wall;
    double volume = 0;
    for (const VolumePoint& point : volume_points(tube)) volume += point.volume;
    EXPECT_NEAR(volume * wood.density / mass, 1, 1e-12) << wall;
    // The strain energy of a stretched or twisted tube is half the stiffness of its end.
    const Strain strain = strain_at(tube, c, 0.4);
    const double r = base + 0.4 * (tip - base), bore = r * (1 - wall);
    EXPECT_NEAR(strain.axial * wood.youngs_modulus * pi * (r * r - bore * bore) * c.axial, 1, 1e-12);
    EXPECT_NEAR(
        strain.torsion * wood.shear_modulus * pi / 2 * (std::pow(r, 4) - std::pow(bore, 4)) * c.torsion, 1,
        1e-12);
  }
}

TEST(Tube, WithAThinWallHasPiR3Delta) {
  const double r = 0.04;
  for (const double wall : {1e-3, 1e-5}) {
    const double delta = wall * r, middle = r - delta / 2;
    EXPECT_NEAR(bending_stiffness_at(tube_of(1, r, r, wall), 0) /
                    (wood.youngs_modulus * pi * std::pow(middle, 3) * delta),
                1, wall * wall);
  }
}

TEST(Tube, WhoseWallIsTheRadiusIsTheSolidStemToTheBit) {
  const Beam tube = tube_of(1.1, 0.03, 0.02, 1), stem = beam_of(1.1, 0.03, 0.02);
  EXPECT_EQ(tube.inertia_factor, stem.inertia_factor);
  EXPECT_EQ(tube.tube.area, 1);
  EXPECT_EQ(tube.tube.polar, 1);
  EXPECT_EQ(compliance(tube).deflection, compliance(stem).deflection);
  EXPECT_EQ(consistent_mass(tube, true).bending, consistent_mass(stem, true).bending);
}

TEST(Shape, IsHermitesCubicsForEqualRadii) {
  const double L = 0.8;
  const Beam beam = beam_of(L, 0.02, 0.02);
  for (const double s : {0.0, 0.1, 0.5, 0.77, 1.0}) {
    const Shape shape = shape_at(beam, s);
    const double s2 = s * s, s3 = s2 * s;
    EXPECT_NEAR(shape.deflection[0], 1 - 3 * s2 + 2 * s3, 1e-14);
    EXPECT_NEAR(shape.deflection[1], L * (s - 2 * s2 + s3), 1e-14);
    EXPECT_NEAR(shape.deflection[2], 3 * s2 - 2 * s3, 1e-14);
    EXPECT_NEAR(shape.deflection[3], L * (s3 - s2), 1e-14);
    EXPECT_NEAR(shape.slope[0], (6 * s2 - 6 * s) / L, 1e-13);
    EXPECT_NEAR(shape.slope[3], 3 * s2 - 2 * s, 1e-13);
    EXPECT_NEAR(shape.axial[1], s, 1e-14);
    EXPECT_NEAR(shape.torsion[0], 1 - s, 1e-14);
  }
}

TEST(Shape, OfATaperedBeamKeepsItsEndsItsSlopesAndRigidMotions) {
  const double L = 0.8;
  const Beam beam = beam_of(L, 0.03, 0.004);
  EXPECT_LT((shape_at(beam, 0).deflection - Eigen::Vector4d(1, 0, 0, 0)).norm(), 1e-14);
  EXPECT_LT((shape_at(beam, 1).deflection - Eigen::Vector4d(0, 0, 1, 0)).norm(), 1e-13);
  EXPECT_LT((shape_at(beam, 0).slope - Eigen::Vector4d(0, 1, 0, 0)).norm(), 1e-13);
  EXPECT_LT((shape_at(beam, 1).slope - Eigen::Vector4d(0, 0, 0, 1)).norm(), 1e-12);
  for (const double s : {0.2, 0.6, 0.95}) {
    const Shape shape = shape_at(beam, s);
    EXPECT_NEAR(shape.deflection.dot(Eigen::Vector4d(1, 0, 1, 0)), 1, 1e-13);
    EXPECT_NEAR(shape.deflection.dot(Eigen::Vector4d(0, 1, L, 1)), s * L, 1e-13);
    EXPECT_NEAR(shape.slope.dot(Eigen::Vector4d(0, 1, L, 1)), 1, 1e-12);
    const double h = 1e-6;
    const Eigen::Vector4d difference =
        (shape_at(beam, s + h).deflection - shape_at(beam, s - h).deflection) / (2 * h * L);
    EXPECT_LT((difference - shape.slope).norm(), 1e-7 * shape.slope.norm() + 1e-8);
  }
}

// A beam on a spring is two elements in series with a node between them that nothing loads. Eliminated by
// textbook algebra in long double, which keeps the digits that cancel on soft springs.
struct OnSpring {
  using Matrix = Eigen::Matrix<long double, 2, 2>;
  Matrix compliance, foot;  // (v, phi) of the tip per wrench; of the start per (v, phi) of the tip

  explicit OnSpring(const Beam& beam) {
    Beam clamped = beam;
    clamped.base = {};
    const Compliance c = tremula::compliance(clamped);
    Matrix own, spring, to_tip;
    own << c.deflection, c.deflection_slope, c.deflection_slope, c.slope;
    spring << beam.base.translation, 0, 0, beam.base.rotation;
    to_tip << 1, beam.length, 0, 1;
    compliance = own + to_tip * spring * to_tip.transpose();
    foot = spring * to_tip.transpose() * compliance.inverse();
  }
};

const BaseCompliance springs[] = {{1e-6, 0},   {0, 1e-4},   {3e-6, 2e-5},
                                  {1e-3, 1e3}, {1e4, 1e-5}, {1e-12, 1e-9}};

TEST(Compliance, OnASpringIsThatOfTheSpringAndTheBeamInSeries) {
  for (const BaseCompliance& base : springs) {
    for (const double tip : {0.03, 0.01, 0.06}) {
      Beam beam = beam_of(1.3, 0.03, tip);
      const Compliance own = compliance(beam);
      beam.base = base;
      const Compliance c = compliance(beam);
      const OnSpring wanted(beam);
      EXPECT_NEAR(c.axial / (own.axial + base.translation), 1, 1e-14);
      EXPECT_NEAR(c.torsion / (own.torsion + base.rotation), 1, 1e-14);
      EXPECT_NEAR(c.deflection / static_cast<double>(wanted.compliance(0, 0)), 1, 1e-14);
      EXPECT_NEAR(c.deflection_slope / static_cast<double>(wanted.compliance(0, 1)), 1, 1e-14);
      EXPECT_NEAR(c.slope / static_cast<double>(wanted.compliance(1, 1)), 1, 1e-14);
      const auto held = static_cast<double>(wanted.compliance.determinant() / wanted.compliance(0, 0));
      EXPECT_NEAR(c.slope_held / held, 1, 1e-9) << base.translation << ", " << base.rotation << ", " << tip;
    }
  }
}

TEST(Compliance, OnASpringKeepsTheHeldSlopeWhereTheDifferenceHasLostIt) {
  Beam beam = beam_of(1.3, 0.03, 0.03);
  beam.base = {0, 1e30};  // a hinge: the tip held, what is left is the beam on two hinges, L/3EI
  const double I = pi * std::pow(0.03, 4) / 4;
  EXPECT_NEAR(compliance(beam).slope_held * 3 * wood.youngs_modulus * I / 1.3, 1, 1e-14);
}

TEST(Shape, OnASpringStandsInBalanceAtItsFootAndFollowsItsTip) {
  for (const BaseCompliance& base : springs) {
    Beam beam = beam_of(1.3, 0.03, 0.01);
    beam.base = base;
    const Shape foot = shape_at(beam, 0), tip = shape_at(beam, 1);
    const OnSpring wanted(beam);
    Eigen::Matrix2d found;
    found << foot.deflection.tail<2>().transpose(), foot.slope.tail<2>().transpose();
    EXPECT_LT((found - wanted.foot.cast<double>()).norm(), 1e-8 * found.norm()) << base.rotation;
    EXPECT_NEAR(foot.axial[1], base.translation / compliance(beam).axial, 1e-14);
    EXPECT_NEAR(foot.torsion[1], base.rotation / compliance(beam).torsion, 1e-14);
    EXPECT_LT((tip.deflection - Eigen::Vector4d(0, 0, 1, 0)).norm(), 1e-12);
    EXPECT_LT((tip.slope - Eigen::Vector4d(0, 0, 0, 1)).norm(), 1e-11);
    for (const double s : {0.0, 0.3, 0.8}) {  // moved rigidly, ground and tip together
      const Shape shape = shape_at(beam, s);
      EXPECT_NEAR(shape.axial.sum(), 1, 1e-14);
      EXPECT_NEAR(shape.deflection.dot(Eigen::Vector4d(1, 0, 1, 0)), 1, 1e-12);
      EXPECT_NEAR(shape.deflection.dot(Eigen::Vector4d(0, 1, 1.3, 1)), s * 1.3, 1e-12);
      EXPECT_NEAR(shape.slope.dot(Eigen::Vector4d(0, 1, 1.3, 1)), 1, 1e-11);
    }
  }
}

TEST(ConsistentMass, IsPrzemienieckisMatrixForEqualRadii) {
  const double L = 0.9, r = 0.05, A = pi * r * r, I = A * r * r / 4, m = wood.density * A * L;
  for (const bool rotatory : {false, true}) {
    const ElementMass mass = consistent_mass(beam_of(L, r, r), rotatory);
    Eigen::Matrix4d bending, rotation;
    bending << 156, 22 * L, 54, -13 * L, 22 * L, 4 * L * L, 13 * L, -3 * L * L, 54, 13 * L, 156, -22 * L,
        -13 * L, -3 * L * L, -22 * L, 4 * L * L;
    rotation << 36, 3 * L, -36, 3 * L, 3 * L, 4 * L * L, -3 * L, -L * L, -36, -3 * L, 36, -3 * L, 3 * L,
        -L * L, -3 * L, 4 * L * L;
    const Eigen::Matrix4d wanted =
        m / 420 * bending + (rotatory ? 1 : 0) * wood.density * I / (30 * L) * rotation;
    EXPECT_LT((mass.bending - wanted).norm() / wanted.norm(), 1e-14);
    Eigen::Matrix2d linear;
    linear << 2, 1, 1, 2;
    EXPECT_LT((mass.axial - m / 6 * linear).norm() / m, 1e-14);
    EXPECT_LT((mass.torsion - m * r * r / 12 * linear).norm() / (m * r * r), 1e-14);
  }
}

TEST(ConsistentMass, OfADiscThatIsShorterThanAMillionthOfItsRadiusIsItsMassAndNoMore) {
  for (const double length : {4e-16, 1e-9}) {
    Branch branch;
    branch.end = Vec3(0, 0, length);
    branch.start_radius = 0.04;
    branch.end_radius = 0.03;
    const Material& oak = find_material("oak");
    const ElementMass mass = consistent_mass(make_beam(branch, oak, Section::exact), true);
    const double whole =
        oak.density * 3.14159265358979 * length / 3 * (0.04 * 0.04 + 0.04 * 0.03 + 0.03 * 0.03);
    EXPECT_NEAR(mass.bending(0, 0) + 2 * mass.bending(0, 2) + mass.bending(2, 2), whole, 1e-12 * whole);
    EXPECT_LT(mass.bending(2, 2), whole) << length << " m";
    EXPECT_GT(mass.bending(2, 2), 0.1 * whole) << length << " m";
  }
}

TEST(ConsistentMass, OfATaperedBeamMovedRigidlyIsThatOfTheFrustum) {
  for (const double b : {0.05, 0.03, 0.011, 0.002}) {
    const double L = 1.1, a = 0.06;
    const ElementMass mass = consistent_mass(beam_of(L, a, b), false);
    const double frustum = wood.density * pi * L / 3 * (a * a + a * b + b * b);
    const Eigen::Vector4d translation(1, 0, 1, 0), rotation(0, 1, L, 1);
    EXPECT_NEAR(translation.dot(mass.bending * translation) / frustum, 1, 1e-12) << b;
    EXPECT_NEAR(mass.axial.sum() / frustum, 1, 1e-12) << b;
    double inertia = 0, polar = 0;  // about the start; about the axis
    for (const QuadraturePoint& q : gauss_legendre(20)) {
      const double r = a + q.position * (b - a), x = q.position * L,
                   dm = wood.density * pi * r * r * L * q.weight;
      inertia += dm * x * x;
      polar += dm * r * r / 2;
    }
    EXPECT_NEAR(rotation.dot(mass.bending * rotation) / inertia, 1, 1e-12) << b;
    EXPECT_NEAR(mass.torsion.sum() / polar, 1, 1e-12) << b;
  }
}

TEST(AddPointMass, AtTheEndActsOnTheEndAlone) {
  ElementMass mass;
  add_point_mass(beam_of(1, 0.03, 0.01), 1, 2.5, mass);
  EXPECT_NEAR(mass.axial(1, 1), 2.5, 1e-12);
  EXPECT_NEAR(mass.bending(2, 2), 2.5, 1e-12);
  EXPECT_NEAR(mass.bending.cwiseAbs().sum(), 2.5, 1e-11);
  EXPECT_EQ(mass.torsion, Eigen::Matrix2d::Zero());
}

}  // namespace
}  // namespace tremula
