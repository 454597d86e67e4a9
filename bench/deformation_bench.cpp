#include <benchmark/benchmark.h>

#include <utility>

#include "plants.hpp"
#include "tremula/deformation/bent_pose.hpp"
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
// A tree that stands bent, with 24 shapes about that: a pose by strains costs the superposition, which reads
// 24 columns of 48 bytes a branch, and some 600 operations and two pairs of sine and cosine a branch.
struct BentPlant {
  Skeleton skeleton;
  Structure structure = assemble(skeleton, {});
  Motion motion{.period = 10, .basis = {}, .coordinates = Eigen::MatrixXd::Random(300, 25)};

  explicit BentPlant(int branches) : skeleton(bench::stam_tree(branches)) {
    motion.lean_strains = 0.02 * Eigen::VectorXd::Random(structure.size());
    for (const Member& member : structure.members)
      motion.lean_strains.segment<3>(member.end_row) *= member.beam.length;
    Modes shapes;
    shapes.frequency = Eigen::VectorXd::Ones(24);
    shapes.shapes.resize(structure.size(), 24);
    for (Eigen::Index r = 0; r < 24; ++r) {
      const Eigen::VectorXd shape = structure.flexibility(Eigen::VectorXd::Random(structure.size()));
      const double turned = shape.reshaped(6, shape.size() / 6).bottomRows(3).colwise().norm().maxCoeff();
      shapes.shapes.col(r) = 0.2 / turned * shape;  // [rad]
    }
    motion.basis = join(Eigen::VectorXd::Zero(structure.size()), std::move(shapes), {});
    motion.coordinates.col(0).setOnes();
  }
};

void superpose_displacements(benchmark::State& state) {
  const BentPlant plant(static_cast<int>(state.range(0)));
  double time = 0;
  for (auto _ : state) benchmark::DoNotOptimize(displacement_at(plant.motion, time += 0.033));
}
BENCHMARK(superpose_displacements)->Arg(2257)->Arg(20000)->Unit(benchmark::kMicrosecond);

void bend_by_strains(benchmark::State& state) {
  const BentPlant plant(static_cast<int>(state.range(0)));
  const BentLean lean = bend_lean(plant.structure, plant.motion);
  double time = 0;
  for (auto _ : state) benchmark::DoNotOptimize(bent_at(lean, plant.motion, time += 0.033));
  state.counters["poses/s"] = benchmark::Counter(1, benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(bend_by_strains)->Arg(2257)->Arg(20000)->Unit(benchmark::kMicrosecond);

void bend_skin(benchmark::State& state) {
  const BentPlant plant(static_cast<int>(state.range(0)));
  const Surface surface = mesh_surface(plant.skeleton);
  const std::vector<BentBranch> bent = bent_at(plant.structure, plant.motion, 0.7);
  for (auto _ : state) benchmark::DoNotOptimize(bend_surface(plant.structure, surface, bent));
  state.counters["vertices/s"] = benchmark::Counter(static_cast<double>(surface.vertex_count()),
                                                    benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(bend_skin)->Arg(2257)->Arg(20000)->Unit(benchmark::kMillisecond);

BENCHMARK(deform_tree)->Arg(2257)->Arg(20000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace tremula
