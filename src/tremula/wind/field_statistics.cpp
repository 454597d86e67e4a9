#include "tremula/wind/field_statistics.hpp"

#include "tremula/base/error.hpp"
#include "tremula/base/number_text.hpp"
#include "tremula/numerics/fft.hpp"
#include "tremula/wind/check_field.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <deque>
#include <numbers>
#include <string>

namespace tremula {
namespace {

// Under a Hann window the powers of neighbouring bins are correlated (by 4/9, of next neighbours by 1/36), so
// that a mean over bins scatters more than over independent ones: by 1 + 2 (4/9 + 1/36).
constexpr double hann_variance_factor = 1 + 2 * (4.0 / 9 + 1.0 / 36);
constexpr int fewest_bins_that_show_their_scatter = 4;

// How the series of a point are cut up, and what makes |coefficient|^2 of a piece a spectral density.
struct Segments {
  int length = 0, count = 1, hop = 0;
  Eigen::ArrayXd window;  // empty: none
  double density = 1;     // S = density |v|^2
};

Segments choose_segments(const WindGrid& grid, int wanted_length) {
  if (grid.periodic) return {.length = grid.step_count, .window = {}, .density = 2 * grid.period()};
  const int length = wanted_length > 0 ? std::min(wanted_length, grid.step_count)
                                       : std::max(grid.step_count / 4, std::min(grid.step_count, 16));
  const int hop = std::max(length / 2, 1);
  Segments segments{
      .length = length, .count = 1 + (grid.step_count - length) / hop, .hop = hop, .window = {}};
  segments.window.resize(length);
  for (int n = 0; n < length; ++n)
    segments.window[n] = 0.5 - 0.5 * std::cos(2 * std::numbers::pi * n / length);
  const double power = std::max(segments.window.square().sum(), 1e-300);
  segments.density = 2 * grid.step * length * length / power;
  return segments;
}

// (steps x points) of one row with the points' means taken out.
struct RowSeries {
  Eigen::MatrixXd fluctuation;
  Eigen::VectorXd mean;
};

RowSeries row_series(const WindField& field, int row, std::size_t component) {
  const WindGrid& grid = field.grid;
  RowSeries series;
  series.fluctuation.resize(grid.step_count, grid.y_count);
  for (int t = 0; t < grid.step_count; ++t) {
    const float* values = field.velocity[component].data() +
                          (static_cast<std::size_t>(t) * static_cast<std::size_t>(grid.z_count) +
                           static_cast<std::size_t>(row)) *
                              static_cast<std::size_t>(grid.y_count);
    for (int j = 0; j < grid.y_count; ++j) series.fluctuation(t, j) = static_cast<double>(values[j]);
  }
  series.mean = series.fluctuation.colwise().mean();
  series.fluctuation.rowwise() -= series.mean.transpose();
  return series;
}

// What one component of one row adds to rows, point_mean and point_deviation.
void add_moments(FieldStatistics& statistics, const WindField& field, int row_index, std::size_t component,
                 const RowSeries& series) {
  RowStatistics& row = statistics.rows[static_cast<std::size_t>(row_index)];
  row.height = field.grid.z(row_index);
  row.mean[component] = series.mean.mean();
  const Eigen::ArrayXd variance = series.fluctuation.cwiseAbs2().colwise().mean().transpose();
  row.deviation[component] = std::sqrt(variance.mean());
  for (Eigen::Index j = 0; j < variance.size(); ++j) {
    statistics.point_mean[component].push_back(series.mean[j]);
    statistics.point_deviation[component].push_back(std::sqrt(variance[j]));
  }
  if (component != 0) return;
  row.turbulence_intensity = row.mean[0] > 0 ? row.deviation[0] / row.mean[0] : 0;
  row.covariance_uw = series.fluctuation.cwiseProduct(row_series(field, row_index, 2).fluctuation).mean();
}

// (bins x points * segments): point j of segment s in column s * points + j.
Eigen::MatrixXcd spectra_of(const Eigen::MatrixXd& fluctuation, const Segments& segments) {
  if (segments.window.size() == 0) return half_spectra_from_samples(fluctuation);
  const Eigen::Index points = fluctuation.cols();
  Eigen::MatrixXd pieces(segments.length, points * segments.count);
  for (int s = 0; s < segments.count; ++s) {
    pieces.middleCols(s * points, points) =
        (fluctuation.middleRows(s * segments.hop, segments.length).array().colwise() * segments.window)
            .matrix();
  }
  return half_spectra_from_samples(pieces);
}

RowSpectrum banded(const Eigen::MatrixXcd& spectra, const std::vector<FrequencyBand>& bands,
                   const Segments& segments) {
  RowSpectrum result;
  for (const FrequencyBand& band : bands) {
    const Eigen::ArrayXd by_bin =
        segments.density *
        spectra.middleRows(band.first_bin, band.bin_count()).cwiseAbs2().rowwise().mean().array();
    const double mean = by_bin.mean(), bins = band.bin_count();
    double variance = mean * mean / bins;  // one point's |v|^2 is exponential: it scatters by its own mean
    if (band.bin_count() >= fewest_bins_that_show_their_scatter)
      variance = (by_bin - mean).square().sum() / ((bins - 1) * bins);
    if (segments.window.size() > 0) variance *= std::min(hann_variance_factor, bins);
    result.value.push_back(mean);
    result.standard_error.push_back(std::sqrt(variance));
  }
  return result;
}

// Adds what the columns of a and the columns of b that lie `shift` points further show of one coherence.
class CoherenceSum {
 public:
  CoherenceSum(const std::vector<FrequencyBand>& bands, Eigen::Index points)
      : bands_(bands),
        points_(points),
        sum_(Eigen::ArrayXcd::Zero(static_cast<Eigen::Index>(bands.size()))) {}

  void add(const Eigen::MatrixXcd& a, const Eigen::MatrixXcd& b, int shift) {
    for (std::size_t i = 0; i < bands_.size(); ++i) {
      std::complex<double> cross = 0;
      double power_a = 0, power_b = 0;
      for (Eigen::Index first = 0; first < a.cols(); first += points_) {
        const auto part_a = a.block(bands_[i].first_bin, first, bands_[i].bin_count(), points_ - shift);
        const auto part_b =
            b.block(bands_[i].first_bin, first + shift, bands_[i].bin_count(), points_ - shift);
        cross += part_b.conjugate().cwiseProduct(part_a).sum();
        power_a += part_a.squaredNorm();
        power_b += part_b.squaredNorm();
      }
      const double power = std::sqrt(power_a * power_b);
      if (power > 0) sum_[static_cast<Eigen::Index>(i)] += cross / power;
    }
    ++rows_;
  }

  void finish(FieldCoherence& coherence) const {
    coherence.pair_count =
        static_cast<std::size_t>(rows_ * (points_ - (coherence.vertical ? 0 : coherence.cells)));
    for (const std::complex<double>& sum : sum_) {
      coherence.root.push_back(std::abs(sum) / static_cast<double>(rows_));
      coherence.real.push_back(sum.real() / static_cast<double>(rows_));
    }
  }

 private:
  const std::vector<FrequencyBand>& bands_;
  Eigen::Index points_, rows_ = 0;
  Eigen::ArrayXcd sum_;
};

std::vector<int> usable(std::vector<int> cells, int point_count, const char* what) {
  for (const int separation : cells) {
    if (separation < 1) throw InputError(what, std::to_string(separation) + " cells", "1 or more");
  }
  std::sort(cells.begin(), cells.end());
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  std::erase_if(cells, [&](int separation) { return separation >= point_count; });
  return cells;
}

}  // namespace

std::vector<FrequencyBand> logarithmic_bands(int last_bin, double resolution, double bands_per_decade) {
  if (!(bands_per_decade >= 1 && bands_per_decade <= 1000))
    throw InputError("bands per decade", number_text(bands_per_decade), "1 to 1000");
  std::vector<FrequencyBand> bands;
  const double ratio = std::pow(10, 1 / bands_per_decade);
  double edge = 0.5;  // between bins
  for (int first = 1; first <= last_bin;) {
    edge = std::max(edge * ratio, first + 0.5);
    const int last = std::min(static_cast<int>(std::floor(std::min(edge, 2e9))), last_bin);
    bands.push_back({first, std::max(first, last), 0.5 * (first + std::max(first, last)) * resolution});
    first = bands.back().last_bin + 1;
  }
  return bands;
}

FieldStatistics field_moments(const WindField& field) {
  check_wind_field(field);
  FieldStatistics statistics;
  statistics.rows.resize(static_cast<std::size_t>(field.grid.z_count));
  for (std::size_t c = 0; c < 3; ++c) {
    for (int i = 0; i < field.grid.z_count; ++i)
      add_moments(statistics, field, i, c, row_series(field, i, c));
  }
  return statistics;
}

FieldStatistics field_statistics(const WindField& field, const FieldStatisticsOptions& options) {
  check_wind_field(field);
  const WindGrid& grid = field.grid;
  if (options.segment_length < 0)
    throw InputError("segment length", std::to_string(options.segment_length), "0 (automatic) or more steps");
  const Segments segments = choose_segments(grid, options.segment_length);

  FieldStatistics statistics;
  statistics.segment_length = segments.length;
  statistics.segment_count = segments.count;
  statistics.resolution = 1 / (segments.length * grid.step);
  // Up to below the Nyquist bin, which is real and stands for half a band.
  statistics.bands =
      logarithmic_bands((segments.length - 1) / 2, statistics.resolution, options.bands_per_decade);
  statistics.rows.resize(static_cast<std::size_t>(grid.z_count));
  statistics.spectra.resize(static_cast<std::size_t>(grid.z_count));
  const std::vector<int> across = usable(options.y_separations, grid.y_count, "separation across"),
                         upward = usable(options.z_separations, grid.z_count, "vertical separation");

  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<CoherenceSum> sums_across(across.size(), CoherenceSum(statistics.bands, grid.y_count)),
        sums_upward(upward.size(), CoherenceSum(statistics.bands, grid.y_count));
    std::deque<Eigen::MatrixXcd> below;  // spectra of the rows that this one is compared with, nearest first
    for (int i = 0; i < grid.z_count; ++i) {
      const RowSeries series = row_series(field, i, c);
      add_moments(statistics, field, i, c, series);
      const Eigen::MatrixXcd spectra = spectra_of(series.fluctuation, segments);
      statistics.spectra[static_cast<std::size_t>(i)][c] = banded(spectra, statistics.bands, segments);
      for (std::size_t k = 0; k < across.size(); ++k) sums_across[k].add(spectra, spectra, across[k]);
      for (std::size_t k = 0; k < upward.size(); ++k) {
        if (upward[k] <= i) sums_upward[k].add(spectra, below[static_cast<std::size_t>(upward[k] - 1)], 0);
      }
      if (upward.empty()) continue;
      below.push_front(spectra);
      if (below.size() > static_cast<std::size_t>(upward.back())) below.pop_back();
    }
    const auto finish = [&](bool vertical, const std::vector<int>& cells,
                            const std::vector<CoherenceSum>& sums) {
      const double spacing = vertical ? grid.z_spacing : grid.y_spacing;
      for (std::size_t k = 0; k < cells.size(); ++k) {
        FieldCoherence coherence{.vertical = vertical,
                                 .cells = cells[k],
                                 .distance = cells[k] * spacing,
                                 .component = c,
                                 .root = {},
                                 .real = {}};
        sums[k].finish(coherence);
        statistics.coherence.push_back(coherence);
      }
    };
    finish(false, across, sums_across);
    finish(true, upward, sums_upward);
  }
  return statistics;
}

}  // namespace tremula
