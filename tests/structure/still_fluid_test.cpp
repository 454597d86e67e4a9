#include "tremula/structure/still_fluid.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include <Eigen/Cholesky>

namespace tremula {
namespace {

using std::numbers::pi;

// Twice the kinetic energy per density of the fluid, where the plate moves at w(x, y).
double twice_energy(double width, double height, int count,
                    const std::function<double(double x, double y)>& speed) {
  const FluidPanels panels = fluid_panels(width, height, count);
  Eigen::VectorXd w(panels.centres.cols());
  for (Eigen::Index p = 0; p < w.size(); ++p) w[p] = speed(panels.centres(0, p), panels.centres(1, p));
  return panels.area * w.dot(panels.influence.llt().solve(w));
}

double one(double, double) { return 1; }

TEST(FluidPanels, InfluenceIsSymmetricAndPositiveDefinite) {
  const Eigen::MatrixXd A = fluid_panels(2, 1, 200).influence;
  EXPECT_EQ((A - A.transpose()).norm(), 0);
  EXPECT_EQ(A.llt().info(), Eigen::Success);
}

// DNV-RP-C205 (2010), appendix A, table A-2: the added mass of a rectangular plate across itself is
// C_A rho pi a^2 b / 4 with its short side a.
TEST(FluidPanels, OfARectangleHaveTheAddedMassOfTheTable) {
  for (const auto& [ratio, wanted] :
       {std::pair{1.0, 0.579}, {1.5, 0.690}, {2.0, 0.757}, {3.0, 0.830}, {5.0, 0.897}, {10.0, 0.947}}) {
    EXPECT_NEAR(twice_energy(ratio, 1, 400, one) / (ratio * pi / 4), wanted, 0.01) << ratio;
    EXPECT_NEAR(twice_energy(1, ratio, 400, one) / (ratio * pi / 4), wanted, 0.01) << ratio;
  }
}

// Of a long strip each metre carries rho pi b^2 / 4 when it moves across itself and rho pi b^4 / 128 when it
// turns (Lamb 1932, Hydrodynamics, section 71).
TEST(FluidPanels, OfALongStripHaveTheAddedMassOfItsSections) {
  const double length = 60, b = 0.8;
  EXPECT_NEAR(twice_energy(length, b, 800, one) / (length * pi * b * b / 4), 1, 0.02);
  const double turned = twice_energy(length, b, 800, [&](double, double y) { return y - b / 2; });
  EXPECT_NEAR(turned / (length * pi * std::pow(b, 4) / 128), 1, 0.05);
}

TEST(FluidPanels, ErrorsFallWithTheNumberOfPanels) {
  const double fine = twice_energy(1, 1, 1600, one);
  const double coarse = std::abs(twice_energy(1, 1, 100, one) - fine),
               half = std::abs(twice_energy(1, 1, 400, one) - fine);
  EXPECT_LT(half, coarse / 3);
  EXPECT_LT(half, 2e-3 * fine);
}

}  // namespace
}  // namespace tremula
