#include "tremula/wind/profile.hpp"

#include "tremula/base/error.hpp"

#include <cmath>
#include <numbers>
#include <string>

namespace tremula {

void check_mean_wind(const MeanWind& wind) {
  const auto check = [](bool good, const char* what, double value, const char* wanted) {
    if (!good || !std::isfinite(value)) throw InputError(what, std::to_string(value), wanted);
  };
  check(wind.speed >= 0 && wind.speed <= 100, "wind speed", wind.speed, "0 to 100 m/s");
  check(wind.reference_height > 0, "reference height", wind.reference_height, "a height above 0 m");
  check(std::isfinite(wind.heading), "heading", wind.heading, "an angle in degrees");
  check(wind.roughness_length > 0 && wind.roughness_length < wind.reference_height, "roughness length",
        wind.roughness_length, "above 0 m and below the reference height");
  check(wind.power_exponent >= 0 && wind.power_exponent <= 1, "power exponent", wind.power_exponent,
        "0 to 1");
}

double mean_speed(const MeanWind& wind, double height) {
  if (height <= 0) return 0;
  switch (wind.profile) {
    case ProfileKind::constant:
      return wind.speed;
    case ProfileKind::logarithmic:
      if (height <= wind.roughness_length) return 0;
      return wind.speed * std::log(height / wind.roughness_length) /
             std::log(wind.reference_height / wind.roughness_length);
    case ProfileKind::power:
      return wind.speed * std::pow(height / wind.reference_height, wind.power_exponent);
  }
  return 0;
}

Vec3 heading_direction(const MeanWind& wind) {
  const double angle = wind.heading * std::numbers::pi / 180;
  return {std::cos(angle), std::sin(angle), 0};
}

}  // namespace tremula
