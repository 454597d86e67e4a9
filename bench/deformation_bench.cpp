#include <benchmark/benchmark.h>

#include "plants.hpp"
#include "tremula/deformation/pose.hpp"

namespace tremula {
namespace {

void deform_tree(benchmark::State& state) {
  const Skeleton skeleton = bench::stam_tree(static_cast<int>(state.range(0)));
  const Structure structure = assemble(skeleton, {});
  const Surface surface = mesh_surface(skeleton);
  const Eigen::VectorXd displacement = Eigen::VectorXd::Random(structure.size());
  for (auto _ : state) benchmark::DoNotOptimize(deform_surface(structure, surface, displacement));
  state.counters["vertices/s"] = benchmark::Counter(static_cast<double>(surface.vertex_count()),
                                                    benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(deform_tree)->Arg(2257)->Arg(20000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace tremula
