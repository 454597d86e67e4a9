#include "tremula/wind/profile.hpp"

#include "tremula/base/error.hpp"
#include "tremula/base/number_text.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

namespace tremula {
namespace {

// A number of the rows, at a height.
double interpolated(const std::vector<ProfileRow>& table, double height, double ProfileRow::*number) {
  const auto above = std::upper_bound(table.begin(), table.end(), height,
                                      [](double z, const ProfileRow& row) { return z < row.height; });
  if (above == table.begin()) return table.front().*number;
  if (above == table.end()) return table.back().*number;
  const ProfileRow &low = *(above - 1), &high = *above;
  const double share = (height - low.height) / (high.height - low.height);
  return (1 - share) * (low.*number) + share * (high.*number);
}

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
    case ProfileKind::table:
      return table_speed(wind.table, height);
  }
  return 0;
}

double shape(const MeanWind& wind, double height) {
  if (height >= wind.canopy_height) return above_canopy(wind, height);
  return above_canopy(wind, wind.canopy_height) *
         std::exp(-wind.canopy_decay * (1 - height / wind.canopy_height));
}

void check_table(const MeanWind& wind) {
  const std::vector<ProfileRow>& table = wind.table;
  if (table.empty()) throw InputError("profile", "a table without rows", "one row or more");
  for (std::size_t i = 0; i < table.size(); ++i) {
    const auto& [height, speed, turn] = table[i];
    const bool rises = i == 0 ? height >= 0 : height > table[i - 1].height;
    if (!rises || !std::isfinite(height))
      throw InputError("height in the profile", number_text(height), "0 m or more, and above the row before");
    if (!(speed >= 0 && speed <= 100))
      throw InputError("speed in the profile", number_text(speed), "0 to 100 m/s");
    if (!std::isfinite(turn))
      throw InputError("turn in the profile", number_text(turn), "an angle in degrees");
  }
  if (wind.canopy_height > 0)
    throw InputError("canopy height", number_text(wind.canopy_height), "none beside a profile as measured");
  if (wind.speed > 0 && table_speed(table, wind.reference_height) <= 0) {
    throw InputError("reference height", number_text(wind.reference_height),
                     "a height where the profile as measured has wind");
  }
}

}  // namespace

void check_mean_wind(const MeanWind& wind) {
  const auto check = [](bool good, const char* what, double value, const char* wanted) {
    if (!good || !std::isfinite(value)) throw InputError(what, number_text(value), wanted);
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
  if (wind.profile == ProfileKind::table) check_table(wind);
}

double mean_speed(const MeanWind& wind, double height) {
  if (height <= 0 || wind.speed == 0) return 0;
  const bool one_at_reference = wind.profile == ProfileKind::constant || wind.profile == ProfileKind::power;
  const double reference =
      one_at_reference && wind.canopy_height <= 0 ? 1 : shape(wind, wind.reference_height);
  return wind.speed * shape(wind, height) / reference;
}

double table_speed(const std::vector<ProfileRow>& table, double height) {
  return interpolated(table, height, &ProfileRow::speed);
}

double veer(const MeanWind& wind, double height) {
  if (wind.profile != ProfileKind::table) return 0;
  return interpolated(wind.table, height, &ProfileRow::turn) -
         interpolated(wind.table, wind.reference_height, &ProfileRow::turn);
}

double log_law_friction_velocity(const MeanWind& wind) {
  constexpr double kappa = 0.4;
  const double height = std::max(wind.reference_height, wind.canopy_height);
  return kappa * mean_speed(wind, height) / std::log((height - wind.displacement) / wind.roughness_length);
}

Vec3 heading_direction(double heading) {
  const double angle = heading * std::numbers::pi / 180;
  return {std::cos(angle), std::sin(angle), 0};
}

Vec3 heading_direction(const MeanWind& wind) { return heading_direction(wind.heading); }

Vec3 heading_direction(const MeanWind& wind, double height) {
  return heading_direction(wind.heading + veer(wind, height));
}

Vec3 mean_velocity(const MeanWind& wind, double height) {
  return mean_speed(wind, height) * heading_direction(wind, height);
}

}  // namespace tremula
