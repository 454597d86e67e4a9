// Small plants for the tests, made here.
#pragma once

#include "tremula/geometry/skeleton.hpp"
#include "tremula/numerics/random.hpp"
#include "tremula/structure/beam_tree.hpp"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>

namespace tremula::test {

// For closed forms that know nothing of weight, and for trees that could not stand under theirs.
inline StructureOptions weightless(StructureOptions options = {}) {
  options.gravity = 0;
  return options;
}

inline Branch make_branch(int start_node, const Vec3& start, const Vec3& end, double start_radius,
                          double end_radius) {
  Branch branch;
  branch.start_node = start_node;
  branch.start = start;
  branch.end = end;
  branch.start_radius = start_radius;
  branch.end_radius = end_radius;
  return branch;
}

// A straight stem from the origin, cut into equal pieces, its radius linear from base to tip.
inline Skeleton straight_stem(int pieces, double length, double base_radius, double tip_radius,
                              const Vec3& direction = Vec3::UnitZ()) {
  Skeleton skeleton;
  skeleton.roots.push_back(Vec3::Zero());
  const auto at = [&](int i) { return static_cast<double>(i) / pieces; };
  const auto radius = [&](int i) { return base_radius + at(i) * (tip_radius - base_radius); };
  for (int i = 0; i < pieces; ++i) {
    skeleton.branches.push_back(
        make_branch(i, at(i) * length * direction, at(i + 1) * length * direction, radius(i), radius(i + 1)));
  }
  return skeleton;
}

// Such a stem of one radius along z, with a ribbon of so many kg/m all along it, whose normal is x.
inline Skeleton stem_with_ribbon(int pieces, double length, double radius, double width,
                                 double mass_per_length) {
  Skeleton stem = straight_stem(pieces, length, radius, radius);
  for (int k = 0; k < pieces; ++k) {
    const Branch& branch = stem.branches[static_cast<std::size_t>(k)];
    stem.leaves.push_back({.branch = k,
                           .position = 0.5,
                           .base = branch.start,
                           .axis = Vec3::UnitZ(),
                           .normal = Vec3::UnitX(),
                           .length = branch.length(),
                           .width = width,
                           .area = width * branch.length(),
                           .mass = mass_per_length * branch.length(),
                           .is_ribbon = true,
                           .end_width = width});
  }
  return stem;
}

// A random branching tree: lengths around 0.5 m, radii that shrink by order, tapered.
inline Skeleton random_tree(int branch_count, std::uint64_t seed) {
  Skeleton skeleton;
  skeleton.roots.push_back(Vec3::Zero());
  const auto draw = [&](int k, std::uint32_t what) {
    return uniform({seed, RandomStream::test, what, static_cast<std::uint64_t>(k)});
  };
  for (int k = 0; k < branch_count; ++k) {
    const int start_node = k == 0 ? 0 : 1 + static_cast<int>(draw(k, 0) * std::min(k, 1 + k / 2));
    const Vec3 start = skeleton.node_position(start_node);
    const double parent_radius =
        start_node == 0 ? 0.08 : skeleton.branches[std::size_t(start_node - 1)].end_radius;
    const Vec3 direction = Vec3(2 * draw(k, 1) - 1, 2 * draw(k, 2) - 1, 0.3 + draw(k, 3)).normalized();
    const double radius = k == 0 ? 0.08 : parent_radius * (0.6 + 0.3 * draw(k, 4));
    skeleton.branches.push_back(make_branch(start_node, start, start + (0.3 + 0.5 * draw(k, 5)) * direction,
                                            radius, radius * (0.7 + 0.3 * draw(k, 6))));
  }
  return skeleton;
}

// A random tree with what real ones have: leaves, two roots, and branches that start beside their nodes.
inline Skeleton awkward_tree() {
  Skeleton skeleton = random_tree(12, 5);
  skeleton.roots.emplace_back(1, 0, 0);
  for (Branch& branch : skeleton.branches) {
    if (branch.start_node > 0) ++branch.start_node;
  }
  skeleton.branches.push_back(make_branch(1, Vec3(1, 0, 0), Vec3(1.1, 0.2, 0.7), 0.03, 0.02));
  const Vec3 beside = skeleton.node_position(4) + Vec3(0.05, -0.03, 0.02);
  skeleton.branches.push_back(make_branch(4, beside, beside + Vec3(0.3, 0.1, 0.2), 0.01, 0.008));
  for (const int branch : {3, 7, 13}) {
    Leaf leaf;
    leaf.branch = branch;
    leaf.position = 0.6;
    leaf.mass = 0.02;
    skeleton.leaves.push_back(leaf);
  }
  return skeleton;
}

// The contiguous cylinders of the reference trees (TreeQSM text: radius, length, start, axis, parent …).
inline Skeleton cylinders_from_text(const std::filesystem::path& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot open " + path.string());
  Skeleton skeleton;
  skeleton.roots.push_back(Vec3::Zero());
  std::string line;
  while (std::getline(file, line)) {
    if (line.empty()) continue;
    std::istringstream columns(line);
    double radius, length;
    Vec3 start, axis;
    int parent;
    columns >> radius >> length >> start[0] >> start[1] >> start[2] >> axis[0] >> axis[1] >> axis[2] >>
        parent;
    skeleton.branches.push_back(make_branch(parent, start, start + length * axis, radius, radius));
  }
  return skeleton;
}

}  // namespace tremula::test
