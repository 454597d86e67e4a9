#include "tremula/reference/response_variance.hpp"

#include <algorithm>
#include <complex>
#include <numbers>
#include <vector>

#include "tremula/numerics/quadrature.hpp"

namespace tremula {

Eigen::VectorXd response_variance(const ModalSystem& system, const Eigen::MatrixXd& force_spectrum,
                                  const std::function<double(double omega)>& relative_power, double lowest,
                                  double highest) {
  // Gauss points on intervals that shrink towards every pole, so that no resonance falls between them.
  std::vector<double> breaks{lowest, highest};
  const Poles poles = find_poles(system);
  for (const std::complex<double>& pole : poles.pole) {
    const double centre = pole.imag(), half_width = std::max(-pole.real(), 1e-9);
    for (double distance = half_width; distance < highest; distance *= 2) {
      breaks.push_back(centre - distance);
      breaks.push_back(centre + distance);
    }
    breaks.push_back(centre);
  }
  for (double omega = std::max(lowest, 1e-6); omega < highest; omega *= 1.5) breaks.push_back(omega);
  std::sort(breaks.begin(), breaks.end());
  const std::vector<QuadraturePoint> points = gauss_legendre(8);
  Eigen::VectorXd variance = Eigen::VectorXd::Zero(system.omega.size());
  for (std::size_t i = 0; i + 1 < breaks.size(); ++i) {
    const double from = std::max(breaks[i], lowest), to = std::min(breaks[i + 1], highest);
    if (to <= from) continue;
    for (const QuadraturePoint& point : points) {
      const double omega = from + point.position * (to - from);
      const Eigen::MatrixXcd transfer = transfer_function(system, omega);
      const double weight = point.weight * (to - from) * relative_power(omega) / (2 * std::numbers::pi);
      variance += weight * (transfer * force_spectrum * transfer.adjoint()).diagonal().real();
    }
  }
  return variance;
}

}  // namespace tremula
