// The air as light passes through it: molecules, aerosol and ozone over a round earth, in sixteen bands of
// the visible spectrum. One scattering is integrated along the ray (Nishita et al. 1993); all further ones
// are taken as isotropic and summed as a geometric series (Hillaire 2020, section 5.5). Profiles, cross
// sections and the sun's spectrum are those of Bruneton 2017 (precomputed_atmospheric_scattering).
#pragma once

#include "tremula/base/types.hpp"

#include <array>
#include <vector>

#include <Eigen/Core>

namespace tremula {

inline constexpr double earth_radius = 6'360'000;       // [m]
inline constexpr double air_height = 60'000;            // above it there is none [m]
inline constexpr double sun_angular_radius = 0.004675;  // [rad]

inline constexpr int band_count = 16;
inline constexpr double first_wavelength = 380, last_wavelength = 720;  // [nm]
using Spectrum = Eigen::Array<float, band_count, 1>;                    // a value for each band, per nm of it

double band_centre(int band);  // [nm]

// What the eye makes of it: linear sRGB with luminance in units of W weighed by the eye (683 lm each).
// Colours that sRGB does not have lose what is negative.
Eigen::Vector3f linear_srgb(const Spectrum& light);
float luminance(const Eigen::Vector3f& linear);

// A spectrum that is red in its long bands, green in the middle and blue in the short ones: of an albedo 0–1.
Spectrum smooth_spectrum(const Eigen::Vector3f& linear);

// Of the sun above the air, on a plane that faces it [W/(m^2 nm)].
Spectrum solar_irradiance();

struct Air {
  Spectrum molecules;           // scattering at the ground [1/m]
  Spectrum aerosol;             // extinction at the ground [1/m]
  Spectrum ozone;               // absorption where it is densest [1/m]
  float aerosol_albedo = 0.9F;  // share of extinction that is scattering
};

// `turbidity`: the optical thickness of molecules and aerosol over that of molecules, straight up at 550 nm;
// 1: no aerosol. The aerosol's goes with wavelength^-1.3 (Ångström 1929).
Air air_of(double turbidity);

// Molecules, aerosol and ozone: densities as shares of where an Air has them, or such densities summed along
// a path [m].
using Column = Vec3;
Column density_at(double height);                         // height above the ground [m]
Column column_above(double height, double zenith_angle);  // along a ray to the top of the air, by quadrature
Spectrum optical_depth(const Air& air, const Column& column);

// Per steradian, of the cosine between the ways before and after; each integrates to 1 over the sphere. The
// aerosol's is that of Cornette and Shanks with g = 0.76 (Bruneton & Neyret 2008).
float molecular_phase(float cosine);
float aerosol_phase(float cosine);

// Where the sun is below the horizon of a height, by the zenith angle [rad].
double horizon_angle(double height);

// column_above of every height and angle, tabled.
class ColumnTable {
 public:
  ColumnTable();
  Column operator()(double height, double zenith_angle) const;  // of rays that do not meet the ground

 private:
  static constexpr int heights = 48, angles = 64;
  std::vector<Column> columns_;
};

// What is seen along a ray, of a sun of irradiance 1 above the air in every band.
struct SkyLight {
  Spectrum single;         // scattered once
  Spectrum multiple;       // more often
  Spectrum transmittance;  // of what lies at the end
  bool ground = false;     // whether that is the ground, else it is space
};

class Atmosphere {
 public:
  // The sun stands at that angle from the zenith of the place from where it is looked [rad].
  Atmosphere(const Air& air, double sun_angle, const Spectrum& ground_albedo);

  // From a height [m] in a direction: its elevation, and its azimuth from the sun's [rad].
  SkyLight along(double height, double elevation, double azimuth, int steps = 40) const;
  // Share of the sun's light that arrives at a height where it stands at that angle from the zenith; where it
  // sets, that of the part of its disc that is above the horizon.
  Spectrum sun_transmittance(double height, double zenith_angle) const;

 private:
  struct March;
  template <class MeanRadiance>
  March march(double height, const Vec3& direction, const Vec3& to_sun, int steps,
              const MeanRadiance& mean) const;
  Spectrum mean_radiance(double height, double zenith_angle) const;
  Spectrum find_mean_radiance(double height, double zenith_angle, const Spectrum& albedo) const;

  static constexpr int heights = 10, angles = 11;
  Air air_;
  double sun_angle_;
  ColumnTable columns_;
  std::array<Spectrum, heights * angles> mean_radiance_;  // of light scattered twice or more
};

}  // namespace tremula
