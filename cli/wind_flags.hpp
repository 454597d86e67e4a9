// A turbulent wind by flags: what tremula wind synthesises and tremula animate blows at plants.
#pragma once

#include "tremula/wind/turbulent_wind.hpp"

#include <optional>
#include <string>
#include <vector>

#include "common.hpp"

namespace tremula::cli {

inline constexpr const char* wind_flag_group = "Wind";

struct WindFlags {
  double speed = 6, reference_height = 10, heading = 0;
  std::string profile = "log", spectrum = "simiu-scanlan", amplitudes = "gaussian";
  std::optional<std::string> coherence, terrain;
  std::optional<double> turbulence_intensity, friction_velocity;  // default_turbulence_intensity, or terrain
  std::optional<int> iec_edition;
  std::optional<double> turbulence_intensity_v, turbulence_intensity_w, sigma_ratio_v, sigma_ratio_w;
  double covariance_uw = 0;
  std::optional<double> power_exponent, roughness_length, displacement, canopy_height, canopy_decay;
  std::vector<double> decay_y, decay_z;  // of u, v, w; empty: those of the model
  std::uint64_t seed = 1;

  // The options themselves, to tell which were given: what every wind has, the turbulence, its realisation.
  CLI::Option* speed_option = nullptr;
  std::vector<CLI::Option*> of_mean, of_turbulence, of_realisation;

  // A field on a plane across the wind has no heading.
  // with_speed: whether it has one, and not several of its own making.
  void add_to(CLI::App& command, bool with_heading, bool with_speed = true);

  // Both throw InputError for flags that would have no effect; they read the profile where --profile names a
  // file.
  MeanWind mean_wind() const;
  double intensity(const MeanWind& mean) const;  // sigma_u / U at the reference height
  // All of it; reads the table where --spectrum names one. Throws InputError.
  TurbulentWind wind() const;
  std::string spectrum_name() const;  // as the program writes it
};

// Throws InputError naming the first of the options that was given: "--seed: given with ..., wanted ...".
void refuse_given(const std::vector<CLI::Option*>& options, const std::string& with,
                  const std::string& wanted);

inline constexpr double default_turbulence_intensity = 0.2;

// The numbers that count, whether given or taken from models and terrain. With the wind the flags made.
Json describe(const WindFlags& flags, const TurbulentWind& wind);

// The terrains with their numbers, a line each.
std::string terrain_table();

}  // namespace tremula::cli
