#include <benchmark/benchmark.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <sys/resource.h>
#include <tbb/global_control.h>

#include "plants.hpp"
#include "tremula/io/turbsim.hpp"
#include "tremula/numerics/fft.hpp"
#include "tremula/numerics/random.hpp"
#include "tremula/structure/structure.hpp"
#include "tremula/wind/coherent_plane.hpp"
#include "tremula/wind/stam_wind.hpp"
#include "tremula/wind/synthesis.hpp"
#include "tremula/wind/travelling_field.hpp"
#include "tremula/wind/turbulent_wind_at_points.hpp"

namespace tremula {
namespace {

// One bin of Stam's wind. Limit: about 50 flops for each pair of points within reach, in the first-level
// cache.
void stam_wind_bin(benchmark::State& state) {
  const Skeleton skeleton = bench::stam_tree(static_cast<int>(state.range(0)));
  const StamWindAtPoints wind({.cutoff = 0}, {256, 256}, assemble(skeleton, {}).find_sites().points);
  for (auto _ : state) benchmark::DoNotOptimize(wind.velocity(64));
  const double pairs = 0.5 * static_cast<double>(state.range(0)) * static_cast<double>(state.range(0));
  state.counters["GFLOP/s"] =
      benchmark::Counter(50e-9 * pairs, benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(stam_wind_bin)->Arg(212)->Arg(692)->Arg(2257)->Unit(benchmark::kMillisecond);

// The field of wind engineers: points x points over 145 m x 145 m, 4096 steps of 0.1 s, 12 m/s at 90 m.
WindGrid rotor(int points) {
  return {.y_count = points,
          .z_count = points,
          .step_count = 4096,
          .y_spacing = 145.0 / (points - 1),
          .z_spacing = 145.0 / (points - 1),
          .bottom = 17.5,
          .step = 0.1};
}

TurbulentWind storm(SpectrumKind kind) {
  return turbulent_wind({.speed = 12, .reference_height = 90, .profile = ProfileKind::power}, 0.15, kind);
}

double plane_flops(int rows, int columns) {
  return 5.0 * rows * columns * std::log2(static_cast<double>(rows) * columns);
}

double series_flops(int steps) { return 2.5 * steps * std::log2(steps); }

void rate(benchmark::State& state, double flops) {
  state.counters["GFLOP/s"] = benchmark::Counter(1e-9 * flops, benchmark::Counter::kIsIterationInvariantRate);
}

// The whole, one thread: u, v, w coherent. range(1): 0 simiu-scanlan, 1 iec-kaimal. Limit: "flops" counts the
// transform in time alone, the part that no method goes without.
void wind_field(benchmark::State& state) {
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const WindGrid grid = rotor(static_cast<int>(state.range(0)));
  const TurbulentWind wind =
      storm(state.range(1) == 0 ? SpectrumKind::simiu_scanlan : SpectrumKind::iec_kaimal);
  for (auto _ : state) benchmark::DoNotOptimize(synthesise_wind(wind, grid));
  rate(state, 3.0 * static_cast<double>(grid.point_count()) * series_flops(grid.step_count));
}
BENCHMARK(wind_field)
    ->Args({31, 0})
    ->Args({31, 1})
    ->Args({51, 0})
    ->Args({51, 1})
    ->Unit(benchmark::kMillisecond);

// What tremula wind does for a .bts, the file included: one thread's seconds in the program and the system.
// "memory": the most the process has held, in sizes of the field (run it alone: --benchmark_filter).
void wind_file(benchmark::State& state) {
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const WindGrid grid = rotor(static_cast<int>(state.range(0)));
  const TurbulentWind wind = storm(SpectrumKind::iec_kaimal);
  const std::string path = std::filesystem::temp_directory_path() / "tremula-bench-wind.bts";
  for (auto _ : state) write_turbsim(path, synthesise_wind(wind, grid));
  std::filesystem::remove(path);
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const double field = 12.0 * static_cast<double>(grid.point_count()) * grid.step_count;
  state.counters["memory"] = 1024.0 * static_cast<double>(usage.ru_maxrss) / field;
  rate(state, 3.0 * static_cast<double>(grid.point_count()) * series_flops(grid.step_count));
}
BENCHMARK(wind_file)->Arg(31)->Arg(51)->MeasureProcessCPUTime()->Unit(benchmark::kMillisecond);

// The parts. First the two bare transforms, which are the limit of what follows.
void bare_plane_series(benchmark::State& state) {
  const int size = static_cast<int>(state.range(0));
  const PlaneSeries series(size, size, size);
  FftArray<std::complex<float>> plane(series.size());
  for (auto _ : state) {
    series.sum(plane.data());
    benchmark::ClobberMemory();
  }
  rate(state, plane_flops(size, size));
}
BENCHMARK(bare_plane_series)->Arg(56)->Arg(64)->Arg(80)->Arg(112)->Unit(benchmark::kMicrosecond);

void bare_real_series(benchmark::State& state) {
  const RealSeries series(4096, 32);
  FftArray<std::complex<float>> in(32 * static_cast<std::size_t>(series.bin_count()));
  FftArray<float> out(32 * static_cast<std::size_t>(series.pitch()));
  for (auto _ : state) {
    series.sum(in.data(), out.data());
    benchmark::ClobberMemory();
  }
  rate(state, 32 * series_flops(4096));
}
BENCHMARK(bare_real_series)->Unit(benchmark::kMicrosecond);

// Kernel, transform and roots for two bins; the flops are those of the transform.
void coherence_of_two_bins(benchmark::State& state) {
  const int size = static_cast<int>(state.range(0));
  const CoherentPlane plane(size, size, size);
  CoherentPlaneWork work;
  for (auto _ : state)
    plane.set_coherences({CoherenceDecay{0.3, 0.3}, CoherenceDecay{0.31, 0.31}}, 1, 1, work);
  rate(state, plane_flops(size, size));
}
BENCHMARK(coherence_of_two_bins)->Arg(64)->Arg(112)->Unit(benchmark::kMicrosecond);

// Noise, amplitudes and transform of one bin; the flops are those of the transform.
void coherent_plane_of_a_bin(benchmark::State& state) {
  const int size = static_cast<int>(state.range(0));
  const CoherentPlane plane(size, size, size);
  CoherentPlaneWork work;
  plane.set_coherences({CoherenceDecay{0.3, 0.3}, CoherenceDecay{0.31, 0.31}}, 1, 1, work);
  std::uint32_t bin = 0;
  for (auto _ : state) plane.draw({.bin = ++bin}, 0, work);
  rate(state, plane_flops(size, size));
}
BENCHMARK(coherent_plane_of_a_bin)->Arg(64)->Arg(112)->Unit(benchmark::kMicrosecond);

void complex_gaussians_of_a_bin(benchmark::State& state) {
  std::vector<std::complex<float>> values(4096);
  std::uint32_t bin = 0;
  for (auto _ : state) {
    complex_gaussians(1, RandomStream::wind_u, ++bin, values.size(), values.data());
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(static_cast<std::int64_t>(values.size()) * state.iterations());
}
BENCHMARK(complex_gaussians_of_a_bin)->Unit(benchmark::kMicrosecond);

// All bins of a loop of 600 samples at the branches of a tree, with what it takes to begin: of the box around
// them, and of the world. Limit: 16 nodes of a spline, of three components as complex numbers, are 96
// multiply-adds a point and bin; about as many go into weights and variances.
void wind_at_branches(benchmark::State& state) {
  const Skeleton skeleton = bench::stam_tree(static_cast<int>(state.range(0)));
  const Eigen::Matrix3Xd points = assemble(skeleton, {}).find_sites().points;
  const TimeAxis axis{20, 600};
  const WindAtPointsOptions options{.realisation =
                                        state.range(1) == 0 ? Realisation::of_points : Realisation::of_world};
  for (auto _ : state) {
    const TurbulentWindAtPoints wind(turbulent_wind({}, 0.2), axis, points, options);
    for (int bin = 0; bin < axis.bin_count(); ++bin) benchmark::DoNotOptimize(wind.velocity(bin));
  }
  state.SetItemsProcessed(points.cols() * axis.bin_count() * state.iterations());
}
BENCHMARK(wind_at_branches)
    ->ArgNames({"branches", "of_world"})
    ->ArgsProduct({{212, 2257}, {0, 1}})
    ->Unit(benchmark::kMillisecond);

// The gusts over a square kilometre for a loop of 20 s at 30 frames a second, half a metre apart. By Taylor a
// plane is enough. Limit: the transform in time, 3 series of 600 samples a column.
void gusts_over_a_kilometre(benchmark::State& state) {
  const Wind wind(turbulent_wind({.speed = 10}, 0.2), Realisation::of_world);
  const FieldPlane plane{.columns = 2001, .first_column = -500, .spacing = 0.5, .heights = {0.5}};
  std::size_t bytes = 0;
  for (auto _ : state) {
    const TravellingField field = gust_field(wind, {20, 600}, plane);
    bytes = field.values.size() * sizeof field.values[0];
    benchmark::DoNotOptimize(field.values.data());
  }
  state.counters["MB"] = static_cast<double>(bytes) / 1e6;
  rate(state, 3 * 2001 * series_flops(600));
}
BENCHMARK(gusts_over_a_kilometre)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace tremula
