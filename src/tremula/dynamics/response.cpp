#include "tremula/dynamics/response.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/error.hpp"

#include <algorithm>
#include <atomic>
#include <complex>
#include <vector>

#include <tbb/parallel_for.h>

namespace tremula {

Eigen::MatrixXcd respond(const BinTransfer& transfer, const Eigen::MatrixXd& participation,
                         const TimeAxis& axis, const PointWind& wind,
                         const std::function<void(double done)>& progress, const Eigen::MatrixXd& inertia) {
  // The participation of a large plant is read from memory for every product: once for a few bins, then.
  // Every group of bins is worked out by one thread in one order, so the threads do not show in the result.
  constexpr int bins_together = 4;
  check_equal("columns of the participation", participation.cols(), transfer.coordinate_count());
  check_equal("points of the wind, three numbers each", 3 * wind.mean.cols(), participation.rows());
  const bool pulls = inertia.size() > 0;
  if (pulls) {
    check_equal("rows of the inertia", inertia.rows(), participation.rows());
    check_equal("columns of the inertia", inertia.cols(), participation.cols());
  }
  // Sampled as the papers have it, a loop has no mean but the lean.
  const bool slow_gusts = wind.has_slow_gusts && !(transfer.kind() == Transfer::sampled && wind.power);
  const int first = slow_gusts ? 0 : 1, count = axis.bin_count() - first;
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
    Eigen::MatrixXd pulled;
    if (pulls) pulled.noalias() = inertia.transpose() * gusts;
    column = 0;
    for (int bin = begin; bin < end; ++bin) {
      const BinTransfer::Weights& of_bin = weights[static_cast<std::size_t>(bin - begin)];
      Eigen::MatrixXcd forces(participation.cols(), of_bin.draws());
      for (Eigen::Index draw = 0; draw < of_bin.draws(); ++draw, column += 2) {
        forces.col(draw).real() = parts.col(column);
        forces.col(draw).imag() = parts.col(column + 1);
        if (!pulls) continue;
        const double omega = axis.omega(bin);
        forces.col(draw).real() -= omega * pulled.col(column + 1);
        forces.col(draw).imag() += omega * pulled.col(column);
      }
      coordinates.row(bin) = transfer.respond(bin, of_bin, forces).transpose();
      if (progress) progress(static_cast<double>(++bins_done) / count);
    }
  });
  return coordinates;
}

Eigen::MatrixXcd respond(const BinTransfer& transfer, const TimeAxis& axis,
                         const std::vector<Eigen::MatrixXcd>& forces) {
  check_at_least("draws of the forces", static_cast<std::ptrdiff_t>(forces.size()), transfer.most_draws());
  for (const Eigen::MatrixXcd& of_draw : forces) {
    check_equal("rows of the forces", of_draw.rows(), axis.bin_count());
    check_equal("columns of the forces", of_draw.cols(), transfer.coordinate_count());
  }
  Eigen::MatrixXcd coordinates(axis.bin_count(), transfer.coordinate_count());
  tbb::parallel_for(0, axis.bin_count(), [&](int bin) {
    const BinTransfer::Weights weights = transfer.weights(bin);
    Eigen::MatrixXcd of_bin(transfer.coordinate_count(), weights.draws());
    for (Eigen::Index draw = 0; draw < of_bin.cols(); ++draw)
      of_bin.col(draw) = forces[index_of(draw)].row(bin).transpose();
    coordinates.row(bin) = transfer.respond(bin, weights, of_bin).transpose();
  });
  return coordinates;
}

}  // namespace tremula
