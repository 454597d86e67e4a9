#include "tremula/render/atmosphere.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <tbb/parallel_for.h>
#include <Eigen/Geometry>

namespace tremula {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double molecules_height = 8000, aerosol_height = 1200;  // by which their densities fall to 1/e [m]
constexpr double band_width = (last_wavelength - first_wavelength) / band_count;  // [nm]

// Means over 10 nm from 380 nm on.
constexpr int datum_count = 34;
constexpr double datum_width = 10;
// ASTM G173-03, extraterrestrial [W/(m^2 nm)].
constexpr std::array<double, datum_count> sun_data = {
    1.01249, 1.14716, 1.72765, 1.73054, 1.6887, 1.61253, 1.91198, 2.03474, 2.02042,
    2.02212, 1.93377, 1.95809, 1.91686, 1.8298, 1.8685,  1.8931,  1.85149, 1.8504,
    1.8341,  1.8345,  1.8147,  1.78158, 1.7533, 1.6965,  1.68194, 1.64654, 1.6048,
    1.52143, 1.55622, 1.5113,  1.474,   1.4482, 1.41018, 1.36775};
// Of ozone at 233 K, University of Bremen [m^2].
constexpr std::array<double, datum_count> ozone_data = {
    2.818e-28, 6.636e-28, 1.527e-27, 2.763e-27, 5.52e-27,  8.451e-27, 1.582e-26, 2.316e-26, 3.669e-26,
    4.924e-26, 7.752e-26, 9.016e-26, 1.48e-25,  1.602e-25, 2.139e-25, 2.755e-25, 3.091e-25, 3.5e-25,
    4.266e-25, 4.672e-25, 4.398e-25, 4.701e-25, 5.019e-25, 4.305e-25, 3.74e-25,  3.215e-25, 2.662e-25,
    2.238e-25, 1.852e-25, 1.473e-25, 1.209e-25, 9.423e-26, 7.455e-26, 6.566e-26};
// 300 Dobson units in a tent of 30 km, 15 km of its top [1/m^3].
constexpr double densest_ozone = 300 * 2.687e20 / 15000;

Spectrum means_over_bands(const std::array<double, datum_count>& data) {
  Spectrum mean;
  for (int b = 0; b < band_count; ++b) {
    const double low = b * band_width, high = low + band_width;  // from the first wavelength
    double sum = 0;
    for (int d = 0; d < datum_count; ++d) {
      const double overlap = std::min(high, (d + 1) * datum_width) - std::max(low, d * datum_width);
      sum += std::max(overlap, 0.0) * data[static_cast<std::size_t>(d)];
    }
    mean[b] = static_cast<float>(sum / band_width);
  }
  return mean;
}

double lobe(double wavelength, double centre, double rise, double fall) {
  const double t = (wavelength - centre) * (wavelength < centre ? rise : fall);
  return std::exp(-t * t / 2);
}

// CIE 1931, as fitted by Wyman, Sloan and Shirley 2013.
Vec3 eye_response(double w) {
  return {0.362 * lobe(w, 442.0, 0.0624, 0.0374) + 1.056 * lobe(w, 599.8, 0.0264, 0.0323) -
              0.065 * lobe(w, 501.1, 0.0490, 0.0382),
          0.821 * lobe(w, 568.8, 0.0213, 0.0247) + 0.286 * lobe(w, 530.9, 0.0613, 0.0322),
          1.217 * lobe(w, 437.0, 0.0845, 0.0278) + 0.681 * lobe(w, 459.0, 0.0385, 0.0725)};
}

// What each band adds to red, green and blue (XYZ to sRGB: IEC 61966-2-1) [nm].
Eigen::Matrix<float, 3, band_count> make_color_weights() {
  Eigen::Matrix3d srgb_from_xyz;
  srgb_from_xyz << 3.2406, -1.5372, -0.4986, -0.9689, 1.8758, 0.0415, 0.0557, -0.2040, 1.0570;
  Eigen::Matrix<float, 3, band_count> weights;
  constexpr int parts = 20;
  for (int b = 0; b < band_count; ++b) {
    Vec3 sum = Vec3::Zero();
    for (int i = 0; i < parts; ++i)
      sum += eye_response(first_wavelength + (b + (i + 0.5) / parts) * band_width) * band_width / parts;
    weights.col(b) = (srgb_from_xyz * sum).cast<float>();
  }
  return weights;
}

// (1 - e^-x) / x.
Spectrum mean_transmittance(const Spectrum& depth, const Spectrum& transmittance) {
  return (depth > 1e-3F).select((1 - transmittance) / depth.max(1e-6F), 1 - depth / 2);
}

double length_to_sphere(double from_centre, double cosine, double radius) {
  const double along = from_centre * cosine;
  const double square = along * along - from_centre * from_centre + radius * radius;
  return -along + std::sqrt(std::max(square, 0.0));
}

// A place between two of a table: `at` in steps from the first.
struct Between {
  int index;
  double share;  // of the next one
};
Between between(double at, int count) {
  const double inside = std::clamp(at, 0.0, static_cast<double>(count - 1));
  const int index = std::min(static_cast<int>(inside), count - 2);
  return {index, inside - index};
}

}  // namespace

double band_centre(int band) { return first_wavelength + (band + 0.5) * band_width; }

Eigen::Vector3f linear_srgb(const Spectrum& light) {
  static const auto weights = make_color_weights();
  const Eigen::Vector3f color = weights * light.matrix();
  const float least = color.minCoeff(), grey = luminance(color);
  if (!(least < 0)) return color;
  if (!(grey > 0)) return Eigen::Vector3f::Zero();
  // As much nearer to grey as it takes.
  const float share = grey / (grey - least);
  return (Eigen::Vector3f::Constant(grey) + share * (color - Eigen::Vector3f::Constant(grey))).cwiseMax(0.0F);
}

float luminance(const Eigen::Vector3f& linear) {
  return linear.dot(Eigen::Vector3f(0.2126F, 0.7152F, 0.0722F));
}

Spectrum smooth_spectrum(const Eigen::Vector3f& linear) {
  constexpr double blue_ends = 495, green_ends = 585, half_ramp = 25;  // [nm]
  Spectrum spectrum;
  for (int b = 0; b < band_count; ++b) {
    const auto beyond = [&](double edge) {
      return static_cast<float>(std::clamp(0.5 + (band_centre(b) - edge) / (2 * half_ramp), 0.0, 1.0));
    };
    const float not_blue = beyond(blue_ends), red = beyond(green_ends);
    spectrum[b] = linear.x() * red + linear.y() * (not_blue - red) + linear.z() * (1 - not_blue);
  }
  return spectrum;
}

Spectrum solar_irradiance() { return means_over_bands(sun_data); }

Air air_of(double turbidity) {
  Air air;
  const auto rayleigh = [](double micrometres) { return 1.24062e-6 * std::pow(micrometres, -4); };
  const double aerosol_550 = (turbidity - 1) * rayleigh(0.55) * molecules_height / aerosol_height;
  for (int b = 0; b < band_count; ++b) {
    const double micrometres = band_centre(b) / 1000;
    air.molecules[b] = static_cast<float>(rayleigh(micrometres));
    air.aerosol[b] = static_cast<float>(aerosol_550 * std::pow(micrometres / 0.55, -1.3));
  }
  std::array<double, datum_count> absorption = ozone_data;
  for (double& a : absorption) a *= densest_ozone;
  air.ozone = means_over_bands(absorption);
  return air;
}

Column density_at(double height) {
  const double h = std::max(height, 0.0);
  return {std::exp(-h / molecules_height), std::exp(-h / aerosol_height),
          std::max(0.0, 1 - std::abs(h - 25'000) / 15'000)};
}

Column column_above(double height, double zenith_angle) {
  constexpr int steps = 64;
  const double r = earth_radius + height, cosine = std::cos(zenith_angle);
  const double length = length_to_sphere(r, cosine, earth_radius + air_height);
  Column sum = Column::Zero();
  for (int i = 0; i < steps; ++i) {  // shorter ones first, where the air is dense
    const double u = (i + 0.5) / steps, t = length * u * u;
    sum +=
        density_at(std::sqrt(r * r + t * t + 2 * r * t * cosine) - earth_radius) * (2 * length * u / steps);
  }
  return sum;
}

Spectrum optical_depth(const Air& air, const Column& column) {
  const Eigen::Vector3f c = column.cast<float>();
  return air.molecules * c.x() + air.aerosol * c.y() + air.ozone * c.z();
}

float molecular_phase(float cosine) { return static_cast<float>(3 / (16 * pi)) * (1 + cosine * cosine); }

float aerosol_phase(float cosine) {
  constexpr float g = 0.76F;
  const float spread = std::max(1 + g * g - 2 * g * cosine, 1e-4F);
  return static_cast<float>(3 / (8 * pi)) * (1 - g * g) * (1 + cosine * cosine) /
         ((2 + g * g) * spread * std::sqrt(spread));
}

double horizon_angle(double height) {
  return pi - std::asin(std::min(earth_radius / (earth_radius + std::max(height, 0.0)), 1.0));
}

ColumnTable::ColumnTable() : columns_(std::size_t{heights * angles}) {
  tbb::parallel_for(0, heights, [&](int h) {
    const double v = h / (heights - 1.0), height = air_height * v * v, horizon = horizon_angle(height);
    for (int a = 0; a < angles; ++a) {
      const double u = a / (angles - 1.0);
      columns_[static_cast<std::size_t>(h * angles + a)] = column_above(height, horizon * (1 - u * u));
    }
  });
}

Column ColumnTable::operator()(double height, double zenith_angle) const {
  const double horizon = horizon_angle(height);
  const Between h = between(std::sqrt(std::clamp(height / air_height, 0.0, 1.0)) * (heights - 1), heights);
  const Between a =
      between(std::sqrt(std::clamp(1 - zenith_angle / horizon, 0.0, 1.0)) * (angles - 1), angles);
  const Column* low = &columns_[static_cast<std::size_t>(h.index * angles + a.index)];
  const Column* high = low + angles;
  return (1 - h.share) * ((1 - a.share) * low[0] + a.share * low[1]) +
         h.share * ((1 - a.share) * high[0] + a.share * high[1]);
}

struct Atmosphere::March {
  Spectrum molecules = Spectrum::Zero(),
           aerosol = Spectrum::Zero();   // sunlight that they scatter, without phase
  Spectrum multiple = Spectrum::Zero();  // of the mean radiance
  Spectrum transmittance = Spectrum::Ones();
  bool ground = false;
  double sun_angle_at_end = 0;  // from the zenith there
};

template <class MeanRadiance>
Atmosphere::March Atmosphere::march(double height, const Vec3& direction, const Vec3& to_sun, int steps,
                                    const MeanRadiance& mean) const {
  const double r = earth_radius + height, along = r * direction.z();
  const double square = along * along - r * r + earth_radius * earth_radius;
  March result;
  result.ground = along < 0 && square >= 0;
  const double length = result.ground ? -along - std::sqrt(square)
                                      : length_to_sphere(r, direction.z(), earth_radius + air_height);
  const auto sun_angle_at = [&](const Vec3& point) {
    return std::acos(std::clamp(point.dot(to_sun) / point.norm(), -1.0, 1.0));
  };
  for (int i = 0; i < steps; ++i) {
    const double u = (i + 0.5) / steps, step = 2 * length * u / steps;
    const Vec3 point = Vec3(0, 0, r) + length * u * u * direction;
    const double h = std::max(point.norm() - earth_radius, 0.0), angle = sun_angle_at(point);
    const Column density = density_at(h);
    const Spectrum molecules = air_.molecules * static_cast<float>(density.x());
    const Spectrum aerosol = air_.aerosol * (air_.aerosol_albedo * static_cast<float>(density.y()));
    const Spectrum depth = optical_depth(air_, density) * static_cast<float>(step);
    const Spectrum through = (-depth).exp();
    const Spectrum seen =
        result.transmittance * mean_transmittance(depth, through) * static_cast<float>(step);
    const Spectrum sunlit = seen * sun_transmittance(h, angle);
    result.molecules += sunlit * molecules;
    result.aerosol += sunlit * aerosol;
    result.multiple += seen * (molecules + aerosol) * mean(h, angle);
    result.transmittance *= through;
  }
  result.sun_angle_at_end = sun_angle_at(Vec3(0, 0, r) + length * direction);
  return result;
}

Atmosphere::Atmosphere(const Air& air, double sun_angle, const Spectrum& ground_albedo)
    : air_(air), sun_angle_(sun_angle) {
  // Filled before it is read: find_mean_radiance takes 1 for what it looks for.
  tbb::parallel_for(0, heights * angles, [&](int i) {
    const double v = i / angles / (heights - 1.0), a = i % angles / (angles - 1.0);
    mean_radiance_[static_cast<std::size_t>(i)] =
        find_mean_radiance(air_height * v * v, sun_angle_ + (2 * a - 1) * 8 * pi / 180, ground_albedo);
  });
}

Spectrum Atmosphere::sun_transmittance(double height, double zenith_angle) const {
  const double above = (horizon_angle(height) - zenith_angle) / sun_angular_radius;
  if (above <= -1) return Spectrum::Zero();
  Spectrum share = (-optical_depth(air_, columns_(height, zenith_angle))).exp();
  // The part of a disc on one side of a chord.
  if (above < 1)
    share *= static_cast<float>(0.5 + (std::asin(above) + above * std::sqrt(1 - above * above)) / pi);
  return share;
}

// Hillaire 2020, eqs. 5 to 10. The ground sends the mean radiance back too.
Spectrum Atmosphere::find_mean_radiance(double height, double zenith_angle, const Spectrum& albedo) const {
  constexpr int rings = 16, spokes = 4, steps = 16;
  const double angle = std::abs(zenith_angle);
  const Vec3 to_sun(std::sin(angle), 0, std::cos(angle));
  Spectrum second = Spectrum::Zero(), again = Spectrum::Zero();
  for (int ring = 0; ring < rings; ++ring) {
    const double z = 2 * (ring + 0.5) / rings - 1, across = std::sqrt(1 - z * z);
    for (int spoke = 0; spoke < spokes; ++spoke) {  // the other half is its mirror image
      const double azimuth = pi * (spoke + 0.5) / spokes;
      const Vec3 direction(across * std::cos(azimuth), across * std::sin(azimuth), z);
      const March way = march(height, direction, to_sun, steps, [](double, double) { return 1.0F; });
      second += (way.molecules + way.aerosol) / static_cast<float>(4 * pi);
      again += way.multiple;
      if (!way.ground) continue;
      const double cosine = std::max(std::cos(way.sun_angle_at_end), 0.0);
      second += way.transmittance * albedo * sun_transmittance(0, way.sun_angle_at_end) *
                static_cast<float>(cosine / pi);
      again += way.transmittance * albedo;
    }
  }
  constexpr float count = rings * spokes;
  return second / count / (1 - (again / count).min(0.999F));
}

Spectrum Atmosphere::mean_radiance(double height, double zenith_angle) const {
  const Between h = between(std::sqrt(std::clamp(height / air_height, 0.0, 1.0)) * (heights - 1), heights);
  const Between a = between(((zenith_angle - sun_angle_) * 180 / pi / 8 + 1) / 2 * (angles - 1), angles);
  const Spectrum* low = &mean_radiance_[static_cast<std::size_t>(h.index * angles + a.index)];
  const Spectrum* high = low + angles;
  const auto hs = static_cast<float>(h.share), as = static_cast<float>(a.share);
  return (1 - hs) * ((1 - as) * low[0] + as * low[1]) + hs * ((1 - as) * high[0] + as * high[1]);
}

SkyLight Atmosphere::along(double height, double elevation, double azimuth, int steps) const {
  const double across = std::cos(elevation);
  const Vec3 direction(across * std::cos(azimuth), across * std::sin(azimuth), std::sin(elevation));
  const Vec3 to_sun(std::sin(sun_angle_), 0, std::cos(sun_angle_));
  const March way = march(height, direction, to_sun, steps,
                          [&](double h, double angle) { return mean_radiance(h, angle); });
  const auto cosine = static_cast<float>(direction.dot(to_sun));
  return {molecular_phase(cosine) * way.molecules + aerosol_phase(cosine) * way.aerosol, way.multiple,
          way.transmittance, way.ground};
}

}  // namespace tremula
