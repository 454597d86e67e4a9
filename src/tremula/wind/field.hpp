// Wind on a plane across the mean wind, as it blows through: what measurements, TurbSim files and the
// synthesis all give.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace tremula {

// Points of the plane and the times. x is along the mean wind, y to its left, z up; the plane is centred on
// y = 0.
struct WindGrid {
  int y_count = 1, z_count = 1, step_count = 1;
  double y_spacing = 1, z_spacing = 1;  // [m]
  double bottom = 1;                    // height of the lowest row [m]
  double step = 0.1;                    // [s]
  double mean_speed = 10;               // at the reference height, the one speed of Taylor's advection [m/s]
  double reference_height = 10;         // [m]
  bool periodic = true;                 // step step_count equals step 0

  double y(int j) const { return (j - 0.5 * (y_count - 1)) * y_spacing; }
  double z(int i) const { return bottom + i * z_spacing; }
  double period() const { return step_count * step; }
  std::size_t point_count() const {
    return static_cast<std::size_t>(y_count) * static_cast<std::size_t>(z_count);
  }
};

// velocity[c] has component c (u along the mean wind with the mean in it, v, w) [m/s] at
// (step * z_count + row) * y_count + column. A tower of single points below the grid, where there is one:
// tower[c] at step * tower_count + k, k-th point at height bottom - k z_spacing, y = 0.
struct WindField {
  WindGrid grid;
  std::array<std::vector<float>, 3> velocity;
  int tower_count = 0;
  std::array<std::vector<float>, 3> tower = {};
};

}  // namespace tremula
