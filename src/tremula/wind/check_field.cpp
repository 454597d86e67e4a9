#include "tremula/wind/check_field.hpp"

#include "tremula/base/error.hpp"
#include "tremula/base/number_text.hpp"

#include <cmath>
#include <string>

namespace tremula {
namespace {

void check_count(const char* what, int count, int least) {
  if (count >= least) return;
  throw InputError(std::string("wind field: ") + what, std::to_string(count),
                   std::to_string(least) + " or more");
}

void check_number(const char* what, double value, bool good, const char* wanted) {
  if (!good || !std::isfinite(value))
    throw InputError(std::string("wind field: ") + what, number_text(value), wanted);
}

void check_size(const char* what, std::size_t size, std::size_t points, int steps) {
  const std::size_t wanted = points * static_cast<std::size_t>(steps);
  if (size == wanted) return;
  throw InputError(std::string("wind field: ") + what, std::to_string(size) + " values",
                   std::to_string(wanted) + " for " + std::to_string(points) + " points and " +
                       std::to_string(steps) + " steps");
}

}  // namespace

void check_wind_field(const WindField& field) {
  const WindGrid& grid = field.grid;
  check_count("points across", grid.y_count, 1);
  check_count("rows", grid.z_count, 1);
  check_count("steps", grid.step_count, 1);
  check_count("points of the tower", field.tower_count, 0);
  check_number("spacing across", grid.y_spacing, grid.y_spacing > 0 || grid.y_count == 1,
               "a length above 0 m");
  check_number("spacing of the rows", grid.z_spacing,
               grid.z_spacing > 0 || (grid.z_count == 1 && field.tower_count == 0), "a length above 0 m");
  check_number("height of the lowest row", grid.bottom, true, "a finite number");
  check_number("step", grid.step, grid.step > 0, "a time above 0 s");
  check_number("mean speed", grid.mean_speed, grid.mean_speed >= 0, "0 m/s or more");
  check_number("reference height", grid.reference_height, true, "a finite number");
  for (std::size_t c = 0; c < 3; ++c) {
    check_size("velocity", field.velocity[c].size(), grid.point_count(), grid.step_count);
    if (field.tower_count > 0 || !field.tower[c].empty()) {
      check_size("tower", field.tower[c].size(), static_cast<std::size_t>(field.tower_count),
                 grid.step_count);
    }
  }
}

}  // namespace tremula
