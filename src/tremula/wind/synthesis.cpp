#include "tremula/wind/synthesis.hpp"

#include "tremula/base/error.hpp"
#include "tremula/numerics/fft.hpp"
#include "tremula/numerics/time_axis.hpp"
#include "tremula/wind/coherent_plane.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <complex>
#include <map>
#include <memory>
#include <numbers>
#include <string>
#include <utility>

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

namespace tremula {
namespace {

using Complex = std::complex<float>;

constexpr RandomStream streams[3] = {RandomStream::wind_u, RandomStream::wind_v, RandomStream::wind_w};

// Neighbours with less root-coherence than this are drawn independently.
constexpr double negligible_coherence = 1e-3;

// Points go through the transform in time this many at once: 256 bytes of a bin, and what a core's cache
// holds.
constexpr std::size_t tile_points = 32;

// sqrt(S/(2T)) for every bin and row, of all components.
struct RowAmplitudes {
  int rows = 0;
  std::array<std::vector<float>, 3> of = {};                  // (bins x rows)
  std::array<std::vector<double>, 3> resolved_variance = {};  // (rows)

  const float* at(int component, int bin) const {
    return of[static_cast<std::size_t>(component)].data() + static_cast<std::ptrdiff_t>(bin) * rows;
  }
};

RowAmplitudes row_amplitudes(const TurbulentWind& wind, const WindGrid& grid, const TimeAxis& axis) {
  RowAmplitudes result{.rows = grid.z_count};
  const auto size = static_cast<std::size_t>(axis.bin_count()) * static_cast<std::size_t>(grid.z_count);
  for (std::size_t c = 0; c < 3; ++c) {
    result.of[c].assign(size, 0.0F);
    result.resolved_variance[c].assign(static_cast<std::size_t>(grid.z_count), 0.0);
  }
  std::vector<double> heights, speeds;
  for (int i = 0; i < grid.z_count; ++i) {
    heights.push_back(std::max(grid.z(i), lowest_spectrum_height));
    speeds.push_back(mean_speed(wind.mean, heights.back()));
  }
  tbb::parallel_for(
      tbb::blocked_range<int>(1, axis.bin_count(), 64), [&](const tbb::blocked_range<int>& bins) {
        for (int bin = bins.begin(); bin < bins.end(); ++bin) {
          for (int i = 0; i < grid.z_count; ++i) {
            const auto row = static_cast<std::size_t>(i);
            const Vec3 s = spectrum(wind.spectrum, axis.frequency(bin), heights[row], speeds[row]);
            const std::size_t at =
                static_cast<std::size_t>(bin) * static_cast<std::size_t>(grid.z_count) + row;
            for (std::size_t c = 0; c < 3; ++c) {
              result.of[c][at] = static_cast<float>(std::sqrt(s[static_cast<int>(c)] / (2 * axis.period)));
            }
          }
        }
      });
  for (int bin = 1; bin < axis.bin_count(); ++bin) {
    const double sides = 2 * bin == axis.sample_count ? 1 : 2;
    for (int c = 0; c < 3; ++c) {
      for (int i = 0; i < grid.z_count; ++i) {
        const auto amplitude = static_cast<double>(result.at(c, bin)[i]);
        result.resolved_variance[static_cast<std::size_t>(c)][static_cast<std::size_t>(i)] +=
            sides * amplitude * amplitude;
      }
    }
  }
  return result;
}

// One or two neighbouring bins of one component, drawn on one periodic plane; no plane: white in space.
struct Job {
  int first_bin = 1, bin_count = 1;
  const CoherentPlane* plane = nullptr;
};

class Planes {
 public:
  explicit Planes(int kept_rows) : kept_rows_(kept_rows) {}

  const CoherentPlane& of_size(int rows, int columns) {
    auto& plane = planes_[{rows, columns}];
    if (!plane) plane = std::make_unique<CoherentPlane>(rows, columns, kept_rows_);
    return *plane;
  }

  const auto& all() const { return planes_; }

 private:
  int kept_rows_;
  std::map<std::pair<int, int>, std::unique_ptr<CoherentPlane>> planes_;
};

std::vector<Job> plan_jobs(const TurbulentWind& wind, const WindGrid& grid, const TimeAxis& axis,
                           int component, const SynthesisOptions& options, Planes& planes) {
  std::vector<Job> jobs;
  for (int bin = 1; bin < axis.bin_count(); bin += jobs.back().bin_count) {
    const CoherenceDecay decay = coherence_decay(wind.coherence, component, axis.frequency(bin));
    const bool white =
        (grid.y_count == 1 || root_coherence(decay, grid.y_spacing, 0) < negligible_coherence) &&
        (grid.z_count == 1 || root_coherence(decay, 0, grid.z_spacing) < negligible_coherence);
    if (white) {
      jobs.push_back({bin, 1, nullptr});
      continue;
    }
    int rows = grid.z_count, columns = grid.y_count;
    if (!options.tile) {
      rows = fast_length(periodic_length(rows, grid.z_spacing, decay.z, options.padding_tolerance));
      columns = fast_length(periodic_length(columns, grid.y_spacing, decay.y, options.padding_tolerance));
    }
    // Coherence falls with frequency: what is wide enough for the first is so for the second.
    jobs.push_back({bin, std::min(2, axis.bin_count() - bin), &planes.of_size(rows, columns)});
  }
  return jobs;
}

// Fourier coefficients of one component: (tiles x bins x tile_points), so that a tile is one piece of memory.
struct Coefficients {
  std::size_t points, bins, tiles;
  std::unique_ptr<Complex[]> values;

  Coefficients(std::size_t point_count, std::size_t bin_count)
      : points(point_count),
        bins(bin_count),
        tiles((point_count + tile_points - 1) / tile_points),
        values(new Complex[tiles * bins * tile_points]) {}

  Complex* at(std::size_t tile, std::size_t bin) { return values.get() + (tile * bins + bin) * tile_points; }

  void store(std::size_t bin, const Complex* of_points) {
    for (std::size_t tile = 0; tile < tiles; ++tile) {
      const std::size_t first = tile * tile_points, count = std::min(tile_points, points - first);
      std::fill(std::copy_n(of_points + first, count, at(tile, bin)), at(tile, bin) + tile_points,
                Complex(0));
    }
  }
};

// How much is done, of all components. Drawing a component takes about twice as long as summing it in time.
class Meter {
 public:
  explicit Meter(const std::function<void(double)>& tell) : tell_(tell) {}
  void drawn(std::size_t jobs, std::size_t of) { add(2.0 / 9, jobs, of); }
  void summed(std::size_t tiles, std::size_t of) { add(1.0 / 9, tiles, of); }

 private:
  const std::function<void(double)>& tell_;
  std::atomic<double> done_ = 0;

  void add(double share, std::size_t part, std::size_t of) {
    if (tell_) tell_(done_ += share * static_cast<double>(part) / static_cast<double>(of));
  }
};

struct BinWork {
  CoherentPlaneWork plane;
  std::vector<Complex> window;
};

struct Clipped {
  double largest = 0, weighted = 0, weights = 0;
};

void draw_coefficients(const TurbulentWind& wind, const WindGrid& grid, const TimeAxis& axis, int component,
                       const RowAmplitudes& amplitudes, const std::vector<double>& row_factors,
                       const std::vector<Job>& jobs, Coefficients& coefficients, SynthesisReport& report,
                       Meter& meter) {
  std::vector<std::array<double, 2>> clipped(jobs.size());
  tbb::enumerable_thread_specific<BinWork> works;
  const auto columns = static_cast<std::size_t>(grid.y_count);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, jobs.size(), 8), [&](const auto& range) {
    BinWork& work = works.local();
    work.window.resize(grid.point_count());
    for (std::size_t j = range.begin(); j < range.end(); ++j) {
      const Job& job = jobs[j];
      if (job.plane != nullptr) {
        std::array<CoherenceDecay, 2> decays;
        for (int k = 0; k < 2; ++k) {
          const int bin = job.first_bin + std::min(k, job.bin_count - 1);
          decays[static_cast<std::size_t>(k)] =
              coherence_decay(wind.coherence, component, axis.frequency(bin));
        }
        job.plane->set_coherences(decays, grid.z_spacing, grid.y_spacing, work.plane);
        clipped[j] = work.plane.clipped_share;
      }
      for (int k = 0; k < job.bin_count; ++k) {
        const int bin = job.first_bin + k;
        const auto stream_bin = static_cast<std::uint32_t>(bin);
        const Complex* source = work.window.data();
        std::size_t pitch = columns;
        float scale = 1;
        if (job.plane == nullptr) {
          draw_noise(wind.amplitudes, wind.seed, streams[component], stream_bin, grid.point_count(),
                     work.window.data());
        } else {
          job.plane->draw(wind.amplitudes, wind.seed, streams[component], stream_bin, k, work.plane);
          source = work.plane.plane.data();
          pitch = static_cast<std::size_t>(job.plane->pitch());
          scale = work.plane.scale[static_cast<std::size_t>(k)];
        }
        // The coefficient at half the sampling rate is real and carries its power alone.
        const bool real = 2 * bin == axis.sample_count;
        for (std::size_t row = 0; row < row_factors.size(); ++row) {
          const float factor =
              scale * static_cast<float>(row_factors[row]) * amplitudes.at(component, bin)[row];
          for (std::size_t i = 0; i < columns; ++i) {
            const Complex value = factor * source[row * pitch + i];
            work.window[row * columns + i] = real ? std::numbers::sqrt2_v<float> * value.real() : value;
          }
        }
        coefficients.store(static_cast<std::size_t>(bin), work.window.data());
      }
    }
    meter.drawn(range.size(), jobs.size());
  });

  const auto c = static_cast<std::size_t>(component);
  double weights = 0, weighted = 0;
  for (std::size_t j = 0; j < jobs.size(); ++j) {
    for (int k = 0; k < jobs[j].bin_count; ++k) {
      const double share = clipped[j][static_cast<std::size_t>(k)];
      const double amplitude = static_cast<double>(
          amplitudes.at(component, jobs[j].first_bin + k)[static_cast<std::size_t>(grid.z_count / 2)]);
      report.clipped_share[c] = std::max(report.clipped_share[c], share);
      weights += amplitude * amplitude;
      weighted += amplitude * amplitude * share;
    }
  }
  if (weights > 0) report.mean_clipped_share[c] = weighted / weights;
}

void sum_in_time(const TimeAxis& axis, Coefficients& coefficients, std::vector<float>& velocity,
                 Meter& meter) {
  struct Work {
    FftArray<Complex> spectra;
    FftArray<float> samples;
  };
  const auto steps = static_cast<std::size_t>(axis.sample_count);
  const RealSeries series(axis.sample_count, tile_points);
  const auto pitch = static_cast<std::size_t>(series.pitch());
  const std::size_t points = coefficients.points, bins = coefficients.bins;
  tbb::enumerable_thread_specific<Work> works;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, coefficients.tiles, 1), [&](const auto& range) {
    Work& work = works.local();
    work.spectra.resize(tile_points * bins);
    work.samples.resize(tile_points * pitch);
    for (std::size_t tile = range.begin(); tile < range.end(); ++tile) {
      const std::size_t first = tile * tile_points, count = std::min(tile_points, points - first);
      for (std::size_t bin = 0; bin < bins; ++bin) {
        const Complex* of_points = coefficients.at(tile, bin);
        for (std::size_t i = 0; i < tile_points; ++i) work.spectra[i * bins + bin] = of_points[i];
      }
      series.sum(work.spectra.data(), work.samples.data());
      for (std::size_t step = 0; step < steps; ++step) {
        float* row = velocity.data() + step * points + first;
        for (std::size_t i = 0; i < count; ++i) row[i] = work.samples[i * pitch + step];
      }
    }
    meter.summed(range.size(), coefficients.tiles);
  });
}

// Looks at the first bin of every domain size, where the coherence reaches furthest.
double coherence_error(const TurbulentWind& wind, const WindGrid& grid, const TimeAxis& axis, int component,
                       const std::vector<Job>& jobs) {
  double largest = 0;
  CoherentPlaneWork work;
  for (std::size_t j = 0; j < jobs.size(); ++j) {
    const CoherentPlane* plane = jobs[j].plane;
    if (plane == nullptr || (j > 0 && plane == jobs[j - 1].plane)) continue;
    const CoherenceDecay decay =
        coherence_decay(wind.coherence, component, axis.frequency(jobs[j].first_bin));
    const std::array decays = {decay, decay};
    plane->set_coherences(decays, grid.z_spacing, grid.y_spacing, work);
    largest = std::max(largest, plane->coherence_error(decays, grid.z_spacing, grid.y_spacing, grid.z_count,
                                                       grid.y_count, work)[0]);
  }
  return largest;
}

}  // namespace

void check_wind_grid(const WindGrid& grid) {
  const auto check = [](bool good, const char* what, double value, const char* wanted) {
    if (!good || !std::isfinite(value)) throw InputError(what, std::to_string(value), wanted);
  };
  check(grid.y_count >= 1, "points across the wind", grid.y_count, "1 or more");
  check(grid.z_count >= 1, "points above each other", grid.z_count, "1 or more");
  check(grid.step_count >= 1, "time steps", grid.step_count, "1 or more");
  check(grid.y_spacing > 0, "spacing across the wind", grid.y_spacing, "above 0 m");
  check(grid.z_spacing > 0, "spacing of heights", grid.z_spacing, "above 0 m");
  check(grid.bottom > 0, "height of the lowest row", grid.bottom, "above 0 m");
  check(grid.step > 0, "time step", grid.step, "above 0 s");
  const double samples = static_cast<double>(grid.y_count) * grid.z_count * grid.step_count;
  check(samples <= 0x1p31, "points times time steps", samples, "at most 2147483648");
}

WindField synthesise_wind(const TurbulentWind& wind, const WindGrid& grid, const SynthesisOptions& options,
                          SynthesisReport* report_wanted) {
  check_turbulent_wind(wind);
  check_wind_grid(grid);
  if (!(options.padding_tolerance > 0 && options.padding_tolerance < 1)) {
    throw InputError("padding tolerance", std::to_string(options.padding_tolerance), "between 0 and 1");
  }
  WindField field{.grid = grid, .velocity = {}};
  field.grid.mean_speed = wind.mean.speed;
  field.grid.reference_height = wind.mean.reference_height;
  field.grid.periodic = true;

  const TimeAxis axis{grid.period(), grid.step_count};
  const RowAmplitudes amplitudes = row_amplitudes(wind, grid, axis);
  const Vec3 variance = spectrum_variance(wind.spectrum);
  SynthesisReport report;
  Meter meter(options.progress);
  Planes planes(grid.z_count);
  const auto rows = static_cast<std::size_t>(grid.z_count), columns = static_cast<std::size_t>(grid.y_count);
  Coefficients coefficients(grid.point_count(), static_cast<std::size_t>(axis.bin_count()));
  for (int component = 0; component < 3; ++component) {
    const auto c = static_cast<std::size_t>(component);
    std::vector<double> factors(rows, 1.0);
    report.resolved_share[c].assign(rows, 0.0);
    for (std::size_t row = 0; row < rows; ++row) {
      const double resolved = amplitudes.resolved_variance[c][row];
      if (resolved <= 0) continue;
      report.resolved_share[c][row] = resolved / variance[component];
      if (options.match_variance) factors[row] = std::sqrt(variance[component] / resolved);
    }
    const std::vector<Job> jobs = plan_jobs(wind, grid, axis, component, options, planes);
    std::vector<Complex> mean(grid.point_count());
    if (component == 0) {
      for (std::size_t k = 0; k < mean.size(); ++k) {
        mean[k] = static_cast<float>(mean_speed(wind.mean, grid.z(static_cast<int>(k / columns))));
      }
    }
    coefficients.store(0, mean.data());
    draw_coefficients(wind, grid, axis, component, amplitudes, factors, jobs, coefficients, report, meter);
    field.velocity[c].resize(grid.point_count() * static_cast<std::size_t>(grid.step_count));
    sum_in_time(axis, coefficients, field.velocity[c], meter);
    if (report_wanted != nullptr && !options.tile) {
      report.coherence_error[c] = coherence_error(wind, grid, axis, component, jobs);
    }
  }
  for (const auto& [size, plane] : planes.all()) {
    report.largest_rows = std::max(report.largest_rows, size.first);
    report.largest_columns = std::max(report.largest_columns, size.second);
  }
  if (report_wanted != nullptr) *report_wanted = std::move(report);
  return field;
}

}  // namespace tremula
