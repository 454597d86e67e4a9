#include "tremula/structure/sheet.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <string>

#include <Eigen/Eigenvalues>

#include "complaint.hpp"
#include "random_vector.hpp"
#include "sheets.hpp"
#include "tremula/structure/structure.hpp"

namespace tremula {
namespace {

using std::numbers::pi;

// All eigenvalues of K and M, omega [rad/s]; rounding may leave those of rigid motions a little below 0.
Eigen::VectorXd dense_omega(const SheetMatrices& matrices) {
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(
      Eigen::MatrixXd(matrices.bending + matrices.geometric), Eigen::MatrixXd(matrices.mass),
      Eigen::EigenvaluesOnly);
  return solver.eigenvalues().cwiseMax(0).cwiseSqrt();
}

// data/validation.json, plate.free.square: Ritz with 14 x 14 polynomials, and NAFEMS FV12.
TEST(AssembleSheet, OfAFreeSquareHasThreeRigidModesAndThoseOfFV12) {
  Sheet sheet;
  sheet.width = sheet.height = 10;
  sheet.thickness = 0.05;
  sheet.youngs_modulus = 200e9;
  sheet.density = 8000;
  const double published[] = {1.622, 2.360, 2.922, 4.190, 4.190, 7.356};
  const double ritz[] = {13.4682, 19.59614, 24.2702, 34.80089, 34.80089, 61.09324};
  Eigen::VectorXd errors[2];
  for (const int half : {0, 1}) {
    sheet.elements = half ? std::array{16, 16} : std::array{8, 8};
    const Eigen::VectorXd omega = dense_omega(assemble_sheet(sheet, {.gravity = 0}));
    errors[half].resize(6);
    EXPECT_LT(omega[2], 1e-3 * omega[3]);
    for (int r = 0; r < 6; ++r) {
      const double frequency = omega[3 + r] / (2 * pi);
      errors[half][r] = test::plate_number(sheet, frequency) / ritz[r] - 1;
      if (half == 1) {
        EXPECT_NEAR(frequency / published[r], 1, 0.006) << r;
      }
    }
  }
  for (int r = 0; r < 6; ++r) {
    EXPECT_LT(std::abs(errors[1][r]), 0.006) << r;
    // Second order. The error of the double mode passes through zero between the two meshes.
    if (r != 3 && r != 4) {
      EXPECT_NEAR(errors[0][r] / errors[1][r], 4, 0.7) << r;
    }
  }
}

TEST(AssembleSheet, HoldsAnEdgeByItsNodes) {
  Sheet sheet = test::steel_sheet(3, 2);
  sheet.clamped = {SheetEdge::left};
  sheet.pinned = {SheetEdge::top};
  const SheetMatrices matrices = assemble_sheet(sheet, {.gravity = 0});
  const auto unknowns = [&](int column, int row) {
    return matrices.unknowns[index_of(sheet.node(column, row))];
  };
  EXPECT_THAT(unknowns(0, 1), testing::Each(-1));
  EXPECT_THAT(unknowns(0, 2), testing::Each(-1));
  EXPECT_EQ(unknowns(2, 2)[0], -1);
  EXPECT_GE(unknowns(2, 2)[1], 0);
  EXPECT_EQ(unknowns(2, 2)[2], -1);
  EXPECT_THAT(unknowns(2, 1), testing::Each(testing::Ge(0)));
  EXPECT_EQ(matrices.size(), 3 * 6 + 3);
}

TEST(MembraneForces, OfAHangingSheetAreTheWeightBelow) {
  Sheet sheet = test::steel_sheet(3, 10);
  sheet.poisson_ratio = 0;
  sheet.pinned = {SheetEdge::top};
  const std::vector<MembraneForce> forces = membrane_forces(sheet, {.gravity = 9.81});
  for (int j = 0; j < 10; ++j) {
    const MembraneForce& force = forces[index_of(3 * j + 1)];
    EXPECT_NEAR(force.y, sheet.density * sheet.thickness * 9.81 * (j + 0.5) / 10, 1e-9);
    EXPECT_NEAR(force.x, 0, 1e-9);
    EXPECT_NEAR(force.xy, 0, 1e-9);
  }
}

// In its plane a sheet that is held at the side is a beam: the forces on a cut bear what lies beyond.
TEST(MembraneForces, OfASheetHeldAtTheSideBearTheWeightBeyondACut) {
  Sheet sheet = test::steel_sheet(12, 8);
  sheet.clamped = {SheetEdge::left};
  const std::vector<MembraneForce> forces = membrane_forces(sheet, {});
  const double weight = sheet.density * sheet.thickness * 9.81;  // per area
  for (const int i : {2, 6, 10}) {
    double pull = 0, shear = 0;
    for (int j = 0; j < 8; ++j) {
      pull += forces[index_of(12 * j + i)].x / 8;
      shear += forces[index_of(12 * j + i)].xy / 8;
    }
    EXPECT_NEAR(pull, 0, 1e-9 * weight);
    EXPECT_NEAR(shear, -weight * (1 - (i + 0.5) / 12), 1e-9 * weight);
    EXPECT_GT(forces[index_of(12 * 7 + i)].x, 0);
    EXPECT_LT(forces[index_of(i)].x, 0);
  }
}

TEST(MembraneForces, OfAClothOnlyPull) {
  Sheet sheet = test::steel_sheet(12, 8);
  sheet.clamped = {SheetEdge::left};
  sheet.wrinkles = true;
  for (const MembraneForce& force : membrane_forces(sheet, {})) {
    EXPECT_GE(force.x, -1e-9);
    EXPECT_GE(force.y, -1e-9);
    EXPECT_GE(force.x * force.y - force.xy * force.xy, -1e-6);
  }
}

TEST(MembraneForces, AreTheTensionWhereNothingHasWeight) {
  Sheet sheet = test::steel_sheet(2, 2);
  sheet.tension = {30, 20, 5};
  for (const MembraneForce& force : membrane_forces(sheet, {.gravity = 0})) {
    EXPECT_EQ(force.x, 30);
    EXPECT_EQ(force.y, 20);
    EXPECT_EQ(force.xy, 5);
  }
}

TEST(AssembleSheetStructure, MovesAcrossTheSheetAloneWhateverPushesIt) {
  Sheet sheet = test::steel_sheet(4, 3);
  sheet.along_width = Vec3(0.6, 0.8, 0);
  sheet.along_height = Vec3(0, 0, 1);
  sheet.clamped = {SheetEdge::left};
  sheet.pinned_points = {{1, 1}};
  const Structure structure = assemble(sheet, {.gravity = 0});
  ASSERT_EQ(structure.nodes.size(), 20u);
  EXPECT_EQ(structure.nodes[0].row, -1);
  EXPECT_EQ(structure.size(), 6 * 16);
  const Eigen::VectorXd force = test::random_vector(structure.size(), 3);
  const Eigen::VectorXd moved = structure.flexibility(force);
  for (std::size_t i = 0; i < structure.nodes.size(); ++i) {
    const Vec6 own = node_displacement(structure, moved, i);
    EXPECT_LT(own.head<3>().cross(sheet.normal()).norm(), 1e-14 * moved.norm());
    EXPECT_LT(std::abs(own.tail<3>().dot(sheet.normal())), 1e-14 * moved.norm());
  }
  EXPECT_LT(node_displacement(structure, moved, 19).head<3>().norm(), 1e-15 * moved.norm());
  EXPECT_GT(node_displacement(structure, moved, 19).tail<3>().norm(), 1e-3 * moved.norm());
}

TEST(AssembleSheetStructure, TakesMassAndFlexibilityOfTheMatrices) {
  Sheet sheet = test::steel_sheet(4, 3);
  sheet.clamped = {SheetEdge::bottom};
  const Structure structure = assemble(sheet, {.fluid_density = 1000});
  const Eigen::VectorXd a = test::random_vector(structure.size(), 1),
                        b = test::random_vector(structure.size(), 2);
  EXPECT_NEAR(a.dot(structure.mass(b)), b.dot(structure.mass(a)),
              1e-10 * a.norm() * structure.mass(b).norm());
  EXPECT_NEAR(a.dot(structure.flexibility(b)), b.dot(structure.flexibility(a)),
              1e-10 * a.norm() * structure.flexibility(b).norm());
  EXPECT_GT(a.dot(structure.mass(a)), a.dot(assemble(sheet, {}).mass(a)));
}

TEST(AssembleSheetStructure, BendsUnderItsEndAsTheBeamThatItIs) {
  // Without Poisson's ratio a plate that is even across is a beam: F L^3 / (3 D b).
  Sheet sheet = test::steel_sheet(8, 2);
  sheet.poisson_ratio = 0;
  sheet.height = 0.2;
  sheet.clamped = {SheetEdge::left};
  const Structure structure = assemble(sheet, {.gravity = 0});
  const Sites sites = structure.find_sites();
  Eigen::VectorXd force = Eigen::VectorXd::Zero(structure.size());
  const double F = 7;
  for (const auto& [row, share] : {std::pair{0, 0.25}, {1, 0.5}, {2, 0.25}})
    force.segment<3>(structure.nodes[index_of(sheet.node(8, row))].row) = share * F * sheet.normal();
  const Eigen::VectorXd moved = structure.flexibility(force);
  const double D = plate_section(sheet.thickness, sheet.youngs_modulus, 0, sheet.density).bending_stiffness;
  EXPECT_NEAR(node_displacement(structure, moved, index_of(sheet.node(8, 1))).head<3>().dot(sheet.normal()),
              F / (3 * D * sheet.height), 1e-6 * F / (3 * D * sheet.height));
}

TEST(SheetSites, FollowTheSheetAndGatherIsTheTransposeOfTheirMotion) {
  Sheet sheet = test::steel_sheet(4, 3);
  sheet.clamped = {SheetEdge::left};
  const Structure structure = assemble(sheet, {.gravity = 0});
  const Sites sites = structure.find_sites();
  ASSERT_EQ(sites.sites.size(), 48u);
  EXPECT_EQ(sites.point_count(), 12);
  double area = 0;
  for (const Site& site : sites.sites) area += site.area;
  EXPECT_NEAR(area, sheet.width * sheet.height, 1e-14);
  const Eigen::VectorXd u = test::random_vector(structure.size(), 5);
  const Eigen::VectorXd random = test::random_vector(144, 6);
  const Eigen::Matrix3Xd forces = Eigen::Map<const Eigen::Matrix3Xd>(random.data(), 3, 48);
  EXPECT_NEAR(sites.motion(0, 48, u).col(0).dot(random), u.dot(sites.gather(forces)), 1e-12);
  EXPECT_EQ(sites.motion(4, 6, u), sites.motion(0, 48, u).middleRows(12, 6));

  // Turned about the clamped edge as a whole, as far as its free elements are.
  Eigen::VectorXd turned = Eigen::VectorXd::Zero(structure.size());
  for (const Node& node : structure.nodes) {
    if (node.row < 0) continue;
    turned.segment<3>(node.row) = Vec3::UnitZ().cross(node.position);
    turned.segment<3>(node.row + 3) = Vec3::UnitZ();
  }
  // Element 3, the last of the bottom row, about its middle.
  const Eigen::MatrixXd motion = sites.motion(12, 16, turned), turning = sites.turning(12, 16, turned);
  Vec3 mean = Vec3::Zero();
  for (int k = 0; k < 4; ++k) {
    mean += motion.block<3, 1>(3 * k, 0) / 4;
    EXPECT_LT((turning.block<3, 1>(3 * k, 0) - Vec3::UnitZ()).norm(), 1e-14);
  }
  EXPECT_LT((mean - Vec3::UnitZ().cross(sites.points.col(3))).norm(), 1e-14);
}

// An even pressure: the forces on the nodes do no work on a sheet that bends about a free edge alone.
TEST(SheetSites, GatherAnEvenPressureAsTheElementsHaveIt) {
  Sheet sheet = test::steel_sheet(4, 3);
  sheet.clamped = {SheetEdge::left};
  const Structure structure = assemble(sheet, {.gravity = 0});
  const Sites sites = structure.find_sites();
  Eigen::Matrix3Xd forces(3, 48);
  for (int s = 0; s < 48; ++s) forces.col(s) = sites.sites[index_of(s)].area * sheet.normal();
  // The consistent load of a rectangle is rho h w_tt of its mass matrix under an even acceleration.
  const Eigen::VectorXd wanted = structure.find_ground_inertia().forces * sheet.normal() / (7850 * 0.005);
  EXPECT_LT((sites.gather(forces) - wanted).norm(), 1e-13);
}

TEST(SheetGroundInertia, IsTheMassTimesARigidShift) {
  Sheet sheet = test::steel_sheet(6, 4);
  sheet.clamped = {SheetEdge::left};
  const Structure structure = assemble(sheet, {.gravity = 0});
  const GroundInertia inertia = structure.find_ground_inertia();
  EXPECT_NEAR(inertia.total_mass, 7850 * 0.005, 1e-12);
  Eigen::VectorXd shift = Eigen::VectorXd::Zero(structure.size());
  for (const Node& node : structure.nodes) {
    if (node.row >= 0) shift.segment<3>(node.row) = sheet.normal();
  }
  // Away from the clamp the mass times the shift is that of all nodes.
  const Eigen::VectorXd wanted = structure.mass(shift), found = inertia.forces * sheet.normal();
  const Eigen::Index row = structure.nodes[index_of(sheet.node(4, 2))].row;
  EXPECT_LT((found - wanted).segment<6>(row).norm(), 1e-12 * wanted.norm());
  EXPECT_LT(inertia.forces.col(0).norm() + inertia.forces.col(2).norm(), 1e-15);
}

// An even pressure N_x on a plate that is pinned all round buckles it at k pi^2 D / b^2, k = 4 for a square
// (Bryan 1891); a strip that is clamped at one end and free at the sides at pi^2 D / (4 L^2) (Euler).
TEST(SheetLoadMargin, IsThatOfBryanAndOfEuler) {
  Sheet sheet = test::steel_sheet(16, 16);
  sheet.pinned = {SheetEdge::left, SheetEdge::right, SheetEdge::bottom, SheetEdge::top};
  sheet.tension = {-1000, 0, 0};
  double D = plate_section(sheet.thickness, sheet.youngs_modulus, 0.3, sheet.density).bending_stiffness;
  EXPECT_NEAR(assemble(sheet, {.gravity = 0}).find_load_margin().factor, 4 * pi * pi * D / 1000,
              0.01 * 4 * pi * pi * D / 1000);

  Sheet strip = test::steel_sheet(16, 1);
  strip.poisson_ratio = 0;
  strip.height = 0.1;
  strip.clamped = {SheetEdge::left};
  strip.tension = {-1000, 0, 0};
  D = plate_section(strip.thickness, strip.youngs_modulus, 0, strip.density).bending_stiffness;
  EXPECT_NEAR(assemble(strip, {.gravity = 0}).find_load_margin().factor, pi * pi * D / 4000,
              1e-3 * pi * pi * D / 4000);
}

TEST(SheetLoadMargin, OfASheetThatIsPulledHasNoEnd) {
  Sheet sheet = test::steel_sheet(4, 4);
  sheet.poisson_ratio = 0;
  sheet.pinned = {SheetEdge::top};
  EXPECT_EQ(assemble(sheet, {}).find_load_margin().factor, std::numeric_limits<double>::infinity());
}

TEST(AssembleSheetStructure, RefusesInOneLineWhatCannotStand) {
  const auto expect_refused = [](const std::function<void(Sheet&)>& spoil, const std::string& what) {
    Sheet sheet = test::steel_sheet(4, 4);
    sheet.clamped = {SheetEdge::left};
    spoil(sheet);
    const std::string complaint = test::complaint_of([&] { assemble(sheet, {}); });
    EXPECT_THAT(complaint, testing::HasSubstr(what));
    EXPECT_THAT(complaint, testing::Not(testing::HasSubstr("\n")));
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  expect_refused([](Sheet& sheet) { sheet.thickness = 0; }, "sheet thickness: 0 m, wanted a number above 0");
  expect_refused([&](Sheet& sheet) { sheet.width = nan; }, "sheet width");
  expect_refused([](Sheet& sheet) { sheet.height = -1; }, "sheet height");
  expect_refused([](Sheet& sheet) { sheet.youngs_modulus = 0; }, "sheet youngs_modulus");
  expect_refused([](Sheet& sheet) { sheet.density = -3; }, "sheet density");
  expect_refused([](Sheet& sheet) { sheet.poisson_ratio = 0.7; }, "sheet poisson_ratio");
  expect_refused([](Sheet& sheet) { sheet.elements = {0, 4}; }, "sheet elements");
  expect_refused([](Sheet& sheet) { sheet.elements = {900, 900}; }, "sheet elements");
  expect_refused([](Sheet& sheet) { sheet.pinned_points = {{2, 0}}; }, "sheet point");
  expect_refused([](Sheet& sheet) { sheet.along_width = {1, 1, 0}; }, "two unit vectors");
  expect_refused([](Sheet& sheet) { sheet.clamped.clear(); }, "clamped nowhere");
  expect_refused([](Sheet& sheet) { sheet.clamped = {}, sheet.pinned = {SheetEdge::bottom}; },
                 "free to turn");
  expect_refused([](Sheet& sheet) { sheet.clamped = {}, sheet.pinned_points = {{0, 0}}; }, "two or more");
  expect_refused([](Sheet& sheet) { sheet.tension = {-1e9, 0, 0}; }, "it buckles");
  expect_refused([](Sheet& sheet) { sheet.thickness = 1e-4, sheet.clamped = {SheetEdge::bottom}; },
                 "it buckles");
}

}  // namespace
}  // namespace tremula
