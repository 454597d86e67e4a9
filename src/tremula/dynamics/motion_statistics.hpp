// How much a structure moves, in a few numbers.
#pragma once

#include "tremula/dynamics/motion.hpp"
#include "tremula/structure/structure.hpp"

namespace tremula {

// Root mean squares over the loop.
struct Sway {
  double displacement = 0;           // of the end of a member that moves most [m]
  double rotation = 0;               // of the end that turns most [rad]
  int branch = 0;                    // the member whose end moves most; behind them count the nodes of panels
  Eigen::VectorXd coordinates = {};  // (m + k) of modes and static shapes [m sqrt(kg)]
};

struct MotionStatistics {
  double largest_lean = 0;           // displacement of an end under the mean wind [m]
  double largest_lean_rotation = 0;  // [rad]
  // A loop has gusts slower than itself as a mean of its own, which the seed decides. About the lean they
  // count: over seeds and for any period the mean square is the variance of the wind's answer. About the
  // loop's own mean they do not: what is seen to move, the less the shorter the loop.
  Sway about_lean = {}, about_mean = {};
  // How much longer the chord of a branch becomes than it is, the most over the loop, as small displacements
  // superposed make it: on the plant at rest (deformation/pose.hpp), or on the bent lean of a motion that has
  // one, as morph targets play it (poses by strains stretch nothing). 0.1: a tenth. Nothing real stretches
  // so: it measures the error.
  double largest_stretch = 0;
  int most_stretched_branch = 0;
};

// From the covariance of the modal coordinates: cost N m^2, whatever the length of the loop. The stretch is
// looked for at all samples, or, on large plants in long loops, at as many of them, evenly spaced, as 4e8
// operations allow, at least 32. Throws InputError for a motion that holds numbers that are none, and for one
// of another structure.
MotionStatistics motion_statistics(const Structure& structure, const Motion& motion);

}  // namespace tremula
