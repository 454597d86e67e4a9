// What is wrong with a scene is said with its place, its key and what was wanted.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "complaint.hpp"
#include "scene/vocabulary.hpp"

namespace tremula {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

struct Broken {
  const char* name;
  std::string text;
  std::string place;                // line and column
  std::vector<std::string> saying;  // the key, what was found, what was wanted
};

const std::string oak = "[[objects]]\nsource = 'oak'\n";  // two lines; what follows begins on the third
const std::string scatter =
    "[[objects]]\nsource = 'oak'\n[[objects.scatter]]\ndensity = 0.01\nlow = [-9, -9]\nhigh = [9, 9]\n";
const std::string grid = "[[objects]]\nsource = 'oak'\n[[objects.grid]]\ncolumns = 3\nrows = 3\n";
const std::string path_key = "[[camera.path]]\ntime = 0\neye = [1, 2, 3]\nlook_at = [0, 0, 1]\n";

std::string repeated(const std::string& text, int times) {
  std::string all;
  for (int i = 0; i < times; ++i) all += text;
  return all;
}

const std::vector<Broken>& broken_scenes() {
  static const std::vector<Broken> all = {
      // ---- No TOML
      {"UnbalancedHeader", oak + "[sky\nturbidity = 3\n", "3:", {}},
      {"UnbalancedList", oak + "[camera]\neye = [1, 2\nlook_at = 3\n", "5:", {}},
      {"UnbalancedText", "name = \"wood\n" + oak, "1:", {}},
      {"NoValue", oak + "[sky]\nturbidity =\n", "4:", {}},
      {"KeyTwice", oak + "source = 'birch'\n", "3:", {"source"}},
      {"HeaderTwice", oak + "[sky]\nturbidity = 3\n[sky]\nturbidity = 4\n", "5:", {"sky"}},
      {"InvalidUtf8", "name = \"\xff\xfe\"\n" + oak, "1:", {}},
      {"ListsInLists", "name = " + std::string(2000, '[') + "\n" + oak, "1:", {}},
      {"KeysInKeys", repeated("a.", 200'000) + "a = 1\n" + oak, "1:", {"more than 256 levels"}},
      {"Empty", "", "1:1", {"objects: none", "[[objects]]"}},

      // ---- Keys that are not there
      {"UnknownTable",
       oak + "[skye]\n",
       "3:2",
       {"skye: no such key; did you mean sky?", "one of name, wind"}},
      {"UnknownKey",
       oak + "[sky]\nsun_elevaton = 3\n",
       "4:1",
       {"sky.sun_elevaton: no such key; did you mean sun_elevation?", "one of sun_elevation"}},
      {"UnknownKeyUnlikeAny",
       oak + "[ground]\nwetness = 3\n",
       "4:1",
       {"ground.wetness", "one of kind, color, height"}},
      {"UnknownSetting",
       oak + "[wind]\nwind_sped = 8\n",
       "4:1",
       {"wind.wind_sped", "did you mean wind_speed?"}},
      {"UnknownKeyOfAnObject",
       oak + "heading = 8\n",
       "3:1",
       {"objects.heading: in [[objects]]", "in [wind]"}},
      {"SettingOfTheFilmInTheWind",
       oak + "[wind]\nperiod = 8\n",
       "4:1",
       {"wind.period: in [wind]", "in [motion]"}},
      {"SettingOfTheWindOfAnObject",
       oak + "wind_speed = 8\n",
       "3:1",
       {"objects.wind_speed", "one wind blows"}},
      {"SettingOfTheFilmOfAnObject", oak + "period = 8\n", "3:1", {"objects.period", "all objects share it"}},
      {"SettingOfAnObjectInTheWind",
       oak + "[wind]\nmodes = 8\n",
       "4:1",
       {"wind.modes", "in [[objects]] for one"}},
      {"UnknownKeyOfACopy",
       oak + "[[objects.instances]]\npositon = [1, 2]\n",
       "4:1",
       {"did you mean position?"}},
      {"UnknownRule", oak + "[[objects.grids]]\nrows = 3\n", "3:11", {"objects.grids", "did you mean grid?"}},

      // ---- Values of another kind, or out of range
      {"TextForANumber",
       oak + "[sky]\nsun_elevation = \"high\"\n",
       "4:17",
       {"sky.sun_elevation: 'high'", "a number from 0 to 90 [degrees]"}},
      {"TooLarge", oak + "[sky]\nsun_elevation = 91\n", "4:17", {"sky.sun_elevation: 91", "from 0 to 90"}},
      {"NotANumber",
       oak + "[sky]\nsun_elevation = nan\n",
       "4:17",
       {"sky.sun_elevation: nan", "from 0 to 90"}},
      {"Infinite", oak + "[sky]\nturbidity = inf\n", "4:13", {"sky.turbidity: inf", "from 1 to 10"}},
      {"SettingNotANumber", oak + "modes = nan\n", "3:9", {"objects.modes: nan", "a whole number"}},
      {"SettingInfinite", oak + "[wind]\nwind_speed = inf\n", "4:14", {"wind.wind_speed: inf", "a number"}},
      {"SettingOfAnotherKind",
       oak + "[wind]\nwind_speed = \"8\"\n",
       "4:14",
       {"wind.wind_speed: '8'", "a number"}},
      {"SettingThatIsADate", oak + "[wind]\nwind_speed = 1979-05-27\n", "4:14", {"a date", "a number"}},
      {"SettingNotWhole", oak + "[motion]\nmodes = 2.5\n", "4:9", {"motion.modes: 2.5", "a whole number"}},
      {"SettingThatIsNoSwitch", oak + "no_shelter = 1\n", "3:14", {"objects.no_shelter: 1", "true or false"}},
      {"SettingThatIsAnEmptyList", oak + "mode_damping = []\n", "3:16", {"a list of 0", "a list of numbers"}},
      {"UnknownChoice",
       oak + "[ground]\nkind = \"gras\"\n",
       "4:8",
       {"did you mean grass?", "one of grass, soil"}},
      {"UnknownMedium", oak + "[medium]\nkind = \"watr\"\n", "4:8", {"did you mean water?"}},
      {"NoVisibility",
       oak + "[medium]\nvisibility = 0\n",
       "4:14",
       {"medium.visibility: 0", "a number of 0.1 or more [m]"}},
      {"TwoOfThreeNumbers",
       oak + "[ground]\nkind = \"plain\"\ncolor = [1, 0]\n",
       "5:9",
       {"ground.color: a list of 2", "three numbers from 0 to 1"}},
      {"OneOfThreeNumbersTooLarge",
       oak + "[ground]\nkind = \"plain\"\ncolor = [1, 0, 2]\n",
       "5:16",
       {"ground.color: 2"}},
      {"TruthForANumber", oak + "[ground]\nheight = true\n", "4:10", {"ground.height: true", "a number [m]"}},
      {"NumberForTruth", oak + "[picture]\ndenoise = 1\n", "4:11", {"picture.denoise: 1", "true or false"}},
      {"SizeOfAnotherForm",
       oak + "[picture]\nsize = \"640*360\"\n",
       "4:8",
       {"picture.size: '640*360'", "two whole numbers"}},
      {"SizeOfNothing", oak + "[picture]\nsize = [640, 0]\n", "4:14", {"picture.size: 0", "from 1 to 16384"}},
      {"HalfASample",
       oak + "[picture]\nsamples = 1.5\n",
       "4:11",
       {"picture.samples: 1.5", "from 1 to 65536"}},
      {"NegativeShutter",
       oak + "[picture]\nshutter = -0.5\n",
       "4:11",
       {"picture.shutter: -0.5", "from 0 to 1"}},
      {"ExposureInWords",
       oak + "[picture]\nexposure = \"automatic\"\n",
       "4:12",
       {"picture.exposure", "wanted a number from -40 to 40"}},
      {"NegativeSeed", oak + "[picture]\nseed = -1\n", "4:8", {"picture.seed: -1", "0 or more"}},
      {"NoHeadings", oak + "headings = 0\n", "3:12", {"objects.headings: 0", "from 1 to 64"}},
      {"TableInsideAnObject", oak + "camera = []\n", "3:1", {"objects.camera: no such key"}},
      {"NumberForATable", "sky = 3\n" + oak, "1:7", {"sky: 3", "[sky]"}},
      {"EmptyName", "name = ''\n" + oak, "1:8", {"name: nothing", "a text"}},

      // ---- What says nothing beside something else
      {"ColorOfGrass",
       oak + "[ground]\ncolor = [1, 0, 0]\n",
       "4:9",
       {"ground.color: given with kind \"grass\"", "plain"}},
      {"SunInAUniformSky",
       oak + "[sky]\nuniform = 1\nturbidity = 3\n",
       "5:13",
       {"sky.turbidity: given with uniform"}},
      {"AzimuthOfAnEye",
       oak + "[camera]\neye = [1, 2, 3]\nlook_at = [0, 0, 1]\nazimuth = 3\n",
       "6:11",
       {"camera.azimuth: given with an eye", "one of them"}},
      {"FocusOfAPinhole",
       oak + "[camera]\nfocus_distance = 3\n",
       "4:18",
       {"camera.focus_distance", "an aperture"}},
      {"PathThatRepeatsWithoutAPath", oak + "[camera]\npath_repeats = true\n", "4:16", {"without a path"}},
      {"EyeBesideAPath",
       "[camera]\neye = [1, 2, 3]\n" + path_key +
           "[[camera.path]]\ntime = 1\neye = [1, 2, 3]\nlook_at = [0, 0, 1]\n" + oak,
       "2:7",
       {"camera.eye: given with a path", "one of them"}},

      // ---- The camera
      {"CameraBelowTheGround",
       oak + "[camera]\neye = [0, 0, -1]\nlook_at = [0, 0, 3]\n",
       "4:7",
       {"camera.eye: at a height of -1 m", "above the ground, which is at 0 m"}},
      {"CameraBelowHighGround",
       oak + "[ground]\nheight = 5\n[camera]\neye = [0, 0, 5]\nlook_at = [0, 0, 9]\n",
       "6:7",
       {"at a height of 5 m", "which is at 5 m"}},
      {"CameraThatLooksAtItself",
       oak + "[camera]\neye = [1, 2, 3]\nlook_at = [1, 2, 3]\n",
       "5:11",
       {"camera.look_at: where the eye is", "another point"}},
      {"EyeAlone", oak + "[camera]\neye = [1, 2, 3]\n", "4:7", {"camera.eye: alone", "eye and look_at"}},
      {"LookAlone", oak + "[camera]\nlook_at = [1, 2, 3]\n", "4:11", {"camera.look_at: alone"}},
      {"EyeInThePlane",
       oak + "[camera]\neye = [1, 2]\nlook_at = [0, 0, 1]\n",
       "4:7",
       {"camera.eye: a list of 2", "three numbers [m]"}},
      {"EyeAtInfinity",
       oak + "[camera]\neye = [1, 2, inf]\nlook_at = [0, 0, 1]\n",
       "4:14",
       {"camera.eye: inf"}},
      {"NoFieldOfView",
       oak + "[camera]\nfield_of_view = 0\n",
       "4:17",
       {"camera.field_of_view: 0", "[degrees]"}},
      {"FramedObjectThatIsNotThere",
       oak + "[camera]\nframe = [\"oka\"]\n",
       "4:9",
       {"no object 'oka'; did you mean oak?"}},
      {"PathOfOneKey", oak + path_key, "3:1", {"camera.path: 1 key", "two or more"}},
      {"PathThatStandsStillInTime",
       oak + path_key + path_key,
       "8:8",
       {"camera.path.time: 0 s", "after the last, 0 s"}},
      {"PathBelowTheGround",
       oak + path_key + "[[camera.path]]\ntime = 1\neye = [1, 2, -3]\nlook_at = [0, 0, 1]\n",
       "9:7",
       {"camera.path.eye", "above the ground"}},
      {"PathWithoutAView",
       oak + path_key + "[[camera.path]]\ntime = 1\neye = [1, 2, 3]\n",
       "7:1",
       {"camera.path.look_at: none"}},

      // ---- Objects and their copies
      {"NoObjects", "[sky]\nturbidity = 3\n", "1:1", {"objects: none", "one or more [[objects]]"}},
      {"EmptyObjects", "objects = []\n", "1:11", {"objects: 0", "1 to 1000"}},
      {"ObjectsThatAreANumber", "objects = 3\n", "1:11", {"objects: 3", "[[objects]]"}},
      {"ObjectsThatAreATable", "[objects]\nsource = 'oak'\n", "1:1", {"objects: a table", "[[objects]]"}},
      {"ObjectsOfNumbers", "objects = [1]\n", "1:12", {"objects: 1", "[[objects]]"}},
      {"NoSource", "[[objects]]\nname = 'x'\n", "1:1", {"objects.source: none", "a text"}},
      {"UnknownPreset",
       "[[objects]]\nsource = 'oka'\n",
       "2:10",
       {"objects.source: 'oka'; did you mean oak?", "a preset"}},
      {"MissingMesh",
       "[[objects]]\nsource = 'trees/missing.swc'\n",
       "2:10",
       {"objects.source: 'trees/missing.swc'", "a file that is there"}},
      {"NameTwice",
       oak + "name = 'a'\n[[objects]]\nsource = 'oak'\nname = 'a'\n",
       "6:8",
       {"objects.name: 'a' again", "another name"}},
      {"PlaceOfOneNumber",
       oak + "[[objects.instances]]\nposition = [1]\n",
       "4:12",
       {"objects.instances.position", "two or three numbers"}},
      {"PlaceThatIsNoNumber", oak + "[[objects.instances]]\nposition = [1, nan]\n", "4:16", {"nan"}},
      {"CopiesThatAreATable",
       oak + "[objects.instances]\nposition = [1, 2]\n",
       "3:1",
       {"objects.instances: a table"}},
      {"NegativeScale",
       grid + "scale = -1\n",
       "6:9",
       {"objects.grid.scale: -1", "a number or two from 0.001 to 1000"}},
      {"ScalesTheWrongWayRound",
       grid + "scale = [2, 1]\n",
       "6:9",
       {"objects.grid.scale", "the smallest first"}},
      {"TurnInWords", grid + "turn = \"randm\"\n", "6:8", {"objects.grid.turn: 'randm'", "or \"random\""}},
      {"NoRows",
       oak + "[[objects.grid]]\ncolumns = 3\n",
       "3:1",
       {"objects.grid.rows: none", "a whole number"}},
      {"ThousandMillionInAGrid",
       oak + "[[objects.grid]]\ncolumns = 1000000\nrows = 1000\n",
       "3:1",
       {"objects.grid: 1000000000 instances", "at most 10000000"}},
      {"ThousandMillionScattered",
       oak + "[[objects.scatter]]\ndensity = 1000\nlow = [0, 0]\nhigh = [1000, 1000]\n",
       "3:1",
       {"objects.scatter: 1000000000 instances", "at most 10000000"}},
      {"MoreThanAnyNumber",
       oak + "[[objects.scatter]]\ndensity = 1e6\nlow = [-1e6, -1e6]\nhigh = [1e6, 1e6]\n",
       "3:1",
       {"objects.scatter: 4000000000000000000 instances"}},
      {"TooManyTogether",
       grid + "[[objects.grid]]\ncolumns = 10000\nrows = 1000\n",
       "6:1",
       {"10000009 instances with those before", "at most 10000000"}},
      {"FieldInsideOut",
       oak + "[[objects.scatter]]\ndensity = 1\nlow = [0, 0]\nhigh = [10, -1]\n",
       "3:1",
       {"objects.scatter: the field: it ends before it begins"}},
      {"NoDensity",
       oak + "[[objects.scatter]]\nlow = [0, 0]\nhigh = [1, 1]\n",
       "3:1",
       {"objects.scatter.density: none"}},
      {"NegativeDensity",
       oak + "[[objects.scatter]]\ndensity = -1\nlow = [0, 0]\nhigh = [1, 1]\n",
       "4:11",
       {"objects.scatter.density: -1", "above 0"}},
      {"PolygonOfTwoCorners",
       scatter + "inside = [[[0, 0], [1, 1]]]\n",
       "7:11",
       {"objects.scatter.inside: a polygon of 2 corners", "three or more"}},
      {"EmptyMask",
       scatter + "inside = []\n",
       "7:10",
       {"objects.scatter.inside: an empty list", "a polygon or more"}},
      {"MaskOfTexts",
       scatter + "outside = [\"lake\"]\n",
       "7:12",
       {"objects.scatter.outside: 'lake'", "polygons"}},
      {"PolygonThatCrossesItself",
       scatter + "inside = [[0, 0], [4, 4], [4, 0], [0, 3]]\n",
       "3:1",
       {"sides 1 and 3 cross"}},
      {"PolygonOnALine",
       scatter + "outside = [[0, 0], [1, 1], [2, 2]]\n",
       "3:1",
       {"objects.scatter: a polygon: no area"}},
      {"NoRoomForTheDistance",
       scatter + "distance = 20\n",
       "3:1",
       {"density: 0.01 per m^2", "20 m of distance"}},
  };
  return all;
}

class BrokenScene : public testing::TestWithParam<Broken> {};

TEST_P(BrokenScene, IsRefusedWithPlaceKeyAndExpectation) {
  const Broken& broken = GetParam();
  const std::string message = test::complaint_of([&] { test::parsed(broken.text); });
  EXPECT_THAT(message, StartsWith("scene.toml:" + broken.place));
  for (const std::string& words : broken.saying) EXPECT_THAT(message, HasSubstr(words));
  EXPECT_EQ(message.find('\n'), std::string::npos);
  EXPECT_LT(message.size(), 400U) << message;
}

INSTANTIATE_TEST_SUITE_P(Every, BrokenScene, testing::ValuesIn(broken_scenes()),
                         [](const auto& instance) { return std::string(instance.param.name); });

TEST(BrokenScenes, AreFiftyAndMore) { EXPECT_GE(broken_scenes().size(), 50U); }

}  // namespace
}  // namespace tremula
