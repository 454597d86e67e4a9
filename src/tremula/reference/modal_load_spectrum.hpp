// The joint statistics of the modal forces, without drawing a wind.
#pragma once

#include "tremula/wind/turbulent_wind.hpp"

#include <cstdint>

#include <Eigen/Core>

namespace tremula {

// The cross-spectral matrix G^T S_vv G of the modal forces at a frequency [Hz] > 0, one-sided, per Hz: (m x
// m), Hermitian. Between two points every component of the wind has sqrt(S S') times the root-coherence times
// the phase that Taylor's advection makes of their distance along the wind. points (3 x N), z above the
// ground, participation (3N x m). Cost N^2 (m + some). Throws InputError
// for a wind whose u and w are correlated.
Eigen::MatrixXcd modal_load_spectrum(const TurbulentWind& wind, const Eigen::Matrix3Xd& points,
                                     const Eigen::MatrixXd& participation, double frequency);

// Modal forces drawn directly (which S section 5 tried for each mode by itself, and found wrong): the
// matrix's root times complex Gaussian noise has exactly the joint statistics that the wind gives the modes.
// Coefficients in the convention of StamWindAtPoints for a loop of that period [s], (m x draws); the same for
// the same seed and bin. Throws InputError for a period that is not above 0.
Eigen::MatrixXcd draw_modal_forces(const Eigen::MatrixXcd& spectrum, double period, std::uint64_t seed,
                                   int bin, int draws = 1);

}  // namespace tremula
