#include "tremula/reference/response_as_printed.hpp"

#include <complex>

#include <tbb/parallel_for.h>

#include "tremula/base/check.hpp"
#include "tremula/numerics/fft.hpp"

namespace tremula {

Eigen::MatrixXcd project_loads(const Eigen::MatrixXd& participation, const TimeAxis& axis,
                               const VelocityAtBin& velocity) {
  check_at_least("samples of the loop", axis.sample_count, 1);
  Eigen::MatrixXcd modal_forces(axis.bin_count(), participation.cols());
  // Every bin is worked out by one thread in one order, so the threads do not show in the result.
  tbb::parallel_for(0, axis.bin_count(), [&](int bin) {
    const Eigen::Matrix3Xcd wind = velocity(bin);
    check_equal("points of the wind, three numbers each", 3 * wind.cols(), participation.rows());
    const Eigen::VectorXcd stacked = wind.reshaped();
    Eigen::VectorXcd force(participation.cols());
    force.real().noalias() = participation.transpose() * stacked.real();
    force.imag().noalias() = participation.transpose() * stacked.imag();
    modal_forces.row(bin) = force.transpose();
  });
  return modal_forces;
}

Eigen::MatrixXd respond_as_printed(const Modes& modes, const Eigen::MatrixXcd& modal_forces,
                                   const TimeAxis& axis, const Damping& damping) {
  check_equal("bins of the modal forces", modal_forces.rows(), axis.bin_count());
  check_equal("modes of the modal forces", modal_forces.cols(), modes.count());
  Eigen::MatrixXcd coordinates(modal_forces.rows(), modal_forces.cols());
  const Eigen::VectorXd mode_omega = modes.omega(), damping_rate = structural_damping(damping, mode_omega);
  for (Eigen::Index r = 0; r < modal_forces.cols(); ++r) {
    for (int bin = 0; bin < axis.bin_count(); ++bin) {
      const double omega = axis.omega(bin);
      coordinates(bin, r) = modal_forces(bin, r) / std::complex(mode_omega[r] * mode_omega[r] - omega * omega,
                                                                damping_rate[r] * omega);
    }
  }
  return samples_from_half_spectra(coordinates, axis.sample_count);
}

}  // namespace tremula
