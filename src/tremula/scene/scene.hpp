// A scene: several plants under one sky and in one wind, and who looks. From TOML.
#pragma once

#include "tremula/base/types.hpp"
#include "tremula/deformation/loop.hpp"

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace tremula {

// Where something stands in a scene's file; line 0: nowhere.
struct FilePlace {
  std::string file;
  int line = 0, column = 0;
};
std::string text_of(const FilePlace& place);  // "scene.toml:12:3"

// What the motion of an object is made with, under the name that the flag of `tremula animate` has, with _ for -:
// {"wind_speed", {"8"}, …}. A list has several values; a switch that is on none, and one that is off is left out.
struct Setting {
  std::string key;
  std::vector<std::string> values;
  FilePlace place;
};

// Where copies of an object stand. Rules add up; an object without any stands once, where its source puts it.
struct Placed {  // one by one
  Instance instance;
};
struct Grid {
  int columns = 1, rows = 1;
  double spacing = 10;  // [m]
  Vec3 centre = Vec3::Zero();
};
struct Scatter {
  double density = 0.01;                      // [1/m^2]
  Eigen::Vector2d low = {-50, -50}, high = {50, 50};  // of the field [m]
  double distance = 0;                        // that two of them keep at least [m]
  std::vector<std::vector<Eigen::Vector2d>> inside, outside;  // masks: polygons [m]
};
struct Crowd {
  std::vector<Placed> placed;
  std::vector<Grid> grids;
  std::vector<Scatter> scatters;
  std::uint64_t seed = 1;
  double jitter = 0;                 // of places, of a grid's spacing
  Eigen::Vector2d scale = {1, 1};    // smallest and largest
  Eigen::Vector2d turn = {0, 0};     // [rad], of which any is as likely
  double random_shift = 0;           // of time shifts beside what the wind's way makes [s]
  bool travelling_gusts = true;      // time shifts follow Taylor: x / U along the wind
};

// Copies of an object, in order. `advection`: the mean wind that carries gusts [m/s], 0: no shift.
// Throws InputError for more than most_instances, with the number.
inline constexpr std::int64_t most_instances = 10'000'000;
std::vector<Instance> place_instances(const Crowd& crowd, const Vec3& advection, double period);

struct SceneObject {
  std::string name, source;  // source: a file, beside the scene's, or a preset
  FilePlace place;
  std::vector<Setting> settings;
  Crowd crowd;
  int headings = 8;  // a turned copy bows downwind in a motion made for its heading, the nearest of so many
};

}  // namespace tremula
