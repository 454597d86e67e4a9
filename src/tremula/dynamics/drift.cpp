#include "tremula/dynamics/drift.hpp"

#include "tremula/base/check.hpp"
#include "tremula/numerics/random.hpp"
#include "tremula/wind/profile.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <utility>

#include <tbb/parallel_for.h>

namespace tremula {
namespace {

using Eigen::Vector3f;

constexpr double gravity = 9.81;       // [m/s^2]
constexpr double slowest_fall = 0.01;  // [m/s]
constexpr double most_spreads = 3;     // standard deviations of fall speeds
constexpr std::size_t candidates_a_task = 2048;

// Atlas, Srivastava & Sekhon 1973, of Gunn & Kinzer's table: [m/s] of a diameter [m], from 0.6 mm on.
double fall_speed_of_drop(double diameter) { return 9.65 - 10.3 * std::exp(-600 * diameter); }

bool has_exponential_sizes(DriftForm form) { return form == DriftForm::flake || form == DriftForm::drop; }

// The size that this share of them do not reach.
double size_at(const DriftKind& kind, double share) {
  if (!has_exponential_sizes(kind.form)) return kind.smallest + share * (kind.largest - kind.smallest);
  const double mean = kind.size - kind.smallest;
  if (!(mean > 0)) return kind.smallest;
  const double within = 1 - std::exp(-(kind.largest - kind.smallest) / mean);
  return kind.smallest - mean * std::log(1 - share * within);
}

// Of matter through a square metre, one of each in a cubic metre [kg/(m^2 s)].
double mean_mass_flux(const DriftKind& kind) {
  constexpr int count = 512;
  double sum = 0;
  for (int i = 0; i < count; ++i) {
    const double size = size_at(kind, (i + 0.5) / count);
    sum += kind.matter_density * std::numbers::pi / 6 * size * size * size * fall_speed(kind, size);
  }
  return sum / count;
}

// One that may come in, as drawn.
struct Candidate {
  Vec3 place = Vec3::Zero();
  double birth = 0, size = 0, fall_speed = 0, tau = 0;
  double choice = 0;  // comes in if below its share of the largest flux
  std::uint32_t mark = 0;
};

// A rectangle across an axis through which they come, or (axis -1) a box in which they are let go.
struct Door {
  std::uint32_t number = 0;
  int axis = -1;
  double inwards = 1;  // along the axis
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();
  double largest_flux = 0;  // speed inwards that no one exceeds [m/s]
  std::size_t candidates = 0;
};

double normal_number(double a, double b) {
  return std::sqrt(-2 * std::log(1 - a)) * std::cos(2 * std::numbers::pi * b);
}

Candidate draw(const Drift& drift, const Door& door, double period, std::uint64_t number) {
  const auto pair = [&](std::uint32_t of) {
    return two_uniforms({drift.seed, RandomStream::drift, door.number + 16 * of, number});
  };
  const auto [x, y] = pair(0);
  const auto [z, time] = pair(1);
  const auto [choice, size] = pair(2);
  const auto [radius, angle] = pair(3);
  Candidate candidate;
  candidate.place = door.low + (door.high - door.low).cwiseProduct(Vec3(x, y, z));
  candidate.birth = period * time;
  candidate.choice = choice;
  candidate.size = size_at(drift.kind, size);
  const double spread =
      std::clamp(normal_number(radius, angle), -most_spreads, most_spreads) * drift.kind.fall_spread;
  candidate.fall_speed = std::max(fall_speed(drift.kind, candidate.size) * (1 + spread), slowest_fall);
  candidate.tau = candidate.fall_speed / gravity;
  candidate.mark = static_cast<std::uint32_t>(4294967296.0 * pair(4)[0]);
  return candidate;
}

class Carrier {
 public:
  Carrier(const TravellingField& gusts, const Drift& drift, double sample_step)
      : gusts_(gusts), drift_(drift), sample_step_(sample_step), lands_(drift.low.z() <= gusts.ground) {
    low_ = drift.low;
    if (lands_) low_.z() = gusts.ground;
  }

  std::vector<Door> doors() const;

  // Appends the path of one that comes in.
  void follow(const Candidate& candidate, const Door& door, std::vector<DriftPath>& paths,
              std::vector<std::array<std::int16_t, 3>>& off_line) const;

 private:
  Vec3 wind(const Vec3& place, double time) const { return value_at(gusts_, place, time); }
  Vec3 velocity_on_entry(const Candidate& candidate) const;
  std::pair<Vec3, Vec3> step(const Vec3& place, const Vec3& velocity, double time, double duration,
                             const Candidate& candidate) const;
  std::pair<double, int> share_inside(const Vec3& from, const Vec3& to) const;

  const TravellingField& gusts_;
  const Drift& drift_;
  double sample_step_;
  Vec3 low_;
  bool lands_;
};

// No wind of the field is faster, about the mean and with it, along each axis of the world.
std::pair<Vec3, Vec3> largest_speeds(const TravellingField& gusts) {
  Vec3 local = Vec3::Zero(), mean = Vec3::Zero();
  for (const auto& value : gusts.values) {
    for (int c = 0; c < 3; ++c)
      local[c] = std::max(local[c], static_cast<double>(std::abs(value[index_of(c)])));
  }
  for (const Vec3& layer : gusts.mean) mean = mean.cwiseMax(layer.cwiseAbs());
  const Vec3 along = heading_direction(gusts.heading).cwiseAbs();
  return {Vec3(along.x() * local.x() + along.y() * local.y(), along.y() * local.x() + along.x() * local.y(),
               local.z()),
          mean};
}

double fastest_of(const DriftKind& kind) {
  return fall_speed(kind, kind.largest) * (1 + most_spreads * kind.fall_spread);
}

std::vector<Door> Carrier::doors() const {
  const double period = gusts_.loop.period;
  if (drift_.source) {
    return {{.number = 5,
             .low = drift_.source->low,
             .high = drift_.source->high,
             .candidates = static_cast<std::size_t>(std::round(drift_.source->rate * period))}};
  }
  const auto [gust, mean] = largest_speeds(gusts_);
  const Vec3 size = drift_.high - low_;
  std::vector<Door> doors;
  double expected = 0;
  for (std::uint32_t number = 0; number < 6; ++number) {
    const int axis = static_cast<int>(number / 2);
    const bool at_high = number % 2 == 1;
    if (axis == 2 && !at_high && lands_) continue;  // nothing rises from the ground
    Door door{
        .number = number, .axis = axis, .inwards = at_high ? -1.0 : 1.0, .low = low_, .high = drift_.high};
    (at_high ? door.low : door.high)[axis] = (at_high ? drift_.high : low_)[axis];
    door.largest_flux = gust[axis] + mean[axis];
    if (axis == 2) door.largest_flux = at_high ? gust.z() + fastest_of(drift_.kind) : gust.z();
    const double area = size.x() * size.y() * size.z() / size[axis];
    const double count = drift_.kind.number_density * area * period * door.largest_flux;
    expected += count;
    door.candidates = static_cast<std::size_t>(std::round(std::min(count, 1e12)));
    doors.push_back(door);
  }
  if (expected > 20 * most_drifting)
    throw InputError("drift of " + drift_.kind.name, number_text(expected) + " that might come in in a loop",
                     "at most " + number_text(20 * most_drifting) + ": take a smaller box or fewer of them");
  return doors;
}

// What the lag has made of the wind it came through: the mean over the past, weighted by exp(-s/tau) (three
// nodes of Gauss and Laguerre), on the way it came in the mean wind.
Vec3 Carrier::velocity_on_entry(const Candidate& candidate) const {
  constexpr std::array<double, 3> nodes = {0.4157745567834791, 2.294280360279042, 6.289945082937479};
  constexpr std::array<double, 3> weights = {0.7110930099291730, 0.2785177335692408, 0.0103892565015861};
  const Vec3 falling(0, 0, -candidate.fall_speed);
  const Vec3 back = mean_at(gusts_, candidate.place.z()) + falling;
  Vec3 velocity = falling;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const double ago = nodes[i] * candidate.tau;
    velocity += weights[i] * wind(candidate.place - ago * back, candidate.birth - ago);
  }
  return velocity;
}

// Exact for a wind that stays what it is in the middle of the step; of second order else, however small tau.
std::pair<Vec3, Vec3> Carrier::step(const Vec3& place, const Vec3& velocity, double time, double duration,
                                    const Candidate& candidate) const {
  const double kept = std::exp(-duration / candidate.tau), lagged = candidate.tau * (1 - kept);
  const Vec3 target =
      wind(place + 0.5 * duration * velocity, time + 0.5 * duration) - candidate.fall_speed * Vec3::UnitZ();
  return {place + duration * target + lagged * (velocity - target), target + kept * (velocity - target)};
}

// What part of a straight step lies within the box, 1: all of it; and the axis of the side it leaves by.
std::pair<double, int> Carrier::share_inside(const Vec3& from, const Vec3& to) const {
  double share = 1;
  int side = -1;
  for (int axis = 0; axis < 3; ++axis) {
    const double move = to[axis] - from[axis];
    const double limit = move > 0 ? drift_.high[axis] : low_[axis];
    if (move > 0 ? to[axis] <= limit : to[axis] >= limit) continue;
    const double until = std::clamp((limit - from[axis]) / move, 0.0, 1.0);
    if (until < share || side < 0) share = until, side = axis;
  }
  return {share, side};
}

void Carrier::follow(const Candidate& candidate, const Door& door, std::vector<DriftPath>& paths,
                     std::vector<std::array<std::int16_t, 3>>& off_line) const {
  const bool let_go = door.axis < 0;
  Vec3 place = candidate.place, velocity = let_go ? Vec3::Zero() : velocity_on_entry(candidate);
  if (!let_go && !(candidate.choice * door.largest_flux < door.inwards * velocity[door.axis])) return;
  constexpr double longest_part = 0.063;  // [s] a gust of 1 Hz comes out to a hundredth
  const int parts = static_cast<int>(std::ceil(sample_step_ / longest_part));  // of a sample
  const double part = sample_step_ / parts;
  const double longest = 10 * gusts_.loop.period + 50 * (drift_.high.z() - low_.z()) / candidate.fall_speed;
  const Vec3 first_velocity = velocity;
  std::vector<Vec3> samples = {Vec3::Zero(), place};
  double air_time = -1;
  bool rests = false;
  int more = 2;  // samples after the end, for the cubic
  for (int number = 0; more > 0; ++number) {
    const double age = number * part;
    auto [next, next_velocity] = step(place, velocity, candidate.birth + age, part, candidate);
    if (air_time < 0) {
      const auto [share, side] = share_inside(place, next);
      if (side >= 0 || age > longest) air_time = age + share * part;
      rests = lands_ && side == 2 && next.z() < place.z();
    }
    place = next, velocity = next_velocity;
    if (number % parts == parts - 1) {
      samples.push_back(place);
      if (air_time >= 0) --more;
    }
  }
  if (!(air_time > 1e-3)) return;  // it only touched the box
  samples[0] = samples[2] - 2 * sample_step_ * first_velocity;

  DriftPath path;
  path.birth = static_cast<float>(candidate.birth);
  path.air_time = static_cast<float>(air_time);
  path.size = static_cast<float>(candidate.size);
  path.fall_speed = static_cast<float>(candidate.fall_speed);
  path.mark = candidate.mark;
  path.count = static_cast<std::uint32_t>(samples.size());
  path.first = off_line.size();
  const auto last = static_cast<double>(samples.size() - 2);
  path.start = candidate.place.cast<float>();
  path.velocity = ((samples.back() - candidate.place) / (last * sample_step_)).cast<float>();
  double most = 1e-12;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples[i] -= path.start.cast<double>() +
                  (static_cast<double>(i) - 1) * sample_step_ * path.velocity.cast<double>();
    most = std::max(most, samples[i].cwiseAbs().maxCoeff());
  }
  path.unit = static_cast<float>(most / 32000);
  for (const Vec3& off : samples) {
    const Vec3 units = off / static_cast<double>(path.unit);
    off_line.push_back({static_cast<std::int16_t>(std::lround(units.x())),
                        static_cast<std::int16_t>(std::lround(units.y())),
                        static_cast<std::int16_t>(std::lround(units.z()))});
  }
  if (rests) path.lying_time = static_cast<float>(drift_.lying_time);
  paths.push_back(path);
}

void check_box(const char* what, const Vec3& low, const Vec3& high, bool flat) {
  const Vec3 size = high - low;
  if (size.allFinite() && (flat ? size.minCoeff() >= 0 : size.minCoeff() > 0)) return;
  throw InputError(what,
                   "from (" + number_text(low.x()) + ", " + number_text(low.y()) + ", " +
                       number_text(low.z()) + ") to (" + number_text(high.x()) + ", " +
                       number_text(high.y()) + ", " + number_text(high.z()) + ")",
                   "a low corner below a high one");
}

void check_kind(const DriftKind& kind) {
  const std::string of = " of " + kind.name;
  check_positive(("number density" + of).c_str(), kind.number_density, " /m^3");
  if (!(kind.matter_density > 0) || !(kind.matter_density <= heaviest_matter)) {
    throw InputError("matter density" + of, number_text(kind.matter_density) + " kg/m^3",
                     "above 0 to " + number_text(heaviest_matter) + ": stone does not drift");
  }
  if (!(kind.smallest > 0) || !(kind.size >= kind.smallest) || !(kind.largest >= kind.size) ||
      !(kind.largest <= 1)) {
    throw InputError("size" + of,
                     number_text(kind.size) + " m from " + number_text(kind.smallest) + " to " +
                         number_text(kind.largest) + " m",
                     "above 0 to 1 m, between the smallest and the largest");
  }
  if (!(kind.fall_spread >= 0 && kind.fall_spread <= 1))
    throw InputError("spread of the fall speed" + of, number_text(kind.fall_spread), "0 to 1");
  if (!(kind.fall_speed >= slowest_fall) || !(fastest_of(kind) <= fastest_fall)) {
    throw InputError("fall speed" + of, number_text(kind.fall_speed) + " m/s",
                     number_text(slowest_fall) + " to " + number_text(fastest_fall) +
                         " m/s, the largest and fastest included: stone does not drift");
  }
}

// Many that are followed one after the other, in a block of their own.
struct Block {
  std::vector<DriftPath> paths;
  std::vector<std::array<std::int16_t, 3>> off_line;
};

void append(Block& block, DriftPaths& to) {
  for (DriftPath& path : block.paths) {
    path.first += to.off_line.size();
    to.paths.push_back(path);
  }
  to.off_line.insert(to.off_line.end(), block.off_line.begin(), block.off_line.end());
  block = {};
}

}  // namespace

const std::vector<DriftKind>& drift_kinds() {
  static const std::vector<DriftKind> kinds = {
      {.name = "snow", .fall_spread = 0.12},
      {.name = "rain",
       .form = DriftForm::drop,
       .number_density = 147,
       .matter_density = 1000,
       .size = 0.00134,
       .smallest = 0.001,
       .largest = 0.006,
       .fall_speed = 5.04},
      {.name = "leaves",
       .form = DriftForm::leaf,
       .number_density = 0.02,
       .matter_density = 500,
       .size = 0.06,
       .smallest = 0.045,
       .largest = 0.075,
       .fall_speed = 1.3,
       .fall_spread = 0.2},
      {.name = "seeds",
       .form = DriftForm::seed,
       .number_density = 0.02,
       .matter_density = 300,
       .size = 0.035,
       .smallest = 0.03,
       .largest = 0.04,
       .fall_speed = 1.2,
       .fall_spread = 0.1},
  };
  return kinds;
}

const DriftKind& drift_kind_named(std::string_view name) {
  for (const DriftKind& kind : drift_kinds()) {
    if (kind.name == name) return kind;
  }
  throw InputError("kind of drift", "'" + std::string(name) + "'", "snow, rain, leaves or seeds");
}

double fall_speed(const DriftKind& kind, double size) {
  switch (kind.form) {
    case DriftForm::flake:  // Locatelli & Hobbs 1974
      return kind.fall_speed * std::pow(size / kind.size, 0.16);
    case DriftForm::drop:
      return kind.fall_speed * std::max(fall_speed_of_drop(size) / fall_speed_of_drop(kind.size), 0.05);
    case DriftForm::leaf:
    case DriftForm::seed:
      break;
  }
  return kind.fall_speed;
}

DriftKind with_intensity(DriftKind kind, double intensity) {
  check_positive(("intensity of " + kind.name).c_str(), intensity, " mm/h");
  if (!has_exponential_sizes(kind.form))
    throw InputError("intensity of " + kind.name, number_text(intensity) + " mm/h", "a density [1/m^3]");
  if (kind.form == DriftForm::drop) {  // Marshall & Palmer 1948
    const double slope = 4100 * std::pow(intensity, -0.21);
    const double size = std::min(kind.smallest + 1 / slope, kind.largest);
    kind.fall_speed *= fall_speed_of_drop(size) / fall_speed_of_drop(kind.size);
    kind.size = size;
    kind.number_density = 8e6 / slope * std::exp(-slope * kind.smallest);
    return kind;
  }
  kind.number_density = intensity / 3600 / mean_mass_flux(kind);  // 1 mm of water is 1 kg/m^2
  return kind;
}

DriftKind with_size(DriftKind kind, double size) {
  check_positive(("size of " + kind.name).c_str(), size, " m");
  const double larger = size / kind.size;
  kind.fall_speed = fall_speed(kind, size);
  kind.size = size;
  kind.smallest *= larger;
  kind.largest *= larger;
  return kind;
}

DriftKind with_matter_density(DriftKind kind, double matter_density) {
  kind.fall_speed *= std::sqrt(std::max(matter_density, 0.0) / kind.matter_density);
  kind.matter_density = matter_density;
  check_kind(kind);
  return kind;
}

void check_drift(const Drift& drift) {
  check_kind(drift.kind);
  const std::string of = " of " + drift.kind.name;
  check_box(("box" + of).c_str(), drift.low, drift.high, false);
  if (!(drift.lying_time >= 0) || !(drift.lying_time <= 3600))
    throw InputError("time that " + drift.kind.name + " lies", number_text(drift.lying_time) + " s",
                     "0 to 3600 s");
  if (drift.source) {
    check_box(("source" + of).c_str(), drift.source->low, drift.source->high, true);
    check_positive(("rate of the source" + of).c_str(), drift.source->rate, " /s");
    if (!((drift.source->low - drift.low).minCoeff() >= 0) ||
        !((drift.high - drift.source->high).minCoeff() >= 0))
      throw InputError("source" + of, "a box that reaches beyond that of the drift", "one within it");
  }
}

FieldPlane plane_around(const Drift& drift, double heading, double ground) {
  std::vector<Vec3> corners;
  for (int i = 0; i < 4; ++i) {
    corners.emplace_back((i % 2 == 0 ? drift.low : drift.high).x(), (i / 2 == 0 ? drift.low : drift.high).y(),
                         0);
  }
  // Gusts get larger with the height, and so do layers.
  std::vector<double> heights = {0.5};
  while (heights.back() < drift.high.z() - ground) heights.push_back(1.6 * heights.back());
  const double width = (drift.high - drift.low).head<2>().norm();
  return plane_across(corners, heading, std::max(1.0, width / 64), heights);
}

DriftPaths carry(const TravellingField& gusts, const Drift& drift) {
  check_drift(drift);
  check_plane(gusts.plane, gusts.loop);
  if (!(drift.high.z() > gusts.ground))
    throw InputError("box of " + drift.kind.name, "up to " + number_text(drift.high.z()) + " m",
                     "above the ground at " + number_text(gusts.ground) + " m");
  DriftPaths result;
  result.loop = gusts.loop;
  result.form = drift.kind.form;
  result.step = std::clamp(drift.kind.fall_speed / gravity, 0.05, 0.25);
  result.ground = static_cast<float>(gusts.ground);
  const double seen = drift.source
                          ? drift.source->rate * (drift.high.z() - drift.low.z()) / drift.kind.fall_speed
                          : drift.kind.number_density * (drift.high - drift.low).prod();
  const double samples = seen * gusts.loop.period / result.step;
  if (!(seen <= most_drifting) || !(samples <= most_drift_samples)) {
    throw InputError("drift of " + drift.kind.name,
                     number_text(seen) + " in the air at a time, of " + number_text(samples) + " samples",
                     "at most " + number_text(most_drifting) + " and " + number_text(most_drift_samples) +
                         ": take a smaller box, fewer of them or a shorter loop");
  }
  const Carrier carrier(gusts, drift, result.step);
  for (const Door& door : carrier.doors()) {
    const std::size_t count = (door.candidates + candidates_a_task - 1) / candidates_a_task;
    std::vector<Block> blocks(count);
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t number) {
      const std::size_t first = number * candidates_a_task;
      const std::size_t last = std::min(first + candidates_a_task, door.candidates);
      for (std::size_t i = first; i < last; ++i)
        carrier.follow(draw(drift, door, gusts.loop.period, i), door, blocks[number].paths,
                       blocks[number].off_line);
    });
    for (Block& block : blocks) append(block, result);
  }
  return result;
}

double mean_seen(const DriftPaths& paths) {
  double sum = 0;
  for (const DriftPath& path : paths.paths)
    sum += static_cast<double>(path.air_time) + static_cast<double>(path.lying_time);
  return sum / paths.loop.period;
}

DriftPaths thinned(const DriftPaths& paths, double share) {
  DriftPaths fewer;
  fewer.loop = paths.loop;
  fewer.form = paths.form;
  fewer.step = paths.step;
  fewer.ground = paths.ground;
  for (const DriftPath& path : paths.paths) {
    if (!(uniform({path.mark, RandomStream::drift, 0, 2}) < share)) continue;
    const auto samples = paths.off_line.begin() + static_cast<std::ptrdiff_t>(path.first);
    fewer.paths.push_back(path);
    fewer.paths.back().first = fewer.off_line.size();
    fewer.off_line.insert(fewer.off_line.end(), samples, samples + path.count);
  }
  return fewer;
}

namespace {

struct OnPath {
  float within = 0;            // its age in the air
  std::uint32_t interval = 0;  // of samples
  float share = 0;             // of the interval
};

OnPath on_path(const DriftPaths& paths, const DriftPath& path, float age) {
  const float within = std::clamp(age, 0.0F, path.air_time);
  const float position = within / static_cast<float>(paths.step);
  const auto interval = std::min(static_cast<std::uint32_t>(position), path.count - 4);
  return {within, interval, position - static_cast<float>(interval)};
}

}  // namespace

const std::array<std::int16_t, 3>* samples_at(const DriftPaths& paths, const DriftPath& path, float age) {
  return paths.off_line.data() + path.first + on_path(paths, path, age).interval;
}

Vector3f place_at(const DriftPaths& paths, const DriftPath& path, float age) {
  const auto [within, interval, t] = on_path(paths, path, age);
  const std::array<float, 4> weights = {((-0.5F * t + 1) * t - 0.5F) * t, (1.5F * t - 2.5F) * t * t + 1,
                                        ((-1.5F * t + 2) * t + 0.5F) * t, (0.5F * t - 0.5F) * t * t};
  const auto* samples = paths.off_line.data() + path.first + interval;
  Vector3f off = Vector3f::Zero();
  for (std::size_t i = 0; i < weights.size(); ++i)
    off += weights[i] * Vector3f(samples[i][0], samples[i][1], samples[i][2]);
  Vector3f place = path.start + within * path.velocity + path.unit * off;
  if (age > path.air_time && path.lying_time > 0) place.z() = paths.ground;
  return place;
}

double within_loop(double time, double period) {
  constexpr double fineness = 1 << 30;
  double share = std::fmod(time / period, 1.0);
  if (share < 0) share += 1;
  share = std::round(share * fineness) / fineness;
  return share < 1 ? share * period : 0;
}

std::vector<DriftSight> drift_at(const DriftPaths& paths, double time) {
  const double period = paths.loop.period, now = within_loop(time, period);
  std::vector<DriftSight> seen;
  for (std::size_t i = 0; i < paths.paths.size(); ++i) {
    const DriftPath& path = paths.paths[i];
    const double until = static_cast<double>(path.air_time) + static_cast<double>(path.lying_time);
    double age = now - static_cast<double>(path.birth);
    if (age < 0) age += period;
    for (; age < until; age += period) {
      const auto rounded = static_cast<float>(age);
      seen.push_back({place_at(paths, path, rounded), static_cast<std::uint32_t>(i), rounded});
    }
  }
  return seen;
}

}  // namespace tremula
