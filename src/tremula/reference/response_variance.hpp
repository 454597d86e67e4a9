// How much a system moves in a wind that blows for ever: what the variances of loops are compared with.
#pragma once

#include "tremula/dynamics/transfer.hpp"

#include <functional>

#include <Eigen/Core>

namespace tremula {

// The variance of every coordinate, the integral of H S_f H^H over all f > 0, for modal forces with one
// cross-spectral matrix (one-sided, per Hz) times relative_power(omega), by quadrature between frequencies
// [rad/s].
Eigen::VectorXd response_variance(const ModalSystem& system, const Eigen::MatrixXd& force_spectrum,
                                  const std::function<double(double omega)>& relative_power, double lowest,
                                  double highest);

}  // namespace tremula
