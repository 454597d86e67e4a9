// A turbulent wind by flags: what tremula wind synthesises and tremula animate blows at plants.
#pragma once

#include "tremula/wind/turbulent_wind.hpp"

#include <optional>
#include <string>
#include <vector>

#include "common.hpp"

namespace tremula::cli {

// What differs between the commands.
struct WindFlagNames {
  std::string speed = "--wind-speed";
  std::string spectrum = "--spectrum";  // further names after commas
  bool heading = true;                  // a field on a plane across the wind has none
  std::string group = "Wind";
};

struct WindFlags {
  double speed = 6, reference_height = 10, heading = 0;
  std::string profile = "log", spectrum = "simiu-scanlan", amplitudes = "gaussian";
  std::optional<std::string> coherence, terrain;
  std::optional<double> turbulence_intensity, friction_velocity;  // default_turbulence_intensity, or terrain
  std::optional<int> iec_edition;
  std::optional<double> power_exponent, roughness_length, displacement, canopy_height, canopy_decay;
  std::vector<double> decay_y, decay_z;  // of u, v, w; empty: those of the model
  std::uint64_t seed = 1;

  void add_to(CLI::App& command, const WindFlagNames& names = {});

  MeanWind mean_wind() const;
  // At the reference height: as given, or that of the friction velocity, of the terrain, or the default.
  double intensity(const MeanWind& mean) const;
  // All of it; reads the table where --spectrum names one. Both throw InputError.
  TurbulentWind wind() const;
};

inline constexpr double default_turbulence_intensity = 0.2;

// The numbers that count, whether given or taken from models and terrain. With the wind the flags made.
Json describe(const WindFlags& flags, const TurbulentWind& wind);

// The terrains with their numbers, a line each.
std::string terrain_table();

}  // namespace tremula::cli
