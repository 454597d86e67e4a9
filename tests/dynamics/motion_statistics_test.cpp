#include "tremula/dynamics/motion_statistics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace tremula {
namespace {

TEST(MotionStatistics, AreTheRootMeanSquaresOfTheDisplacements) {
  Modes modes;
  modes.frequency = Eigen::VectorXd::Ones(3);
  modes.shapes = Eigen::MatrixXd::Random(24, 3);
  Motion motion{2, Eigen::MatrixXd::Random(50, 3), Eigen::VectorXd::Random(24)};
  double largest = 0, largest_rotation = 0, largest_lean = 0;
  int branch = -1;
  for (int k = 0; k < 4; ++k) {
    double squares = 0, rotation_squares = 0;
    for (int p = 0; p < 50; ++p) {
      const Eigen::VectorXd u = modes.shapes * motion.coordinates.row(p).transpose();
      squares += u.segment<3>(6 * k).squaredNorm() / 50;
      rotation_squares += u.segment<3>(6 * k + 3).squaredNorm() / 50;
    }
    if (std::sqrt(squares) > largest) branch = k;
    largest = std::max(largest, std::sqrt(squares));
    largest_rotation = std::max(largest_rotation, std::sqrt(rotation_squares));
    largest_lean = std::max(largest_lean, motion.lean.segment<3>(6 * k).norm());
  }
  const MotionStatistics statistics = motion_statistics(modes, motion);
  EXPECT_NEAR(statistics.largest_rms, largest, 1e-13);
  EXPECT_NEAR(statistics.largest_rms_rotation, largest_rotation, 1e-13);
  EXPECT_EQ(statistics.largest_lean, largest_lean);
  EXPECT_EQ(statistics.most_moved_branch, branch);
}

}  // namespace
}  // namespace tremula
