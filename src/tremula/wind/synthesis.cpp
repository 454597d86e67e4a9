#include "tremula/wind/synthesis.hpp"

#include "tremula/base/error.hpp"
#include "tremula/base/number_text.hpp"
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

// Places of the coherent plane: those of the grid, and of what a tower adds below it. Points are numbered
// through the grid and then down the tower.
struct Lattice {
  int rows = 1, columns = 1;
  int below = 0;   // rows under the lowest of the grid
  int stride = 1;  // columns from one of the grid to the next: 2 where the tower stands between two of them
  double row_spacing = 1, column_spacing = 1, bottom = 1;
  WindGrid grid;
  int tower_count = 0;

  double z(int row) const { return bottom + row * row_spacing; }
  std::size_t place_count() const {
    return static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns);
  }
  std::size_t point_count() const { return grid.point_count() + static_cast<std::size_t>(tower_count); }
  int row_of_point(std::size_t point) const {
    const std::size_t on_grid = grid.point_count();
    if (point < on_grid) return below + static_cast<int>(point / static_cast<std::size_t>(grid.y_count));
    return below - static_cast<int>(point - on_grid);
  }
};

Lattice lattice_of(const WindGrid& grid, int tower_count) {
  Lattice lattice{.rows = grid.z_count,
                  .columns = grid.y_count,
                  .row_spacing = grid.z_spacing,
                  .column_spacing = grid.y_spacing,
                  .bottom = grid.bottom,
                  .grid = grid,
                  .tower_count = tower_count};
  if (tower_count == 0) return lattice;
  lattice.below = tower_count - 1;
  lattice.rows += lattice.below;
  lattice.bottom -= lattice.below * grid.z_spacing;
  if (grid.y_count % 2 == 0) {
    lattice.stride = 2;
    lattice.columns = 2 * grid.y_count - 1;
    lattice.column_spacing /= 2;
  }
  return lattice;
}

// sqrt(S/(2T)) for every bin and row, of all components.
struct RowAmplitudes {
  int rows = 0;
  std::array<std::vector<float>, 3> of = {};                  // (bins x rows)
  std::array<std::vector<double>, 3> resolved_variance = {};  // (rows)

  const float* at(int component, int bin) const {
    return of[static_cast<std::size_t>(component)].data() + static_cast<std::ptrdiff_t>(bin) * rows;
  }
};

RowAmplitudes row_amplitudes(const TurbulentWind& wind, const Lattice& lattice, const TimeAxis& axis) {
  const auto rows = static_cast<std::size_t>(lattice.rows);
  RowAmplitudes result{.rows = lattice.rows};
  for (std::size_t c = 0; c < 3; ++c) {
    result.of[c].assign(static_cast<std::size_t>(axis.bin_count()) * rows, 0.0F);
    result.resolved_variance[c].assign(rows, 0.0);
  }
  std::vector<double> heights, speeds;
  for (int i = 0; i < lattice.rows; ++i) {
    heights.push_back(std::max(lattice.z(i), lowest_spectrum_height));
    speeds.push_back(mean_speed(wind.mean, heights.back()));
  }
  tbb::parallel_for(
      tbb::blocked_range<int>(1, axis.bin_count(), 64), [&](const tbb::blocked_range<int>& bins) {
        for (int bin = bins.begin(); bin < bins.end(); ++bin) {
          for (std::size_t row = 0; row < rows; ++row) {
            const Vec3 s = spectrum(wind.spectrum, axis.frequency(bin), heights[row], speeds[row]);
            const std::size_t at = static_cast<std::size_t>(bin) * rows + row;
            for (std::size_t c = 0; c < 3; ++c) {
              result.of[c][at] = static_cast<float>(std::sqrt(s[static_cast<int>(c)] / (2 * axis.period)));
            }
          }
        }
      });
  for (int bin = 1; bin < axis.bin_count(); ++bin) {
    const double sides = 2 * bin == axis.sample_count ? 1 : 2;
    for (int c = 0; c < 3; ++c) {
      for (std::size_t row = 0; row < rows; ++row) {
        const auto amplitude = static_cast<double>(result.at(c, bin)[row]);
        result.resolved_variance[static_cast<std::size_t>(c)][row] += sides * amplitude * amplitude;
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

// Which components' noise is shared out over the same places as this one's.
std::vector<int> drawn_together(int component, double coherency) {
  if (coherency == 0 || component == 1) return {component};
  return {0, 2};
}

std::vector<Job> plan_jobs(const TurbulentWind& wind, const Lattice& lattice, const TimeAxis& axis,
                           const std::vector<int>& components, const SynthesisOptions& options,
                           Planes& planes) {
  std::vector<Job> jobs;
  for (int bin = 1; bin < axis.bin_count(); bin += jobs.back().bin_count) {
    CoherenceDecay decay = coherence_decay(wind.coherence, components[0], axis.frequency(bin));
    for (const int component : components) {
      const CoherenceDecay of_component = coherence_decay(wind.coherence, component, axis.frequency(bin));
      decay = {std::min(decay.y, of_component.y), std::min(decay.z, of_component.z)};
    }
    const bool white =
        (lattice.columns == 1 || root_coherence(decay, lattice.column_spacing, 0) < negligible_coherence) &&
        (lattice.rows == 1 || root_coherence(decay, 0, lattice.row_spacing) < negligible_coherence);
    if (white) {
      jobs.push_back({bin, 1, nullptr});
      continue;
    }
    int rows = lattice.rows, columns = lattice.columns;
    if (!options.tile) {
      rows = fast_length(periodic_length(rows, lattice.row_spacing, decay.z, options.padding_tolerance));
      columns =
          fast_length(periodic_length(columns, lattice.column_spacing, decay.y, options.padding_tolerance));
    }
    // Coherence falls with frequency: what is wide enough for the first is so for the second.
    const int bins = components.size() > 1 ? 1 : std::min(2, axis.bin_count() - bin);
    jobs.push_back({bin, bins, &planes.of_size(rows, columns)});
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
  std::vector<Complex> places, window;
};

// What the drawing of one component needs to know.
struct Drawing {
  const TurbulentWind& wind;
  const Lattice& lattice;
  const TimeAxis& axis;
  int component = 0;
  double coherency = 0;  // with u, of w
  const RowAmplitudes& amplitudes;
  const std::vector<double>& row_factors;

  Noise noise(int bin) const {
    return {.amplitudes = wind.amplitudes,
            .seed = wind.seed,
            .stream = streams[component],
            .bin = static_cast<std::uint32_t>(bin),
            .shared = component == 2 ? coherency : 0};
  }

  // The coherences of a job: of its two bins, or of u and w in its one.
  std::array<CoherenceDecay, 2> decays(const Job& job) const {
    const double first = axis.frequency(job.first_bin);
    if (noise(0).shared != 0)
      return {coherence_decay(wind.coherence, 0, first), coherence_decay(wind.coherence, 2, first)};
    return {coherence_decay(wind.coherence, component, first),
            coherence_decay(wind.coherence, component, axis.frequency(job.first_bin + job.bin_count - 1))};
  }

  // From unit places (rows at a pitch) to the coefficients of the points.
  void take_points(int bin, const Complex* places, std::size_t pitch, float scale, Complex* points) const {
    // The coefficient at half the sampling rate is real and carries its power alone.
    const bool real = 2 * bin == axis.sample_count;
    const auto take_row = [&](int row, int first, int last, int stride) {
      const auto at = static_cast<std::size_t>(row);
      const float factor = scale * static_cast<float>(row_factors[at]) * amplitudes.at(component, bin)[at];
      const Complex* from = places + at * pitch;
      for (int column = first; column <= last; column += stride) {
        const Complex value = factor * from[column];
        *points++ = real ? std::numbers::sqrt2_v<float> * value.real() : value;
      }
    };
    for (int row = lattice.below; row < lattice.rows; ++row)
      take_row(row, 0, lattice.columns - 1, lattice.stride);
    const int middle = lattice.columns / 2;
    for (int k = 0; k < lattice.tower_count; ++k) take_row(lattice.below - k, middle, middle, 1);
  }
};

void draw_coefficients(const Drawing& drawing, const std::vector<Job>& jobs, Coefficients& coefficients,
                       SynthesisReport& report, Meter& meter) {
  const Lattice& lattice = drawing.lattice;
  std::vector<std::array<double, 2>> clipped(jobs.size());
  tbb::enumerable_thread_specific<BinWork> works;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, jobs.size(), 8), [&](const auto& range) {
    BinWork& work = works.local();
    work.window.resize(lattice.point_count());
    for (std::size_t j = range.begin(); j < range.end(); ++j) {
      const Job& job = jobs[j];
      const bool shares = drawing.noise(0).shared != 0;
      double shared = drawing.noise(0).shared;
      if (job.plane != nullptr) {
        job.plane->set_coherences(drawing.decays(job), lattice.row_spacing, lattice.column_spacing,
                                  work.plane);
        clipped[j] = work.plane.clipped_share;
        if (shares) {
          std::swap(clipped[j][0], clipped[j][1]);
          shared = std::clamp(shared / job.plane->likeness(work.plane), -1.0, 1.0);
        }
      }
      for (int k = 0; k < job.bin_count; ++k) {
        const int bin = job.first_bin + k, which = shares ? 1 : k;
        Noise noise = drawing.noise(bin);
        noise.shared = shared;
        if (job.plane == nullptr) {
          work.places.resize(lattice.place_count());
          draw_noise(noise, work.places.size(), work.places.data());
          drawing.take_points(bin, work.places.data(), static_cast<std::size_t>(lattice.columns), 1,
                              work.window.data());
        } else {
          job.plane->draw(noise, which, work.plane);
          drawing.take_points(bin, work.plane.plane.data(), static_cast<std::size_t>(job.plane->pitch()),
                              work.plane.scale[static_cast<std::size_t>(which)], work.window.data());
        }
        coefficients.store(static_cast<std::size_t>(bin), work.window.data());
      }
    }
    meter.drawn(range.size(), jobs.size());
  });

  const auto c = static_cast<std::size_t>(drawing.component);
  const auto middle = static_cast<std::size_t>(lattice.below + lattice.grid.z_count / 2);
  double weights = 0, weighted = 0;
  for (std::size_t j = 0; j < jobs.size(); ++j) {
    for (int k = 0; k < jobs[j].bin_count; ++k) {
      const double share = clipped[j][static_cast<std::size_t>(k)];
      const auto amplitude =
          static_cast<double>(drawing.amplitudes.at(drawing.component, jobs[j].first_bin + k)[middle]);
      report.clipped_share[c] = std::max(report.clipped_share[c], share);
      weights += amplitude * amplitude;
      weighted += amplitude * amplitude * share;
    }
  }
  if (weights > 0) report.mean_clipped_share[c] = weighted / weights;
}

// Scales the fluctuations so that at the hub, or at every point, they have this variance in the loop.
std::array<double, 2> match_sample(Match match, std::size_t hub, const TimeAxis& axis, double variance,
                                   Coefficients& coefficients) {
  std::vector<double> found(coefficients.tiles * tile_points, 0.0);
  for (std::size_t tile = 0; tile < coefficients.tiles; ++tile) {
    for (int bin = 1; bin < axis.bin_count(); ++bin) {
      const double sides = 2 * bin == axis.sample_count ? 1 : 2;
      const Complex* values = coefficients.at(tile, static_cast<std::size_t>(bin));
      for (std::size_t i = 0; i < tile_points; ++i)
        found[tile * tile_points + i] += sides * static_cast<double>(std::norm(values[i]));
    }
  }
  const auto factor_of = [&](std::size_t point) {
    const double sample = found[match == Match::hub ? hub : point];
    return sample > 0 ? std::sqrt(variance / sample) : 1.0;
  };
  std::array<double, 2> range{factor_of(hub), factor_of(hub)};
  for (std::size_t tile = 0; tile < coefficients.tiles; ++tile) {
    std::array<float, tile_points> factors{};
    for (std::size_t i = 0; i < tile_points; ++i) {
      const std::size_t point = tile * tile_points + i;
      if (point >= coefficients.points) continue;
      const double factor = factor_of(point);
      range = {std::min(range[0], factor), std::max(range[1], factor)};
      factors[i] = static_cast<float>(factor);
    }
    for (int bin = 1; bin < axis.bin_count(); ++bin) {
      Complex* values = coefficients.at(tile, static_cast<std::size_t>(bin));
      for (std::size_t i = 0; i < tile_points; ++i) values[i] *= factors[i];
    }
  }
  return range;
}

// The points in time: those of the grid, and the rest, which is the tower.
void sum_in_time(const TimeAxis& axis, std::size_t grid_points, Coefficients& coefficients,
                 std::vector<float>& velocity, std::vector<float>& tower, Meter& meter) {
  struct Work {
    FftArray<Complex> spectra;
    FftArray<float> samples;
  };
  const auto steps = static_cast<std::size_t>(axis.sample_count);
  const RealSeries series(axis.sample_count, tile_points);
  const auto pitch = static_cast<std::size_t>(series.pitch());
  const std::size_t points = coefficients.points, bins = coefficients.bins, towers = points - grid_points;
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
      const std::size_t on_grid = std::min(count, grid_points - std::min(first, grid_points));
      for (std::size_t step = 0; step < steps; ++step) {
        float* row = velocity.data() + step * grid_points + first;
        for (std::size_t i = 0; i < on_grid; ++i) row[i] = work.samples[i * pitch + step];
        for (std::size_t i = on_grid; i < count; ++i)
          tower[step * towers + (first + i - grid_points)] = work.samples[i * pitch + step];
      }
    }
    meter.summed(range.size(), coefficients.tiles);
  });
}

// Looks at the first bin of every domain size, where the coherence reaches furthest.
double coherence_error(const TurbulentWind& wind, const Lattice& lattice, const TimeAxis& axis, int component,
                       const std::vector<Job>& jobs) {
  double largest = 0;
  CoherentPlaneWork work;
  for (std::size_t j = 0; j < jobs.size(); ++j) {
    const CoherentPlane* plane = jobs[j].plane;
    if (plane == nullptr || (j > 0 && plane == jobs[j - 1].plane)) continue;
    const CoherenceDecay decay =
        coherence_decay(wind.coherence, component, axis.frequency(jobs[j].first_bin));
    const std::array decays = {decay, decay};
    plane->set_coherences(decays, lattice.row_spacing, lattice.column_spacing, work);
    largest = std::max(largest, plane->coherence_error(decays, lattice.row_spacing, lattice.column_spacing,
                                                       lattice.rows, lattice.columns, work)[0]);
  }
  return largest;
}

// Where the wind veers, along and across turn with the height.
void turn_with_height(const MeanWind& mean, const Lattice& lattice, WindField& field) {
  const auto turn = [&](std::size_t first_point, std::size_t count, std::vector<float>& u,
                        std::vector<float>& v) {
    for (std::size_t k = 0; k < count; ++k) {
      const double angle =
          veer(mean, lattice.z(lattice.row_of_point(first_point + k))) * std::numbers::pi / 180;
      if (angle == 0) continue;
      const auto cosine = static_cast<float>(std::cos(angle)), sine = static_cast<float>(std::sin(angle));
      for (std::size_t at = k; at < u.size(); at += count) {
        const float along = u[at], across = v[at];
        u[at] = cosine * along - sine * across;
        v[at] = sine * along + cosine * across;
      }
    }
  };
  turn(0, lattice.grid.point_count(), field.velocity[0], field.velocity[1]);
  turn(lattice.grid.point_count(), static_cast<std::size_t>(lattice.tower_count), field.tower[0],
       field.tower[1]);
}

void check_options(const TurbulentWind& wind, const WindGrid& grid, const SynthesisOptions& options) {
  if (!(options.padding_tolerance > 0 && options.padding_tolerance < 1)) {
    throw InputError("padding tolerance", number_text(options.padding_tolerance), "between 0 and 1");
  }
  if (options.tower_count < 0 || options.tower_count > tower_points_above_ground(grid)) {
    throw InputError("points of the tower", std::to_string(options.tower_count),
                     "0 to " + std::to_string(tower_points_above_ground(grid)) + ", which is the ground");
  }
  if (options.tile && options.tower_count > 0)
    throw InputError("tower", "under a tile", "no tower: the rows of a tile go round");
  const double above = (wind.mean.reference_height - grid.bottom) / grid.z_spacing;
  if (options.match == Match::hub && !(above >= -0.5 && above <= grid.z_count - 0.5)) {
    throw InputError("match at the hub",
                     "a reference height of " + number_text(wind.mean.reference_height) + " m",
                     "one within the grid, " + number_text(grid.bottom) + " to " +
                         number_text(grid.z(grid.z_count - 1)) + " m");
  }
}

}  // namespace

Match match_named(const std::string& name) {
  if (name == "spectrum") return Match::spectrum;
  if (name == "variance") return Match::variance;
  if (name == "hub") return Match::hub;
  if (name == "points") return Match::points;
  throw InputError("match", name, "spectrum, variance, hub or points");
}

std::array<int, 2> hub_point(const WindGrid& grid) {
  // One row may have no spacing.
  const double row =
      grid.z_count > 1 ? std::round((grid.reference_height - grid.bottom) / grid.z_spacing) : 0.0;
  return {static_cast<int>(std::clamp(row, 0.0, grid.z_count - 1.0)), (grid.y_count - 1) / 2};
}

int tower_points_above_ground(const WindGrid& grid) {
  // A hair above it does not count.
  return static_cast<int>(std::clamp(std::ceil(grid.bottom / grid.z_spacing - 1e-6), 1.0, 1e6));
}

void check_wind_grid(const WindGrid& grid) {
  const auto check = [](bool good, const char* what, double value, const char* wanted) {
    if (!good || !std::isfinite(value)) throw InputError(what, number_text(value), wanted);
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
  check_options(wind, grid, options);
  WindField field{.grid = grid, .velocity = {}, .tower_count = options.tower_count};
  field.grid.mean_speed = wind.mean.speed;
  field.grid.reference_height = wind.mean.reference_height;
  field.grid.periodic = true;

  const TimeAxis axis{grid.period(), grid.step_count};
  const Lattice lattice = lattice_of(field.grid, options.tower_count);
  const RowAmplitudes amplitudes = row_amplitudes(wind, lattice, axis);
  const Vec3 variance = spectrum_variance(wind.spectrum);
  const double coherency = coherency_uw(wind);
  const auto [hub_row, hub_column] = hub_point(field.grid);
  const auto hub = static_cast<std::size_t>(hub_row * grid.y_count + hub_column);
  SynthesisReport report;
  Meter meter(options.progress);
  Planes planes(lattice.rows);
  const auto rows = static_cast<std::size_t>(lattice.rows), below = static_cast<std::size_t>(lattice.below),
             steps = static_cast<std::size_t>(grid.step_count);
  Coefficients coefficients(lattice.point_count(), static_cast<std::size_t>(axis.bin_count()));
  for (int component = 0; component < 3; ++component) {
    const auto c = static_cast<std::size_t>(component);
    std::vector<double> factors(rows, 1.0);
    report.resolved_share[c].assign(static_cast<std::size_t>(grid.z_count), 0.0);
    for (std::size_t row = 0; row < rows; ++row) {
      const double resolved = amplitudes.resolved_variance[c][row];
      if (resolved <= 0) continue;
      if (row >= below) report.resolved_share[c][row - below] = resolved / variance[component];
      if (options.match == Match::variance) factors[row] = std::sqrt(variance[component] / resolved);
    }
    const auto [least, most] = std::minmax_element(factors.begin(), factors.end());
    report.match_factor[c] = {*least, *most};

    const std::vector<Job> jobs =
        plan_jobs(wind, lattice, axis, drawn_together(component, coherency), options, planes);
    std::vector<Complex> mean(lattice.point_count());
    if (component == 0) {
      for (std::size_t k = 0; k < mean.size(); ++k)
        mean[k] = static_cast<float>(mean_speed(wind.mean, lattice.z(lattice.row_of_point(k))));
    }
    coefficients.store(0, mean.data());
    draw_coefficients({wind, lattice, axis, component, coherency, amplitudes, factors}, jobs, coefficients,
                      report, meter);
    if (options.match == Match::hub || options.match == Match::points)
      report.match_factor[c] = match_sample(options.match, hub, axis, variance[component], coefficients);
    field.velocity[c].resize(grid.point_count() * steps);
    field.tower[c].resize(static_cast<std::size_t>(options.tower_count) * steps);
    sum_in_time(axis, grid.point_count(), coefficients, field.velocity[c], field.tower[c], meter);
    if (report_wanted != nullptr && !options.tile) {
      report.coherence_error[c] = coherence_error(wind, lattice, axis, component, jobs);
    }
  }
  if (wind.mean.profile == ProfileKind::table) turn_with_height(wind.mean, lattice, field);
  for (const auto& [size, plane] : planes.all()) {
    report.largest_rows = std::max(report.largest_rows, size.first);
    report.largest_columns = std::max(report.largest_columns, size.second);
  }
  if (report_wanted != nullptr) *report_wanted = std::move(report);
  return field;
}

}  // namespace tremula
