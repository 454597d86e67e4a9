#include "tremula/structure/membrane_element.hpp"

#include "tremula/numerics/quadrature.hpp"

#include <vector>

namespace tremula {
namespace {

template <class Integrand>
PlateMatrix integrated(const PlateElement& element, const Integrand& integrand) {
  static const std::vector<QuadraturePoint> quadrature = gauss_legendre(2);
  PlateMatrix sum = PlateMatrix::Zero();
  for (const QuadraturePoint& along : quadrature) {
    for (const QuadraturePoint& up : quadrature)
      sum += along.weight * up.weight * integrand(along.position, up.position);
  }
  return element.width * element.height * sum;
}

}  // namespace

MembraneSection membrane_section(double thickness, double youngs_modulus, double poisson_ratio,
                                 double density) {
  return {youngs_modulus * thickness, poisson_ratio, density * thickness,
          density * thickness * thickness * thickness / 12};
}

Eigen::Vector4d corner_shares(double s, double t) {
  return {(1 - s) * (1 - t), s * (1 - t), s * t, (1 - s) * t};
}

Eigen::Matrix<double, 3, 8> membrane_strains(const PlateElement& element, double s, double t) {
  const double sx[] = {-(1 - t), 1 - t, t, -t}, sy[] = {-(1 - s), -s, s, 1 - s};
  Eigen::Matrix<double, 3, 8> strains = Eigen::Matrix<double, 3, 8>::Zero();
  for (int i = 0; i < 4; ++i) {
    const double x = sx[i] / element.width, y = sy[i] / element.height;
    strains.block<3, 2>(0, 2 * i) << x, 0, 0, y, y, x;
  }
  return strains;
}

Eigen::Matrix3d plane_stress(double nu) {
  Eigen::Matrix3d elastic;
  elastic << 1, nu, 0, nu, 1, 0, 0, 0, (1 - nu) / 2;
  return elastic / (1 - nu * nu);
}

PlateMatrix membrane_stiffness(const PlateElement& element, const MembraneSection& section,
                               double rotation_stiffness) {
  const Eigen::Matrix3d elastic = section.stretch_stiffness * plane_stress(section.poisson_ratio);
  const double tie = rotation_stiffness * section.shear_stiffness();
  return integrated(element, [&](double s, double t) -> PlateMatrix {
    const Eigen::Matrix<double, 3, 8> of_corners = membrane_strains(element, s, t);
    const Eigen::Vector4d share = corner_shares(s, t);
    Eigen::Matrix<double, 3, 12> strains = Eigen::Matrix<double, 3, 12>::Zero();
    PlateVector slip;  // omega - theta_z
    for (int corner = 0; corner < 4; ++corner) {
      strains.middleCols<2>(3 * corner) = of_corners.middleCols<2>(2 * corner);
      const double x = of_corners(0, 2 * corner), y = of_corners(1, 2 * corner + 1);
      slip.segment<3>(3 * corner) << -0.5 * y, 0.5 * x, -share[corner];
    }
    return strains.transpose() * elastic * strains + tie * slip * slip.transpose();
  });
}

PlateMatrix membrane_mass(const PlateElement& element, const MembraneSection& section) {
  const Eigen::Vector3d density(section.mass_per_area, section.mass_per_area, section.inertia_per_area);
  return integrated(element, [&](double s, double t) {
    const Eigen::Vector4d share = corner_shares(s, t);
    PlateMatrix mass = PlateMatrix::Zero();
    for (int a = 0; a < 4; ++a) {
      for (int b = 0; b < 4; ++b) mass.block<3, 3>(3 * a, 3 * b).diagonal() = share[a] * share[b] * density;
    }
    return mass;
  });
}

}  // namespace tremula
