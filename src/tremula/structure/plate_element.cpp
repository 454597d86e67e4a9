#include "tremula/structure/plate_element.hpp"

#include "tremula/numerics/quadrature.hpp"

#include <vector>

namespace tremula {
namespace {

// A polynomial of one coordinate with its derivatives, in the element's own -1 … 1.
struct Factor {
  double value, first, second;
};

// The sum of integrand(shape) over the element; four points a side are exact to degree 7, and w^2 has 6.
template <class Integrand>
PlateMatrix integrated(const PlateElement& element, const Integrand& integrand) {
  static const std::vector<QuadraturePoint> quadrature = gauss_legendre(4);
  PlateMatrix sum = PlateMatrix::Zero();
  const double area = element.width * element.height;
  for (const QuadraturePoint& along : quadrature) {
    for (const QuadraturePoint& up : quadrature) {
      sum +=
          along.weight * up.weight * area * integrand(plate_shape_at(element, along.position, up.position));
    }
  }
  return sum;
}

}  // namespace

PlateSection plate_section(double thickness, double youngs_modulus, double poisson_ratio, double density) {
  return {youngs_modulus * thickness * thickness * thickness / (12 * (1 - poisson_ratio * poisson_ratio)),
          poisson_ratio, density * thickness};
}

PlateShape plate_shape_at(const PlateElement& element, double s, double t) {
  constexpr double corner_x[] = {-1, 1, 1, -1}, corner_y[] = {-1, -1, 1, 1};
  const double a = element.width / 2, b = element.height / 2;
  PlateShape shape;
  const auto set = [&](int i, double scale, double f, double fx, double fy, double fxx, double fyy,
                       double fxy) {
    shape.deflection[i] = scale * f;
    shape.slope_x[i] = scale * fx / a;
    shape.slope_y[i] = scale * fy / b;
    shape.bend_x[i] = scale * fxx / (a * a);
    shape.bend_y[i] = scale * fyy / (b * b);
    shape.twist[i] = scale * fxy / (a * b);
  };
  for (int corner = 0; corner < 4; ++corner) {
    const double cx = corner_x[corner], cy = corner_y[corner];
    const double x = 2 * s - 1, y = 2 * t - 1;
    const double p = 1 + x * cx, q = 1 + y * cy;  // 2 at the corner, 0 at the sides away from it
    // w: p q (x cx + y cy + 2 - x^2 - y^2) / 8
    const double r = x * cx + y * cy + 2 - x * x - y * y, rx = cx - 2 * x, ry = cy - 2 * y;
    set(3 * corner, 0.125, p * q * r, q * (cx * r + p * rx), p * (cy * r + q * ry), q * (2 * cx * rx - 2 * p),
        p * (2 * cy * ry - 2 * q), cx * cy * r + cx * q * ry + p * cy * rx);
    // A slope: (1 + z)^2 (z - 1), which is 0 at both corners and has the slope 4 at its own.
    const auto cubic = [](double z, double c) {
      return Factor{(1 + z) * (1 + z) * (z - 1), c * (1 + z) * (3 * z - 1), 6 * z + 2};
    };
    const Factor u = cubic(x * cx, cx), v = cubic(y * cy, cy);
    set(3 * corner + 1, 0.125 * b * cy, p * v.value, cx * v.value, p * v.first, 0, p * v.second,
        cx * v.first);
    set(3 * corner + 2, -0.125 * a * cx, q * u.value, q * u.first, cy * u.value, q * u.second, 0,
        cy * u.first);
  }
  return shape;
}

PlateMatrix plate_stiffness(const PlateElement& element, const PlateSection& section) {
  const double nu = section.poisson_ratio;
  return section.bending_stiffness * integrated(element, [nu](const PlateShape& shape) -> PlateMatrix {
           const PlateVector moment_x = shape.bend_x + nu * shape.bend_y,
                             moment_y = shape.bend_y + nu * shape.bend_x;
           return shape.bend_x * moment_x.transpose() + shape.bend_y * moment_y.transpose() +
                  2 * (1 - nu) * shape.twist * shape.twist.transpose();
         });
}

PlateMatrix plate_mass(const PlateElement& element, double mass_per_area) {
  return mass_per_area * integrated(element, [](const PlateShape& shape) -> PlateMatrix {
           return shape.deflection * shape.deflection.transpose();
         });
}

PlateMatrix plate_geometric_stiffness(const PlateElement& element, const MembraneForce& force) {
  return integrated(element, [&](const PlateShape& shape) -> PlateMatrix {
    const PlateVector x = force.x * shape.slope_x + force.xy * shape.slope_y,
                      y = force.xy * shape.slope_x + force.y * shape.slope_y;
    return shape.slope_x * x.transpose() + shape.slope_y * y.transpose();
  });
}

}  // namespace tremula
