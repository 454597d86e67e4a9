#include "tremula/structure/frame.hpp"

#include "tremula/reference/sparse_matrices.hpp"

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/SparseCholesky>
#include "complaint.hpp"
#include "frames.hpp"
#include "trees.hpp"

namespace tremula {
namespace {

using std::numbers::pi;

const Material wood{"wood", 9e9, 7e8, 950, ""};

double second_moment(double radius) { return pi * std::pow(radius, 4) / 4; }

Eigen::VectorXd solve(const FrameMatrices& matrices, const Eigen::VectorXd& force) {
  return Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(matrices.stiffness).solve(force);
}

TEST(AssembleFrame, OfATreeGivesTheMatricesOfTheTree) {
  Skeleton skeleton = test::random_tree(20, 11);
  Leaf leaf;
  leaf.branch = 13;
  leaf.mass = 0.4;
  skeleton.leaves.push_back(leaf);
  for (const bool rotatory : {false, true}) {
    for (const Section section : {Section::exact, Section::paper}) {
      const SparseMatrices tree = assemble_sparse(
          assemble_tree(skeleton, {.material = wood, .section = section, .rotatory_inertia = rotatory}));
      const FrameMatrices frame =
          assemble_frame(test::frame_of(skeleton, wood), {.section = section, .rotatory_inertia = rotatory});
      EXPECT_LT((frame.stiffness - tree.stiffness).norm(), 1e-13 * tree.stiffness.norm());
      EXPECT_LT((frame.mass - tree.mass).norm(), 1e-13 * tree.mass.norm());
      EXPECT_EQ(frame.row[0], -1);
      EXPECT_EQ(frame.row[1], 0);
    }
  }
}

TEST(AssembleFrame, APortalSwaysAsTheClosedFormSays) {
  // Two clamped columns and a beam under a force H at the top: H h^3/(12 E I) (3k + 2)/(6k + 1), with k the
  // stiffness I/L of the beam in units of the column's; without change of length, which adds parts in 1e5.
  const double h = 3, span = 2, column = 0.005, H = 7;
  for (const double beam : {0.002, 0.005, 0.008}) {
    Frame frame;
    frame.nodes = {{0, 0, 0}, {0, 0, h}, {span, 0, h}, {span, 0, 0}};
    frame.clamped = {0, 3};
    frame.elements = {test::make_element(0, 1, column, column, wood),
                      test::make_element(1, 2, beam, beam, wood),
                      test::make_element(2, 3, column, column, wood)};
    const FrameMatrices matrices = assemble_frame(frame);
    Eigen::VectorXd force = Eigen::VectorXd::Zero(matrices.size());
    force[matrices.row[1]] = force[matrices.row[2]] = H / 2;
    const double k = second_moment(beam) / span / (second_moment(column) / h);
    const double wanted =
        H * h * h * h / (12 * wood.youngs_modulus * second_moment(column)) * (3 * k + 2) / (6 * k + 1);
    EXPECT_NEAR(solve(matrices, force)[matrices.row[1]] / wanted, 1, 5e-5) << beam;
  }
}

TEST(AssembleFrame, AForceOnABeamWithTwoClampsBendsItByAHundredAndNinetySecond) {
  const double L = 2, r = 0.02, F = 30;
  for (const int pieces : {2, 6}) {
    Frame frame;
    frame.nodes = {{0, 0, 0}, {L, 0, 0}};
    frame.clamped = {0, 1};
    test::add_beam(frame, 0, 1, pieces, r, wood);
    const FrameMatrices matrices = assemble_frame(frame);
    const int middle = matrices.row[static_cast<std::size_t>(1 + pieces / 2)];
    Eigen::VectorXd force = Eigen::VectorXd::Zero(matrices.size());
    force[middle + 2] = F;
    const double wanted = F * L * L * L / (192 * wood.youngs_modulus * second_moment(r));
    EXPECT_NEAR(solve(matrices, force)[middle + 2] / wanted, 1, 1e-11);
  }
}

TEST(AssembleFrame, EveryElementHasItsOwnMaterial) {
  const Material softer{"softer", wood.youngs_modulus / 5, wood.shear_modulus, wood.density, ""};
  Frame frame;
  frame.nodes = {{0, 0, 0}, {0, 0, 1}, {0, 0, 3}};
  frame.clamped = {0};
  frame.elements = {test::make_element(0, 1, 0.02, 0.02, wood), test::make_element(1, 2, 0.02, 0.02, softer)};
  const FrameMatrices matrices = assemble_frame(frame);
  const Eigen::VectorXd u = solve(matrices, Eigen::VectorXd::Unit(12, 8));
  EXPECT_NEAR(u[8] * wood.youngs_modulus * pi * 0.02 * 0.02, 1 + 2 * 5, 1e-10);
}

TEST(AssembleFrame, ElementsMayPointEitherWay) {
  Frame frame = test::table(3, wood);
  for (FrameElement& element : frame.elements) element.end_radius *= 0.7;
  Frame turned = frame;
  for (std::size_t i = 0; i < turned.elements.size(); i += 2) {
    std::swap(turned.elements[i].start_node, turned.elements[i].end_node);
    std::swap(turned.elements[i].start_radius, turned.elements[i].end_radius);
  }
  const FrameMatrices a = assemble_frame(frame), b = assemble_frame(turned);
  EXPECT_LT((a.stiffness - b.stiffness).norm(), 1e-12 * a.stiffness.norm());
  EXPECT_LT((a.mass - b.mass).norm(), 1e-12 * a.mass.norm());
}

TEST(AssembleFrame, RefusesInOneLineWhatIsNoFrame) {
  const auto expect_refused = [](const std::function<void(Frame&)>& spoil, const std::string& what) {
    Frame frame = test::table(2, wood);
    spoil(frame);
    const std::string complaint = test::complaint_of([&] { assemble_frame(frame); });
    EXPECT_THAT(complaint, testing::HasSubstr(what));
    EXPECT_THAT(complaint, testing::Not(testing::HasSubstr("\n")));
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  expect_refused([&](Frame& f) { f.nodes[5].x() = nan; }, "frame node 5: its position is not finite");
  expect_refused([](Frame& f) { f.elements[3].end_node = 99; },
                 "frame element 3: node 99, wanted one of the");
  expect_refused([](Frame& f) { f.elements[3].start_node = -1; }, "frame element 3: node -1");
  expect_refused([](Frame& f) { f.elements[3].end_node = f.elements[3].start_node; },
                 "frame element 3: length 0.0");
  expect_refused([](Frame& f) { f.elements[1].start_radius = 0; }, "frame element 1: radius 0.0");
  expect_refused([&](Frame& f) { f.elements[1].end_radius = nan; }, "frame element 1: radius");
  expect_refused([](Frame& f) { f.elements[1].start_radius = f.elements[1].end_radius = 1e-90; },
                 "frame element 1: its stiffness is beyond");
  expect_refused([](Frame& f) { f.elements[2].material.density = -1; }, "frame element 2: density: -1 ");
  expect_refused([](Frame& f) { f.masses = {{0, -2}}; }, "frame point mass at node 0: -2.0");
  expect_refused([](Frame& f) { f.masses = {{40, 1}}; }, "frame point mass: node 40");
  expect_refused([](Frame& f) { f.clamped = {-7}; }, "frame clamp: node -7");
  expect_refused([](Frame& f) { f.clamped.clear(); }, "no node is clamped");
  expect_refused([](Frame& f) { f.nodes.emplace_back(5, 5, 5); }, "nothing connects it with a clamped node");
  expect_refused(
      [](Frame& f) {
        f.nodes.emplace_back(5, 5, 5);
        f.nodes.emplace_back(5, 5, 6);
        const int last = static_cast<int>(f.nodes.size()) - 1;
        f.elements.push_back(test::make_element(last - 1, last, 0.1, 0.1, wood));
      },
      "nothing connects it with a clamped node");
  expect_refused(
      [](Frame& f) {
        for (std::size_t i = 0; i < f.nodes.size(); ++i) f.clamped.push_back(static_cast<int>(i));
      },
      "all nodes are clamped");
}

}  // namespace
}  // namespace tremula
