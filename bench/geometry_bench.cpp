#include <benchmark/benchmark.h>

#include "plants.hpp"
#include "tremula/geometry/surface.hpp"

namespace tremula {
namespace {

void grow_tree(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(bench::stam_tree(static_cast<int>(state.range(0))));
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(grow_tree)->Arg(2257)->Arg(20000)->Unit(benchmark::kMillisecond);

void mesh_tree(benchmark::State& state) {
  const Skeleton skeleton = bench::stam_tree(static_cast<int>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(mesh_surface(skeleton));
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(mesh_tree)->Arg(2257)->Arg(20000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace tremula
