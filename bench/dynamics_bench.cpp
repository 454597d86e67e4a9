#include <benchmark/benchmark.h>

#include "plants.hpp"
#include "tremula/dynamics/loads.hpp"
#include "tremula/dynamics/modal_load_spectrum.hpp"
#include "tremula/dynamics/response.hpp"
#include "tremula/wind/wind_at_points.hpp"

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
// The modal forces of one bin two ways: by a wind at the points, and from their cross-spectral matrix (worked
// out, then one draw). Limits: a few 2-D FFTs of 4096 nodes and more; 6 N^2 (m + some) flops.
void modal_forces_by_wind(benchmark::State& state) {
  const Skeleton skeleton = bench::stam_tree(static_cast<int>(state.range(0)));
  const TurbulentWindAtPoints wind(turbulent_wind({}, 0.2), {20, 600}, load_points(skeleton));
  const Eigen::MatrixXd participation = Eigen::MatrixXd::Random(3 * skeleton.branch_count(), 20);
  for (auto _ : state) {
    const Eigen::Matrix3Xcd velocity = wind.velocity(30);
    Eigen::VectorXcd forces = participation.transpose() * velocity.reshaped();
    benchmark::DoNotOptimize(forces);
  }
}
BENCHMARK(modal_forces_by_wind)->Arg(17)->Arg(62)->Arg(212)->Arg(692)->Unit(benchmark::kMicrosecond);

void modal_forces_directly(benchmark::State& state) {
  const Skeleton skeleton = bench::stam_tree(static_cast<int>(state.range(0)));
  const Eigen::Matrix3Xd points = load_points(skeleton);
  const TurbulentWind wind = turbulent_wind({}, 0.2);
  const Eigen::MatrixXd participation = Eigen::MatrixXd::Random(3 * skeleton.branch_count(), 20);
  for (auto _ : state)
    benchmark::DoNotOptimize(
        draw_modal_forces(modal_load_spectrum(wind, points, participation, 1.5), 20, 1, 30));
}
BENCHMARK(modal_forces_directly)->Arg(17)->Arg(62)->Arg(212)->Arg(692)->Unit(benchmark::kMicrosecond);

// Once the matrix is known, another realisation.
void modal_forces_directly_again(benchmark::State& state) {
  const Eigen::MatrixXcd root = Eigen::MatrixXcd::Random(20, 20);
  const Eigen::MatrixXcd spectrum = root * root.adjoint();
  for (auto _ : state) benchmark::DoNotOptimize(draw_modal_forces(spectrum, 20, 1, 30));
}
BENCHMARK(modal_forces_directly_again)->Unit(benchmark::kMicrosecond);

}  // namespace tremula
