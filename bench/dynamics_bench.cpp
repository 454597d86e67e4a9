#include <benchmark/benchmark.h>

#include <numbers>

#include "plants.hpp"
#include "tremula/dynamics/branch_oscillators.hpp"
#include "tremula/dynamics/gust_average.hpp"
#include "tremula/dynamics/response.hpp"
#include "tremula/dynamics/response_field.hpp"
#include "tremula/dynamics/shelter.hpp"
#include "tremula/pipeline.hpp"
#include "tremula/reference/modal_load_spectrum.hpp"
#include "tremula/structure/structure.hpp"
#include "tremula/wind/turbulent_wind_at_points.hpp"

namespace tremula {
namespace {

// A system of 20 modes in a loop of 600 samples.
const TimeAxis axis{20, 600};

ModalSystem twenty_modes() {
  const Eigen::VectorXd omega = 2 * std::numbers::pi * Eigen::VectorXd::LinSpaced(20, 0.5, 5);
  return {omega, (0.1 * omega).asDiagonal()};
}

// From the wind at the points to the coordinates, all bins, in a wind that costs nothing. Limit: 4 flops for
// each of 3P x m entries and draw, from a matrix in cache, and the transfer of twenty_modes alone.
void respond_tree(benchmark::State& state) {
  const auto points = static_cast<Eigen::Index>(state.range(0));
  const Eigen::MatrixXd participation = Eigen::MatrixXd::Random(3 * points, 20);
  const Eigen::Matrix3Xcd gust = Eigen::Matrix3Xcd::Random(3, points);
  const PointWind wind{.mean = Eigen::Matrix3Xd::Zero(3, points), .velocity = [&](int, int) { return gust; }};
  const BinTransfer transfer(twenty_modes(), axis, Transfer::bin_averaged);
  for (auto _ : state) benchmark::DoNotOptimize(respond(transfer, participation, axis, wind));
}
BENCHMARK(respond_tree)->Arg(1)->Arg(2257)->Arg(20000)->Unit(benchmark::kMillisecond)->UseRealTime();

WindAt steady(const Vec3& velocity) {
  return [velocity](Eigen::Index, const Vec3&) { return GustStatistics{velocity, 4 * Mat3::Identity()}; };
}

// Where a tree comes to rest in a wind of 20 m/s. Limit: what a step works out a branch (drag at four places,
// a 6 x 6 system and half a dozen products of such matrices, some 5000 flops) times five or six, and once
// more half as much for the tree as it then stands.
void lean_of_tree(benchmark::State& state) {
  const Structure structure = assemble(bench::stam_tree(static_cast<int>(state.range(0))), {});
  for (auto _ : state) benchmark::DoNotOptimize(find_lean(structure, steady({20, 0, 0}), {}));
}
BENCHMARK(lean_of_tree)->Arg(2257)->Arg(200000)->Unit(benchmark::kMillisecond)->UseRealTime();

// From a structure and its lean to what the wind does to it: sites, loads, static shapes, participation,
// damping.
void loads_of_tree(benchmark::State& state) {
  const Skeleton skeleton = bench::stam_tree(static_cast<int>(state.range(0)));
  const Structure structure = assemble(skeleton, {});
  const Modes modes = solve_modes(structure, {.count = 20});
  for (auto _ : state) {
    const Sites sites = structure.find_sites();
    const Loads loads = linearise_loads(sites, Vec3(5, 1, 0).replicate(1, sites.point_count()));
    benchmark::DoNotOptimize(static_shapes(structure, sites, loads, modes));
    benchmark::DoNotOptimize(modal_participation(sites, loads, modes.shapes));
    benchmark::DoNotOptimize(aerodynamic_damping(sites, loads, modes.shapes));
    benchmark::DoNotOptimize(aerodynamic_stiffness(sites, loads, modes.shapes));
  }
}
BENCHMARK(loads_of_tree)->Arg(2257)->Arg(20000)->Unit(benchmark::kMillisecond)->UseRealTime();

// The modal forces of one bin two ways: by a wind at the points, and from their cross-spectral matrix (worked
// out, then one draw). Limits: a few 2-D FFTs of 4096 nodes and more; 6 N^2 (m + some) flops.
void modal_forces_by_wind(benchmark::State& state) {
  const Skeleton skeleton = bench::stam_tree(static_cast<int>(state.range(0)));
  const TurbulentWindAtPoints wind(turbulent_wind({}, 0.2), {20, 600},
                                   assemble(skeleton, {}).find_sites().points);
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
  const Eigen::Matrix3Xd points = assemble(skeleton, {}).find_sites().points;
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

// One wind of gusts, averaged. Limit: an exponential and three or four divisions at each of 14 nodes.
GustStatistics gusts() {
  Mat3 covariance = Vec3(4, 2.5, 1).asDiagonal();
  covariance(0, 2) = covariance(2, 0) = -0.5;
  return {Vec3(5, 0.1, 0.2), covariance};
}

void average_over_cylinder(benchmark::State& state) {
  GustStatistics wind = gusts();
  const Vec3 along = Vec3(0.2, 0.1, 1).normalized();
  for (auto _ : state) {
    benchmark::DoNotOptimize(wind);
    benchmark::DoNotOptimize(average_drag_across(along, wind));
  }
}
BENCHMARK(average_over_cylinder)->Unit(benchmark::kNanosecond);

void average_over_foliage(benchmark::State& state) {
  GustStatistics wind = gusts();
  const FoldingMixture mixture = mix_folding({});
  for (auto _ : state) {
    benchmark::DoNotOptimize(wind);
    benchmark::DoNotOptimize(average_folding_drag(mixture, wind));
  }
}
BENCHMARK(average_over_foliage)->Unit(benchmark::kNanosecond);

// Of sites that fill a crown of 8 m. Limit: to sort four entries a site.
void shelter_in_crown(benchmark::State& state) {
  const auto count = static_cast<Eigen::Index>(state.range(0));
  const Eigen::Matrix3Xd places = 4 * Eigen::Matrix3Xd::Random(3, count);
  const Eigen::VectorXd drag_area = Eigen::VectorXd::Constant(count, 60.0 / static_cast<double>(count));
  for (auto _ : state) benchmark::DoNotOptimize(find_shelter(places, drag_area, Vec3::UnitX()));
}
BENCHMARK(shelter_in_crown)->Arg(20000)->Arg(200000)->Unit(benchmark::kMillisecond);

// One frame of the bamboo of F section 6.1, by a thread: every branch one mode in two directions, from the
// wind at the branches (force) to where the branches are (step). Limit of the step: 36 bytes and 8 flops for
// every pair of oscillators of which one acts on the other, directly or through others, from cache, and two
// triangular solutions of 12 bytes and 2 flops a coupling.
struct Bamboo {
  BranchOscillators branches;
  OscillatorIntegrator integrator;

  static BranchOscillators grown() {
    const GrownPlant plant = grow(parse_lsystem(find_preset("bamboo-2942").text, "bamboo-2942"), {});
    const Structure structure = assemble(plant.skeleton, {});
    const Sites sites = structure.find_sites();
    const Loads loads = linearise_loads(sites, Vec3(5, 1, 0).replicate(1, sites.point_count()));
    return branch_oscillators(structure, sites, loads, {});
  }
  Bamboo() : branches(grown()), integrator(branches.network, 1.0 / 30) {}
};

void oscillators_step(benchmark::State& state) {
  const Bamboo bamboo;
  const Eigen::Index count = bamboo.branches.network.size();
  OscillatorState now = at_rest(bamboo.branches.network);
  const Eigen::VectorXd before = Eigen::VectorXd::Random(count), after = Eigen::VectorXd::Random(count);
  for (auto _ : state) bamboo.integrator.advance(now, before, after);
  state.counters["axes"] = static_cast<double>(bamboo.branches.axes.size());
  state.counters["pairs"] = static_cast<double>(bamboo.integrator.pair_count());
}
BENCHMARK(oscillators_step)->Unit(benchmark::kMicrosecond);

void oscillators_force(benchmark::State& state) {
  const Bamboo bamboo;
  const Eigen::VectorXd gust = Eigen::VectorXd::Random(bamboo.branches.participation.cols());
  Eigen::VectorXd force(bamboo.branches.network.size());
  for (auto _ : state) {
    force.noalias() = bamboo.branches.participation * gust;
    benchmark::DoNotOptimize(force.data());
  }
  state.counters["entries"] = static_cast<double>(bamboo.branches.participation.nonZeros());
}
BENCHMARK(oscillators_force)->Unit(benchmark::kMicrosecond);

// What follows the gusts along them over a kilometre of meadow with a column every metre, a loop of 600
// samples: exponential, 0 (none) or 2 m. Limit: two transforms of every column (5 M log2 M flops each, half
// of that for real series, in double and in float) and for each bin 4 flops a column and weight; the weights
// take some 60 exponentials each.
void response_field(benchmark::State& state) {
  TravellingField gusts;
  gusts.loop = axis;
  gusts.speed = 6;
  gusts.plane = {.columns = 1001, .heights = {0.5}};
  gusts.mean = {{6, 0, 0}};
  gusts.values.resize(1001 * static_cast<std::size_t>(axis.sample_count));
  for (std::size_t i = 0; i < gusts.values.size(); ++i)
    gusts.values[i][0] = static_cast<float>(i * 7919 % 1000) / 500 - 1;
  const auto length = static_cast<double>(state.range(0));
  const auto kind = length > 0 ? SpatialResponse::Kind::exponential : SpatialResponse::Kind::none;
  const FieldResponse response{.along = oscillator_impedance(1.5, 0.1, 0.02),
                               .spatial = {.kind = kind, .length = length > 0 ? length : 1}};
  for (auto _ : state) benchmark::DoNotOptimize(respond(gusts, response));
}
BENCHMARK(response_field)->Arg(0)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace tremula
