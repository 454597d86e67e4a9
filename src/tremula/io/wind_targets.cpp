#include "tremula/io/wind_targets.hpp"

#include <algorithm>
#include <cmath>

namespace tremula {
namespace {

// Variances [(m/s)^2] in bins 1 … steps/2, of which the last of an even number is half a bin wide.
Vec3 resolved_variance(const TurbulentWind& wind, const WindGrid& grid, double height) {
  Vec3 sum = Vec3::Zero();
  for (int bin = 1; 2 * bin <= grid.step_count; ++bin) {
    const double width = (2 * bin == grid.step_count ? 0.5 : 1.0) / grid.period();
    sum += width * spectrum_at(wind, height, bin / grid.period());
  }
  return sum;
}

}  // namespace

WindTargets wind_targets(const TurbulentWind& wind, const WindGrid& grid, const FieldStatistics& statistics,
                         bool match_variance) {
  WindTargets targets;
  const Vec3 whole = spectrum_variance(wind.spectrum);
  const std::size_t rows = statistics.rows.size();
  std::vector<double> frequency;
  for (const FrequencyBand& band : statistics.bands) frequency.push_back(band.frequency);

  for (std::size_t row = 0; row < rows; ++row) {
    const double height = statistics.rows[row].height;
    targets.mean.x.push_back(height);
    targets.mean.y.push_back(mean_speed(wind.mean, height));
    const Vec3 resolved = resolved_variance(wind, grid, height);
    Vec3 factor = Vec3::Ones();
    for (int c = 0; c < 3; ++c) {
      if (match_variance && resolved[c] > 0) factor[c] = whole[c] / resolved[c];
      Curve& deviation = targets.deviation[static_cast<std::size_t>(c)];
      deviation.x.push_back(height);
      deviation.y.push_back(std::sqrt(factor[c] * resolved[c]));
      targets.spectra.push_back(
          {.row = row, .component = static_cast<std::size_t>(c), .curve = {.x = frequency, .y = {}}});
    }
    for (const FrequencyBand& band : statistics.bands) {
      Vec3 sum = Vec3::Zero();
      for (int bin = band.first_bin; bin <= band.last_bin; ++bin)
        sum += spectrum_at(wind, height, bin * statistics.resolution);
      for (std::size_t c = 0; c < 3; ++c) {
        const auto component = static_cast<int>(c);
        targets.spectra[3 * row + c].curve.y.push_back(factor[component] * sum[component] / band.bin_count());
      }
    }
  }

  const double middle = rows > 0 ? statistics.rows[rows / 2].height : 0;
  for (const FieldCoherence& pair : statistics.coherence) {
    WindTargets::Coherence wanted{.vertical = pair.vertical,
                                  .cells = pair.cells,
                                  .component = pair.component,
                                  .curve = {.x = frequency, .y = {}}};
    const auto component = static_cast<int>(pair.component);
    for (const FrequencyBand& band : statistics.bands) {
      double cross = 0, power = 0;
      for (int bin = band.first_bin; bin <= band.last_bin; ++bin) {
        const double f = bin * statistics.resolution, s = spectrum_at(wind, middle, f)[component];
        cross += s * root_coherence(wind.coherence, component, f, pair.vertical ? 0 : pair.distance,
                                    pair.vertical ? pair.distance : 0);
        power += s;
      }
      wanted.curve.y.push_back(power > 0 ? cross / power : 0);
    }
    targets.coherence.push_back(std::move(wanted));
  }
  return targets;
}

}  // namespace tremula
