#include <benchmark/benchmark.h>

#include "plants.hpp"
#include "tremula/dynamics/loads.hpp"
#include "tremula/wind/stam_wind.hpp"

namespace tremula {
namespace {

// One bin of Stam's wind. Limit: about 50 flops for each pair of points within reach, in the first-level
// cache.
void stam_wind_bin(benchmark::State& state) {
  const Skeleton skeleton = bench::stam_tree(static_cast<int>(state.range(0)));
  const StamWindAtPoints wind({.cutoff = 0}, {256, 256}, load_points(skeleton));
  for (auto _ : state) benchmark::DoNotOptimize(wind.velocity(64));
  const double pairs = 0.5 * static_cast<double>(state.range(0)) * static_cast<double>(state.range(0));
  state.counters["GFLOP/s"] =
      benchmark::Counter(50e-9 * pairs, benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(stam_wind_bin)->Arg(212)->Arg(692)->Arg(2257)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace tremula
