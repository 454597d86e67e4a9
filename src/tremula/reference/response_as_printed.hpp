// The response as the papers print it: one coefficient a bin, each mode by itself.
#pragma once

#include "tremula/dynamics/damping.hpp"
#include "tremula/modes/modes.hpp"
#include "tremula/numerics/time_axis.hpp"

#include <functional>

#include <Eigen/Core>

namespace tremula {

// Gives the Fourier coefficients of the wind at the load points for a bin: (3 x N) [m/s]. Called from several
// threads at once, for each bin once.
using VelocityAtBin = std::function<Eigen::Matrix3Xcd(int bin)>;

// Modal forces for every bin. participation (3N x m) -> (M/2+1 x m)
Eigen::MatrixXcd project_loads(const Eigen::MatrixXd& participation, const TimeAxis& axis,
                               const VelocityAtBin& velocity);

// S eq. 7 in every bin, the loop by inverse FFT:
//   y_r(omega) = f_r(omega) / (omega_r^2 - omega^2 + i c_r omega),  omega = 2 pi p/T (errata S2).
// modal_forces (M/2+1 x m) -> modal coordinates at the samples (M x m) [m sqrt(kg)]
Eigen::MatrixXd respond_as_printed(const Modes& modes, const Eigen::MatrixXcd& modal_forces,
                                   const TimeAxis& axis, const Damping& damping);

}  // namespace tremula
