#include <benchmark/benchmark.h>

#include "plants.hpp"
#include "tremula/structure/structure.hpp"

namespace tremula {
namespace {

void assemble_plant(benchmark::State& state) {
  const Skeleton skeleton = bench::stam_tree(static_cast<int>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(assemble(skeleton, {}));
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(assemble_plant)->Arg(2257)->Arg(20000)->Unit(benchmark::kMillisecond);

void apply_operator(benchmark::State& state) {
  const BeamTree tree = assemble_tree(bench::stam_tree(static_cast<int>(state.range(0))), {});
  const Eigen::VectorXd s = Eigen::VectorXd::Ones(tree.size());
  for (auto _ : state) benchmark::DoNotOptimize(apply_compliance_form(tree, s));
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(apply_operator)->Arg(692)->Arg(2257)->Arg(20000)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace tremula
