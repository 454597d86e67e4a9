#include "tremula/dynamics/flutter.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <utility>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "sheets.hpp"
#include "tremula/base/error.hpp"
#include "tremula/modes/solve_modes.hpp"

namespace tremula {
namespace {

using std::numbers::pi;

// A ribbon of length 1 in a flow along it. beta: the share of the fluid's mass, rho pi b^2 / 4 a metre, in
// all.
struct Ribbon {
  Sheet sheet;
  double fluid_density, unit;  // unit: sqrt(D b / (rho pi b^2 / 4)) / L, of the speed
};

Ribbon ribbon(double width, double beta) {
  Ribbon result;
  result.sheet = test::steel_sheet(20, 1);
  result.sheet.height = width;
  result.sheet.thickness = 1e-3;
  result.sheet.poisson_ratio = 0;
  result.sheet.clamped = {SheetEdge::left};
  const PlateSection section =
      plate_section(result.sheet.thickness, result.sheet.youngs_modulus, 0, result.sheet.density);
  const double fluid = beta / (1 - beta) * section.mass_per_area * width;
  result.fluid_density = fluid / (pi * width * width / 4);
  result.unit = std::sqrt(section.bending_stiffness * width / fluid);
  return result;
}

FlutterOnset onset(const Ribbon& of) {
  return find_flutter(of.sheet, {.gravity = 0, .fluid_density = of.fluid_density}, Vec3::UnitX(),
                      15 * of.unit, 8);
}

// The same as a pipe that conveys fluid, w_xxxx + u^2 w_xx + 2 sqrt(beta) u w_xt + w_tt = 0, clamped and
// free: the determinant of what holds its ends, for w = sum of A_j exp(i alpha_j x + i omega t).
std::complex<double> pipe(double beta, double u, double omega) {
  // alpha^4 - u^2 alpha^2 - 2 sqrt(beta) u omega alpha - omega^2 = 0
  Eigen::Matrix4d companion = Eigen::Matrix4d::Zero();
  companion.topRightCorner<3, 3>().setIdentity();
  companion.bottomRows<1>() << omega * omega, 2 * std::sqrt(beta) * u * omega, u * u, 0;
  const Eigen::Vector4cd alpha = companion.eigenvalues();
  Eigen::Matrix4cd ends;
  for (int j = 0; j < 4; ++j) {
    const std::complex<double> a = alpha[j], tip = std::exp(std::complex<double>(0, 1) * a);
    ends.col(j) << 1, a, a * a * tip, a * a * a * tip;
  }
  // Whatever the order of the roots.
  std::complex<double> differences = 1;
  for (int j = 0; j < 4; ++j) {
    for (int k = 0; k < j; ++k) differences *= alpha[j] - alpha[k];
  }
  return ends.determinant() / differences;
}

// Where it vanishes for a real omega, near a guess (Newton): {u, omega}.
Eigen::Vector2d pipe_onset(double beta, Eigen::Vector2d guess) {
  for (int round = 0; round < 40; ++round) {
    const double step = 1e-6;
    const std::complex<double> here = pipe(beta, guess[0], guess[1]),
                               by_u = (pipe(beta, guess[0] + step, guess[1]) - here) / step,
                               by_omega = (pipe(beta, guess[0], guess[1] + step) - here) / step;
    Eigen::Matrix2d slope;
    slope << by_u.real(), by_omega.real(), by_u.imag(), by_omega.imag();
    const Eigen::Vector2d change = slope.partialPivLu().solve(Eigen::Vector2d(here.real(), here.imag()));
    guess -= change;
    if (change.norm() < 1e-9) break;
  }
  EXPECT_LT(std::abs(pipe(beta, guess[0], guess[1])), 1e-6);
  return guess;
}

// The threshold curve of Gregory & Paidoussis (1966, Proc. R. Soc. A 293), from the equation that they solve.
// In the limit of a narrow sheet it is that of Eloy et al. 2007.
TEST(FindFlutter, OfANarrowRibbonIsOnTheCurveOfThePipeThatConveysFluid) {
  for (const double beta : {0.1, 0.2, 0.5}) {
    const Ribbon narrow = ribbon(0.02, beta);
    const FlutterOnset found = onset(narrow);
    const PlateSection section = plate_section(1e-3, 200e9, 0, 7850);
    const double all = section.mass_per_area / (1 - beta);
    const double omega = 2 * pi * found.frequency * std::sqrt(all / section.bending_stiffness);
    const double u = found.speed / narrow.unit;
    const Eigen::Vector2d exact = pipe_onset(beta, {u, omega});
    EXPECT_NEAR(u / exact[0], 1, 0.02) << beta;
    EXPECT_NEAR(omega / exact[1], 1, 0.03) << beta;
  }
}

TEST(ReactiveForces, OfANarrowRibbonHaveTheMassOfItsSections) {
  const Ribbon narrow = ribbon(0.02, 0.5);
  const Structure structure = assemble(narrow.sheet, {.gravity = 0});
  const Modes modes = solve_modes(structure, {.count = 2});
  const ReactiveForces forces = reactive_forces(structure, modes.shapes, narrow.fluid_density, Vec3::UnitX());
  // beta = 1/2: as much fluid as sheet, whose modal masses are 1. The last jump reaches a quarter of a panel
  // too far.
  EXPECT_NEAR(forces.mass(0, 0), 1, 0.03);
  EXPECT_NEAR(forces.mass(1, 1), 1, 0.05);
  EXPECT_NEAR(forces.mass(0, 1), 0, 0.03);
}

TEST(FindFlutter, GoesWithTheRootOfTheStiffness) {
  Ribbon one = ribbon(0.2, 0.2), stiffer = one;
  stiffer.sheet.youngs_modulus *= 4;
  stiffer.unit *= 2;
  const FlutterOnset soft = onset(one), hard = onset(stiffer);
  EXPECT_NEAR(hard.speed / soft.speed, 2, 1e-4);
  EXPECT_NEAR(hard.frequency / soft.frequency, 2, 1e-3);
}

// Eloy, Souilliez & Schouveiler 2007: a plate of finite span is more stable than a wider one.
TEST(FindFlutter, ComesLaterTheNarrowerTheSheet) {
  double before = 0;
  for (const double width : {1.5, 1.0, 0.5, 0.2}) {
    Ribbon of = ribbon(width, 0.2);
    of.fluid_density = 0.6 * of.sheet.density * of.sheet.thickness;  // the mass ratio rho L / m
    of.unit = std::sqrt(plate_section(1e-3, 200e9, 0, 7850).bending_stiffness / (of.sheet.density * 1e-3));
    const double speed = find_flutter(of.sheet, {.gravity = 0, .fluid_density = of.fluid_density},
                                      Vec3::UnitX(), 30 * of.unit, 8)
                             .speed;
    EXPECT_GT(speed, before) << width;
    before = speed;
  }
}

TEST(FindFlutter, IsTheSameWhicheverWayTheSheetLies) {
  const Ribbon one = ribbon(0.2, 0.2);
  const double wanted = onset(one).speed;
  Ribbon mirrored = one;
  mirrored.sheet.clamped = {SheetEdge::right};
  const SheetOptions options{.gravity = 0, .fluid_density = one.fluid_density};
  EXPECT_NEAR(find_flutter(mirrored.sheet, options, -Vec3::UnitX(), 15 * one.unit, 8).speed, wanted,
              1e-3 * wanted);
  Ribbon hanging = one;
  std::swap(hanging.sheet.width, hanging.sheet.height);
  std::swap(hanging.sheet.elements[0], hanging.sheet.elements[1]);
  hanging.sheet.clamped = {SheetEdge::bottom};
  EXPECT_NEAR(find_flutter(hanging.sheet, options, Vec3::UnitZ(), 15 * one.unit, 8).speed, wanted,
              1e-3 * wanted);
}

TEST(FindFlutter, FindsNoneBelowItAndLaterWithDamping) {
  const Ribbon one = ribbon(0.1, 0.1);
  const Structure structure = assemble(one.sheet, {.gravity = 0});
  const Modes modes = solve_modes(structure, {.count = 8});
  const ReactiveForces forces = reactive_forces(structure, modes.shapes, one.fluid_density, Vec3::UnitX());
  const double speed = find_flutter(forces, modes.omega(), 10 * one.unit).speed;
  EXPECT_EQ(find_flutter(forces, modes.omega(), 0.99 * speed).speed, std::numeric_limits<double>::infinity());
  EXPECT_GT(find_flutter(forces, modes.omega(), 10 * one.unit, 0.2 * modes.omega()).speed, 1.01 * speed);
}

TEST(FindFlutter, RefusesWhatIsNotSo) {
  const Ribbon one = ribbon(0.1, 0.1);
  const SheetOptions options{.gravity = 0, .fluid_density = 1.2};
  EXPECT_THROW(find_flutter(one.sheet, options, Vec3::UnitY(), 10), InputError);
  EXPECT_THROW(find_flutter(one.sheet, options, Vec3::UnitX(), 0), InputError);
  EXPECT_THROW(reactive_forces(Structure{}, Eigen::MatrixXd(0, 1), 1.2, Vec3::UnitX()), InputError);
}

}  // namespace
}  // namespace tremula
