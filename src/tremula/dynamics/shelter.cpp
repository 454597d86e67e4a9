#include "tremula/dynamics/shelter.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/error.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <span>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

namespace tremula {
namespace {

// In cells, from the mean of the places.
struct Grid {
  Eigen::VectorXd along;      // the wind
  Eigen::Matrix2Xd across;    // it
  std::vector<int> downwind;  // the sites from the first that the wind meets to the last
};

// The share that a site has in a column.
struct Entry {
  int rank;  // of the site in Grid::downwind
  double weight;
};

void check_places(const Eigen::Matrix3Xd& places, const Eigen::VectorXd& drag_area) {
  check_equal("drag areas of the sites", drag_area.size(), places.cols());
  if (!places.allFinite()) throw InputError("places of the sites", "numbers that are not finite", "metres");
  if (!drag_area.allFinite() || (drag_area.array() < 0).any())
    throw InputError("drag areas of the sites", "one below 0 or not finite", "0 or more");
}

void check_direction(const Vec3& direction) {
  constexpr double rounding = 1e-6;
  const double length = direction.norm();
  if (!(std::abs(length - 1) < rounding))
    throw InputError("length of the direction of the wind", std::to_string(length), "1");
}

Grid lay_grid(const Eigen::Matrix3Xd& places, const Vec3& direction, double cell) {
  if (!std::isfinite(cell) || cell <= 0)
    throw InputError("cell of the shelter", std::to_string(cell), "a number above 0");
  constexpr double most_cells = 1e9;
  const Eigen::Matrix3Xd from_mean = (places.colwise() - places.rowwise().mean()) / cell;
  if (!(from_mean.cwiseAbs().maxCoeff() < 0.5 * most_cells))
    throw InputError("cell of the shelter", std::to_string(cell) + " m",
                     "at least a billionth of the extent of the plant");
  // Level in a wind that is, so that grid and wind turn together.
  const Vec3 sideways = direction.unitOrthogonal();
  Grid grid;
  grid.along = from_mean.transpose() * direction;
  grid.across.resize(2, places.cols());
  grid.across << sideways.transpose() * from_mean, direction.cross(sideways).transpose() * from_mean;
  grid.downwind.resize(index_of(places.cols()));
  std::iota(grid.downwind.begin(), grid.downwind.end(), 0);
  std::ranges::sort(grid.downwind, [&](int a, int b) {
    return grid.along[a] != grid.along[b] ? grid.along[a] < grid.along[b] : a < b;
  });
  return grid;
}

// Column by column, downwind in each: memory goes with the sites, whatever the room between them.
struct Columns {
  std::vector<Entry> entries;
  std::vector<std::size_t> first;  // entry of each column, and behind the last
};

// The four columns about a cell, by their numbers.
class ColumnsAboutCells {
 public:
  const std::array<int, 4>& about(std::int64_t i, std::int64_t j) {
    const auto [cell, is_new] = about_.try_emplace(key(i, j));
    if (is_new) {
      for (int corner = 0; corner < 4; ++corner)
        cell->second[index_of(corner)] = number_of(i + (corner & 1), j + (corner >> 1));
    }
    return cell->second;
  }
  std::size_t count() const { return numbers_.size(); }

 private:
  static std::int64_t key(std::int64_t i, std::int64_t j) { return i * (std::int64_t{1} << 32) + j; }
  int number_of(std::int64_t i, std::int64_t j) {
    return numbers_.try_emplace(key(i, j), static_cast<int>(numbers_.size())).first->second;
  }

  std::unordered_map<std::int64_t, std::array<int, 4>> about_;
  std::unordered_map<std::int64_t, int> numbers_;
};

Columns share_among_columns(const Grid& grid) {
  ColumnsAboutCells cells;
  std::vector<std::pair<int, Entry>> downwind;  // and the column
  downwind.reserve(4 * grid.downwind.size());
  for (std::size_t rank = 0; rank < grid.downwind.size(); ++rank) {
    const Eigen::Array2d place = grid.across.col(grid.downwind[rank]), low = place.floor(), x = place - low;
    const std::array<int, 4>& about =
        cells.about(static_cast<std::int64_t>(low[0]), static_cast<std::int64_t>(low[1]));
    for (int corner = 0; corner < 4; ++corner) {
      const double weight = ((corner & 1) == 0 ? 1 - x[0] : x[0]) * (corner >> 1 == 0 ? 1 - x[1] : x[1]);
      downwind.push_back({about[index_of(corner)], {static_cast<int>(rank), weight}});
    }
  }
  Columns columns{std::vector<Entry>(downwind.size()), std::vector<std::size_t>(cells.count() + 1, 0)};
  for (const auto& [column, entry] : downwind) ++columns.first[index_of(column) + 1];
  std::partial_sum(columns.first.begin(), columns.first.end(), columns.first.begin());
  std::vector<std::size_t> next(columns.first.begin(), columns.first.end() - 1);
  for (const auto& [column, entry] : downwind) columns.entries[next[index_of(column)]++] = entry;
  return columns;
}

// For each of the places (ascending) the depths of those before it: in full from `ramp` cells on.
std::vector<double> sum_before(const std::vector<double>& places, const std::vector<double>& depths) {
  constexpr double ramp = 0.125;
  std::vector<double> sums(places.size());
  // From `passed` on they are within the ramp; moment: of these, about the place.
  double full = 0, within = 0, moment = 0;
  std::size_t passed = 0;
  for (std::size_t k = 0; k < places.size(); ++k) {
    if (k > 0) moment += within * (places[k] - places[k - 1]);
    for (; places[k] - places[passed] >= ramp; ++passed) {
      full += depths[passed];
      within -= depths[passed];
      moment -= depths[passed] * (places[k] - places[passed]);
    }
    sums[k] = std::max(0.0, full + moment / ramp);
    within += depths[k];
  }
  return sums;
}

// What is left of the wind at the sites of one column, weighted, added to theirs. `face` of it [m^2].
void blow_through(std::span<const Entry> column, const Grid& grid, const Eigen::VectorXd& drag_area,
                  double face, bool induction, Eigen::VectorXd& shelter) {
  const auto site = [&](std::size_t k) { return grid.downwind[index_of(column[k].rank)]; };
  const std::size_t count = column.size();
  std::vector<double> places(count), depths(count);  // depth: -ln of what a site leaves of the wind
  std::vector<double> upwind_places(count), upwind_depths(count);
  for (std::size_t k = 0; k < count; ++k) {
    places[k] = grid.along[site(k)];
    depths[k] = 0.5 * column[k].weight * drag_area[site(k)] / face;
    upwind_places[count - 1 - k] = -places[k];
    upwind_depths[count - 1 - k] = depths[k];
  }
  const std::vector<double> before = sum_before(places, depths);
  const std::vector<double> behind = sum_before(upwind_places, upwind_depths);
  for (std::size_t k = 0; k < count; ++k) {
    const double left = std::exp(-before[k]), behind_it = std::exp(-behind[count - 1 - k]);
    const double through = left * behind_it, thrust = induction ? 1 - through * through : 0;
    // (1 - i)^2 thrust = 4 i (1 - i)
    shelter[site(k)] += column[k].weight * left * 4 / (4 + thrust);
  }
}

}  // namespace

Eigen::VectorXd find_shelter(const Eigen::Matrix3Xd& places, const Eigen::VectorXd& drag_area,
                             const Vec3& direction, const ShelterOptions& options) {
  check_places(places, drag_area);
  check_direction(direction);
  if (!options.on || places.cols() == 0) return Eigen::VectorXd::Ones(places.cols());
  const Grid grid = lay_grid(places, direction, options.cell);
  const Columns columns = share_among_columns(grid);
  Eigen::VectorXd shelter = Eigen::VectorXd::Zero(places.cols());
  for (std::size_t k = 0; k + 1 < columns.first.size(); ++k) {
    blow_through({&columns.entries[columns.first[k]], columns.first[k + 1] - columns.first[k]}, grid,
                 drag_area, options.cell * options.cell, options.induction, shelter);
  }
  return shelter.cwiseMin(1);
}

}  // namespace tremula
