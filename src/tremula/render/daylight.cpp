#include "tremula/render/daylight.hpp"

#include "tremula/base/error.hpp"
#include "tremula/base/number_text.hpp"
#include "tremula/render/atmosphere.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include <tbb/parallel_for.h>

namespace tremula {
namespace {

constexpr double pi = std::numbers::pi;
constexpr float half_pi = static_cast<float>(pi / 2);
// Of the eye [m]. As high as a tree, so that the ground fades into haze before it ends.
constexpr double eye_height = 10;
constexpr float share_below = 0.1F;  // of samples

// Columns by azimuth from the sun on one side (the other is its mirror image), close beside the sun; rows by
// elevation, close at the horizon, of the sky above it and of the ground below.
constexpr int columns = 48, sky_rows = 96, ground_rows = 24;
// Cells of equal density: half as fine, all round.
constexpr int cell_columns = 64, sky_cells = 48, ground_cells = 8;
constexpr int cell_rows = sky_cells + ground_cells;

double horizon_elevation() { return pi / 2 - horizon_angle(eye_height); }

// Elevation of a share of the way from the horizon to zenith or nadir, both ends included [rad].
double elevation_of(double share, bool sky) {
  const double horizon = horizon_elevation();
  return sky ? horizon + (pi / 2 - horizon) * share * share : horizon - (pi / 2 + horizon) * share * share;
}

// Share of the way of a direction, and whether it is above the horizon.
float share_of(float elevation, bool& sky) {
  static const auto horizon = static_cast<float>(horizon_elevation());
  sky = elevation >= horizon;
  const float way =
      sky ? (elevation - horizon) / (half_pi - horizon) : (horizon - elevation) / (half_pi + horizon);
  return std::sqrt(std::clamp(way, 0.0F, 1.0F));
}

void check(const char* what, double found, double low, double high, const char* wanted) {
  if (found >= low && found <= high) return;
  throw InputError(what, number_text(found), wanted);
}

void check(const DaylightSettings& settings) {
  check("azimuth of the sun [rad]", settings.sun_azimuth, -1e6, 1e6, "a number");
  check("elevation of the sun [rad]", settings.sun_elevation, 0, pi / 2 + 1e-9, "0 to pi/2");
  check("turbidity of the air", settings.turbidity, 1, 10, "1 to 10");
  for (const float albedo : settings.ground_albedo) check("albedo of the ground", albedo, 0, 1, "0 to 1");
}

}  // namespace

struct Daylight::Tables {
  Eigen::Vector3f to_sun, sun_irradiance, sky_irradiance;
  Eigen::Vector2f sun_side;  // unit, level, towards the sun
  std::array<Eigen::Vector3f, std::size_t{(sky_rows + 1) * (columns + 1)}> sky;
  std::array<Eigen::Vector3f, std::size_t{(ground_rows + 1) * (columns + 1)}> ground;
  std::array<float, cell_rows + 1> row_edges;                            // sines of elevations, upwards
  std::array<float, cell_rows + 1> row_sums;                             // probability of the rows below
  std::array<std::array<float, cell_columns + 1>, cell_rows> cell_sums;  // of the cells before, in a row

  explicit Tables(const DaylightSettings& settings);
  void fill(const DaylightSettings& settings);
  void fill_cells();
  Eigen::Vector3f look_up(float elevation, float azimuth) const;
  float cell_density(int row, int column) const;
};

Daylight::Tables::Tables(const DaylightSettings& settings) {
  const auto azimuth = static_cast<float>(std::remainder(settings.sun_azimuth, 2 * pi));
  const auto elevation = static_cast<float>(settings.sun_elevation);
  sun_side = {std::cos(azimuth), std::sin(azimuth)};
  to_sun << std::cos(elevation) * sun_side, std::sin(elevation);
  to_sun.normalize();
  fill(settings);
  fill_cells();
}

void Daylight::Tables::fill(const DaylightSettings& settings) {
  const Spectrum albedo = smooth_spectrum(settings.ground_albedo), above = solar_irradiance();
  const double sun_angle = std::max(pi / 2 - settings.sun_elevation, 0.0);
  const Atmosphere air(air_of(settings.turbidity), sun_angle, albedo);
  const Spectrum sun = air.sun_transmittance(0, sun_angle) * above;
  sun_irradiance = linear_srgb(sun);

  const auto each = [&](int rows, bool is_sky, const auto& take) {
    tbb::parallel_for(0, rows + 1, [&](int row) {
      // On the horizon itself a ray would end where rounding has it.
      const double share = std::max(static_cast<double>(row) / rows, 1e-4);
      for (int column = 0; column <= columns; ++column) {
        const double side = static_cast<double>(column) / columns;
        take(row, column, air.along(eye_height, elevation_of(share, is_sky), pi * side * side));
      }
    });
  };
  const auto place = [](int row, int column) {
    return static_cast<std::size_t>(row * (columns + 1) + column);
  };
  std::vector<Spectrum> spectra(sky.size());
  each(sky_rows, true, [&](int row, int column, const SkyLight& light) {
    spectra[place(row, column)] = (light.single + light.multiple) * above;
    sky[place(row, column)] = linear_srgb(spectra[place(row, column)]);
  });

  // Irradiance: trapezes over sin^2/2 and azimuth, twice for the other side.
  Spectrum level = Spectrum::Zero();
  sky_irradiance.setZero();
  for (int row = 0; row < sky_rows; ++row) {
    const double low = std::sin(std::max(elevation_of(static_cast<double>(row) / sky_rows, true), 0.0));
    const double high = std::sin(std::max(elevation_of((row + 1.0) / sky_rows, true), 0.0));
    for (int column = 0; column < columns; ++column) {
      const double turn = pi * (2 * column + 1) / (columns * columns);
      const auto weight = static_cast<float>((high * high - low * low) / 2 * turn * 2 / 4);
      for (const std::size_t corner :
           {place(row, column), place(row, column + 1), place(row + 1, column), place(row + 1, column + 1)}) {
        level += weight * spectra[corner];
        sky_irradiance += weight * sky[corner];
      }
    }
  }
  const Spectrum sent_up = albedo / static_cast<float>(pi) * (level + sun * std::max(to_sun.z(), 0.0F));
  each(ground_rows, false, [&](int row, int column, const SkyLight& light) {
    ground[place(row, column)] =
        linear_srgb((light.single + light.multiple) * above + light.transmittance * sent_up);
  });
}

Eigen::Vector3f Daylight::Tables::look_up(float elevation, float azimuth) const {
  bool is_sky = true;
  const float row_share = share_of(elevation, is_sky);
  const int rows = is_sky ? sky_rows : ground_rows;
  const float row_at = row_share * static_cast<float>(rows);
  const float column_at =
      std::sqrt(std::min(azimuth * static_cast<float>(1 / pi), 1.0F)) * static_cast<float>(columns);
  const int row = std::min(static_cast<int>(row_at), rows - 1);
  const int column = std::min(static_cast<int>(column_at), columns - 1);
  const float r = row_at - static_cast<float>(row), c = column_at - static_cast<float>(column);
  const Eigen::Vector3f* low = (is_sky ? sky.data() : ground.data()) + row * (columns + 1) + column;
  const Eigen::Vector3f* high = low + columns + 1;
  return (1 - r) * ((1 - c) * low[0] + c * low[1]) + r * ((1 - c) * high[0] + c * high[1]);
}

// Rows from nadir to zenith, columns once round from the sun's azimuth.
void Daylight::Tables::fill_cells() {
  for (int row = 0; row <= cell_rows; ++row) {
    const bool is_sky = row >= ground_cells;
    const double share = is_sky ? static_cast<double>(row - ground_cells) / sky_cells
                                : static_cast<double>(ground_cells - row) / ground_cells;
    row_edges[static_cast<std::size_t>(row)] = static_cast<float>(std::sin(elevation_of(share, is_sky)));
  }
  constexpr int parts = 3;  // in either direction of a cell, to find its mean
  std::array<double, cell_rows> row_weights;
  for (int row = 0; row < cell_rows; ++row) {
    const auto r = static_cast<std::size_t>(row);
    auto& sums = cell_sums[r];
    std::array<double, cell_columns> weights;
    double total = 0;
    for (int column = 0; column < cell_columns; ++column) {
      double sum = 0;
      for (int part = 0; part < parts * parts; ++part) {
        const double up = (part / parts + 0.5) / parts, round = (part % parts + 0.5) / parts;
        const double sine = row_edges[r] + up * (row_edges[r + 1] - row_edges[r]);
        const double azimuth =
            2 * pi * std::min((column + round) / cell_columns, 1 - (column + round) / cell_columns);
        sum += luminance(look_up(static_cast<float>(std::asin(sine)), static_cast<float>(azimuth)));
      }
      weights[static_cast<std::size_t>(column)] = sum * (row_edges[r + 1] - row_edges[r]);
      total += weights[static_cast<std::size_t>(column)];
    }
    row_weights[r] = total;
    double before = 0;
    for (int column = 0; column < cell_columns; ++column) {
      sums[static_cast<std::size_t>(column)] = static_cast<float>(before);
      // An even share besides, so that no cell is without.
      before += total > 0 ? 0.98 * weights[static_cast<std::size_t>(column)] / total + 0.02 / cell_columns
                          : 1.0 / cell_columns;
    }
    sums[cell_columns] = 1;
  }
  double above = 0, below = 0;
  for (int row = 0; row < cell_rows; ++row)
    (row < ground_cells ? below : above) += row_weights[static_cast<std::size_t>(row)];
  double before = 0;
  for (int row = 0; row < cell_rows; ++row) {
    const auto r = static_cast<std::size_t>(row);
    const bool is_sky = row >= ground_cells;
    const double even = (row_edges[r + 1] - row_edges[r]) /
                        (is_sky ? 1 - row_edges[ground_cells] : 1 + row_edges[ground_cells]);
    const double all = is_sky ? above : below;
    const double share = all > 0 ? 0.98 * row_weights[r] / all + 0.02 * even : even;
    row_sums[r] = static_cast<float>(before);
    before += share * static_cast<double>(is_sky ? 1 - share_below : share_below);
  }
  row_sums[cell_rows] = 1;
}

float Daylight::Tables::cell_density(int row, int column) const {
  const auto r = static_cast<std::size_t>(row), c = static_cast<std::size_t>(column);
  constexpr auto turn = static_cast<float>(2 * pi / cell_columns);
  return (row_sums[r + 1] - row_sums[r]) * (cell_sums[r][c + 1] - cell_sums[r][c]) /
         ((row_edges[r + 1] - row_edges[r]) * turn);
}

Daylight::Daylight(const DaylightSettings& settings) {
  check(settings);
  tables_ = std::make_shared<Tables>(settings);
}

const Eigen::Vector3f& Daylight::to_sun() const { return tables_->to_sun; }
float Daylight::sun_cosine() const { return static_cast<float>(std::cos(sun_angular_radius)); }
const Eigen::Vector3f& Daylight::sun_irradiance() const { return tables_->sun_irradiance; }
const Eigen::Vector3f& Daylight::sky_irradiance() const { return tables_->sky_irradiance; }
Eigen::Vector3f Daylight::level_irradiance() const {
  return tables_->sky_irradiance + tables_->sun_irradiance * std::max(tables_->to_sun.z(), 0.0F);
}

Eigen::Vector3f Daylight::sky(const Eigen::Vector3f& direction) const {
  const Eigen::Vector2f& side = tables_->sun_side;
  const float along = direction.head<2>().dot(side);
  const float across = direction.y() * side.x() - direction.x() * side.y();
  return tables_->look_up(std::asin(std::clamp(direction.z(), -1.0F, 1.0F)),
                          std::abs(std::atan2(across, along)));
}

Eigen::Vector3f Daylight::sample_sky(const Eigen::Vector2f& random, float& density) const {
  // The step of a sum that holds a number, and how far in it the number lies.
  const auto find = [](const auto& sums, float number, float& inside) {
    const auto last = sums.end() - 1;
    const auto next = std::clamp(std::upper_bound(sums.begin(), sums.end(), number), sums.begin() + 1, last);
    const float width = *next - *(next - 1);
    inside = width > 0 ? std::clamp((number - *(next - 1)) / width, 0.0F, 1.0F) : 0.5F;
    return static_cast<int>(next - sums.begin()) - 1;
  };
  float up = 0, round = 0;
  const int row = find(tables_->row_sums, random.x(), up);
  const auto r = static_cast<std::size_t>(row);
  const int column = find(tables_->cell_sums[r], random.y(), round);
  density = tables_->cell_density(row, column);
  const float sine = tables_->row_edges[r] + up * (tables_->row_edges[r + 1] - tables_->row_edges[r]);
  const float azimuth = (static_cast<float>(column) + round) * static_cast<float>(2 * pi / cell_columns);
  const float across = std::sqrt(std::max(1 - sine * sine, 0.0F));
  const float along = across * std::cos(azimuth), aside = across * std::sin(azimuth);
  const Eigen::Vector2f& side = tables_->sun_side;
  return {along * side.x() - aside * side.y(), along * side.y() + aside * side.x(), sine};
}

float Daylight::sky_density(const Eigen::Vector3f& direction) const {
  const auto& edges = tables_->row_edges;
  const auto next = std::clamp(std::upper_bound(edges.begin(), edges.end(), direction.z()), edges.begin() + 1,
                               edges.end() - 1);
  const Eigen::Vector2f& side = tables_->sun_side;
  const float along = direction.head<2>().dot(side);
  const float across = direction.y() * side.x() - direction.x() * side.y();
  float turn = std::atan2(across, along) * static_cast<float>(1 / (2 * pi));
  if (turn < 0) turn += 1;
  const int column = std::clamp(static_cast<int>(turn * cell_columns), 0, cell_columns - 1);
  return tables_->cell_density(static_cast<int>(next - edges.begin()) - 1, column);
}

}  // namespace tremula
