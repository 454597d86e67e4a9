// Gauss–Legendre quadrature on [0, 1].
#pragma once

#include <vector>

namespace tremula {

struct QuadraturePoint {
  double position;  // in (0, 1)
  double weight;    // weights sum to 1
};

// Exact for polynomials of degree 2 count - 1. count >= 1.
std::vector<QuadraturePoint> gauss_legendre(int count);

}  // namespace tremula
