// What a tree cannot say: a loop. A garden arch of two bent green rods that meet at the top, with a rung
// across, stands on two feet. How much slower does it sway when one foot comes loose? Loops and several
// clamps are a Frame; the modes come from the same solver, with the same proof that none is missing.

#include <tremula/modes/solve_modes.hpp>

#include <cmath>
#include <cstdio>

namespace {

using namespace tremula;

// A half circle of 2 m span in `pieces` straight ones, thinner towards the top, and a rung at half its
// height.
Frame arch(int pieces) {
  const double pi = 3.14159265358979323846;
  Frame frame;
  for (int i = 0; i <= pieces; ++i) {
    const double angle = pi * i / pieces;
    frame.nodes.emplace_back(-std::cos(angle), 0, std::sin(angle));
  }
  const auto radius = [&](int i) { return 0.014 - 0.006 * std::sin(pi * i / pieces); };
  for (int i = 0; i < pieces; ++i) {
    frame.elements.push_back(
        {.start_node = i, .end_node = i + 1, .start_radius = radius(i), .end_radius = radius(i + 1)});
  }
  // The rung in pieces too: a single one would be too stiff in its own swing.
  const int left = pieces / 6, right = pieces - left, rung_pieces = 12;
  const Vec3 start = frame.nodes[static_cast<std::size_t>(left)],
             end = frame.nodes[static_cast<std::size_t>(right)];
  for (int i = 0, last = left; i < rung_pieces; ++i) {
    const int next = i + 1 < rung_pieces ? static_cast<int>(frame.nodes.size()) : right;
    if (next != right) frame.nodes.push_back(start + (end - start) * (i + 1) / rung_pieces);
    frame.elements.push_back(
        {.start_node = last, .end_node = next, .start_radius = 0.006, .end_radius = 0.006});
    last = next;
  }
  frame.masses.push_back({.node = pieces / 2, .mass = 0.5});  // a lantern at the top
  return frame;
}

}  // namespace

int main() {
  Frame frame = arch(48);
  frame.clamped = {0, 48};
  const Modes standing = solve_modes(assemble(frame), {.count = 6});
  frame.clamped = {0};
  const Modes loose = solve_modes(assemble(frame), {.count = 6});

  bool right = true;
  std::printf("mode  both feet clamped  one foot loose\n");
  for (int r = 0; r < 6; ++r) {
    std::printf("%4d  %14.4f Hz  %11.4f Hz\n", r + 1, standing.frequency[r], loose.frequency[r]);
    // Rayleigh: letting go can only lower a frequency.
    right = right && loose.frequency[r] < standing.frequency[r];
  }
  for (const Modes* modes : {&standing, &loose}) {
    std::printf("modes found %d, by the inertia of K - omega^2 M %d, largest error bound %.0e\n",
                modes->count_below, modes->count_by_inertia, modes->error_bound.maxCoeff());
    right = right && modes->count_below == modes->count_by_inertia;
  }
  return right ? 0 : 1;
}
