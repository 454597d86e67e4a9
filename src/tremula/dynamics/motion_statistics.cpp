#include "tremula/dynamics/motion_statistics.hpp"

#include <algorithm>
#include <cmath>

namespace tremula {

MotionStatistics motion_statistics(const Modes& modes, const Motion& motion) {
  check_fit(modes, motion);
  const Eigen::MatrixXd covariance =
      motion.coordinates.transpose() * motion.coordinates / static_cast<double>(motion.sample_count());
  MotionStatistics statistics;
  statistics.coordinate_rms = covariance.diagonal().cwiseSqrt();
  const int more = motion.static_shapes.count();
  const auto rms = [&](Eigen::Index row) {
    Eigen::MatrixXd part(3, covariance.rows());
    part.leftCols(modes.count()) = modes.shapes.middleRows(row, 3);
    if (more > 0) part.rightCols(more) = motion.static_shapes.shapes.middleRows(row, 3);
    return std::sqrt(std::max(0.0, (part * covariance).cwiseProduct(part).sum()));
  };
  for (Eigen::Index k = 0; k < modes.shapes.rows() / 6; ++k) {
    statistics.largest_lean = std::max(statistics.largest_lean, motion.lean.segment<3>(6 * k).norm());
    statistics.largest_lean_rotation =
        std::max(statistics.largest_lean_rotation, motion.lean.segment<3>(6 * k + 3).norm());
    statistics.largest_rms_rotation = std::max(statistics.largest_rms_rotation, rms(6 * k + 3));
    const double displacement = rms(6 * k);
    if (displacement > statistics.largest_rms) {
      statistics.largest_rms = displacement;
      statistics.most_moved_branch = static_cast<int>(k);
    }
  }
  return statistics;
}

}  // namespace tremula
