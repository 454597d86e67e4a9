// Snow: how long the paths of a box full of flakes take, what they need, and how long a frame of them takes.
#include <benchmark/benchmark.h>

#include <cmath>
#include <memory>

#include "tremula/deformation/drift_pose.hpp"
#include "tremula/wind/point_wind.hpp"

namespace tremula {
namespace {

constexpr TimeAxis snow_loop{.period = 20, .sample_count = 600};

// A cube of air with as many flakes.
Drift snow(double flakes) {
  const double side = std::cbrt(flakes / 10);
  return {.kind = drift_kind_named("snow"), .low = {0, 0, 0}, .high = {side, side, side}};
}

TravellingField gusts_for(const Drift& drift) {
  const Wind wind = turbulent_wind(mean_wind_over(terrain_named("open"), 4), 0.15);
  return gust_field(wind, snow_loop, plane_around(drift, wind.reference.heading));
}

void carry_snow(benchmark::State& state) {
  const Drift drift = snow(static_cast<double>(state.range(0)));
  const TravellingField gusts = gusts_for(drift);
  for (auto _ : state) benchmark::DoNotOptimize(carry(gusts, drift));
}
BENCHMARK(carry_snow)->Arg(100000)->Unit(benchmark::kMillisecond)->UseRealTime()->Iterations(1);

void pose_snow(benchmark::State& state) {
  const Drift drift = snow(static_cast<double>(state.range(0)));
  const auto paths = std::make_shared<const DriftPaths>(carry(gusts_for(drift), drift));
  const Loop loop = make_loop(paths, {}, look_of(paths->form));
  double time = 0;
  for (auto _ : state) benchmark::DoNotOptimize(loop.skin_at(time += 1.0 / 30));
  state.counters["flakes"] = static_cast<double>(drift_at(*paths, 0).size());
  state.counters["meshes"] = static_cast<double>(loop.rest->parts[0].pieces.count);
  state.counters["bytes of paths"] = static_cast<double>(paths->bytes());
}
BENCHMARK(pose_snow)->Arg(100000)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace tremula
