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

// The static lean under the mean wind (6N), exact in the structure, with the drag of every branch reduced to
//
//   lambda = 1 / (1 + x^2)^2,     x = theta/theta_0, theta the rotation of its end in the lean itself.
//
// `loads` are reduced: the mean by lambda, the part per velocity by lambda times what is left of the growth
// of the drag with the wind, 1 / (1 + 4 x^2/(1 + x^2)): a gust, too, turns the branch out of the wind. What
// damping is made of is reduced by lambda alone: that a branch turns out of the wind makes it stiffer, not
// less damped. Drag then grows with less than the square of the wind, as it does on real plants (Vogel 1989;
// de Langre 2008, Annu. Rev. Fluid Mech. 40), and rotations stay where small displacements describe them. The
// form is a choice, not a measurement: angle = 0 gives the linear lean K^-1 f and leaves the loads alone.
// Throws InputError for an angle below 0, or above it but below 1e-6, and Error where the factors do not
// settle to a thousandth.
Eigen::VectorXd lean_and_reconfigure(const Structure& structure, const Reconfiguration& reconfiguration,
                                     Loads& loads);

}  // namespace tremula
