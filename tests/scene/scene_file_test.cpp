#include "tremula/scene/scene_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <numbers>
#include <string>

#include "complaint.hpp"
#include "scene/vocabulary.hpp"
#include "support.hpp"
#include "tremula/geometry/plants.hpp"
#include "tremula/scene/placing.hpp"
#include "tremula/structure/sheet_presets.hpp"

namespace tremula {
namespace {

using test::parsed;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr double degree = std::numbers::pi / 180;

const std::string wood = R"(name = "A wood"
[wind]
wind_speed = 8
heading = 30.5
decay_y = [16, 10, 8.5]
[motion]
period = 12
modes = 10
no_shelter = true
[ground]
kind = "plain"
color = [0.1, 0.2, 0.3]
height = -2
[sky]
sun_elevation = 30
sun_azimuth = -90
turbidity = 4.5
[medium]
kind = "air"
visibility = 5000
[camera]
eye = [-30, 4, 1.7]
look_at = [0, 0, 6]
field_of_view = 40
aperture = 0.02
focus_distance = 25
[picture]
size = "640x360"
samples = 16
bounces = 3
shutter = 0.25
exposure = 1.5
denoise = false
seed = 9
[[objects]]
source = "oak"
modes = 40
growth_seed = 7
set = ["limb=6"]
leaf_color = [0.2, 0.5, 0.1]
headings = 4
[[objects.instances]]
position = [1, 2]
turn = 90
scale = 1.5
time_shift = 3
[[objects.instances]]
position = [1, 2, 3]
[[objects.grid]]
columns = 3
rows = 2
spacing = [4, 5]
centre = [10, 20]
jitter = 0.1
[[objects]]
name = "birches"
source = "birch"
travelling_gusts = false
no_shelter = false
[[objects.scatter]]
density = 0.01
low = [-100, -50]
high = [100, 50]
distance = 4
inside = [[[-90, -40], [90, -40], [0, 40]]]
outside = [[0, 0], [10, 0], [10, 10]]
scale = [0.8, 1.2]
turn = "random"
random_shift = 2
seed = 5
)";

TEST(SceneFile, IsEveryKeyOfIt) {
  const Scene scene = parsed(wood);
  EXPECT_EQ(scene.name, "A wood");
  ASSERT_EQ(scene.wind.size(), 3U);
  EXPECT_EQ(scene.wind[0].key, "wind_speed");
  EXPECT_THAT(scene.wind[0].values, ElementsAre("8"));
  EXPECT_EQ(text_of(scene.wind[0].place), "scene.toml:3:14");
  EXPECT_THAT(scene.wind[1].values, ElementsAre("30.5"));
  EXPECT_THAT(scene.wind[2].values, ElementsAre("16", "10", "8.5"));
  EXPECT_EQ(scene.ground.kind, "plain");
  EXPECT_EQ(scene.ground.color, Eigen::Vector3f(0.1F, 0.2F, 0.3F));
  EXPECT_EQ(scene.ground.height, -2);
  EXPECT_NEAR(scene.sky.sun_elevation, 30 * degree, 1e-15);
  EXPECT_NEAR(scene.sky.sun_azimuth, -90 * degree, 1e-15);
  EXPECT_EQ(scene.sky.turbidity, 4.5);
  EXPECT_EQ(scene.medium.kind, "air");
  EXPECT_EQ(scene.medium.visibility, 5000);
  EXPECT_EQ(scene.camera.eye, Vec3(-30, 4, 1.7));
  EXPECT_EQ(scene.camera.look_at, Vec3(0, 0, 6));
  EXPECT_NEAR(scene.camera.field_of_view, 40 * degree, 1e-15);
  EXPECT_EQ(scene.camera.aperture, 0.02);
  EXPECT_EQ(scene.camera.focus_distance, 25);
  EXPECT_EQ(scene.picture.size, Eigen::Vector2i(640, 360));
  EXPECT_EQ(scene.picture.samples, 16);
  EXPECT_EQ(scene.picture.bounces, 3);
  EXPECT_EQ(scene.picture.shutter, 0.25);
  EXPECT_EQ(scene.picture.exposure, 1.5);
  EXPECT_FALSE(scene.picture.denoise);
  EXPECT_EQ(scene.picture.seed, 9U);
  ASSERT_EQ(scene.objects.size(), 2U);
  const SceneObject &oak = scene.objects[0], &birches = scene.objects[1];
  EXPECT_EQ(oak.name, "oak") << "that of its source";
  EXPECT_EQ(oak.growth_seed, 7U);
  EXPECT_THAT(oak.constants, ElementsAre("limb=6"));
  EXPECT_EQ(oak.leaf_color, Eigen::Vector3f(0.2F, 0.5F, 0.1F));
  EXPECT_EQ(oak.headings, 4);
  EXPECT_TRUE(oak.crowd.travelling_gusts);
  ASSERT_EQ(oak.crowd.instances.size(), 2U);
  EXPECT_EQ(oak.crowd.instances[0].position, Vec3(1, 2, -2)) << "two numbers: on the ground";
  EXPECT_NEAR(oak.crowd.instances[0].turn, 90 * degree, 1e-15);
  EXPECT_EQ(oak.crowd.instances[0].scale, 1.5);
  EXPECT_EQ(oak.crowd.instances[0].time_shift, 3);
  EXPECT_EQ(oak.crowd.instances[1].position, Vec3(1, 2, 3));
  ASSERT_EQ(oak.crowd.grids.size(), 1U);
  EXPECT_EQ(oak.crowd.grids[0].columns, 3);
  EXPECT_EQ(oak.crowd.grids[0].rows, 2);
  EXPECT_EQ(oak.crowd.grids[0].spacing, Eigen::Vector2d(4, 5));
  EXPECT_EQ(oak.crowd.grids[0].centre, Vec3(10, 20, -2));
  EXPECT_EQ(oak.crowd.grids[0].jitter, 0.1);
  EXPECT_EQ(birches.name, "birches");
  EXPECT_EQ(birches.source, "birch");
  EXPECT_FALSE(birches.crowd.travelling_gusts);
  ASSERT_EQ(birches.crowd.scatters.size(), 1U);
  const Scatter& scatter = birches.crowd.scatters[0];
  EXPECT_EQ(scatter.density, 0.01);
  EXPECT_EQ(scatter.low, Eigen::Vector2d(-100, -50));
  EXPECT_EQ(scatter.high, Eigen::Vector2d(100, 50));
  EXPECT_EQ(scatter.distance, 4);
  EXPECT_EQ(scatter.inside.size(), 1U);
  ASSERT_EQ(scatter.outside.size(), 1U) << "one polygon need not be a list of polygons";
  EXPECT_EQ(scatter.outside[0].size(), 3U);
  EXPECT_EQ(scatter.height, -2) << "that of the ground";
  EXPECT_EQ(scatter.scale, Eigen::Vector2d(0.8, 1.2));
  EXPECT_NEAR(scatter.turn[1], 2 * std::numbers::pi, 1e-15);
  EXPECT_EQ(scatter.random_shift, 2);
  EXPECT_EQ(scatter.seed, 5U);
}

TEST(SceneFile, OfOneObjectHasTheDefaultsOfTheStructs) {
  const Scene scene = parsed("[[objects]]\nsource = 'oak'\n"), otherwise;
  EXPECT_EQ(scene.name, "scene") << "that of the file";
  EXPECT_TRUE(scene.wind.empty());
  EXPECT_EQ(scene.ground.kind, otherwise.ground.kind);
  EXPECT_EQ(scene.sky.sun_elevation, otherwise.sky.sun_elevation);
  EXPECT_EQ(scene.camera.field_of_view, otherwise.camera.field_of_view);
  EXPECT_FALSE(scene.camera.eye || scene.camera.azimuth);
  EXPECT_EQ(scene.picture.size, otherwise.picture.size);
  EXPECT_EQ(count_instances(scene.objects[0].crowd), 1);
}

TEST(SceneFile, AnObjectsOwnSettingsTakeThePlaceOfThoseOfAll) {
  const Scene scene = parsed(wood);
  const auto value = [&](int object, const char* key) {
    const std::vector<Setting> all = settings_of(scene, scene.objects[static_cast<std::size_t>(object)]);
    EXPECT_EQ(std::ranges::count(all, key, &Setting::key), 1) << key;
    const auto found = std::ranges::find(all, key, &Setting::key);
    return found == all.end() || found->values.empty() ? "" : found->values[0];
  };
  EXPECT_EQ(value(0, "modes"), "40");
  EXPECT_EQ(value(1, "modes"), "10");
  EXPECT_EQ(value(1, "wind_speed"), "8");
  EXPECT_EQ(value(1, "period"), "12");
}

TEST(SceneFile, ASwitchThatAnObjectTurnsOffIsOff) {
  const Scene scene = parsed(wood);
  const auto has = [&](std::size_t object) {
    const std::vector<Setting> all = settings_of(scene, scene.objects[object]);
    return std::ranges::find(all, "no_shelter", &Setting::key) != all.end();
  };
  EXPECT_TRUE(has(0));
  EXPECT_FALSE(has(1));
}

TEST(SceneFile, NumbersOfSettingsComeBackToTheLastBit) {
  for (const double value : {0.1, 1.0 / 3, 1e-7, 6.02214076e23, -2.5}) {
    char text[40];
    std::snprintf(text, sizeof text, "%.17g", value);
    std::string written = text;
    if (written.find_first_of(".e") == std::string::npos) written += ".0";
    const Scene scene = parsed("[wind]\nwind_speed = " + written + "\n[[objects]]\nsource = 'oak'\n");
    EXPECT_EQ(std::stod(scene.wind[0].values[0]), value) << written;
  }
}

TEST(SceneFile, TakesFilesFromItsOwnFolder) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "tree.swc") << "1 1 0 0 0 1 -1\n";
  std::ofstream(folder / "measured.csv") << "height_m,speed_m_s\n";
  std::ofstream(folder / "a.toml") << "[wind]\nprofile = 'measured.csv'\n[[objects]]\nsource = "
                                      "'tree.swc'\n[[objects]]\nsource = 'tree.swc'\n";
  const Scene scene = read_scene(folder / "a.toml", test::vocabulary());
  EXPECT_EQ(scene.objects[0].source, folder / "tree.swc");
  EXPECT_EQ(scene.objects[0].name, "tree");
  EXPECT_EQ(scene.objects[1].name, "tree-2") << "names tell objects apart";
  EXPECT_THAT(scene.wind[0].values, ElementsAre(folder / "measured.csv"));
  std::filesystem::create_directory(folder.path / "oak");
  std::ofstream(folder / "b.toml") << "[[objects]]\nsource = 'oak'\n";
  EXPECT_THAT(test::complaint_of([&] { read_scene(folder / "b.toml", test::vocabulary()); }),
              HasSubstr("b.toml:2:10: objects.source: 'oak', which is a folder"));
}

TEST(SceneFile, IsRefusedWhereItIsTooLarge) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "large.toml") << std::string((std::size_t{8} << 20) + 1, '#');
  EXPECT_THAT(test::complaint_of([&] { read_scene(folder / "large.toml", test::vocabulary()); }),
              HasSubstr("large.toml"));
  EXPECT_NE(test::complaint_of([&] { read_scene(folder / "none.toml", test::vocabulary()); }), "");
}

TEST(SceneFile, WithAPathHasItsKeysInOrder) {
  const Scene scene = parsed(
      "[camera]\nfield_of_view = 30\n[[camera.path]]\ntime = 0\neye = [9, 0, 2]\nlook_at = [0, 0, 1]\n"
      "[[camera.path]]\ntime = 4\neye = [0, 9, 2]\nlook_at = [0, 0, 1]\nfield_of_view = 20\n"
      "[[objects]]\nsource = 'oak'\n");
  ASSERT_EQ(scene.camera.path.size(), 2U);
  EXPECT_EQ(scene.camera.path[1].time, 4);
  EXPECT_FALSE(scene.camera.path[0].field_of_view);
  EXPECT_NEAR(*scene.camera.path[1].field_of_view, 20 * degree, 1e-15);
  EXPECT_EQ(text_of(scene.camera.path[1].place), "scene.toml:7:1");
}

TEST(SceneFile, OfTenThousandCopiesOneByOneIsReadInASecond) {
  std::string text = "[[objects]]\nsource = 'oak'\n";
  for (int i = 0; i < 10'000; ++i)
    text += "[[objects.instances]]\nposition = [" + std::to_string(i % 100 * 10) + ", " +
            std::to_string(i / 100 * 10) + "]\nturn = 45\n";
  const Scene scene = parsed(text);
  EXPECT_EQ(scene.objects[0].crowd.instances.size(), 10'000U);
}

TEST(SceneFile, OfTheRepositoryAreAllTaken) {
  SceneVocabulary known = test::vocabulary();
  for (const PlantPreset& preset : plant_presets()) known.presets.push_back(preset.name);
  for (const SheetPreset& preset : sheet_presets()) known.presets.push_back(preset.name);
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(test::source_folder() / "scenes")) {
    if (entry.path().extension() != ".toml") continue;
    ++count;
    const Scene scene = read_scene(entry.path().string(), known);
    EXPECT_NO_THROW(place_objects(scene.objects, {8, 0, 0}, 20));
  }
  EXPECT_GE(count, 6);
}

}  // namespace
}  // namespace tremula
