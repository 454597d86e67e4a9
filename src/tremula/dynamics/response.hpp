// From the wind to the motion, in the frequency domain (S section 3, 5 and 6).
#pragma once

#include "tremula/dynamics/transfer.hpp"
#include "tremula/numerics/time_axis.hpp"
#include "tremula/wind/point_wind.hpp"

#include <functional>
#include <vector>

#include <Eigen/Core>

namespace tremula {

// S eq. 7 in every bin, with all that the transfer function knows: damping between modes, the width of the
// bins. One bin of wind at a time a thread: no array of points and bins ever exists.
// participation (3P x (m + k)). A wind without draws wants Transfer::sampled; without slow gusts
// bin 0 stays zero. Gives the coefficients of the coordinates, (M/2+1 x (m + k)): samples_from_half_spectra
// makes the loop of them.
// inertia (3P x (m + k)): of dv/dt likewise, which in a bin is i omega v; empty: none.
Eigen::MatrixXcd respond(const BinTransfer& transfer, const Eigen::MatrixXd& participation,
                         const TimeAxis& axis, const PointWind& wind,
                         const std::function<void(double done)>& progress = {},
                         const Eigen::MatrixXd& inertia = {});

// The same from coefficients of the forces on the coordinates, (M/2+1 x (m + k)) for every draw: those of
// drag_in_time, whose mean over the loop is in bin 0. Throws InputError for too few draws or other sizes.
Eigen::MatrixXcd respond(const BinTransfer& transfer, const TimeAxis& axis,
                         const std::vector<Eigen::MatrixXcd>& forces);

}  // namespace tremula
