#include "tremula/scene/placing.hpp"

#include "tremula/base/error.hpp"
#include "tremula/base/number_text.hpp"
#include "tremula/numerics/random.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

namespace tremula {
namespace {

constexpr std::int64_t too_many = std::int64_t{1} << 62;
constexpr std::uint32_t rules_per_object = 4096;
constexpr double most_covered = 0.45;  // of the field, by discs as wide as the distance
constexpr std::uint64_t tries = 1000;

// What is drawn for a copy, two numbers at a time: each pair has an address of its own.
enum class Drawn : std::uint64_t { place, size_and_turn, shift };

double between(double low, double high, double share) { return low + (high - low) * share; }

// The random numbers of one rule.
struct Draw {
  std::uint64_t seed = 0;
  std::uint32_t rule = 0;  // of the scene

  std::array<double, 2> operator()(std::int64_t copy, Drawn what, std::uint64_t again = 0) const {
    return two_uniforms(
        {seed, RandomStream::placing, rule,
         (again << 32U) + 4 * static_cast<std::uint64_t>(copy) + static_cast<std::uint64_t>(what)});
  }
};

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

// Rays to +x cross the border an odd number of times.
bool is_inside(const Polygon& polygon, const Eigen::Vector2d& point) {
  bool inside = false;
  for (std::size_t i = 0, last = polygon.size() - 1; i < polygon.size(); last = i++) {
    const Eigen::Vector2d &a = polygon[last], &b = polygon[i];
    if ((a.y() > point.y()) == (b.y() > point.y())) continue;
    if (point.x() < a.x() + (point.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x())) inside = !inside;
  }
  return inside;
}

bool is_masked(const Scatter& scatter, const Eigen::Vector2d& point) {
  return !masks_leave(scatter.inside, scatter.outside, point);
}

// What of the field the polygons may have copies in.
Eigen::AlignedBox2d field_of(const Scatter& scatter) {
  Eigen::AlignedBox2d field(scatter.low, scatter.high);
  if (scatter.inside.empty()) return field;
  Eigen::AlignedBox2d masks;
  for (const Polygon& polygon : scatter.inside) {
    for (const Eigen::Vector2d& corner : polygon) masks.extend(corner);
  }
  return field.intersection(masks);
}

double slots_of(const Scatter& scatter) {
  const Eigen::AlignedBox2d field = field_of(scatter);
  return field.isEmpty() ? 0 : std::round(scatter.density * field.volume());
}

// Points by the square cell that they stand in, so that neighbours are found in the nine around. Cells share
// buckets: whoever else is in one is far away, or near.
class Neighbours {
 public:
  Neighbours(double distance, std::size_t count)
      : distance_(distance), first_(std::bit_ceil(2 * count + 1), -1) {
    points_.reserve(count);
    next_.reserve(count);
  }

  void add(const Eigen::Vector2d& point) {
    int& first = first_[bucket(cell(point.x()), cell(point.y()))];
    next_.push_back(first);
    first = static_cast<int>(points_.size());
    points_.push_back(point);
  }
  bool is_free(const Eigen::Vector2d& point) const {
    const std::int64_t x = cell(point.x()), y = cell(point.y());
    for (std::int64_t i = x - 1; i <= x + 1; ++i) {
      for (std::int64_t j = y - 1; j <= y + 1; ++j) {
        for (int other = first_[bucket(i, j)]; other >= 0; other = next_[index_of(other)]) {
          if ((points_[index_of(other)] - point).squaredNorm() < distance_ * distance_) return false;
        }
      }
    }
    return true;
  }

 private:
  std::int64_t cell(double x) const {
    return static_cast<std::int64_t>(std::floor(std::clamp(x / distance_, -1e15, 1e15)));
  }
  std::size_t bucket(std::int64_t x, std::int64_t y) const {
    const std::uint64_t mixed =
        (static_cast<std::uint64_t>(x) * 0x9e3779b97f4a7c15U ^ static_cast<std::uint64_t>(y)) *
        0xd6e8feb86659fd93U;
    return static_cast<std::size_t>(mixed >> 32U) & (first_.size() - 1);
  }

  double distance_;
  std::vector<int> first_, next_;  // of a bucket, and after a point; -1: none
  std::vector<Eigen::Vector2d> points_;
};

Instance varied(const Variation& variation, const Draw& draw, std::int64_t copy, const Vec3& position) {
  Instance instance;
  instance.position = position;
  if (variation.scale[0] != variation.scale[1] || variation.turn[0] != variation.turn[1]) {
    const auto [size, turn] = draw(copy, Drawn::size_and_turn);
    instance.scale = between(variation.scale[0], variation.scale[1], size);
    instance.turn = between(variation.turn[0], variation.turn[1], turn);
  } else {
    instance.scale = variation.scale[0];
    instance.turn = variation.turn[0];
  }
  if (variation.random_shift > 0)
    instance.time_shift =
        between(-variation.random_shift, variation.random_shift, draw(copy, Drawn::shift)[0]);
  return instance;
}

void add_grid(const Grid& grid, const Draw& draw, std::vector<Instance>& placed) {
  std::int64_t copy = 0;
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column, ++copy) {
      Eigen::Vector2d off = Eigen::Vector2d::Zero();
      if (grid.jitter > 0) {
        const auto [x, y] = draw(copy, Drawn::place);
        off = {between(-grid.jitter, grid.jitter, x), between(-grid.jitter, grid.jitter, y)};
      }
      const Vec3 step((column - 0.5 * (grid.columns - 1) + off.x()) * grid.spacing.x(),
                      (row - 0.5 * (grid.rows - 1) + off.y()) * grid.spacing.y(), 0);
      placed.push_back(varied(grid, draw, copy, grid.centre + step));
    }
  }
}

// A slot whose first place is masked stays empty: that leaves the density where there are copies. One whose
// place is too near another tries elsewhere.
void add_scatter(const Scatter& scatter, const Draw& draw, const std::vector<std::vector<Instance>>& before,
                 std::vector<Instance>& placed) {
  const Eigen::AlignedBox2d field = field_of(scatter);
  const auto slots = static_cast<std::int64_t>(slots_of(scatter));
  const bool apart = scatter.distance > 0;
  std::size_t most = 0;
  if (apart) {
    most = placed.size() + static_cast<std::size_t>(slots);
    for (const auto& object : before) most += object.size();
  }
  Neighbours neighbours(apart ? scatter.distance : 1, most);
  if (apart) {
    for (const auto& object : before) {
      for (const Instance& instance : object) neighbours.add(instance.position.head<2>());
    }
    for (const Instance& instance : placed) neighbours.add(instance.position.head<2>());
  }
  for (std::int64_t copy = 0; copy < slots; ++copy) {
    for (std::uint64_t again = 0; again < tries; ++again) {
      const auto [x, y] = draw(copy, Drawn::place, again);
      const Eigen::Vector2d point(between(field.min().x(), field.max().x(), x),
                                  between(field.min().y(), field.max().y(), y));
      const bool masked = is_masked(scatter, point);
      if (masked && again == 0) break;
      if (masked || (apart && !neighbours.is_free(point))) continue;
      if (apart) neighbours.add(point);
      placed.push_back(varied(scatter, draw, copy, Vec3(point.x(), point.y(), scatter.height)));
      break;
    }
  }
}

void check_rule(const Variation& rule) {
  if (!(rule.scale[0] > 0) || !(rule.scale[1] >= rule.scale[0]) || !std::isfinite(rule.scale[1]))
    throw InputError("scale of copies", number_text(rule.scale[0]) + " to " + number_text(rule.scale[1]),
                     "finite numbers above 0, the smallest first");
  if (!rule.turn.allFinite() || !std::isfinite(rule.random_shift) || rule.random_shift < 0)
    throw InputError("copies", "a turn or a time that is no number", "finite numbers");
}

void check_crowd(const Crowd& crowd) {
  if (!crowd.instances.empty()) check_instances(crowd.instances);
  for (const Grid& grid : crowd.grids) {
    check_rule(grid);
    if (grid.columns < 1 || grid.rows < 1 || !grid.spacing.allFinite() || !grid.centre.allFinite() ||
        !(grid.jitter >= 0) || !std::isfinite(grid.jitter))
      throw InputError("grid", std::to_string(grid.columns) + " x " + std::to_string(grid.rows),
                       "columns and rows of finite numbers");
  }
  for (const Scatter& scatter : crowd.scatters) {
    check_rule(scatter);
    check_scatter(scatter);
  }
}

void check_count(std::span<const SceneObject> objects) {
  std::int64_t all = 0;
  for (const SceneObject& object : objects) {
    const std::int64_t count = count_instances(object.crowd);
    all = count > most_instances ? count : all + count;
    if (all > most_instances)
      throw InputError("instances", std::to_string(all), "at most " + std::to_string(most_instances));
  }
}

double wrapped(double time, double period) {
  const double rest = std::fmod(time, period);
  const double from_zero = rest < 0 ? rest + period : rest;
  return from_zero < period ? from_zero : 0;
}

void shift_times(const Crowd& crowd, const Vec3& advection, double period, std::vector<Instance>& placed) {
  const double square = advection.squaredNorm();
  const Vec3 slowness = crowd.travelling_gusts && square > 0 ? Vec3(advection / square) : Vec3(Vec3::Zero());
  for (Instance& instance : placed) {
    instance.time_shift =
        period > 0 ? wrapped(instance.time_shift - instance.position.dot(slowness), period) : 0;
  }
}

bool touch(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c,
           const Eigen::Vector2d& d) {
  const double at_c = cross(b - a, c - a), at_d = cross(b - a, d - a);
  const double at_a = cross(d - c, a - c), at_b = cross(d - c, b - c);
  return at_c * at_d < 0 && at_a * at_b < 0;
}

void check_polygon(const Polygon& polygon) {
  if (polygon.size() < 3)
    throw InputError("a polygon", std::to_string(polygon.size()) + " corners", "three or more");
  double area = 0, extent = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    if (!a.allFinite()) throw InputError("a polygon", "a corner that is not finite", "finite numbers");
    area += 0.5 * cross(a - polygon[0], b - polygon[0]);
    extent = std::max(extent, (a - polygon[0]).squaredNorm());
  }
  if (std::abs(area) <= 1e-12 * extent)
    throw InputError("a polygon", "no area", "corners that are not on one line");
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    for (std::size_t j = i + 2; j < polygon.size(); ++j) {
      const std::size_t after = (j + 1) % polygon.size();
      if (after != i && touch(polygon[i], polygon[i + 1], polygon[j], polygon[after])) {
        throw InputError("a polygon",
                         "sides " + std::to_string(i + 1) + " and " + std::to_string(j + 1) + " cross",
                         "a border that does not cross itself");
      }
    }
  }
}

}  // namespace

bool masks_leave(std::span<const Polygon> inside, std::span<const Polygon> outside,
                 const Eigen::Vector2d& place) {
  const auto holds = [&](const Polygon& polygon) { return is_inside(polygon, place); };
  return (inside.empty() || std::ranges::any_of(inside, holds)) && std::ranges::none_of(outside, holds);
}

void check_scatter(const Scatter& scatter) {
  if (!scatter.low.allFinite() || !scatter.high.allFinite() || !((scatter.high - scatter.low).minCoeff() > 0))
    throw InputError("the field", "it ends before it begins", "low below high, along x and y");
  if (!(scatter.density > 0) || !std::isfinite(scatter.density) || !std::isfinite(scatter.distance) ||
      !std::isfinite(scatter.height) || scatter.distance < 0)
    throw InputError("density", number_text(scatter.density), "a number above 0, and finite lengths");
  for (const auto* masks : {&scatter.inside, &scatter.outside}) {
    for (const Polygon& polygon : *masks) check_polygon(polygon);
  }
  const double covered = scatter.density * std::numbers::pi / 4 * scatter.distance * scatter.distance;
  if (covered > most_covered) {
    throw InputError("density", number_text(scatter.density) + " per m^2",
                     "at most " + number_text(scatter.density * most_covered / covered) +
                         " where they keep " + number_text(scatter.distance) + " m of distance");
  }
}

std::int64_t count_instances(const Crowd& crowd) {
  if (crowd.instances.empty() && crowd.grids.empty() && crowd.scatters.empty()) return 1;
  double count = static_cast<double>(crowd.instances.size());
  for (const Grid& grid : crowd.grids) count += static_cast<double>(grid.columns) * grid.rows;
  for (const Scatter& scatter : crowd.scatters) count += slots_of(scatter);
  return count < static_cast<double>(too_many) ? static_cast<std::int64_t>(count) : too_many;
}

std::vector<std::vector<Instance>> place_objects(std::span<const SceneObject> objects, const Vec3& advection,
                                                 double period) {
  if (!advection.allFinite() || !std::isfinite(period))
    throw InputError("wind and period", "no finite numbers", "finite numbers");
  check_count(objects);
  std::vector<std::vector<Instance>> placed;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const Crowd& crowd = objects[i].crowd;
    check_crowd(crowd);
    auto rule = static_cast<std::uint32_t>(i) * rules_per_object;
    std::vector<Instance> copies = crowd.instances;
    for (const Grid& grid : crowd.grids) add_grid(grid, {grid.seed, rule++}, copies);
    for (const Scatter& scatter : crowd.scatters)
      add_scatter(scatter, {scatter.seed, rule++}, placed, copies);
    if (crowd.instances.empty() && crowd.grids.empty() && crowd.scatters.empty()) copies.emplace_back();
    shift_times(crowd, advection, period, copies);
    placed.push_back(std::move(copies));
  }
  return placed;
}

std::vector<Instance> place_instances(const Crowd& crowd, const Vec3& advection, double period) {
  SceneObject object;
  object.crowd = crowd;
  return place_objects({&object, 1}, advection, period).front();
}

int nearest_heading(double turn, int headings) {
  if (headings < 1 || !std::isfinite(turn))
    throw InputError("headings", std::to_string(headings), "1 or more, and a finite turn");
  const double step = 2 * std::numbers::pi / headings;
  const double turns = std::remainder(turn, 2 * std::numbers::pi);
  const int nearest = static_cast<int>(std::lround(turns / step)) % headings;
  return nearest < 0 ? nearest + headings : nearest;
}

std::vector<std::vector<Instance>> split_by_heading(std::span<const Instance> instances, int headings) {
  nearest_heading(0, headings);  // refuses what is no number of headings
  std::vector<std::vector<Instance>> lists(static_cast<std::size_t>(headings));
  for (const Instance& instance : instances)
    lists[static_cast<std::size_t>(nearest_heading(instance.turn, headings))].push_back(instance);
  return lists;
}

}  // namespace tremula
