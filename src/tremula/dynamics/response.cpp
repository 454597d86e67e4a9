#include "tremula/dynamics/response.hpp"

#include "tremula/base/error.hpp"
#include "tremula/numerics/fft.hpp"

#include <atomic>
#include <complex>

#include <tbb/parallel_for.h>

namespace tremula {

Eigen::MatrixXcd project_loads(const Eigen::MatrixXd& participation, const TimeAxis& axis,
                               const VelocityAtBin& velocity) {
  Eigen::MatrixXcd modal_forces(axis.bin_count(), participation.cols());
  // Every bin is worked out by one thread in one order, so the threads do not show in the result.
  tbb::parallel_for(0, axis.bin_count(), [&](int bin) {
    const Eigen::Matrix3Xcd wind = velocity(bin);
    const Eigen::VectorXcd stacked = wind.reshaped();
    Eigen::VectorXcd force(participation.cols());
    force.real().noalias() = participation.transpose() * stacked.real();
    force.imag().noalias() = participation.transpose() * stacked.imag();
    modal_forces.row(bin) = force.transpose();
  });
  return modal_forces;
}

Motion respond(const Modes& modes, const Eigen::MatrixXcd& modal_forces, const TimeAxis& axis,
               const Damping& damping, const Eigen::VectorXd& lean) {
  Eigen::MatrixXcd coordinates(modal_forces.rows(), modal_forces.cols());
  const Eigen::VectorXd mode_omega = modes.omega(), damping_rate = structural_damping(damping, mode_omega);
  for (Eigen::Index r = 0; r < modal_forces.cols(); ++r) {
    for (int bin = 0; bin < axis.bin_count(); ++bin) {
      const double omega = axis.omega(bin);
      coordinates(bin, r) = modal_forces(bin, r) / std::complex(mode_omega[r] * mode_omega[r] - omega * omega,
                                                                damping_rate[r] * omega);
    }
  }
  return {axis.period, samples_from_half_spectra(coordinates, axis.sample_count), lean};
}

Eigen::MatrixXcd respond(const BinTransfer& transfer, const Eigen::MatrixXd& participation,
                         const TimeAxis& axis, const PointWind& wind,
                         const std::function<void(double done)>& progress) {
  Eigen::MatrixXcd coordinates = Eigen::MatrixXcd::Zero(axis.bin_count(), participation.cols());
  std::atomic<int> bins_done = 0;
  // Every bin is worked out by one thread in one order, so the threads do not show in the result.
  tbb::parallel_for(wind.has_slow_gusts ? 0 : 1, axis.bin_count(), [&](int bin) {
    const BinTransfer::Weights weights = transfer.weights(bin);
    Eigen::MatrixXcd forces(participation.cols(), weights.draws());
    for (int draw = 0; draw < weights.draws(); ++draw) {
      const Eigen::Matrix3Xcd velocity = wind.velocity(bin, draw);
      const Eigen::VectorXcd stacked = velocity.reshaped();
      forces.col(draw).real().noalias() = participation.transpose() * stacked.real();
      forces.col(draw).imag().noalias() = participation.transpose() * stacked.imag();
    }
    coordinates.row(bin) = transfer.respond(bin, weights, forces).transpose();
    if (progress) progress(static_cast<double>(++bins_done) / axis.bin_count());
  });
  return coordinates;
}

}  // namespace tremula
