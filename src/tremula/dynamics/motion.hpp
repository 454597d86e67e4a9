// The narrow waist of the cascade: what the wind does to a structure during one loop, as a small table.
#pragma once

#include "tremula/modes/modes.hpp"

#include <Eigen/Core>

namespace tremula {

// Shapes beside the modes, at right angles to them in mass and in stiffness and mass-normalised like them
// (static_correction.hpp). Their coordinates follow the wind at once: y = f/omega^2.
struct StaticShapes {
  Eigen::VectorXd frequency;  // (k) Rayleigh quotients [Hz]
  Eigen::MatrixXd shapes;     // (6N x k)

  int count() const { return static_cast<int>(frequency.size()); }
};

// Modal coordinates at M equidistant instants of a loop that closes (sample M would equal sample 0), and the
// static lean under the mean wind. The displacement at sample p is lean + (Modes::shapes, static_shapes) *
// coordinates.row(p)^T.
struct Motion {
  double period = 0;            // T [s]
  Eigen::MatrixXd coordinates;  // (M x (m + k)) [m sqrt(kg)], row p at t = p T / M
  Eigen::VectorXd lean;         // (6N) displacement under the mean wind [m, rad], rows as in Modes::shapes
  StaticShapes static_shapes = {};

  int sample_count() const { return static_cast<int>(coordinates.rows()); }
  int mode_count() const { return static_cast<int>(coordinates.cols()) - static_shapes.count(); }
};

enum class Interpolation {
  linear,  // S section 7
  cubic,   // periodic Catmull-Rom: smooth velocity, same samples
};

// Throws InputError unless the motion is one of these modes: numbers of modes, static shapes and rows agree,
// and there is a sample.
void check_fit(const Modes& modes, const Motion& motion);

// Modal coordinates (m) at any time [s], before 0 and after T too; exact at the samples. Throws InputError
// for a motion without samples or period, and for a time that is not finite.
Eigen::VectorXd coordinates_at(const Motion& motion, double time, Interpolation interpolation);

}  // namespace tremula
