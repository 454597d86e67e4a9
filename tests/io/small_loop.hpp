// A plant that moves, made here: what writers of loops write.
#pragma once

#include <cmath>

#include "trees.hpp"
#include "tremula/deformation/loop.hpp"
#include "tremula/modes/solve_modes.hpp"

namespace tremula::test {

constexpr int small_loop_modes = 6, small_loop_samples = 48;

// Without any order in it, and the same every time; -1 … 1.
inline Eigen::MatrixXd numbers(Eigen::Index rows, Eigen::Index columns, double what) {
  return Eigen::MatrixXd::NullaryExpr(rows, columns, [&](Eigen::Index i, Eigen::Index j) {
    return std::sin(what + 1.7 * static_cast<double>(i) + 2.9 * static_cast<double>(j));
  });
}

inline Loop small_loop() {
  const Skeleton skeleton = awkward_tree();
  const Structure structure = assemble(skeleton, test::weightless({.root = {.rotation = 1e4}}));
  const Modes modes = solve_modes(structure, {.count = small_loop_modes});
  const Eigen::Index rows = structure.size();
  const StaticShapes more{Eigen::Vector3d(50, 60, 70), numbers(rows, 3, 0)};
  Motion motion{.period = 2,
                .basis = join(0.02 * numbers(rows, 1, 1), modes, more),
                .coordinates = 0.02 * numbers(small_loop_samples, 1 + small_loop_modes + 3, 2)};
  motion.coordinates.col(0).setOnes();
  return make_loop(structure, mesh_surface(skeleton), motion,
                   {.name = "awkward", .frames_per_second = 24, .wind_speed = 6, .heading = 20, .seed = 4});
}

}  // namespace tremula::test
