#include "tremula/scene/haze.hpp"

#include "tremula/base/error.hpp"
#include "tremula/base/number_text.hpp"

#include <algorithm>
#include <cmath>

namespace tremula {
namespace {

// Where the bands of the three primaries of sRGB have their middle [nm].
const Vec3 wavelength(610, 550, 465);
const Vec3 pure_water(0.2644, 0.0565, 0.01011);  // absorption there [1/m]

double green_extinction(double visibility) {
  if (!(visibility > 0) || !std::isfinite(visibility))
    throw InputError("visibility", number_text(visibility) + " m", "a number above 0 m");
  return koschmieder / visibility;
}

}  // namespace

Eigen::Vector3f air_extinction(double visibility) {
  const double green = green_extinction(visibility), kilometres = visibility / 1000;
  const double exponent = kilometres > 50 ? 1.6 : kilometres > 6 ? 1.3 : 0.585 * std::cbrt(kilometres);
  const Vec3 extinction = green * (wavelength.array() / wavelength[1]).pow(-exponent);
  return extinction.cast<float>();
}

Eigen::Vector3f water_extinction(double visibility) {
  const double floating = std::max(0.0, green_extinction(visibility) - pure_water[1]);
  return (pure_water.array() + floating).matrix().cast<float>();
}

Eigen::Vector3f extinction_of(const SceneMedium& medium, bool under_water) {
  return under_water ? water_extinction(medium.visibility.value_or(default_visibility_in_water))
                     : air_extinction(medium.visibility.value_or(default_visibility_in_air));
}

}  // namespace tremula
