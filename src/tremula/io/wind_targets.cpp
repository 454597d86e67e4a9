#include "tremula/io/wind_targets.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tremula {
namespace {

// Of u, v, w along and across the wind of a height: variances [(m/s)^2], and the covariance of u and w.
struct Power {
  Vec3 variance = Vec3::Zero();
  double covariance = 0;

  void add(const Vec3& spectrum, double width, double coherency) {
    variance += width * spectrum;
    covariance += width * coherency * std::sqrt(spectrum[0] * spectrum[2]);
  }
  // The same of u and v along and across another direction.
  Power turned(double degrees) const {
    const double c = std::cos(degrees * std::numbers::pi / 180),
                 s = std::sin(degrees * std::numbers::pi / 180);
    return {
        {c * c * variance[0] + s * s * variance[1], s * s * variance[0] + c * c * variance[1], variance[2]},
        c * covariance};
  }
  Power times(const Vec3& factor) const {  // of amplitudes
    return {variance.cwiseProduct(factor.cwiseAbs2()), factor[0] * factor[2] * covariance};
  }
};

// In bins 1 … steps/2, of which the last of an even number is half a bin wide.
Power resolved_power(const TurbulentWind& wind, const WindGrid& grid, double height, double coherency) {
  Power sum;
  for (int bin = 1; 2 * bin <= grid.step_count; ++bin) {
    const double width = (2 * bin == grid.step_count ? 0.5 : 1.0) / grid.period();
    sum.add(spectrum_at(wind, height, bin / grid.period()), width, coherency);
  }
  return sum;
}

Vec3 match_factors(const Vec3& whole, const Vec3& resolved) {
  Vec3 factor = Vec3::Ones();
  for (int c = 0; c < 3; ++c) {
    if (resolved[c] > 0) factor[c] = std::sqrt(whole[c] / resolved[c]);
  }
  return factor;
}

}  // namespace

WindTargets wind_targets(const TurbulentWind& wind, const WindGrid& grid, const FieldStatistics& statistics,
                         Match match) {
  WindTargets targets;
  const Vec3 whole = spectrum_variance(wind.spectrum);
  const double coherency = coherency_uw(wind);
  const std::size_t rows = statistics.rows.size();
  std::vector<double> frequency;
  for (const FrequencyBand& band : statistics.bands) frequency.push_back(band.frequency);
  WindGrid hub_grid = grid;
  hub_grid.reference_height = wind.mean.reference_height;
  const double hub_height = grid.z(hub_point(hub_grid)[0]);
  const Vec3 resolved_at_hub = resolved_power(wind, grid, hub_height, coherency).variance,
             at_hub = match_factors(whole, resolved_at_hub);
  for (int c = 0; c < 3; ++c) {
    if (whole[c] > 0) targets.resolved_share[static_cast<std::size_t>(c)] = resolved_at_hub[c] / whole[c];
  }

  for (std::size_t row = 0; row < rows; ++row) {
    const double height = statistics.rows[row].height, turn = veer(wind.mean, height),
                 speed = mean_speed(wind.mean, height);
    const Power resolved = resolved_power(wind, grid, height, coherency);
    const Vec3 factor = match == Match::spectrum ? Vec3(Vec3::Ones())
                        : match == Match::hub    ? at_hub
                                                 : match_factors(whole, resolved.variance);
    const Power wanted = resolved.times(factor).turned(turn);
    const auto add = [height](Curve& curve, double value) {
      curve.x.push_back(height);
      curve.y.push_back(value);
    };
    add(targets.mean, speed * std::cos(turn * std::numbers::pi / 180));
    add(targets.mean_across, speed * std::sin(turn * std::numbers::pi / 180));
    add(targets.covariance, wanted.covariance);
    for (std::size_t c = 0; c < 3; ++c) {
      add(targets.deviation[c], std::sqrt(wanted.variance[static_cast<int>(c)]));
      targets.spectra.push_back({.row = row, .component = c, .curve = {.x = frequency, .y = {}}});
    }
    for (const FrequencyBand& band : statistics.bands) {
      Power density;
      for (int bin = band.first_bin; bin <= band.last_bin; ++bin)
        density.add(spectrum_at(wind, height, bin * statistics.resolution), 1.0 / band.bin_count(),
                    coherency);
      density = density.times(factor).turned(turn);
      for (std::size_t c = 0; c < 3; ++c)
        targets.spectra[3 * row + c].curve.y.push_back(density.variance[static_cast<int>(c)]);
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
