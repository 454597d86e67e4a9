#include "tremula/structure/still_fluid.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tremula {
namespace {

// Of a panel a wide and b high at the distance (x, y): the finite part of the integral over the panel, whose
// integrand has the antiderivative -sqrt(x^2 + y^2) / (x y).
double influence_at(double x, double y, double a, double b) {
  const auto corner = [](double u, double v) { return std::hypot(u, v) / (u * v); };
  const double left = x - a / 2, right = x + a / 2, below = y - b / 2, above = y + b / 2;
  return (corner(right, above) - corner(left, above) - corner(right, below) + corner(left, below)) /
         (4 * std::numbers::pi);
}

}  // namespace

FluidPanels fluid_panels(double width, double height, int count) {
  const int across =
      std::clamp(static_cast<int>(std::lround(std::sqrt(count * width / height))), 8, count / 8);
  const int up = std::max(8, count / across);
  const double a = width / (across + 0.5), b = height / (up + 0.5);
  FluidPanels panels{Eigen::Matrix2Xd(2, across * up), a * b, Eigen::MatrixXd(across * up, across * up)};
  for (int j = 0; j < up; ++j) {
    for (int i = 0; i < across; ++i) panels.centres.col(j * across + i) << (i + 0.75) * a, (j + 0.75) * b;
  }
  // The same distances over and over.
  Eigen::MatrixXd by_distance(across, up);
  for (int j = 0; j < up; ++j) {
    for (int i = 0; i < across; ++i) by_distance(i, j) = influence_at(i * a, j * b, a, b);
  }
  for (int q = 0; q < across * up; ++q) {
    for (int p = 0; p < across * up; ++p)
      panels.influence(p, q) =
          by_distance(std::abs(p % across - q % across), std::abs(p / across - q / across));
  }
  return panels;
}

}  // namespace tremula
