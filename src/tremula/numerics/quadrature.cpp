#include "tremula/numerics/quadrature.hpp"

#include "tremula/base/check.hpp"

#include <cmath>
#include <numbers>

namespace tremula {

std::vector<QuadraturePoint> gauss_legendre(int count) {
  check_at_least("points of a quadrature", count, 1);
  std::vector<QuadraturePoint> points;
  for (int i = 0; i < count; ++i) {
    // Newton on P_n from the classical estimate of its i-th root; quadratic, so a fixed number of steps is
    // enough.
    double x = std::cos(std::numbers::pi * (i + 0.75) / (count + 0.5));
    double slope = 0;
    for (int step = 0; step < 50; ++step) {
      double previous = 1, value = x;
      for (int k = 2; k <= count; ++k) {
        const double next = ((2 * k - 1) * x * value - (k - 1) * previous) / k;
        previous = value;
        value = next;
      }
      slope = count * (x * value - previous) / (x * x - 1);
      const double correction = value / slope;
      x -= correction;
      if (std::abs(correction) < 1e-16) break;
    }
    points.push_back({0.5 * (1 - x), 1 / ((1 - x * x) * slope * slope)});
  }
  return points;
}

}  // namespace tremula
