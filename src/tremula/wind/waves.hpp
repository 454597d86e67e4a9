// Waves over water plants: a sea of long-crested waves that all run one way, by linear theory (Airy). What
// they do to the water goes through the cascade as a wind does, with water for air:
// LoadOptions::fluid_density.
//
//   u = sum of a_i omega_i cosh(k_i z)/sinh(k_i h) cos(k_i x - omega_i t)      along the heading
//   w = sum of a_i omega_i sinh(k_i z)/sinh(k_i h) sin(k_i x - omega_i t)      upwards
//
// z above the ground, h the depth of the water, omega^2 = g k tanh(k h).
#pragma once

#include "tremula/wind/point_wind.hpp"

#include <cstdint>

namespace tremula {

struct Waves {
  double significant_height = 1;  // H_s, four times the deviation of the surface [m]
  double peak_period = 6;         // T_p [s]
  double water_depth = 10;        // h [m]
  double peak_enhancement = 3.3;  // gamma of JONSWAP (Hasselmann et al. 1973); 1: Pierson and Moskowitz 1964
  double heading = 0;             // where they run to, as MeanWind::heading [degrees]
  std::uint64_t seed = 1;
};

// Throws InputError for what is not above 0 (significant_height: below 0), a gamma outside 1 to 10, and for
// waves that would break: higher than 0.6 of the depth, or than a seventh of their length (H_s, at T_p).
void check_waves(const Waves& waves);

// Height and period of the waves under a wind [m/s] that has blown for long over water everywhere as deep
// [m]:
//
//   g H_s/U^2 = 0.283 tanh(0.530 (g h/U^2)^(3/4)),   g T_p/U = 7.54 tanh(0.833 (g h/U^2)^(3/8))
//
// (Shore Protection Manual 1984, eq. 3-39 and 3-40, for a long fetch); in deep water a fully developed sea.
// Where they would break they are as high as they can be. Throws InputError for a wind or a depth that is not
// above 0.
Waves wind_waves(double wind_speed, double water_depth);

// What part of the wind's speed the water under it takes up as a current: 2 to 3.5 per cent at the surface,
// and over the depth about half of that.
inline constexpr double wind_drift = 0.01;

// k of omega^2 = g k tanh(k h) [1/m], to 15 digits. omega [rad/s] 0 or more, depth [m] above 0.
double wave_number(double omega, double water_depth);

// S_eta of the surface [m^2/Hz]: gamma^r f^-5 exp(-5/4 (f/f_p)^-4), r = exp(-((f/f_p - 1)/sigma)^2/2), sigma
// 0.07 below the peak and 0.09 above, scaled so that it integrates to (H_s/4)^2. Makes the scale once.
class WaveSpectrum {
 public:
  explicit WaveSpectrum(const Waves& waves);
  double operator()(double frequency) const;  // [Hz]

 private:
  double peak_frequency_, enhancement_, scale_ = 1;
};

// How the water moves where the surface goes up and down by 1 m at one frequency: u in phase with the crest,
// w a quarter of a period ahead of it [1/s]. z above the ground [m]; above the surface as in it.
struct OrbitalMotion {
  double along = 0, up = 0;
};
OrbitalMotion orbital_motion(double omega, double wave_number, double water_depth, double z);

// The water under waves, at rest but for them. Loops whose period is shorter than the peak period are refused
// when points are asked for; points above the surface are warned of.
Wind wind_of(const Waves& waves);

// A current and waves that do not know of each other: velocities add up.
Wind add_waves(Wind current, const Waves& waves);

}  // namespace tremula
