#include "tremula/wind/turbulent_wind.hpp"

#include "tremula/base/error.hpp"
#include "tremula/base/number_text.hpp"

#include <algorithm>
#include <cmath>

namespace tremula {
namespace {

double most_covariance(const TurbulentWind& wind) {
  const double height = std::max(wind.mean.reference_height, lowest_spectrum_height);
  return largest_covariance_uw(wind.spectrum, height, mean_speed(wind.mean, height));
}

void check_covariance(const TurbulentWind& wind) {
  const double wanted = wind.covariance_uw;
  if (wanted == 0) return;
  const auto refuse = [wanted](const std::string& why) {
    throw InputError("covariance of u and w", number_text(wanted) + " m^2/s^2", why);
  };
  if (wind.amplitudes == Amplitudes::phases_only) refuse("none where amplitudes are phases only");
  if (wind.coherence.iec_for_u_only && wind.coherence.kind == CoherenceKind::iec)
    refuse("none where only u is coherent");
  const double most = most_covariance(wind);
  if (std::isfinite(wanted) && std::abs(wanted) <= most) return;
  const Vec3 deviation = spectrum_variance(wind.spectrum).cwiseSqrt();
  refuse("at most " + number_text(most) +
         " in size, which these spectra allow (their deviations multiply to " +
         number_text(deviation[0] * deviation[2]) + ")");
}

}  // namespace

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
  check_covariance(wind);
}

double coherency_uw(const TurbulentWind& wind) {
  return wind.covariance_uw == 0 ? 0 : wind.covariance_uw / most_covariance(wind);
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

const Terrain& terrain_named(std::string_view name) {
  for (const Terrain& terrain : terrains()) {
    if (terrain.name == name) return terrain;
  }
  throw InputError("terrain", std::string(name), "open, grass, crops, parkland or forest-edge");
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
