// Wind from files: fields and spectra.
#include "tremula/io/profile_table.hpp"
#include "tremula/io/spectrum_table.hpp"
#include "tremula/io/turbsim.hpp"
#include "tremula/io/vti.hpp"
#include "tremula/io/wind_plot.hpp"
#include "tremula/pipeline.hpp"
#include "tremula/wind/field_statistics.hpp"

#include <algorithm>
#include <cmath>

#include "finite.hpp"
#include "harness.hpp"
#include "trees.hpp"

namespace tremula::fuzz {
namespace {

// A field made of 16-bit integers again: each velocity within half a step of what it was (and the rounding of
// single precision).
void check_field_round_trip(const WindField& field) {
  const std::string written = bytes_written([&](const std::string& path) { write_turbsim(path, field); });
  TurbSimFile file;
  require(taken([&] { file = parse_turbsim(written, input_name); }), "a TurbSim file of our own is refused");
  const WindField again = wind_field(file);
  for (std::size_t c = 0; c < 3; ++c) {
    const auto [low, high] = std::minmax_element(field.velocity[c].begin(), field.velocity[c].end());
    double size = std::max(std::abs(*low), std::abs(*high)), width = static_cast<double>(*high) - *low;
    for (const float v : field.tower[c]) {
      size = std::max(size, static_cast<double>(std::abs(v)));
      width = std::max({width, static_cast<double>(v) - *low, static_cast<double>(*high) - v});
    }
    const double bound = width / 65535 + 1e-6 * size + 1e-7;
    for (std::size_t i = 0; i < field.velocity[c].size(); ++i)
      require(std::abs(again.velocity[c][i] - field.velocity[c][i]) <= bound,
              "a velocity changes by more than a step when written as TurbSim and read");
  }
  require(bytes_written([&](const std::string& path) { write_turbsim(path, file); }) == written,
          "a TurbSim file written, read and written again has other bytes");
}

void require_finite_velocities(const WindField& field) {
  for (const auto* values : {&field.velocity, &field.tower}) {
    for (const std::vector<float>& component : *values) require_finite(component, "a velocity");
  }
}

}  // namespace

void try_turbsim(std::string_view bytes) {
  TurbSimFile file;
  if (!taken([&] { file = parse_turbsim(bytes, input_name); })) return;
  require(bytes_written([&](const std::string& path) { write_turbsim(path, file); }) == bytes,
          "a TurbSim file read and written has other bytes");
  const WindField field = wind_field(file);
  require_finite_velocities(field);
  check_field_round_trip(field);
}

void try_spectrum(std::string_view bytes) {
  SpectrumTable table;
  if (!taken([&] { table = read_spectrum_table(bytes, input_name); })) return;
  const SpectrumModel model = table_spectrum(table);
  require_finite(spectrum_variance(model), "a variance");
  for (const double frequency : {1e-6, 1e-3, 0.1, 1.0, 30.0, 1e6})
    require_finite(spectrum(model, frequency, 10, 8), "a spectral density");
}

void try_profile(std::string_view bytes) {
  MeanWind wind{.speed = 8, .profile = ProfileKind::table};
  if (!taken([&] { wind.table = read_profile_table(bytes, input_name); })) return;
  require(wind.table.size() >= 2, "a profile of fewer than two rows");
  taken_by_stages([&] {
    check_mean_wind(wind);
    for (const double height : {0.0, 0.1, 10.0, 1e4})
      require_finite(mean_velocity(wind, height), "a mean velocity");
  });
}

void try_wind_file(std::string_view bytes) {
  TurbSimFile file;
  if (!taken([&] { file = parse_turbsim(bytes, input_name); }) || file.values.size() > 2000) return;
  const auto field = std::make_shared<const WindField>(wind_field(file));

  const FieldStatistics statistics = field_statistics(*field);
  for (const RowStatistics& row : statistics.rows) {
    require_finite(row.mean, "a mean");
    require_finite(row.deviation, "a deviation");
    require_finite(std::array{row.turbulence_intensity, row.covariance_uw, row.height}, "a number of a row");
  }
  for (const auto& row : statistics.spectra) {
    for (const RowSpectrum& spectrum : row) {
      require_finite(spectrum.value, "a spectral density");
      require_finite(spectrum.standard_error, "a standard error");
    }
  }
  for (const FieldCoherence& coherence : statistics.coherence) {
    require_finite(coherence.root, "a coherence");
    require_finite(coherence.real, "the real part of a coherence");
  }
  require_finite_text(plot_wind({.title = input_name, .statistics = statistics}));

  if (taken_by_stages([&] { bytes_written([&](const std::string& path) { write_vti(path, *field); }); })) {
    static const Subject subject = bake(test::straight_stem(3, 2, 0.05, 0.02), {.modes = {.count = 3}});
    Weather weather;
    weather.wind = GivenWind{field, 30};
    weather.loop = {field->grid.period(), std::min(32, field->grid.step_count)};
    Motion motion;
    if (taken_by_stages([&] { motion = set_in_motion(subject, weather); })) require_finite(subject, motion);
  }
}

}  // namespace tremula::fuzz
