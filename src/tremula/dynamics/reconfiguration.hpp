// Plants bend out of the wind: the farther a branch is turned, the less of it and of its leaves the wind
// meets.
#pragma once

#include <Eigen/Core>

#include "tremula/dynamics/loads.hpp"
#include "tremula/structure/structure.hpp"

namespace tremula {

struct Reconfiguration {
  double angle = 0.3;  // theta_0 [rad], the rotation that cuts the drag to a quarter; 0: nothing cuts it
};

// How a structure stands in the mean wind, and the loads on it there.
struct Lean {
  Eigen::VectorXd displacement;  // (rows) [m, rad]
  Loads loads;
};

// The static lean under the mean wind, exact in the structure, with the drag of every site reduced to
//
//   lambda = 1 / (1 + x^2)^2,     x = theta/theta_0, theta the rotation of its point (Sites::turning_row)
//
// in the lean itself. The loads that are left: force and force per velocity times lambda; of what a gust adds
// only a part, 1 / (1 + 4 x^2/(1 + x^2)) (Loads::gust_share): a gust, too, turns the branch out of the wind.
// Damping knows nothing of that part: that a branch turns out of the wind makes it stiffer, not less damped.
// Drag then grows with less than the square of the wind, as it does on real plants (Vogel 1989; de Langre
// 2008, Annu. Rev. Fluid Mech. 40), and rotations stay where small displacements describe them. The form is a
// choice, not a measurement: angle = 0 gives the linear lean K^-1 f and the loads as they were. Throws
// InputError for an angle below 0, or above it but below 1e-6, and Error where the factors do not settle to a
// thousandth.
Lean find_lean(const Structure& structure, const Sites& sites, Loads loads,
               const Reconfiguration& reconfiguration);

}  // namespace tremula
