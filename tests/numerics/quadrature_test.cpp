#include "tremula/numerics/quadrature.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace tremula {
namespace {

TEST(GaussLegendre, IsExactForPolynomialsUpToTwiceItsCountMinusOne) {
  for (const int count : {1, 2, 4, 12, 64}) {
    for (int degree = 0; degree < 2 * count; ++degree) {
      double sum = 0;
      for (const QuadraturePoint& point : gauss_legendre(count)) {
        sum += point.weight * std::pow(point.position, degree);
      }
      EXPECT_NEAR(sum * (degree + 1), 1, 2e-13) << count << " points, degree " << degree;
    }
  }
}

}  // namespace
}  // namespace tremula
