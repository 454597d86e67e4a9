#include "tremula/deformation/bend_table.hpp"

#include <cmath>
#include <cstdlib>

#include <tbb/parallel_for.h>

namespace tremula {
namespace {

using Eigen::Vector2d;

constexpr int chain_pieces = 20, lanes = 4;

// From piece directions of the fine chain to those of the drawn one, x, y, z of four lanes.
std::array<float, 12> drawn(const BladeKind& kind, const Eigen::Matrix3Xd& fine) {
  std::array<float, 12> result = {0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1};
  const std::vector<double> joints = joints_of(kind);
  for (std::size_t piece = 0; piece + 1 < joints.size(); ++piece) {
    const auto first = std::lround(joints[piece] * chain_pieces),
               end = std::lround(joints[piece + 1] * chain_pieces);
    const Vec3 direction = fine.middleCols(first, end - first).rowwise().sum().normalized();
    for (std::size_t axis = 0; axis < 3; ++axis)
      result[lanes * axis + piece] = static_cast<float>(direction[static_cast<Eigen::Index>(axis)]);
  }
  return result;
}

Vector2d angles_at(int column, int row) {
  constexpr double most = 0.9;  // of m; farther out the shape is as there
  Vector2d m(2.0 * column / (bends_in_plane - 1) - 1, static_cast<double>(row) / (bends_across - 1));
  if (m.norm() > most) m *= most / m.norm();
  return m / (1 - m.norm());
}

void tabulate_half(const BladeKind& kind, const BladeResponse& blade, int number, bool forwards,
                   BendTable& table) {
  RodBender bender(blade.rod, trajectory(kind, number, chain_pieces), 1e-6);
  constexpr int middle = bends_in_plane / 2;
  // To and fro, so that every load is near the one before.
  for (int step = 0; step <= middle; ++step) {
    const int column = forwards ? middle + step : middle - step;
    for (int i = 0; i < bends_across; ++i) {
      const int row = step % 2 == 0 ? i : bends_across - 1 - i;
      const Vector2d angles = angles_at(column, row);
      const double size = angles.norm();
      const Vec3 heading = size > 0 ? Vec3(angles.x() / size, angles.y() / size, 0) : Vec3(Vec3::UnitX());
      const RodDrag drag{size * blade.load.along, size * blade.load.tip, blade.load.decay};
      const Eigen::Matrix3Xd& bent = bender.bend(drag, heading);
      if (forwards || column < middle)
        table.directions[index_of((number * bends_across + row) * bends_in_plane + column)] =
            drawn(kind, bent);
    }
  }
}

}  // namespace

BendTable tabulate_bends(const BladeKind& kind, const BladeResponse& blade) {
  BendTable table{.in_plane = bends_in_plane, .across = bends_across, .directions = {}};
  table.directions.resize(index_of(trajectories_per_kind * bends_in_plane * bends_across));
  tbb::parallel_for(0, 2 * trajectories_per_kind,
                    [&](int half) { tabulate_half(kind, blade, half / 2, half % 2 == 0, table); });
  return table;
}

BendTable tabulate_rest(const BladeKind& kind) {
  BendTable table;
  for (int number = 0; number < trajectories_per_kind; ++number)
    table.directions.push_back(drawn(kind, trajectory(kind, number, chain_pieces)));
  return table;
}

}  // namespace tremula
