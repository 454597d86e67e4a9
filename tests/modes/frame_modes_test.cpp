#include "tremula/modes/solve_modes.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "complaint.hpp"
#include "frames.hpp"
#include "trees.hpp"

namespace tremula {
namespace {

using std::numbers::pi;

const Material wood{"wood", 9e9, 7e8, 950, ""};

// Every method gives these, and says that none is missing.
void expect_modes(const Structure& structure, const Eigen::VectorXd& omega, int count, double tolerance) {
  for (const ModeMethod method : {ModeMethod::dense, ModeMethod::iterative}) {
    const Modes modes = solve_modes(structure, {.count = count, .method = method});
    ASSERT_EQ(modes.count(), count);
    for (int r = 0; r < count; ++r) {
      EXPECT_NEAR(modes.omega()[r] / omega[r], 1, tolerance) << "mode " << r;
      EXPECT_LT(modes.error_bound[r], ModeOptions{}.tolerance);
    }
    EXPECT_GE(modes.count_below, count);
    EXPECT_EQ(modes.count_below, modes.count_by_inertia);
  }
}

TEST(SolveFrameModes, OfATreeAreThoseOfTheTree) {
  const Skeleton skeleton = test::random_tree(60, 4);
  const Modes tree = solve_modes(assemble(skeleton, test::weightless({.material = wood})), {.count = 20});
  const Structure structure = assemble(test::frame_of(skeleton, wood));
  expect_modes(structure, tree.omega(), 20, 1e-9);
  const Modes frame = solve_modes(structure, {.count = 20, .method = ModeMethod::iterative});
  for (int r = 0; r < 20; ++r) {
    EXPECT_LT((frame.shapes.col(r) - tree.shapes.col(r)).norm(), 1e-5 * tree.shapes.col(r).norm()) << r;
  }
}

TEST(SolveFrameModes, OfABeamWithTwoClampsAreTheRootsOfItsFrequencyEquation) {
  const double L = 2, r = 0.01;
  Frame frame;
  frame.nodes = {{0, 0, 0}, L * Vec3(0.6, 0, 0.8)};
  frame.clamped = {0, 1};
  const int pieces = 40;
  test::add_beam(frame, 0, 1, pieces, r, wood);
  const Structure structure = assemble(frame, {.rotatory_inertia = false});
  Eigen::VectorXd wanted(8);
  for (int n = 1; n <= 4; ++n) {
    double low = n * pi, high = (n + 1) * pi;  // cos cosh - 1 changes its sign once between
    const auto equation = [](double b) { return std::cos(b) - 1 / std::cosh(b); };
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (low + high);
      (equation(low) * equation(middle) > 0 ? low : high) = middle;
    }
    wanted[2 * n - 2] = wanted[2 * n - 1] =
        low * low / (L * L) * std::sqrt(wood.youngs_modulus * r * r / 4 / wood.density);
  }
  expect_modes(structure, wanted, 8, 1.2 * std::pow(4.5 * pi / pieces, 4) / 720);
}

TEST(SolveFrameModes, OfAPortalFallTowardsALimitAsItIsCut) {
  const auto first = [](int pieces) {
    Frame frame;
    frame.nodes = {{0, 0, 0}, {0, 0, 3}, {2, 0, 3}, {2, 0, 0}};
    frame.clamped = {0, 3};
    test::add_beam(frame, 0, 1, pieces, 0.03, wood);
    test::add_beam(frame, 1, 2, pieces, 0.02, wood);
    test::add_beam(frame, 2, 3, pieces, 0.03, wood);
    return solve_modes(assemble(frame), {.count = 4}).frequency;
  };
  const Eigen::VectorXd coarse = first(2), finer = first(4), fine = first(8), finest = first(16);
  for (int r = 0; r < 4; ++r) {
    EXPECT_GT(coarse[r], finer[r]);
    EXPECT_GT(finer[r], fine[r]);
    EXPECT_GT(fine[r], finest[r]);
    // The twist and stretch in a mode converge as pieces^-2, the bending, which is most of it, as pieces^-4.
    EXPECT_LT(fine[r] - finest[r], (finer[r] - fine[r]) / 3.9);
  }
}

TEST(SolveFrameModes, OfATableAgreeWithADenseSolverOfKAndM) {
  Frame frame = test::table(4, wood);
  frame.masses = {{4, 3.0}};
  expect_modes(assemble(frame), test::dense_omega(assemble_frame(frame)), 30, 1e-9);
}

TEST(SolveFrameModes, OfASymmetricTableMissNoneOfTheDoubleModes) {
  const Frame table = test::table(6, wood);
  const Eigen::VectorXd omega = test::dense_omega(assemble_frame(table));
  int doubles = 0;
  for (int r = 0; r + 1 < 40; ++r) doubles += omega[r + 1] / omega[r] - 1 < 1e-9 ? 1 : 0;
  ASSERT_GT(doubles, 4);
  expect_modes(assemble(table), omega, 40, 1e-9);
}

TEST(SolveFrameModes, OfATriangleAreAllThereAndOrthonormal) {
  Frame frame;
  frame.nodes = {{0, 0, 0}, {1, 0, 0.2}, {0.3, 0.2, 1}};
  frame.clamped = {0};
  frame.elements = {test::make_element(0, 1, 0.03, 0.02, wood), test::make_element(1, 2, 0.02, 0.01, wood),
                    test::make_element(2, 0, 0.02, 0.03, wood)};
  const FrameMatrices matrices = assemble_frame(frame);
  const Modes modes = solve_modes(assemble(frame), {.count = all_modes});
  const Eigen::VectorXd omega = test::dense_omega(matrices);
  ASSERT_EQ(modes.count(), 12);
  for (int r = 0; r < 12; ++r) {
    EXPECT_NEAR(modes.omega()[r] / omega[r], 1, 1e-9);
    EXPECT_EQ(modes.shapes.col(r).cwiseAbs().maxCoeff(), modes.shapes.col(r).maxCoeff());
  }
  const Eigen::MatrixXd mass = modes.shapes.transpose() * matrices.mass * modes.shapes;
  EXPECT_LT((mass - Eigen::MatrixXd::Identity(12, 12)).norm(), 1e-9);
  const Eigen::VectorXd inverse = modes.omega().cwiseInverse();
  const Eigen::MatrixXd stiffness = inverse.asDiagonal() *
                                    (modes.shapes.transpose() * matrices.stiffness * modes.shapes) *
                                    inverse.asDiagonal();
  EXPECT_LT((stiffness - Eigen::MatrixXd::Identity(12, 12)).norm(), 1e-8);
}

TEST(SolveFrameModes, ASecondClampRaisesEveryFrequency) {
  Frame frame = test::table(3, wood);
  const Modes four = solve_modes(assemble(frame), {.count = 10});
  frame.clamped.pop_back();
  const Modes three = solve_modes(assemble(frame), {.count = 10});
  for (int r = 0; r < 10; ++r) EXPECT_LT(three.frequency[r], four.frequency[r] * (1 + 1e-9));
  EXPECT_LT(three.frequency[0], 0.9 * four.frequency[0]);
}

TEST(SolveFrameModes, UpToAFrequencyAreAllBelowIt) {
  const Frame frame = test::table(4, wood);
  const Eigen::VectorXd omega = test::dense_omega(assemble_frame(frame));
  int compared = 0;
  for (int r = 5; r < 30; ++r) {
    if (omega[r + 1] / omega[r] - 1 < 1e-6) continue;
    const double between = std::sqrt(omega[r] * omega[r + 1]) / (2 * pi);
    EXPECT_EQ(solve_modes_up_to(assemble(frame), between).count(), r + 1);
    ++compared;
  }
  EXPECT_GT(compared, 10);
}

TEST(SolveFrameModes, RefusesCountsThatTheFrameDoesNotHave) {
  const Structure structure = assemble(test::table(1, wood));
  for (const int count : {0, -2, 25}) {
    EXPECT_THAT(test::complaint_of([&] { solve_modes(structure, {.count = count}); }),
                testing::HasSubstr("mode count: " + std::to_string(count) + ", wanted 1 to 24"));
  }
}

}  // namespace
}  // namespace tremula
