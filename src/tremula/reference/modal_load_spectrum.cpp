#include "tremula/reference/modal_load_spectrum.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/error.hpp"
#include "tremula/numerics/random.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <string>

#include <Eigen/Eigenvalues>

namespace tremula {

Eigen::MatrixXcd modal_load_spectrum(const TurbulentWind& wind, const Eigen::Matrix3Xd& points,
                                     const Eigen::MatrixXd& participation, double frequency) {
  check_equal("rows of the participation", participation.rows(), 3 * points.cols());
  if (!(std::isfinite(frequency) && frequency > 0)) {
    throw InputError("frequency", std::to_string(frequency), "above 0 Hz");
  }
  const Eigen::Index count = points.cols(), modes = participation.cols();
  if (wind.covariance_uw != 0) {
    throw InputError("covariance of u and w", std::to_string(wind.covariance_uw),
                     "0: the cross spectrum of modal loads takes the components as independent");
  }
  const Vec3 along = heading_direction(wind.mean), across(-along[1], along[0], 0);
  Eigen::MatrixXcd spectrum = Eigen::MatrixXcd::Zero(modes, modes);
  if (wind.mean.speed <= 0) return spectrum;
  Eigen::Matrix3Xd amplitude(3, count);
  Eigen::VectorXcd phase(count);
  for (Eigen::Index k = 0; k < count; ++k) {
    amplitude.col(k) =
        spectrum_at(wind, std::max(lowest_spectrum_height, points(2, k)), frequency).cwiseSqrt();
    phase[k] =
        std::polar(1.0, -2 * std::numbers::pi * frequency * points.col(k).dot(along) / wind.mean.speed);
  }
  const Eigen::VectorXd y = points.transpose() * across, z = points.row(2);
  Eigen::MatrixXd coherence(count, count);
  for (int c = 0; c < 3; ++c) {
    const CoherenceDecay decay = coherence_decay(wind.coherence, c, frequency);
    for (Eigen::Index k = 0; k < count; ++k) {
      for (Eigen::Index l = 0; l <= k; ++l)
        coherence(k, l) = coherence(l, k) = root_coherence(decay, y[k] - y[l], z[k] - z[l]);
    }
    // What this component does to each mode from each point.
    Eigen::MatrixXcd load(count, modes);
    for (Eigen::Index k = 0; k < count; ++k) {
      const Vec3 local = heading_direction(wind.mean, points(2, k));
      const Vec3 axis = c == 0 ? local : c == 1 ? Vec3(-local[1], local[0], 0) : Vec3(Vec3::UnitZ());
      const Eigen::RowVectorXd by_axis = axis.transpose() * participation.middleRows<3>(3 * k);
      load.row(k) = amplitude(c, k) * phase[k] * by_axis.cast<std::complex<double>>();
    }
    // E f f^H of f = load^T w, E w w^H = coherence.
    spectrum.noalias() += load.transpose() * coherence.cast<std::complex<double>>() * load.conjugate();
  }
  return spectrum;
}

Eigen::MatrixXcd draw_modal_forces(const Eigen::MatrixXcd& spectrum, double period, std::uint64_t seed,
                                   int bin, int draws) {
  if (!std::isfinite(period) || period <= 0) {
    throw InputError("period", std::to_string(period), "above 0 s");
  }
  check_equal("columns of the spectrum", spectrum.cols(), spectrum.rows());
  if (draws < 1 || draws > 128) throw InputError("draws", std::to_string(draws), "1 to 128");
  const Eigen::Index modes = spectrum.rows();
  Eigen::MatrixXcd noise(modes, draws);
  for (int draw = 0; draw < draws; ++draw) {
    for (Eigen::Index r = 0; r < modes; ++r) {
      noise(r, draw) = complex_gaussian(
          {seed, RandomStream::modal_loads, bin_of_draw(bin, draw), static_cast<std::uint64_t>(r)});
    }
  }
  // Eigenvectors rather than Cholesky: modes of a small plant may all move with one gust, and the rank is
  // less.
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXcd> solver(spectrum);
  const Eigen::VectorXd root = (solver.eigenvalues().cwiseMax(0) / (2 * period)).cwiseSqrt();
  return solver.eigenvectors() * (root.asDiagonal() * noise);
}

}  // namespace tremula
