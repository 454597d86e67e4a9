// The narrow waist of the cascade: what the wind does to a structure during one loop, as a small table.
#pragma once

#include <Eigen/Core>

namespace tremula {

// Modal coordinates at M equidistant instants of a loop that closes (sample M would equal sample 0), and the
// static lean under the mean wind. The displacement at sample p is lean + shapes * coordinates.row(p)^T.
struct Motion {
  double period = 0;            // T [s]
  Eigen::MatrixXd coordinates;  // (M x m) [m sqrt(kg)], row p at t = p T / M
  Eigen::VectorXd lean;         // (6N) displacement under the mean wind [m, rad], rows as in Modes::shapes

  int sample_count() const { return static_cast<int>(coordinates.rows()); }
  int mode_count() const { return static_cast<int>(coordinates.cols()); }
};

enum class Interpolation {
  linear,  // S section 7
  cubic,   // periodic Catmull-Rom: smooth velocity, same samples
};

// Modal coordinates (m) at any time [s], before 0 and after T too; exact at the samples.
Eigen::VectorXd coordinates_at(const Motion& motion, double time, Interpolation interpolation);

}  // namespace tremula
