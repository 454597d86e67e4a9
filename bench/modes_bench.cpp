#include <benchmark/benchmark.h>

#include "plants.hpp"
#include "tremula/modes/solve_modes.hpp"

namespace tremula {
namespace {

void solve_tree(benchmark::State& state) {
  const Structure structure = assemble(bench::stam_tree(static_cast<int>(state.range(0))), {});
  for (auto _ : state) {
    benchmark::DoNotOptimize(solve_modes(structure, {.count = 40, .method = ModeMethod::iterative}));
  }
}
BENCHMARK(solve_tree)->Arg(212)->Arg(692)->Arg(2257)->Arg(20000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace tremula
