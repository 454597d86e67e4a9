#include "tremula/wind/spectrum.hpp"

#include <cmath>

namespace tremula {

Vec3 simiu_scanlan_spectrum(double frequency, double height, double speed, double friction_velocity) {
  const double per_frequency = friction_velocity * friction_velocity * height / speed;  // C_0 nu / f
  const double nu = frequency * height / speed;
  return per_frequency * Vec3(200 / std::pow(1 + 50 * nu, 5.0 / 3), 15 / std::pow(1 + 9.5 * nu, 5.0 / 3),
                              3.36 / (1 + 10 * std::pow(nu, 5.0 / 3)));
}

double friction_velocity_from_intensity(double turbulence_intensity, double speed) {
  return turbulence_intensity * speed / std::sqrt(6.0);
}

}  // namespace tremula
