#include "tremula/wind/turbulent_wind.hpp"

#include "tremula/base/error.hpp"

#include <algorithm>
#include <cmath>

namespace tremula {

TurbulentWind turbulent_wind(const MeanWind& mean, double turbulence_intensity, SpectrumKind spectrum,
                             IecEdition edition) {
  const bool iec = spectrum == SpectrumKind::iec_kaimal || spectrum == SpectrumKind::von_karman;
  return turbulent_wind(mean, turbulence_intensity, spectrum,
                        iec ? CoherenceKind::iec : CoherenceKind::shinya_fournier, edition);
}

TurbulentWind turbulent_wind(const MeanWind& mean, double turbulence_intensity, SpectrumKind spectrum,
                             CoherenceKind coherence, IecEdition edition) {
  return {.mean = mean,
          .spectrum = spectrum_model(spectrum, mean, turbulence_intensity, edition),
          .coherence = coherence_model(coherence, mean, edition)};
}

void check_turbulent_wind(const TurbulentWind& wind) {
  check_mean_wind(wind.mean);
  check_spectrum(wind.spectrum);
  check_coherence(wind.coherence);
}

Vec3 spectrum_at(const TurbulentWind& wind, double height, double frequency) {
  const double from = std::max(height, lowest_spectrum_height);
  return spectrum(wind.spectrum, frequency, from, mean_speed(wind.mean, from));
}

const std::vector<Terrain>& terrains() {
  static const std::vector<Terrain> all = {{.name = "open"},
                                           {.name = "grass",
                                            .roughness_length = 0.062,
                                            .displacement = 0.33,
                                            .canopy_height = 0.5,
                                            .canopy_decay = 2.5},
                                           {.name = "crops",
                                            .roughness_length = 0.123,
                                            .displacement = 0.67,
                                            .canopy_height = 1,
                                            .canopy_decay = 2.5},
                                           {.name = "parkland", .roughness_length = 0.5},
                                           {.name = "forest-edge",
                                            .roughness_length = 1,
                                            .displacement = 5,
                                            .canopy_height = 15,
                                            .canopy_decay = 1}};
  return all;
}

const Terrain& terrain_named(const std::string& name) {
  for (const Terrain& terrain : terrains()) {
    if (terrain.name == name) return terrain;
  }
  throw InputError("terrain", name, "open, grass, crops, parkland or forest-edge");
}

MeanWind mean_wind_over(const Terrain& terrain, double speed, double reference_height, double heading) {
  const MeanWind mean{.speed = speed,
                      .reference_height = reference_height,
                      .heading = heading,
                      .roughness_length = terrain.roughness_length,
                      .displacement = terrain.displacement,
                      .canopy_height = terrain.canopy_height,
                      .canopy_decay = terrain.canopy_decay};
  check_mean_wind(mean);
  return mean;
}

double turbulence_intensity_of(const MeanWind& mean) {
  return mean.speed > 0 ? std::sqrt(6.0) * log_law_friction_velocity(mean) / mean.speed : 0;
}

}  // namespace tremula
