#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "panels.hpp"
#include "sheets.hpp"
#include "tremula/modes/mode_quality.hpp"
#include "tremula/modes/solve_modes.hpp"
#include "tremula/structure/frame_presets.hpp"
#include "tremula/structure/structure.hpp"

namespace tremula {
namespace {

using std::numbers::pi;

const Material wood{"wood", 9e9, 7e8, 950, ""};

// The first `count` roots of a function that changes its sign at each, found from `low` on in steps.
std::vector<double> roots_of(const std::function<double(double)>& function, double low, double step,
                             std::size_t count) {
  std::vector<double> roots;
  for (double at = low; roots.size() < count; at += step) {
    double a = at, b = at + step;
    if (function(a) * function(b) > 0) continue;
    for (int i = 0; i < 100; ++i) {
      const double middle = 0.5 * (a + b);
      (function(a) * function(middle) > 0 ? a : b) = middle;
    }
    roots.push_back(0.5 * (a + b));
  }
  return roots;
}

// A cantilever that ends in a rigid body, at its centre of mass: w = A (cosh - cos) + B (sinh - sin) of
// beta x with EI w'' = omega^2 J w' and EI w''' = -omega^2 M w at the tip.
std::vector<double> bending_with_a_body(double length, double EI, double mass_per_length, double mass,
                                        double inertia, std::size_t count) {
  const auto determinant = [&](double x) {  // beta L
    const double b = x / length, c = std::cosh(x), s = std::sinh(x), co = std::cos(x), si = std::sin(x);
    const double turn = inertia * b * b * b / mass_per_length, shift = mass * b / mass_per_length;
    const double bend_a = c + co - turn * (s + si), bend_b = s + si - turn * (c - co);
    const double shear_a = s - si + shift * (c - co), shear_b = c + co + shift * (s - si);
    return (bend_a * shear_b - bend_b * shear_a) / (c * c);
  };
  std::vector<double> omega;
  for (const double x : roots_of(determinant, 1e-3, 0.01, count))
    omega.push_back(x * x / (length * length) * std::sqrt(EI / mass_per_length));
  return omega;
}

TEST(SolveModesOfAPanel, ThatIsRigidOnAPostAreThoseOfATipMassWithRotaryInertia) {
  const double L = 2, r = 0.02;
  Sheet sheet = test::panel_sheet();
  sheet.youngs_modulus = 1e13;  // rigid beside the post
  sheet.elements = {4, 4};
  const Structure structure =
      assemble(test::post_with_panel(L, r, wood, sheet, 16), {.rotatory_inertia = false});
  const double mass = 2700 * 0.01 * 1 * 0.6, w2 = mass / 12, h2 = mass * 0.36 / 12;
  const double I = pi * std::pow(r, 4) / 4, EI = wood.youngs_modulus * I, m = wood.density * pi * r * r;
  // Along x the panel turns about y, which lies along its width; along y about its normal.
  const std::vector<double> along_x = bending_with_a_body(L, EI, m, mass, h2, 2),
                            along_y = bending_with_a_body(L, EI, m, mass, w2 + h2, 2);
  // x tan x = inertia of the post over that of the panel
  const double ratio = wood.density * 2 * I * L / w2;
  const double x = roots_of([&](double at) { return at * std::tan(at) - ratio; }, 1e-4, 1e-3, 1)[0];
  const double torsion = x / L * std::sqrt(wood.shear_modulus / wood.density);
  std::vector<double> wanted{along_x[0], along_x[1], along_y[0], along_y[1], torsion};
  std::sort(wanted.begin(), wanted.end());
  const Modes modes = solve_modes(structure, {.count = 5});
  for (int k = 0; k < 5; ++k)
    EXPECT_NEAR(modes.omega()[k] / wanted[static_cast<std::size_t>(k)], 1, 2e-4) << k;
  EXPECT_EQ(modes.count_below, modes.count_by_inertia);
}

// data/validation.json, plate.cantilever.square: Ritz with 14 x 14 polynomials.
TEST(SolveModesOfAPanel, HeldByItsLeftEdgeTendToThoseOfTheCantileverPlate) {
  const double ritz[] = {3.47107, 8.50671, 21.285, 27.1989, 30.9563, 54.1872};
  Sheet sheet = test::steel_sheet();
  Eigen::VectorXd errors[2];
  for (const int n : {8, 16}) {
    sheet.elements = {n, n};
    const Modes modes =
        solve_modes(assemble(test::wall_with_panel(sheet)), {.count = 6, .method = ModeMethod::iterative});
    Eigen::VectorXd& error = errors[n == 16];
    error.resize(6);
    for (int r = 0; r < 6; ++r) error[r] = test::plate_number(sheet, modes.frequency[r]) / ritz[r] - 1;
  }
  for (int r = 0; r < 6; ++r) {
    EXPECT_LT(std::abs(errors[1][r]), 0.006) << r;
    EXPECT_LT(std::abs(errors[1][r]), 0.4 * std::abs(errors[0][r]) + 1e-4) << r;
  }
}

TEST(SolveModesOfAPanel, HaveEnergyInPostAndPanel) {
  const Structure structure = assemble(frame_presets()[0].frame);
  const Modes modes = solve_modes(structure, {.count = 8});
  const ModeQuality quality =
      assess_modes(structure, modes, std::vector<bool>(structure.members.size(), false));
  for (std::size_t r = 0; r < 8; ++r) {
    const EnergyShares& energy = quality.energy[r];
    EXPECT_NEAR(energy.trunk + energy.branch + energy.torsion + energy.axial, 1, 1e-6) << r;
    EXPECT_GE(energy.branch, 0) << r;
  }
  EXPECT_EQ(quality.kind[0], ModeKind::bending);
  EXPECT_LT(quality.effective_mass().colwise().sum().maxCoeff(), quality.total_mass);
}

// Pieces of a beam one after the other, each uniform: EI and mass per length.
struct Piece {
  double length, EI, mass;
};

// Of a cantilever of them, exactly (transfer matrices of Euler's beam over w, w', M, V): the determinant that
// is 0 at its frequencies, whatever the scale.
double transfer_determinant(const std::vector<Piece>& pieces, double omega) {
  Eigen::Matrix<double, 4, 2> state = Eigen::Matrix<double, 4, 2>::Zero();
  state(2, 0) = state(3, 1) = 1;
  for (const Piece& piece : pieces) {
    const double b = std::sqrt(omega) * std::pow(piece.mass / piece.EI, 0.25), x = b * piece.length;
    const double s = (std::cosh(x) + std::cos(x)) / 2, t = (std::sinh(x) + std::sin(x)) / 2,
                 u = (std::cosh(x) - std::cos(x)) / 2, v = (std::sinh(x) - std::sin(x)) / 2;  // Krylov's
    Eigen::Matrix4d transfer;
    const double k = piece.EI, b2 = b * b, b3 = b2 * b;
    transfer << s, t / b, u / (k * b2), v / (k * b3),  //
        b * v, s, t / (k * b), u / (k * b2),           //
        k * b2 * u, k * b * v, s, t / b,               //
        k * b3 * t, k * b2 * u, b * v, s;
    state = transfer * state;
    state.col(0) /= state.col(0).norm();
    state.col(1) /= state.col(1).norm();
  }
  return state.bottomRows<2>().determinant();
}

std::vector<double> culm_frequencies(const std::vector<Piece>& pieces, double step) {
  std::vector<double> frequencies;
  for (const double omega :
       roots_of([&](double at) { return transfer_determinant(pieces, at); }, step, step, 3))
    frequencies.push_back(omega / (2 * pi));
  return frequencies;
}

// A hollow culm with a solid piece at every node.
TEST(SolveModesOfACulm, WithSolidNodesAreThoseOfThePiecewiseBeam) {
  const double r = 0.03, wall = 0.2, internode = 0.3, node = 0.012;
  const int count = 12;
  const double solid_I = pi * std::pow(r, 4) / 4, solid_A = pi * r * r;
  const TubeShare tube = tube_share(wall);
  std::vector<Piece> pieces, without;
  Skeleton culm;
  culm.roots = {Vec3::Zero()};
  double z = 0;
  for (int i = 0; i < count; ++i) {
    for (const bool solid : {false, true}) {
      const double length = solid ? node : internode;
      pieces.push_back({length, wood.youngs_modulus * solid_I * (solid ? 1 : tube.polar),
                        wood.density * solid_A * (solid ? 1 : tube.area)});
      without.push_back(
          {length, wood.youngs_modulus * solid_I * tube.polar, wood.density * solid_A * tube.area});
      culm.branches.push_back({culm.branch_count() == 0 ? 0 : culm.end_node(culm.branch_count() - 1),
                               {0, 0, z},
                               {0, 0, z + length},
                               r,
                               r,
                               solid ? 1 : wall});
      z += length;
    }
  }
  StructureOptions options;
  options.material = wood;
  options.gravity = 0;
  options.rotatory_inertia = false;
  const Modes modes = solve_modes(assemble(culm, options), {.count = 6});
  const std::vector<double> wanted = culm_frequencies(pieces, 0.5), hollow = culm_frequencies(without, 0.5);
  for (std::size_t k = 0; k < 3; ++k) {  // twice each, once a direction
    EXPECT_NEAR(modes.frequency[2 * static_cast<Eigen::Index>(k)] / wanted[k], 1, 1e-4) << k;
    // Nodes of 4 % of the length: stiffer, and heavier by more.
    EXPECT_LT(wanted[k] / hollow[k], 1) << k;
    EXPECT_GT(wanted[k] / hollow[k], 0.95) << k;
  }
}

}  // namespace
}  // namespace tremula
