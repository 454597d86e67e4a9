// How the variance of turbulence spreads over frequency. One-sided, per Hz: the integral over f > 0 is the
// variance. Components u along the mean wind, v across it, w up.
#pragma once

#include "tremula/base/types.hpp"
#include "tremula/wind/iec.hpp"
#include "tremula/wind/profile.hpp"

#include <string>
#include <vector>

namespace tremula {

enum class SpectrumKind {
  simiu_scanlan,  // F eq. 1: by height, C_0 = u*^2
  iec_kaimal,     // IEC 61400-1, Kaimal: one for all heights
  von_karman,     // IEC 61400-1, von Karman's isotropic turbulence: one for all heights
  table,
};

// "simiu-scanlan", "iec-kaimal", "von-karman", "table". Throws InputError for other names.
SpectrumKind spectrum_named(const std::string& name);
std::string name_of(SpectrumKind kind);

// Measured spectra. Between two rows a power of the frequency (log-log interpolation), below the first
// constant, above the last falling with f^-5/3.
struct SpectrumTable {
  // true: `at` is a wave number k1 [rad/m] and the values [m^3/s^2] are per rad/m; at a place where the wind
  // blows with U they become S(f) = (2 pi/U) F(2 pi f/U). false: frequency [Hz] and [(m/s)^2/Hz].
  bool by_wave_number = false;
  std::vector<double> at;    // rising, above 0
  std::vector<Vec3> values;  // S_u, S_v, S_w, above 0
};

struct SpectrumModel {
  SpectrumKind kind = SpectrumKind::simiu_scanlan;
  double friction_velocity = 0;   // u* [m/s]: simiu-scanlan
  Vec3 deviation = Vec3::Zero();  // sigma_u, v, w [m/s]: iec-kaimal, von-karman
  Vec3 length = Vec3::Ones();     // L_u, v, w [m]: iec-kaimal, von-karman
  double reference_speed = 1;     // U that makes a frequency of a length: iec-kaimal, von-karman [m/s]
  SpectrumTable table = {};
  // Of u, v, w: what the spectra of the model are multiplied by, where deviations are wanted that are not its
  // own.
  Vec3 power_factor = Vec3::Ones();
};

// The model with the numbers its source gives, for the along-wind deviation sigma_u = intensity * speed at
// the reference height z_r of the mean wind:
//   simiu-scanlan: u* = sigma_u / sqrt(6), so sigma_v = 0.63 sigma_u, sigma_w = 0.53 sigma_u.
//   iec-kaimal:    sigma_v = 0.8 sigma_u, sigma_w = 0.5 sigma_u; L = 8.1, 2.7, 0.66 times the edition's
//                  turbulence_scale at the reference height (the hub), whose U all heights take.
//   von-karman:    sigma_v = sigma_w = sigma_u; L = 3.5 times that scale for all three. The second edition
//   has
//                  it; with the scale of the third it is what TurbSim makes of it.
// table: use table_spectrum. Throws InputError for an intensity outside 0 to 2.
SpectrumModel spectrum_model(SpectrumKind kind, const MeanWind& mean, double turbulence_intensity,
                             IecEdition edition = IecEdition::third);

// The model with other deviations of u, v, w [m/s], its spectra as they were in shape. A component without
// variance keeps none.
SpectrumModel with_deviations(SpectrumModel model, const Vec3& deviation);

// As measured: no intensity changes it. Throws InputError for a table that is no spectrum (see
// check_spectrum).
SpectrumModel table_spectrum(SpectrumTable table);

// Throws InputError for numbers that make no spectrum.
void check_spectrum(const SpectrumModel& model);

// S_u, S_v, S_w [(m/s)^2/Hz] at a place. frequency [Hz] > 0, height [m] > 0, speed [m/s]: the mean wind
// there. Zero where there is no mean wind.
Vec3 spectrum(const SpectrumModel& model, double frequency, double height, double speed);

// Its integral over f > 0, in closed form: variances of u, v, w [(m/s)^2]. The same at all heights and speeds
// > 0.
Vec3 spectrum_variance(const SpectrumModel& model);

// The integral of sqrt(S_u S_w) over f > 0 [(m/s)^2]: the covariance of u and w if they were the same gust at
// every frequency, and so the most that it can be. Below sigma_u sigma_w, as the two spectra differ in shape.
double largest_covariance_uw(const SpectrumModel& model, double height, double speed);

// S_u, S_v, S_w [(m/s)^2/Hz] of Simiu & Scanlan as F eq. 1 has them, with C_0 = friction_velocity^2 and
// nu = f z/U: variances 6, 2.3684 and 1.6728 u*^2 (errata F2). frequency [Hz] > 0, height [m] > 0, speed
// [m/s] > 0.
Vec3 simiu_scanlan_spectrum(double frequency, double height, double speed, double friction_velocity);

// The friction velocity u* [m/s] that gives the along-wind deviation sigma_u = intensity * speed.
double friction_velocity_from_intensity(double turbulence_intensity, double speed);

}  // namespace tremula
