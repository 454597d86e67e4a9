// What the wind carries and gravity brings down: snow, rain, leaves, seeds (F figure 6). Each is a point that
// follows the wind where it is with a lag and falls through it,
//
//   dx/dt = v,   dv/dt = (u(x, t) - w e_z - v)/tau,   tau = w/g,
//
// w its fall speed in still air: the drag that carries its weight at that speed, taken as linear. The wind is
// a field that loops, so a path that starts a loop later is the same path: all that were ever born are known
// from those that are born within one loop, and at t and t + T the same are in the air, elsewhere none.
#pragma once

#include "tremula/base/types.hpp"
#include "tremula/numerics/time_axis.hpp"
#include "tremula/wind/travelling_field.hpp"

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tremula {

enum class DriftForm { flake, drop, leaf, seed };

// Sizes are diameters, of leaves and seeds the length.
struct DriftKind {
  std::string name;
  DriftForm form = DriftForm::flake;
  double number_density = 10;  // in the air [1/m^3]
  double matter_density = 16;  // of itself, within its outline [kg/m^3]
  // Flakes and drops: exponential above the smallest, with this mean, cut off at the largest. Leaves and
  // seeds: any between smallest and largest.
  double size = 0.004, smallest = 0.002, largest = 0.012;  // [m]
  double fall_speed = 1;   // of one of that size [m/s]; that of others follows a law of the form
  double fall_spread = 0;  // standard deviation at one size, of the fall speed
};

// snow, rain, leaves, seeds. The theory chapter says where the numbers come from.
const std::vector<DriftKind>& drift_kinds();
const DriftKind& drift_kind_named(std::string_view name);  // throws InputError for other names

// As much of it as falls, of snow melted [mm/h]: how many are in the air, and of rain how large they are.
// Throws InputError for what is measured otherwise (leaves, seeds).
DriftKind with_intensity(DriftKind kind, double intensity);
// Larger or smaller ones, that fall as fast as their form does at that size [m].
DriftKind with_size(DriftKind kind, double size);
// Heavier or lighter ones fall as the square root of their density.
DriftKind with_matter_density(DriftKind kind, double matter_density);

double fall_speed(const DriftKind& kind, double size);  // [m/s]

struct Drift {
  DriftKind kind = {};
  // Nothing is known outside of this box [m]: who comes in through its sides is born there, as many as keep
  // the number density, and who leaves it is gone.
  Vec3 low = {-10, -10, 0}, high = {10, 10, 10};
  double lying_time = 0;  // how long one on the ground is seen before it has melted or is gone [s]
  // Instead of those that come in: so many let go each second anywhere in a box, a crown [1/s].
  struct Source {
    Vec3 low = Vec3::Zero(), high = Vec3::Zero();
    double rate = 1;
  };
  std::optional<Source> source = {};
  std::uint64_t seed = 1;
};

// Throws InputError for boxes, sizes and speeds that are none, for what is heavier than stone or falls faster
// than anything that wind carries.
void check_drift(const Drift& drift);

inline constexpr double heaviest_matter = 2000;  // [kg/m^3]
inline constexpr double fastest_fall = 60;       // [m/s]

// Where a drift has to know the wind; layers count from the ground, which is at this height [m].
FieldPlane plane_around(const Drift& drift, double heading, double ground = 0);

// From where one comes into the air to where it leaves it, and lies. Its place is a straight line and what it
// is off that, at every `step`, beginning one step before its birth.
struct DriftPath {
  Eigen::Vector3f start, velocity;  // of the line [m], [m/s]
  float unit = 0;                   // of what it is off the line [m]
  float birth = 0;                  // within the loop [s]
  float air_time = 0;               // [s]
  float lying_time = 0;             // after that [s]
  float size = 0, fall_speed = 0;   // [m], [m/s]
  std::uint32_t mark = 0;           // a random number of its own: for turns and tints
  std::uint32_t count = 0;
  std::size_t first = 0;  // of DriftPaths::off_line
};

struct DriftPaths {
  TimeAxis loop;
  DriftForm form = DriftForm::flake;
  double step = 0.1;                                  // [s]
  float ground = 0;                                   // [m]
  std::vector<DriftPath> paths;                       // by birth within a side of the box
  std::vector<std::array<std::int16_t, 3>> off_line;  // of all paths

  std::size_t bytes() const { return sizeof(DriftPath) * paths.size() + 6 * off_line.size(); }
};

// All that are born in one loop. Where the box reaches down to the ground of the field, they come to rest on
// it. The same on any number of threads. Throws InputError as check_drift does, for a box below the ground,
// and for more than most_drifting of them or paths that would take more than most_drift_samples.
DriftPaths carry(const TravellingField& gusts, const Drift& drift);

inline constexpr double most_drifting = 2e7;
inline constexpr double most_drift_samples = 6e8;  // 3.6 GB

// How many are seen at a time, in the mean over the loop.
double mean_seen(const DriftPaths& paths);

// Fewer of them, each left with the same chance `share` (0 to 1), whole paths: so many of the number density,
// everywhere and always, and those that stay where they were.
DriftPaths thinned(const DriftPaths& paths, double share);

// Where one is at an age [s]: cubic between samples (Catmull and Rom); where it came to rest after its time
// in the air.
Eigen::Vector3f place_at(const DriftPaths& paths, const DriftPath& path, float age);

// Of DriftPaths::off_line, the four that the place at an age is made of: for who fetches them beforehand.
const std::array<std::int16_t, 3>* samples_at(const DriftPaths& paths, const DriftPath& path, float age);

struct DriftSight {
  Eigen::Vector3f place;
  std::uint32_t path = 0;
  float age = 0;
};
// All that are seen at a time [s], in the order of the paths; the same bits at t and t + T.
std::vector<DriftSight> drift_at(const DriftPaths& paths, double time);

// A time [s] in the loop, 0 to below T: equal for t and t + T although sums round.
double within_loop(double time, double period);

}  // namespace tremula
