// A scene: several things under one sky and in one wind, and who looks at them. What a file says
// (scene_file.hpp), before anything of it is grown, moved or placed. Angles in radians.
#pragma once

#include "tremula/base/types.hpp"
#include "tremula/deformation/loop.hpp"

#include <cstdint>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

namespace tremula {

// Where something stands in a scene's file; line 0: nowhere.
struct FilePlace {
  std::string file;
  int line = 0, column = 0;
};
std::string text_of(const FilePlace& place);  // "scene.toml:12:3"

// What a motion is made with, under the name that the flag of `tremula animate` has, with _ for -:
// {"wind_speed", {"8"}, …}. A list has several values; a switch that is on has none, and one that is off has
// "false".
struct Setting {
  std::string key;
  std::vector<std::string> values;
  FilePlace place;
};

// ---- Where copies of an object stand. Rules add up; an object without any stands once, at the origin.

// How copies of one rule differ from each other, drawn by its seed.
struct Variation {
  std::uint64_t seed = 1;
  Eigen::Vector2d scale = {1, 1};  // smallest and largest
  Eigen::Vector2d turn = {0, 0};   // between these [rad]
  double random_shift = 0;         // of the time, up to so much either way [s]
};

// Rows along y of columns along x.
struct Grid : Variation {
  int columns = 1, rows = 1;
  Eigen::Vector2d spacing = {10, 10};  // along x and y [m]
  Vec3 centre = Vec3::Zero();          // of the whole [m]
  double jitter = 0;                   // how far off its place a copy is at most, along x and y, in spacings
};

using Polygon = std::vector<Eigen::Vector2d>;  // corners in order; the last joins the first [m]

// As many on average as a density says.
struct Scatter : Variation {
  double density = 0.01;                              // [1/m^2]
  Eigen::Vector2d low = {-50, -50}, high = {50, 50};  // of the field, along x and y [m]
  double distance = 0;                   // that they keep from each other and from all placed before [m]
  std::vector<Polygon> inside, outside;  // in one of the first, if there are any, and in none of the others
  double height = 0;                     // of the ground [m]
};

struct Crowd {
  std::vector<Instance> instances = {};  // one by one
  std::vector<Grid> grids = {};
  std::vector<Scatter> scatters = {};
  bool travelling_gusts = true;  // time shifts follow Taylor: x / U along the wind
};

// Something that moves, and where its copies stand.
struct SceneObject {
  std::string name;                               // that of its source where the file gives none
  std::string source;                             // a file that is there, or the name of a preset
  std::vector<Setting> settings;                  // its own: settings_of() has all that count for it
  std::optional<std::uint64_t> growth_seed = {};  // of a plant that is grown
  std::vector<std::string> constants = {};        // of its text: "nodes=20"
  std::optional<Eigen::Vector3f> bark_color = {}, leaf_color = {},
                                 color = {};  // sRGB, 0–1; the last of a sheet
  int headings = 8;  // a turned copy bows downwind in a motion of its own heading, the nearest of so many
  // Up to so many copies each move in the gusts of their own place; more share those of the origin, each at
  // its own time.
  int own_gusts = 12;
  Crowd crowd = {};
  FilePlace place = {};
};

// ---- What is looked up in the wind of the scene, rather than baked

// Blades, which stand in an area.
struct SceneGrass {
  std::string name;  // that of the species where the file gives none; a number behind it for more
  std::string species = "meadow";                     // lawn, meadow, wheat, rice, reed
  Eigen::Vector2d low = {-10, -10}, high = {10, 10};  // of the field, along x and y [m]
  std::vector<Polygon> inside, outside;               // in one of the first, and in none of the others
  std::optional<double> density = {};                 // [1/m^2]; that of the species
  std::optional<double> height = {};                  // of blades on the average [m]; that of the species
  std::optional<Eigen::Vector3f> color = {};          // sRGB, 0–1; that of the species
  std::uint64_t seed = 1;
  FilePlace place = {};
};

// What the wind carries off.
struct SceneDrift {
  std::string name;
  std::string kind = "snow";                      // snow, rain, leaves, seeds
  Vec3 low = {-15, -15, 0}, high = {15, 15, 12};  // the box it is seen in [m]
  std::optional<double> density = {};             // [1/m^3]; that of the kind
  std::optional<double> intensity = {};           // as a gauge measures it, instead [mm/h]
  std::optional<double> matter_density = {};      // of itself [kg/m^3]; that of the kind
  // Instead of what comes in through the sides of its box: so many a second let go in this one.
  std::optional<Vec3> source_low = {}, source_high = {};  // [m]
  double source_rate = 1;                                 // [1/s]
  std::optional<double> fall_speed = {};                  // in still air [m/s]; that of the kind
  std::optional<double> size = {};                        // [m]; that of the kind
  std::optional<Eigen::Vector3f> color = {};              // sRGB, 0–1; that of the kind
  double lie_time = 0;                                    // how long it lies on the ground [s]
  std::uint64_t seed = 1;
  FilePlace place = {};
};

// Trees as Gardner paints them: a trunk, and quadrics with a texture for a crown.
struct SceneImpression {
  std::string name;
  std::string shape = "round";                                      // round, oak, poplar, pine, bush
  double height = 10;                                               // [m]
  std::optional<double> width = {};                                 // of the crown [m]; that of the shape
  std::optional<double> frequency = {};                             // of its trunk [Hz]; from its height
  std::optional<Eigen::Vector3f> leaf_color = {}, bark_color = {};  // sRGB, 0–1
  Crowd crowd = {};
  std::uint64_t seed = 1;
  FilePlace place = {};
};

// Plants as a 3-D texture that is repeated over an area.
struct SceneVolume {
  std::string name;
  std::string species = "rice";                       // rice, moss, fur
  Eigen::Vector2d low = {-10, -10}, high = {10, 10};  // of the field, along x and y [m]
  std::vector<Polygon> inside, outside;
  std::optional<double> height = {};          // [m]; that of the species
  std::optional<double> texel_size = {};      // [m]; that of the species
  std::optional<Eigen::Vector3f> color = {};  // sRGB, 0–1; that of the species
  std::uint64_t seed = 1;
  FilePlace place = {};
};

// The wind itself, to be seen.
struct SceneGusts {
  Eigen::Vector2d low = {-20, -20}, high = {20, 20};  // where, along x and y [m]
  double height = 1.5;                                // above the ground [m]
  double spacing = 2;                                 // of the arrows [m]
  double scale = 0.2;                                 // length of an arrow for 1 m/s [s]
  bool arrows = true, tint = false;                   // arrows; colours on the ground
  FilePlace place = {};
};

// ---- What is around them

struct SceneGround {
  std::string kind = "grass";                  // grass, soil, sand, snow, plain or none
  Eigen::Vector3f color{0.18F, 0.18F, 0.18F};  // albedo of a plain one, linear
  double height = 0;                           // [m]
  double grass_height = 0.06;  // of grass that stands in blades near the camera [m]; 0: a pattern alone
};

struct SceneSky {
  double sun_elevation = 35 * std::numbers::pi / 180;  // above the horizon [rad]
  double sun_azimuth = 0;                              // where it stands, from +x towards +y [rad]
  double turbidity = 2.5;                              // 1 pure air … 10 hazy
  std::optional<double> uniform = {};  // instead of sun and sky: this radiance from everywhere
};

// What is between things.
struct SceneMedium {
  std::string kind = "auto";              // air, water, or auto: what the objects live in
  std::optional<double> visibility = {};  // how far a dark thing is seen [m]; else default_visibility
};

// ---- Who looks

struct CameraKey {
  double time = 0;  // [s]
  Vec3 eye = Vec3::Zero(), look_at = Vec3::Zero();
  std::optional<double> field_of_view = {};  // [rad]; that of the camera
  FilePlace place = {};
};

// Along a path where there is one, else from `eye` where there is one, else from where all is in the frame.
struct SceneCamera {
  std::vector<std::string> frame = {};  // objects to frame, by name; none: all
  std::optional<double> azimuth = {};   // to stand at, from +x towards +y [rad]; else across the wind
  double elevation = 3 * std::numbers::pi / 180;       // to look down from [rad]
  double margin = 0.06;                                // of the picture, on each side
  std::optional<Vec3> eye = {}, look_at = {};          // [m]
  double field_of_view = 28 * std::numbers::pi / 180;  // from bottom to top [rad]
  double aperture = 0;                                 // diameter of the lens [m]; 0: all is sharp
  std::optional<double> focus_distance = {};           // [m]; else as far as what it looks at
  std::optional<Vec3> focus_at = {};                   // [m]
  std::vector<CameraKey> path = {};                    // by time
  bool path_repeats = true;                            // with the loop; else it rests at its ends
  FilePlace place = {};
};

struct ScenePicture {
  Eigen::Vector2i size = {960, 540};  // width and height [pixels]
  int samples = 64;                   // a pixel
  int bounces = 6;                    // of light
  double shutter = 0.5;               // how long it is open, of the time of a frame
  double exposure = 0;                // brighter than the light of the day asks for [stops]
  bool denoise = true;
  std::uint64_t seed = 1;  // of the samples
};

struct Scene {
  std::string name;                   // that of its file where it gives none
  std::vector<Setting> wind, motion;  // of all objects
  SceneGround ground;
  SceneSky sky;
  SceneMedium medium;
  SceneCamera camera;
  ScenePicture picture;
  std::vector<SceneObject> objects;
  std::vector<SceneGrass> grass;
  std::vector<SceneDrift> drift;
  std::vector<SceneImpression> impressions;
  std::vector<SceneVolume> volumes;
  std::optional<SceneGusts> gusts;
};

// All that an object is put in motion with: wind and motion of the scene, in their order, then its own in
// place of those of the same name.
std::vector<Setting> settings_of(const Scene& scene, const SceneObject& object);

}  // namespace tremula
