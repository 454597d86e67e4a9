#include <benchmark/benchmark.h>

#include "plants.hpp"
#include "tremula/dynamics/loads.hpp"
#include "tremula/dynamics/response.hpp"

namespace tremula {
namespace {

// Wind to modal forces, all bins. Limit: 4 flops for each of 3N x m entries and bin, from a matrix in cache.
void project_tree(benchmark::State& state) {
  const auto branches = static_cast<Eigen::Index>(state.range(0));
  const Eigen::MatrixXd participation = Eigen::MatrixXd::Random(3 * branches, 20);
  const Eigen::Matrix3Xcd wind = Eigen::Matrix3Xcd::Random(3, branches);
  const TimeAxis axis{20, 600};
  for (auto _ : state) {
    benchmark::DoNotOptimize(project_loads(participation, axis, [&](int) { return wind; }));
  }
  state.counters["GFLOP/s"] =
      benchmark::Counter(4e-9 * 3 * static_cast<double>(branches) * 20 * axis.bin_count(),
                         benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(project_tree)->Arg(2257)->Arg(20000)->Unit(benchmark::kMillisecond)->UseRealTime();

void respond_tree(benchmark::State& state) {
  Modes modes;
  modes.frequency = Eigen::VectorXd::LinSpaced(20, 0.5, 5);
  const TimeAxis axis{20, 600};
  const Eigen::MatrixXcd forces = Eigen::MatrixXcd::Random(axis.bin_count(), 20);
  for (auto _ : state) benchmark::DoNotOptimize(respond(modes, forces, axis, {}, {}));
}
BENCHMARK(respond_tree)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace tremula
