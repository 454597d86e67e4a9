// Plants bend out of the wind: the farther a branch is turned, the less of it and of its leaves the wind
// meets.
#pragma once

#include <Eigen/Core>

#include "tremula/dynamics/loads.hpp"
#include "tremula/structure/structure.hpp"

namespace tremula {

struct Reconfiguration {
  double angle =
      0.3;  // theta_0 [rad], the rotation at which the drag has fallen to a quarter; 0: drag never falls
};

// The static lean under the mean wind (6N), exact in the structure, with the drag of every branch reduced to
//
//   1 / (1 + (theta/theta_0)^2)^2,     theta the rotation of its end in the lean itself,
//
// and `loads`, mean and fluctuating, reduced alike. Drag then grows with less than the square of the wind, as
// it does on real plants (Vogel 1989; de Langre 2008, Annu. Rev. Fluid Mech. 40), and rotations stay where
// small displacements describe them. The form is a choice, not a measurement: angle = 0 gives the linear lean
// K^-1 f. Throws InputError for an angle below 0.
Eigen::VectorXd lean_and_reconfigure(const Structure& structure, const Reconfiguration& reconfiguration,
                                     Loads& loads);

}  // namespace tremula
