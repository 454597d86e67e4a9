#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/Eigenvalues>

#include "sheets.hpp"
#include "tremula/base/error.hpp"
#include "tremula/modes/solve_modes.hpp"
#include "tremula/structure/structure.hpp"

namespace tremula {
namespace {

using std::numbers::pi;

const SheetOptions weightless{.gravity = 0};

// Every method gives the same, and says that none is missing. omega a^2 sqrt(rho h / D).
Eigen::VectorXd plate_numbers(const Sheet& sheet, int count, const SheetOptions& options = weightless) {
  const Structure structure = assemble(sheet, options);
  const Modes modes = solve_modes(structure, {.count = count, .method = ModeMethod::iterative});
  EXPECT_EQ(modes.shapes.rows(), structure.size());
  EXPECT_EQ(modes.count_below, modes.count_by_inertia);
  EXPECT_GE(modes.count_below, count - modes.equal_to_last);
  const Eigen::MatrixXd unit = modes.shapes.transpose() * [&] {
    Eigen::MatrixXd inertia(structure.size(), count);
    for (int r = 0; r < count; ++r) inertia.col(r) = structure.mass(modes.shapes.col(r));
    return inertia;
  }();
  EXPECT_LT((unit - Eigen::MatrixXd::Identity(count, count)).norm(), 1e-7);
  Eigen::VectorXd numbers(count);
  for (int r = 0; r < count; ++r) numbers[r] = test::plate_number(sheet, modes.frequency[r]);
  return numbers;
}

// Relative errors at n and 2 n elements fall as the square of their size.
void expect_second_order(Sheet sheet, const std::vector<double>& wanted, int n, double tolerance,
                         double order_tolerance) {
  const int count = static_cast<int>(wanted.size());
  sheet.elements = {n, n};
  const Eigen::VectorXd coarse = plate_numbers(sheet, count);
  sheet.elements = {2 * n, 2 * n};
  const Eigen::VectorXd fine = plate_numbers(sheet, count);
  for (int r = 0; r < count; ++r) {
    const double error = fine[r] / wanted[index_of(r)] - 1;
    EXPECT_LT(std::abs(error), tolerance) << r;
    EXPECT_NEAR((coarse[r] / wanted[index_of(r)] - 1) / error, 4, order_tolerance) << r;
  }
}

TEST(SolveSheetModes, OfAPinnedSquareAreSumsOfSquares) {
  Sheet sheet = test::steel_sheet();
  sheet.pinned = {SheetEdge::left, SheetEdge::right, SheetEdge::bottom, SheetEdge::top};
  expect_second_order(sheet, {2 * pi * pi, 5 * pi * pi, 5 * pi * pi, 8 * pi * pi, 10 * pi * pi, 10 * pi * pi},
                      16, 0.004, 0.3);
}

// data/validation.json, plate.cantilever.square: Ritz, 14 x 14 polynomials of Legendre, good to four digits.
TEST(SolveSheetModes, OfASquareOnOneEdgeAreThoseOfRitz) {
  Sheet sheet = test::steel_sheet(16, 16);
  sheet.clamped = {SheetEdge::left};
  const double ritz[] = {3.47107, 8.50671, 21.285, 27.1989, 30.9563, 54.1872};
  const Eigen::VectorXd coarse = plate_numbers(test::with_elements(sheet, 8), 6),
                        fine = plate_numbers(sheet, 6);
  for (int r = 0; r < 6; ++r) {
    EXPECT_NEAR(fine[r] / ritz[r], 1, 0.007) << r;
    // At least second order: the errors of the first two modes are about to pass through zero.
    EXPECT_LT(std::abs(fine[r] / ritz[r] - 1), std::abs(coarse[r] / ritz[r] - 1) / 3) << r;
  }
}

TEST(SolveSheetModes, DoNotDependOnHowTheSheetStands) {
  Sheet sheet = test::steel_sheet(5, 4);
  sheet.height = 0.7;
  sheet.clamped = {SheetEdge::left};
  const Eigen::VectorXd upright = plate_numbers(sheet, 5);
  sheet.along_width = Vec3(2, 1, 2) / 3;
  sheet.along_height = Vec3(-2, 2, 1) / 3;
  sheet.corner = {10, -3, 5};
  EXPECT_LT((plate_numbers(sheet, 5) - upright).norm(), 1e-8 * upright.norm());
}

TEST(SolveSheetModes, AreAllThereAndThoseOfADenseSolver) {
  Sheet sheet = test::steel_sheet(4, 3);
  sheet.clamped = {SheetEdge::bottom};
  sheet.tension = {3e4, -2e3, 1e3};
  const SheetMatrices matrices = assemble_sheet(sheet, weightless);
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(
      Eigen::MatrixXd(matrices.bending + matrices.geometric), Eigen::MatrixXd(matrices.mass),
      Eigen::EigenvaluesOnly);
  const Modes modes = solve_modes(assemble(sheet, weightless), {.count = all_modes});
  ASSERT_EQ(modes.count(), matrices.size());
  for (int r = 0; r < modes.count(); ++r)
    EXPECT_NEAR(modes.omega()[r] / std::sqrt(solver.eigenvalues()[r]), 1, 1e-8) << r;
}

// A strip without Poisson's ratio that is pinned at both ends and pulled: omega_n^2 = (n pi/L)^2 (T + D (n
// pi/L)^2)/mu, a string where the tension does it and a beam where the stiffness does.
TEST(SolveSheetModes, OfAStripUnderTensionGoFromABeamToAString) {
  Sheet sheet = test::steel_sheet(32, 1);
  sheet.poisson_ratio = 0;
  sheet.height = 0.002;
  sheet.pinned = {SheetEdge::left, SheetEdge::right};
  const PlateSection section = plate_section(sheet.thickness, sheet.youngs_modulus, 0, sheet.density);
  for (const double share : {0.0, 1.0, 1e4}) {
    sheet.tension.x = share * section.bending_stiffness;
    const Modes modes = solve_modes(assemble(sheet, weightless), {.count = 3});
    for (int n = 1; n <= 3; ++n) {
      const double k = n * pi;
      const double wanted =
          k * std::sqrt((sheet.tension.x + section.bending_stiffness * k * k) / section.mass_per_area);
      EXPECT_NEAR(modes.omega()[n - 1] / wanted, 1, 2e-3) << share << ' ' << n;
    }
  }
}

// A membrane: omega^2 = N ((m pi/a)^2 + (n pi/b)^2) / mu.
TEST(SolveSheetModes, OfAPulledFilmAreThoseOfAMembrane) {
  Sheet sheet = test::steel_sheet(24, 16);
  sheet.thickness = 1e-5;
  sheet.height = 0.6;
  sheet.pinned = {SheetEdge::left, SheetEdge::right, SheetEdge::bottom, SheetEdge::top};
  sheet.tension = {100, 100, 0};
  const Modes modes = solve_modes(assemble(sheet, weightless), {.count = 3});
  const double speed = std::sqrt(100 / (sheet.density * sheet.thickness));
  const double wanted[] = {std::hypot(1, 1 / 0.6), std::hypot(2, 1 / 0.6), std::hypot(3, 1 / 0.6)};
  for (int r = 0; r < 3; ++r) EXPECT_NEAR(modes.omega()[r] / (pi * speed * wanted[r]), 1, 0.006) << r;
}

// Zeros of J_0, and so the hanging chain (Bernoulli 1732): omega = j sqrt(g/L) / 2.
TEST(SolveSheetModes, OfAHangingClothAreThoseOfTheHangingChain) {
  constexpr double zeros[] = {2.404825557695773, 5.520078110286311, 8.653727912911013};
  const auto error = [&](int up) {
    Sheet cloth = test::steel_sheet(1, up);
    cloth.width = 0.05;
    cloth.height = 2;
    cloth.poisson_ratio = 0;
    cloth.thickness = 4e-4;
    cloth.youngs_modulus = 1e4;
    cloth.density = 500;
    cloth.pinned = {SheetEdge::top};
    const Structure structure = assemble(cloth, {.gravity = 9.81});
    const Modes modes = solve_modes(structure, {.count = 12});
    // Without a bending stiffness to speak of it twists as easily as it swings: those that swing move all.
    const GroundInertia inertia = structure.find_ground_inertia();
    const Eigen::VectorXd share =
        (modes.shapes.transpose() * inertia.forces.col(1)).cwiseAbs2() / inertia.total_mass;
    Eigen::Vector3d errors;
    int found = 0;
    for (int r = 0; r < modes.count() && found < 3; ++r) {
      if (share[r] < 0.01) continue;
      errors[found] = modes.omega()[r] / (0.5 * zeros[found] * std::sqrt(9.81 / 2)) - 1;
      ++found;
    }
    EXPECT_EQ(found, 3);
    return errors;
  };
  const Eigen::Vector3d coarse = error(24), fine = error(64);
  for (int r = 0; r < 3; ++r) {
    EXPECT_LT(std::abs(fine[r]), 2e-3) << r;
    EXPECT_LT(std::abs(fine[r]), 0.5 * std::abs(coarse[r])) << r;
  }
}

// What the fluid adds to a long strip is that of its sections, rho pi b^2 / 4, so that all its bending modes
// fall by the same factor. Three-dimensional flow about the ends and between the waves adds less.
TEST(SolveSheetModes, OfAStripInWaterCarryTheWaterOfItsSections) {
  Sheet strip = test::steel_sheet(24, 2);
  strip.height = 0.05;
  strip.clamped = {SheetEdge::left};
  SheetOptions water = weightless;
  water.fluid_density = 1000;
  const Modes dry = solve_modes(assemble(strip, weightless), {.count = 4}),
              wet = solve_modes(assemble(strip, water), {.count = 4});
  const double dry_mass = strip.density * strip.thickness * strip.height, added = 1000 * pi * 0.05 * 0.05 / 4;
  const double wanted = std::sqrt(dry_mass / (dry_mass + added));
  EXPECT_NEAR(wet.frequency[0] / dry.frequency[0] / wanted, 1, 0.02);
  EXPECT_NEAR(wet.frequency[1] / dry.frequency[1] / wanted, 1, 0.04);
  EXPECT_EQ(wet.count_below, wet.count_by_inertia);
}

TEST(SolveSheetModes, InAFluidAreCountedAsTheyAreFound) {
  Sheet sheet = test::steel_sheet(6, 5);
  sheet.clamped = {SheetEdge::left};
  const Structure structure = assemble(sheet, {.gravity = 0, .fluid_density = 1000});
  const Modes modes = solve_modes(structure, {.count = 40, .method = ModeMethod::dense});
  for (const int r : {0, 1, 5, 17, 38}) {
    const double between = 0.5 * (modes.omega()[r] + modes.omega()[r + 1]);
    EXPECT_EQ(structure.eigen.count_below(between)[0], r + 1);
  }
}

TEST(SolveSheetModes, AreAsManyAsNodesCanMove) {
  Sheet sheet = test::steel_sheet(2, 2);
  sheet.clamped = {SheetEdge::left};
  const Structure structure = assemble(sheet, weightless);
  EXPECT_EQ(structure.eigen.all_degrees(), 18);
  EXPECT_EQ(structure.size(), 36);
  EXPECT_EQ(solve_modes(structure, {.count = 18}).count(), 18);
  EXPECT_THROW(solve_modes(structure, {.count = 19}), InputError);
}

}  // namespace
}  // namespace tremula
