// The smallest structure: a straight, uniform stem. Its bending frequencies are known in closed form,
// omega = (beta L)^2 / L^2 sqrt(E I / (rho A)), so the program can be held to them.

#include <tremula/modes/solve_modes.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>

int main() {
  using namespace tremula;

  // 1. A stem of 2 m, 2 cm thick, in twenty pieces. Node 0 is the clamped root; piece i starts at node i.
  const double length = 2, radius = 0.01;
  const int pieces = 20;
  Skeleton stem;
  stem.roots = {Vec3::Zero()};
  for (int i = 0; i < pieces; ++i) {
    Branch piece;
    piece.start_node = i;
    piece.start = {0, 0, length * i / pieces};
    piece.end = {0, 0, length * (i + 1) / pieces};
    piece.start_radius = piece.end_radius = radius;
    stem.branches.push_back(piece);
  }

  // 2. Geometry -> structure -> modes. The closed form knows nothing of weight.
  const StructureOptions options{.material = find_material("birch"), .rotatory_inertia = false, .gravity = 0};
  const Structure structure = assemble(stem, options);
  const Modes modes = solve_modes(structure, {.count = 6});

  // 3. Round sections bend alike in all directions: every frequency comes twice.
  const double beta_l[] = {1.8751040687119611, 4.694091132973949, 7.854757438237613};
  const double unit =
      std::sqrt(options.material.youngs_modulus * radius * radius / 4 / options.material.density) /
      (length * length);
  double worst = 0;
  std::printf("mode  frequency_hz  closed form\n");
  for (int r = 0; r < 6; ++r) {
    const double wanted = beta_l[r / 2] * beta_l[r / 2] * unit / (2 * 3.14159265358979323846);
    std::printf("%4d  %12.6f  %11.6f\n", r + 1, modes.frequency[r], wanted);
    worst = std::max(worst, std::abs(modes.frequency[r] / wanted - 1));
  }
  std::printf("largest difference %.1e\n", worst);
  return worst < 5e-5 ? 0 : 1;
}
