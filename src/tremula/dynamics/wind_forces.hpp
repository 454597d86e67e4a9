// What one realisation of the wind does to the coordinates of a structure, bin by bin, and networks of modes:
// for dynamics that go through time instead of through a transfer function.
#pragma once

#include "tremula/dynamics/oscillators.hpp"
#include "tremula/dynamics/transfer.hpp"
#include "tremula/numerics/time_axis.hpp"
#include "tremula/wind/point_wind.hpp"

#include <Eigen/Core>
#include <Eigen/SparseCore>

namespace tremula {

// Coefficients of the forces (M/2+1 x n). participation: (3P x n), or sparse (n x 3P). Bin 0 stays empty
// where the wind is turbulence, as with Transfer::sampled: its mean is in the lean. Throws InputError for a
// wind at other points.
Eigen::MatrixXcd wind_forces(const Eigen::MatrixXd& participation, const TimeAxis& axis,
                             const PointWind& wind);
Eigen::MatrixXcd wind_forces(const Eigen::SparseMatrix<double, Eigen::RowMajor>& participation,
                             const TimeAxis& axis, const PointWind& wind);

// How they change in time, i omega of each bin [1/s].
Eigen::MatrixXcd rate_of(Eigen::MatrixXcd coefficients, const TimeAxis& axis);

// Modes as oscillators of unit mass that the wind couples. Throws as check_system does.
OscillatorNetwork network_of(const ModalSystem& system);

}  // namespace tremula
