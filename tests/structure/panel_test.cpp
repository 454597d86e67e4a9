#include "tremula/structure/panel.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <string>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "complaint.hpp"
#include "panels.hpp"
#include "random_vector.hpp"
#include "tremula/structure/structure.hpp"

namespace tremula {
namespace {

using testing::HasSubstr;

const Material wood{"wood", 9e9, 7e8, 950, ""};

Sheet slanting(Sheet sheet) {
  const Eigen::AngleAxisd turn(0.7, Vec3(1, 2, -1).normalized());
  sheet.along_width = turn * sheet.along_width;
  sheet.along_height = turn * sheet.along_height;
  sheet.corner = {0.3, -0.2, 1.1};
  return sheet;
}

// The six rigid motions of points: (6 P x 6).
Eigen::MatrixXd rigid_motions(const std::vector<Vec3>& points) {
  Eigen::MatrixXd motions(6 * static_cast<Eigen::Index>(points.size()), 6);
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      const auto row = 6 * static_cast<Eigen::Index>(i);
      motions.col(axis).segment<6>(row) << Vec3::Unit(axis), Vec3::Zero();
      motions.col(3 + axis).segment<6>(row) << Vec3::Unit(axis).cross(points[i]), Vec3::Unit(axis);
    }
  }
  return motions;
}

TEST(PanelStiffness, HasSixMotionsWithoutEnergyAndThoseAreRigid) {
  const Sheet sheet = slanting(test::panel_sheet());
  std::vector<Vec3> corners;
  for (const int node : corners_of(sheet, 1, 2)) corners.push_back(sheet.position(sheet.place(node)));
  const PanelMatrix stiffness = panel_stiffness(sheet);
  const Eigen::MatrixXd rigid = rigid_motions(corners);
  EXPECT_LT((stiffness * rigid).norm(), 1e-12 * stiffness.norm());
  const Eigen::SelfAdjointEigenSolver<PanelMatrix> solver(stiffness);
  EXPECT_LT(std::abs(solver.eigenvalues()[5]), 1e-12 * solver.eigenvalues()[23]);
  EXPECT_GT(solver.eigenvalues()[6], 1e-7 * solver.eigenvalues()[23]);
}

TEST(PanelMass, IsThatOfThePlateInEveryDirection) {
  const Sheet sheet = slanting(test::panel_sheet());
  const PanelMatrix mass = panel_mass(sheet);
  const double whole = sheet.density * sheet.thickness * sheet.width * sheet.height / 12;
  std::vector<Vec3> corners;
  for (const int node : corners_of(sheet, 0, 0)) corners.push_back(sheet.position(sheet.place(node)));
  const Eigen::MatrixXd shifts = rigid_motions(corners).leftCols(3);
  EXPECT_LT((shifts.transpose() * mass * shifts - whole * Mat3::Identity()).norm(), 1e-12 * whole);
}

// About its middle it has M (w^2 + h^2) / 12 about the normal and M w^2 / 12 and M h^2 / 12 about the others.
TEST(PanelMass, TurnsWithTheInertiaOfARectangle) {
  Sheet sheet = slanting(test::panel_sheet());
  sheet.elements = {1, 1};
  std::vector<Vec3> corners;
  for (const int node : corners_of(sheet, 0, 0))
    corners.push_back(sheet.position(sheet.place(node)) - sheet.position({0.5, 0.3}));
  const Eigen::MatrixXd turns = rigid_motions(corners).rightCols(3);
  Mat3 axes;
  axes << sheet.along_width, sheet.along_height, sheet.normal();
  const Mat3 found = axes.transpose() * turns.transpose() * panel_mass(sheet) * turns * axes;
  const double mass = 2700 * 0.01 * 1 * 0.6, h = sheet.thickness;
  const Vec3 wanted = mass / 12 * Vec3(0.36, 1, 1.36 + h * h);
  EXPECT_LT((found - Mat3(wanted.asDiagonal())).norm(), 1e-12 * mass);
}

// Its left edge held, it bends as the sheet that is clamped there does: the same matrix.
TEST(FrameWithAPanel, HeldAlongAnEdgeIsTheSheetClampedThere) {
  Sheet sheet = slanting(test::panel_sheet());
  const FrameMatrices frame = assemble_frame(test::wall_with_panel(sheet));
  sheet.clamped = {SheetEdge::left};
  const SheetMatrices alone = assemble_sheet(sheet, {.gravity = 0});
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(
      Eigen::MatrixXd(alone.bending), Eigen::MatrixXd(alone.mass), Eigen::EigenvaluesOnly);
  const Eigen::VectorXd wanted = solver.eigenvalues().cwiseSqrt(), found = test::dense_omega(frame);
  for (int r = 0; r < 8; ++r) EXPECT_NEAR(found[r] / wanted[r], 1, 1e-6) << r;
}

TEST(FrameWithAPanel, GoesWithItsFixingsAlongRigidArms) {
  Frame frame = test::post_with_panel(2, 0.02, wood, slanting(test::panel_sheet()));
  frame.panels[0].sheet.corner += Vec3(0.1, 0, 0);  // off the post
  const Structure structure = assemble(frame);
  ASSERT_EQ(structure.panels.size(), 1u);
  const PlacedPanel& panel = structure.panels[0];
  const Eigen::VectorXd moved = test::random_vector(structure.size(), 5);
  const Vec6 top = node_displacement(structure, moved, 1);
  const Eigen::Vector2d fixed(0.5, 0.4);  // the node nearest to the middle of three elements
  const PanelPlace there = place_on(panel, fixed);
  const Vec3 arm = panel.sheet.position(fixed) - frame.nodes[1];
  EXPECT_GT(arm.norm(), 0.1);
  const Eigen::MatrixXd corners = corner_displacements(there, moved);
  EXPECT_LT((there.translation * corners - top.head<3>() - top.tail<3>().cross(arm)).norm(), 1e-12);
  EXPECT_LT((there.rotation * corners - top.tail<3>()).norm(), 1e-12);
}

TEST(FrameWithAPanel, MovesEveryPlaceRigidlyWhereAllNodesAre) {
  const Frame frame = test::post_with_panel(2, 0.02, wood, slanting(test::panel_sheet()));
  const Structure structure = assemble(frame);
  const Vec3 about = frame.nodes[1], shift(0.3, -0.1, 0.2), turn(0.2, 0.5, -0.4);
  Eigen::VectorXd moved = Eigen::VectorXd::Zero(structure.size());
  for (const Node& node : structure.nodes) {
    if (node.row >= 0) moved.segment<6>(node.row) << shift + turn.cross(node.position - about), turn;
  }
  const PlacedPanel& panel = structure.panels[0];
  for (const Eigen::Vector2d& place : {Eigen::Vector2d(0, 0), {1, 0.6}, {0.61, 0.13}, {0.4, 0.33}}) {
    const PanelPlace there = place_on(panel, place);
    const Eigen::MatrixXd corners = corner_displacements(there, moved);
    const Vec3 wanted = shift + turn.cross(panel.sheet.position(place) - about);
    EXPECT_LT((there.translation * corners - wanted).norm(), 1e-13) << place.transpose();
    EXPECT_LT((there.rotation * corners - turn).norm(), 1e-12) << place.transpose();
  }
}

// A force on a corner of the panel: the post is statically determinate and bends as by the force and its
// moment, in closed form.
TEST(FrameWithAPanel, HandsAForceOnItsCornerDownThePost) {
  const double L = 2, r = 0.02;
  const Sheet sheet = test::panel_sheet();
  Frame frame = test::post_with_panel(L, r, wood, sheet);
  const Structure structure = assemble(frame);
  const PlacedPanel& panel = structure.panels[0];
  const Vec3 force(7, 3, -5), arm = panel.sheet.position({1, 0.6}) - frame.nodes[1];
  Eigen::VectorXd forces = Eigen::VectorXd::Zero(structure.size());
  const PanelNode& corner = panel.nodes[index_of(panel.sheet.node(4, 3))];
  ASSERT_GE(corner.row, 0);
  forces.segment<3>(corner.row) = force;
  const Vec6 top = node_displacement(structure, structure.flexibility(forces), 1);
  const Vec3 moment = arm.cross(force);
  const double I = M_PI * std::pow(r, 4) / 4, EI = wood.youngs_modulus * I, GJ = wood.shear_modulus * 2 * I;
  // A force across and a moment at the tip: F L^3 / 3 EI + M L^2 / 2 EI, F L^2 / 2 EI + M L / EI.
  const double x = force.x() * L * L * L / (3 * EI) + moment.y() * L * L / (2 * EI),
               y = force.y() * L * L * L / (3 * EI) - moment.x() * L * L / (2 * EI);
  EXPECT_NEAR(top[0], x, 1e-8 * std::abs(x));
  EXPECT_NEAR(top[1], y, 1e-8 * std::abs(y));
  EXPECT_NEAR(top[2], force.z() * L / (wood.youngs_modulus * M_PI * r * r), 1e-12);
  EXPECT_NEAR(top[3], -force.y() * L * L / (2 * EI) + moment.x() * L / EI, 1e-8);
  EXPECT_NEAR(top[4], force.x() * L * L / (2 * EI) + moment.y() * L / EI, 1e-8);
  EXPECT_NEAR(top[5], moment.z() * L / GJ, 1e-8);
}

TEST(FrameWithAPanel, HasTheMassOfPostAndPanel) {
  const Sheet sheet = test::panel_sheet();
  const Structure structure = assemble(test::post_with_panel(2, 0.02, wood, sheet));
  const GroundInertia inertia = structure.find_ground_inertia();
  const double panel = 2700 * 0.01 * 1 * 0.6, post = 950 * M_PI * 0.02 * 0.02 * 2;
  EXPECT_NEAR(inertia.total_mass, panel + post, 1e-9);
  // On the free nodes all of it but what the lowest piece hangs on the ground, a half of 1/12 of the post.
  for (int axis = 0; axis < 3; ++axis) {
    double sum = 0;
    for (Eigen::Index row = axis; row < structure.size(); row += 6) sum += inertia.forces(row, axis);
    EXPECT_NEAR(sum, panel + post * (1 - 0.5 / 12), 1e-6) << axis;
  }
}

TEST(FrameWithAPanel, CountsTheRowsOfItsFreeNodes) {
  const Frame frame = test::post_with_panel(2, 0.02, wood, test::panel_sheet());
  EXPECT_EQ(free_rows(frame), assemble_frame(frame).size());
  EXPECT_EQ(free_rows(frame), 6 * (12 + 5 * 4 - 1));
  EXPECT_EQ(assemble(frame).nodes.size(), 13u + 19u);
}

TEST(SitesOfAFrameWithAPanel, GatherAsTheyMoveAndCoverThePanel) {
  const Frame frame = test::post_with_panel(2, 0.02, wood, slanting(test::panel_sheet()));
  const Structure structure = assemble(frame);
  const Sites sites = structure.find_sites();
  double area = 0;
  for (const Site& site : sites.sites) area += site.kind == SiteKind::plate ? site.area : 0;
  EXPECT_NEAR(area, 0.6, 1e-14);
  ASSERT_EQ(sites.point_count(), 12 + 12);
  const Eigen::VectorXd moved = test::random_vector(structure.size(), 6);
  const auto count = static_cast<Eigen::Index>(sites.sites.size());
  const Eigen::VectorXd numbers = test::random_vector(3 * count, 7);
  const Eigen::Matrix3Xd forces = Eigen::Map<const Eigen::Matrix3Xd>(numbers.data(), 3, count);
  const Eigen::MatrixXd motion = sites.motion(0, sites.sites.size(), moved);
  EXPECT_NEAR(numbers.dot(motion.col(0)), sites.gather(forces).dot(moved), 1e-11);
  // Through the seam between both in one call or two.
  const Eigen::MatrixXd low = sites.motion(0, 50, moved), high = sites.motion(50, sites.sites.size(), moved);
  EXPECT_EQ(motion.topRows(150), low);
  EXPECT_EQ(motion.bottomRows(3 * count - 150), high);
  EXPECT_EQ(sites.turning(40, 60, moved).rows(), 60);
}

TEST(CheckFrame, NamesWhatIsWrongWithAPanel) {
  const auto complaint = [](const std::function<void(Panel&)>& spoil) {
    Frame frame = test::post_with_panel(2, 0.02, wood, test::panel_sheet());
    spoil(frame.panels[0]);
    return test::complaint_of([&] { check_frame(frame); });
  };
  EXPECT_EQ(complaint([](Panel&) {}), "");
  EXPECT_THAT(complaint([](Panel& p) { p.sheet.thickness = 0; }),
              HasSubstr("frame panel 0: sheet thickness: 0 m"));
  EXPECT_THAT(complaint([](Panel& p) { p.sheet.elements = {0, 4}; }), HasSubstr("elements"));
  EXPECT_THAT(complaint([](Panel& p) { p.fixed.clear(); }), HasSubstr("fixed nowhere"));
  EXPECT_THAT(complaint([](Panel& p) { p.fixed[0].node = 99; }), HasSubstr("node 99, wanted one of the 13"));
  EXPECT_THAT(complaint([](Panel& p) {
                p.fixed[0].place = {0.5, 0.7};
              }),
              HasSubstr("fixing at 0.5, 0.7 m: off the panel"));
  EXPECT_THAT(complaint([](Panel& p) { p.fixed[0].place[0] = std::numeric_limits<double>::quiet_NaN(); }),
              HasSubstr("off the panel"));
  EXPECT_THAT(complaint([](Panel& p) { p.fixed.push_back(p.fixed[0]); }),
              HasSubstr("another fixing at the same node"));
  EXPECT_THAT(complaint([](Panel& p) { p.sheet.clamped = {SheetEdge::top}; }), HasSubstr("held or pulled"));
  EXPECT_THAT(complaint([](Panel& p) { p.sheet.tension.x = 4; }), HasSubstr("held or pulled"));
}

TEST(CheckFrame, LetsAPanelConnectNodes) {
  Frame frame = test::post_with_panel(2, 0.02, wood, test::panel_sheet());
  frame.nodes.emplace_back(0, 0.5, 2.3);
  EXPECT_THAT(test::complaint_of([&] { check_frame(frame); }), HasSubstr("nothing connects it"));
  frame.panels[0].fixed.push_back({{1, 0.6}, 13});
  EXPECT_EQ(test::complaint_of([&] { check_frame(frame); }), "");
}

TEST(FrameElement, OfATubeIsTheBeamOfATube) {
  Frame frame = test::post_with_panel(2, 0.02, wood, test::panel_sheet());
  frame.elements[3].wall = 0.2;
  const FrameMatrices matrices = assemble_frame(frame);
  EXPECT_DOUBLE_EQ(matrices.members[3].beam.tube.area, 1 - 0.64);
  EXPECT_DOUBLE_EQ(matrices.members[3].beam.tube.polar, 1 - 0.4096);
  EXPECT_EQ(matrices.members[2].beam.tube.area, 1);
  frame.elements[3].wall = 1.2;
  EXPECT_THAT(test::complaint_of([&] { check_frame(frame); }), HasSubstr("frame element 3: a wall of 1.2"));
}

}  // namespace
}  // namespace tremula
