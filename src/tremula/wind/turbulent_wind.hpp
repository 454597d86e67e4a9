// All that is said about a wind, in one struct: mean, spectrum, coherence, seed. And the winds of named
// terrains.
#pragma once

#include "tremula/wind/coherence.hpp"
#include "tremula/wind/profile.hpp"
#include "tremula/wind/spectrum.hpp"

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace tremula {

enum class Amplitudes {
  gaussian,     // the wind is a Gaussian process
  phases_only,  // F section 3.4: the power of every wave is what the model says, only phases are random
};

struct TurbulentWind {
  MeanWind mean = {};
  SpectrumModel spectrum = {};
  Coherence coherence = {};
  // Of u and w at a point, at all heights [(m/s)^2]: -u*^2 where the ground draws momentum from the wind. 0:
  // they know nothing of each other.
  double covariance_uw = 0;
  Amplitudes amplitudes = Amplitudes::gaussian;
  std::uint64_t seed = 1;
};

// The spectrum and the coherence of one source about a mean wind. Without a coherence kind, the one that goes
// with the spectrum: iec for iec-kaimal and von-karman, shinya-fournier for the others. The edition is that
// of IEC 61400-1, for spectrum and coherence alike.
TurbulentWind turbulent_wind(const MeanWind& mean, double turbulence_intensity,
                             SpectrumKind spectrum = SpectrumKind::simiu_scanlan,
                             IecEdition edition = IecEdition::third);
TurbulentWind turbulent_wind(const MeanWind& mean, double turbulence_intensity, SpectrumKind spectrum,
                             CoherenceKind coherence, IecEdition edition = IecEdition::third);

// Throws InputError; also for a covariance of u and w beyond what their spectra allow, or beside amplitudes
// of phases only (two waves of one size cannot be correlated in part) or coherence of u alone.
void check_turbulent_wind(const TurbulentWind& wind);

// What part of w is the same gust as u, at every frequency alike: the covariance over the most it could be
// (largest_covariance_uw), -1 to 1.
double coherency_uw(const TurbulentWind& wind);

// Where spectra that depend on the height end: lower points take the spectrum of this height [m].
inline constexpr double lowest_spectrum_height = 0.5;

// S_u, S_v, S_w [(m/s)^2/Hz] of the wind at a height [m].
Vec3 spectrum_at(const TurbulentWind& wind, double height, double frequency);

// What the ground does to the wind.
struct Terrain {
  std::string name;
  double roughness_length = 0.03;  // z0 [m]
  double displacement = 0;         // d [m]
  double canopy_height = 0;        // h [m]
  double canopy_decay = 2;         // a
};

// open, grass, crops, parkland, forest-edge. The theory chapter says where the numbers come from.
const std::vector<Terrain>& terrains();
const Terrain& terrain_named(std::string_view name);  // throws InputError for other names

// The logarithmic profile over a terrain, with the speed [m/s] at a reference height [m] (which may lie in
// the canopy). Throws InputError for what makes no wind.
MeanWind mean_wind_over(const Terrain& terrain, double speed, double reference_height = 10,
                        double heading = 0);

// sigma_u / U at the reference height that goes with a logarithmic profile: sqrt(6) u* / U.
double turbulence_intensity_of(const MeanWind& mean);

}  // namespace tremula
