#include "tremula/wind/profile.hpp"

#include "tremula/base/error.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

namespace tremula {
namespace {

// The profile without a canopy, in units of its value at the reference height.
double above_canopy(const MeanWind& wind, double height) {
  switch (wind.profile) {
    case ProfileKind::constant:
      return 1;
    case ProfileKind::logarithmic: {
      const double above = height - wind.displacement;
      if (above <= wind.roughness_length) return 0;
      return std::log(above / wind.roughness_length);
    }
    case ProfileKind::power:
      return std::pow(height / wind.reference_height, wind.power_exponent);
  }
  return 0;
}

double shape(const MeanWind& wind, double height) {
  if (height >= wind.canopy_height) return above_canopy(wind, height);
  return above_canopy(wind, wind.canopy_height) *
         std::exp(-wind.canopy_decay * (1 - height / wind.canopy_height));
}

}  // namespace

void check_mean_wind(const MeanWind& wind) {
  const auto check = [](bool good, const char* what, double value, const char* wanted) {
    if (!good || !std::isfinite(value)) throw InputError(what, std::to_string(value), wanted);
  };
  check(wind.speed >= 0 && wind.speed <= 100, "wind speed", wind.speed, "0 to 100 m/s");
  check(wind.reference_height > 0, "reference height", wind.reference_height, "a height above 0 m");
  check(std::isfinite(wind.heading), "heading", wind.heading, "an angle in degrees");
  const bool canopy = wind.canopy_height > 0;
  check(wind.roughness_length > 0 && (canopy || wind.roughness_length < wind.reference_height),
        "roughness length", wind.roughness_length, "above 0 m and below the reference height");
  check(
      wind.displacement >= 0 && (canopy || wind.displacement + wind.roughness_length < wind.reference_height),
      "displacement height", wind.displacement, "0 m or more, and with z0 below the reference height");
  check(wind.canopy_height >= 0, "canopy height", wind.canopy_height, "0 m or more");
  check(!canopy || wind.displacement + wind.roughness_length < wind.canopy_height, "canopy height",
        wind.canopy_height, "above the displacement height and z0");
  check(wind.canopy_decay >= 0 && wind.canopy_decay <= 10, "canopy decay", wind.canopy_decay, "0 to 10");
  check(wind.power_exponent >= 0 && wind.power_exponent <= 1, "power exponent", wind.power_exponent,
        "0 to 1");
}

double mean_speed(const MeanWind& wind, double height) {
  if (height <= 0) return 0;
  const double reference = wind.profile == ProfileKind::logarithmic || wind.canopy_height > 0
                               ? shape(wind, wind.reference_height)
                               : 1;
  return wind.speed * shape(wind, height) / reference;
}

double log_law_friction_velocity(const MeanWind& wind) {
  constexpr double kappa = 0.4;
  const double height = std::max(wind.reference_height, wind.canopy_height);
  return kappa * mean_speed(wind, height) / std::log((height - wind.displacement) / wind.roughness_length);
}

Vec3 heading_direction(const MeanWind& wind) {
  const double angle = wind.heading * std::numbers::pi / 180;
  return {std::cos(angle), std::sin(angle), 0};
}

}  // namespace tremula
