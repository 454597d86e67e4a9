#include "tremula/dynamics/response.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/error.hpp"
#include "tremula/numerics/fft.hpp"

#include <algorithm>
#include <atomic>
#include <complex>
#include <vector>

#include <tbb/parallel_for.h>

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

Motion respond(const Modes& modes, const Eigen::MatrixXcd& modal_forces, const TimeAxis& axis,
               const Damping& damping, const Eigen::VectorXd& lean) {
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
  return {axis.period, samples_from_half_spectra(coordinates, axis.sample_count), lean};
}

Eigen::MatrixXcd respond(const BinTransfer& transfer, const Eigen::MatrixXd& participation,
                         const TimeAxis& axis, const PointWind& wind,
                         const std::function<void(double done)>& progress) {
  // The participation of a large plant is read from memory for every product: once for a few bins, then.
  // Every group of bins is worked out by one thread in one order, so the threads do not show in the result.
  constexpr int bins_together = 4;
  check_equal("columns of the participation", participation.cols(), transfer.coordinate_count());
  check_equal("points of the wind, three numbers each", 3 * wind.mean.cols(), participation.rows());
  const int first = wind.has_slow_gusts ? 0 : 1, count = axis.bin_count() - first;
  Eigen::MatrixXcd coordinates = Eigen::MatrixXcd::Zero(axis.bin_count(), participation.cols());
  std::atomic<int> bins_done = 0;
  tbb::parallel_for(0, (count + bins_together - 1) / bins_together, [&](int group) {
    const int begin = first + group * bins_together, end = std::min(begin + bins_together, axis.bin_count());
    std::vector<BinTransfer::Weights> weights;
    Eigen::Index draws = 0;
    for (int bin = begin; bin < end; ++bin) {
      weights.push_back(transfer.weights(bin));
      draws += weights.back().draws();
    }
    Eigen::MatrixXd gusts(participation.rows(), 2 * draws);  // real and imaginary parts, side by side
    Eigen::Index column = 0;
    for (int bin = begin; bin < end; ++bin) {
      for (int draw = 0; draw < weights[static_cast<std::size_t>(bin - begin)].draws(); ++draw) {
        const Eigen::Matrix3Xcd velocity = wind.velocity(bin, draw);
        gusts.col(column++) = velocity.reshaped().real();
        gusts.col(column++) = velocity.reshaped().imag();
      }
    }
    const Eigen::MatrixXd parts = participation.transpose() * gusts;
    column = 0;
    for (int bin = begin; bin < end; ++bin) {
      const BinTransfer::Weights& of_bin = weights[static_cast<std::size_t>(bin - begin)];
      Eigen::MatrixXcd forces(participation.cols(), of_bin.draws());
      for (Eigen::Index draw = 0; draw < of_bin.draws(); ++draw, column += 2) {
        forces.col(draw).real() = parts.col(column);
        forces.col(draw).imag() = parts.col(column + 1);
      }
      coordinates.row(bin) = transfer.respond(bin, of_bin, forces).transpose();
      if (progress) progress(static_cast<double>(++bins_done) / count);
    }
  });
  return coordinates;
}

}  // namespace tremula
