// How much a structure moves, in a few numbers.
#pragma once

#include "tremula/dynamics/motion.hpp"
#include "tremula/modes/modes.hpp"

namespace tremula {

struct MotionStatistics {
  double largest_lean = 0;           // displacement of a node under the mean wind [m]
  double largest_lean_rotation = 0;  // [rad]
  double largest_rms = 0;  // root mean square over the loop of a node's displacement about the lean [m]
  double largest_rms_rotation = 0;      // [rad]
  int most_moved_branch = 0;            // whose end has the largest rms displacement
  Eigen::VectorXd coordinate_rms = {};  // (m + k) of the modal coordinates [m sqrt(kg)]
};

// From the covariance of the modal coordinates: cost N m^2, whatever the length of the loop.
MotionStatistics motion_statistics(const Modes& modes, const Motion& motion);

}  // namespace tremula
