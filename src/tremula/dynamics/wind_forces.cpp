#include "tremula/dynamics/wind_forces.hpp"

#include <complex>

#include "tremula/base/check.hpp"

#include <tbb/parallel_for.h>

namespace tremula {
namespace {

template <class Apply>
Eigen::MatrixXcd forces_of(Eigen::Index points3, Eigen::Index count, const TimeAxis& axis,
                           const PointWind& wind, const Apply& apply) {
  check_equal("points of the wind, three numbers each", 3 * wind.mean.cols(), points3);
  const int first = wind.has_slow_gusts && !wind.power ? 0 : 1;
  Eigen::MatrixXcd forces = Eigen::MatrixXcd::Zero(axis.bin_count(), count);
  tbb::parallel_for(first, axis.bin_count(), [&](int bin) {
    const Eigen::Matrix3Xcd velocity = wind.velocity(bin, 0);
    const Eigen::VectorXd real = velocity.reshaped().real(), imaginary = velocity.reshaped().imag();
    const Eigen::VectorXd in_phase = apply(real), ahead = apply(imaginary);
    forces.row(bin).real() = in_phase.transpose();
    forces.row(bin).imag() = ahead.transpose();
  });
  return forces;
}

}  // namespace

Eigen::MatrixXcd wind_forces(const Eigen::MatrixXd& participation, const TimeAxis& axis,
                             const PointWind& wind) {
  return forces_of(
      participation.rows(), participation.cols(), axis, wind,
      [&](const Eigen::VectorXd& gusts) -> Eigen::VectorXd { return participation.transpose() * gusts; });
}

Eigen::MatrixXcd wind_forces(const Eigen::SparseMatrix<double, Eigen::RowMajor>& participation,
                             const TimeAxis& axis, const PointWind& wind) {
  return forces_of(participation.cols(), participation.rows(), axis, wind,
                   [&](const Eigen::VectorXd& gusts) -> Eigen::VectorXd { return participation * gusts; });
}

Eigen::MatrixXcd rate_of(Eigen::MatrixXcd coefficients, const TimeAxis& axis) {
  for (int bin = 0; bin < axis.bin_count(); ++bin)
    coefficients.row(bin) *= std::complex<double>(0, axis.omega(bin));
  return coefficients;
}

OscillatorNetwork network_of(const ModalSystem& system) {
  check_system(system);
  Eigen::MatrixXd coupling = system.omega.cwiseAbs2().asDiagonal();
  if (system.stiffness.size() > 0) coupling += system.stiffness;
  return {Eigen::VectorXd::Ones(system.omega.size()), system.damping.sparseView(), coupling.sparseView()};
}

}  // namespace tremula
