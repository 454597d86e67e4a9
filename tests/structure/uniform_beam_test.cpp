#include "tremula/structure/uniform_beam.hpp"

#include "tremula/base/error.hpp"
#include "tremula/numerics/quadrature.hpp"
#include "tremula/structure/beam.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include "complaint.hpp"

namespace tremula {
namespace {

using std::numbers::pi;
using test::complaint_of;

double integral(const std::function<double(double)>& f, int pieces) {
  double sum = 0;
  for (int i = 0; i < pieces; ++i) {
    for (const QuadraturePoint& q : gauss_legendre(16))
      sum += q.weight / pieces * f((i + q.position) / pieces);
  }
  return sum;
}

TEST(UniformBeam, RootsFulfilTheCharacteristicEquationAndNearOddMultiplesOfHalfPi) {
  for (int mode = 1; mode <= 200; ++mode) {
    const double lambda = clamped_free_root(mode);
    // cos(lambda) = -1/cosh(lambda), to the rounding of lambda.
    EXPECT_NEAR(std::cos(lambda), -1 / std::cosh(lambda), 4e-16 * lambda) << mode;
    EXPECT_NEAR(lambda, (mode - 0.5) * pi, 2 / std::cosh((mode - 0.5) * pi)) << mode;
  }
  EXPECT_NEAR(clamped_free_root(1), 1.875, 5e-4);  // as F prints them
  EXPECT_NEAR(clamped_free_root(2), 4.694, 5e-4);
}

TEST(UniformBeam, EtaIsThatOfAFreeEndAndNotTheOneThatFPrints) {
  const double l = clamped_free_root(1);
  EXPECT_NEAR(clamped_free_eta(1), (std::cosh(l) + std::cos(l)) / (std::sinh(l) + std::sin(l)), 1e-15);
  // The printed one leaves the tip where it is: V(1) = 0.
  const double printed = (std::cosh(l) - std::cos(l)) / (std::sinh(l) - std::sin(l));
  EXPECT_NEAR(std::cosh(l) - std::cos(l) - printed * (std::sinh(l) - std::sin(l)), 0, 1e-14);
  EXPECT_NEAR(clamped_free_shape(1, 1).value, 2, 1e-14);
}

TEST(UniformBeam, ShapesAreThePrintedSumsWhereThoseKeepTheirDigits) {
  for (int mode = 1; mode <= 5; ++mode) {
    const double l = clamped_free_root(mode), eta = clamped_free_eta(mode);
    for (const double x : {0.0, 0.2, 0.5, 0.83, 1.0}) {
      const double z = l * x, rounding = 1e-15 * std::cosh(z);
      const BeamShape shape = clamped_free_shape(mode, x);
      EXPECT_NEAR(shape.value, std::cosh(z) - std::cos(z) - eta * (std::sinh(z) - std::sin(z)), 4 * rounding);
      EXPECT_NEAR(shape.slope / l, std::sinh(z) + std::sin(z) - eta * (std::cosh(z) - std::cos(z)),
                  4 * rounding + 1e-14);
    }
  }
}

TEST(UniformBeam, ShapesAreClampedAtOneEndAndFreeAtTheOtherUpToTheThousandthMode) {
  for (const int mode : {1, 2, 3, 10, 100, 1000}) {
    const double l = clamped_free_root(mode);
    const BeamShape foot = clamped_free_shape(mode, 0), tip = clamped_free_shape(mode, 1);
    EXPECT_NEAR(foot.value, 0, 1e-15) << mode;
    EXPECT_NEAR(foot.slope / l, 0, 1e-15) << mode;
    EXPECT_NEAR(foot.third / (l * l * l), -2 * clamped_free_eta(mode), 1e-14) << mode;
    EXPECT_NEAR(tip.value, mode % 2 == 1 ? 2 : -2, 4e-16 * l + 1e-15) << mode;
    EXPECT_NEAR(tip.curvature / (l * l), 0, 4e-16 * l + 1e-15) << mode;
    EXPECT_NEAR(tip.third / (l * l * l), 0, 4e-16 * l + 1e-15) << mode;
  }
}

TEST(UniformBeam, ShapesAreOrthonormalAndTheirCurvaturesOrthogonal) {
  for (const int r : {1, 2, 3, 7, 30}) {
    for (const int s : {1, 2, 3, 7, 30}) {
      const auto V = [](int mode, double x) { return clamped_free_shape(mode, x); };
      EXPECT_NEAR(integral([&](double x) { return V(r, x).value * V(s, x).value; }, 40), r == s, 1e-12);
      const double stiff = std::pow(clamped_free_root(r) * clamped_free_root(s), 2);
      EXPECT_NEAR(integral([&](double x) { return V(r, x).curvature * V(s, x).curvature; }, 40) / stiff,
                  r == s, 1e-12);
    }
    EXPECT_NEAR(integral([&](double x) { return clamped_free_shape(r, x).value; }, 40), clamped_free_mean(r),
                1e-13);
  }
}

// Fourth derivative lambda^4 V, by differences of the third.
TEST(UniformBeam, ShapesSolveTheBeamEquation) {
  const double h = 1e-4;
  for (const int mode : {1, 2, 6}) {
    const double l = clamped_free_root(mode);
    for (const double x : {0.1, 0.4, 0.9}) {
      const double fourth =
          (clamped_free_shape(mode, x + h).third - clamped_free_shape(mode, x - h).third) / (2 * h);
      EXPECT_NEAR(fourth / std::pow(l, 4), clamped_free_shape(mode, x).value, 1e-6 * mode * mode);
    }
  }
}

TEST(UniformBeam, ThePolynomialIsAtRestAtTheClampAndFreeAtTheEnd) {
  const BeamShape foot = fundamental_polynomial(0), tip = fundamental_polynomial(1);
  EXPECT_EQ(foot.value, 0);
  EXPECT_EQ(foot.slope, 0);
  EXPECT_DOUBLE_EQ(tip.value, 1);
  EXPECT_EQ(tip.curvature, 0);
  EXPECT_EQ(tip.third, 0);
  const double h = 1e-5;
  for (const double x : {0.1, 0.5, 0.9}) {
    const auto at = [](double y) { return fundamental_polynomial(y); };
    EXPECT_NEAR((at(x + h).value - at(x - h).value) / (2 * h), at(x).slope, 1e-9);
    EXPECT_NEAR((at(x + h).slope - at(x - h).slope) / (2 * h), at(x).curvature, 1e-9);
    EXPECT_NEAR((at(x + h).curvature - at(x - h).curvature) / (2 * h), at(x).third, 1e-9);
  }
}

TEST(UniformBeam, ThePolynomialIsWithin1_5PercentAndItsRayleighQuotientIs162Over13) {
  double largest = 0;
  for (int i = 0; i <= 1000; ++i) {
    const double x = i / 1000.0;
    largest =
        std::max(largest, std::abs(fundamental_polynomial(x).value - clamped_free_shape(1, x).value / 2));
  }
  EXPECT_GT(largest, 0.0135);  // F says 1.3 % (errata F10)
  EXPECT_LT(largest, 0.0155);
  const double bending =
      integral([](double x) { return std::pow(fundamental_polynomial(x).curvature, 2); }, 1);
  const double inertia = integral([](double x) { return std::pow(fundamental_polynomial(x).value, 2); }, 1);
  EXPECT_NEAR(bending / inertia, 162.0 / 13, 1e-12);
  EXPECT_GT(bending / inertia, std::pow(clamped_free_root(1), 4));  // Rayleigh: never below
}

TEST(UniformBeam, WhatTheClampTakesIsTheInertiaOfTheWholeBeam) {
  const UniformBeam beam{1.3, 7.0, 0.4};
  for (const int mode : {1, 2, 5}) {
    const double omega = natural_omega(beam, mode);
    const double inertia = omega * omega * beam.mass_per_length * beam.length * clamped_free_mean(mode);
    EXPECT_NEAR(-clamp_shear(beam, mode) / inertia, 1, 1e-12) << mode;
  }
}

// F section 6.1: 2 Hz and 1 s for a branch of 1 m and 5 mm, 0.8 g/cm^3.
TEST(UniformBeam, TheExampleOfFHoldsBothWays) {
  const double f = 2, l = 1, r = 0.005, density = 800;
  // As printed: 13.0 for lambda^4 and I = pi r^4.
  const double printed = std::pow(2 * pi * f, 2) / 13.0 * std::pow(l, 4) * density / (r * r);
  EXPECT_NEAR(printed / 3.89e8, 1, 2e-3);
  const double root4 = std::pow(clamped_free_root(1), 4);
  const RoundSection as_printed{pi * r * r, pi * std::pow(r, 4)}, disc = round_section(r);
  EXPECT_NEAR(youngs_modulus_of(f, l, density, as_printed) / (printed * 13.0 / root4), 1, 1e-12);
  EXPECT_NEAR(youngs_modulus_of(f, l, density, disc) / youngs_modulus_of(f, l, density, as_printed), 4,
              1e-12);
  // And back: the beam of this E swings at 2 Hz, and its amplitude falls to 1/e in 1 s.
  const double E = youngs_modulus_of(f, l, density, disc), c = stiffness_damping_of(1, f);
  const double omega = natural_omega({l, E * disc.second_moment, density * disc.area}, 1);
  EXPECT_NEAR(omega / (2 * pi * f), 1, 1e-14);
  EXPECT_NEAR(2 / (c * omega * omega), 1, 1e-14);
  EXPECT_NEAR(c, 1.267e-2, 5e-6);  // not the printed 3.0e-4 (errata F8)
}

TEST(RoundSection, OfAThinWallTendsToPiR3Delta) {
  const double r = 0.04;
  double before = 0;
  for (const double wall : {4e-3, 2e-3, 1e-3}) {
    const double middle = r - wall / 2, exact = round_section(r, wall).second_moment;
    // About the radius of the middle the error is of second order, wall^2/(4 r^2).
    const double error = exact / (pi * std::pow(middle, 3) * wall) - 1;
    EXPECT_NEAR(error, std::pow(wall / (2 * middle), 2), 1e-12);
    if (before > 0) {
      EXPECT_NEAR(before / error, 4, 0.4);
    }
    before = error;
    // With the outer radius, as F has it, of first order: the print is 3/2 wall/r too much.
    EXPECT_NEAR(pi * std::pow(r, 3) * wall / exact - 1, 1.5 * wall / r, 3 * std::pow(wall / r, 2));
  }
  EXPECT_NEAR(round_section(1, 1e-12).second_moment / (pi * 1e-12), 1, 1e-11);
}

TEST(RoundSection, IsADiscLessItsBore) {
  const double r = 0.05, wall = 0.012, bore = r - wall;
  const RoundSection ring = round_section(r, wall), disc = round_section(r), hole = round_section(bore);
  EXPECT_NEAR(ring.area / (disc.area - hole.area), 1, 1e-14);
  EXPECT_NEAR(ring.second_moment / (disc.second_moment - hole.second_moment), 1, 1e-14);
  EXPECT_EQ(round_section(r, r).second_moment, disc.second_moment);
}

TEST(UniformBeam, RefusesWhatIsNoBeamInOneLine) {
  EXPECT_EQ(complaint_of([] { clamped_free_root(0); }), "mode of a beam: 0, wanted 1 to 1000000");
  EXPECT_EQ(complaint_of([] { clamped_free_shape(1, 1.5); }),
            "place on a beam: 1.500000, wanted 0 (clamp) to 1 (free end)");
  EXPECT_EQ(complaint_of([] {
              natural_omega({0, 1, 1}, 1);
            }),
            "length of a beam: 0, wanted a finite number above 0");
  EXPECT_THROW(natural_omega({1, std::nan(""), 1}, 1), InputError);
  EXPECT_THROW(stiffness_damping_of(0, 2), InputError);
}

}  // namespace
}  // namespace tremula
