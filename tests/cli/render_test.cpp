// Scenes and pictures, as a user asks for them.
#include "cli/program.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "pictures.hpp"
#include "tremula/io/exr.hpp"
#include "tremula/raytrace/raytrace.hpp"

namespace tremula {
namespace {

using test::contents;
using test::file_count;
using test::Outcome;
using test::run;
using test::write;
using testing::HasSubstr;
using testing::Not;

const std::string small = " --size 32x18 --samples 1 ";

class Render : public testing::Test {
 protected:
  void SetUp() override {
    if (!can_trace()) GTEST_SKIP() << "built without Embree";
  }

  test::TemporaryFolder folder;

  void write_scene(const std::string& more = "") const {
    write(folder / "s.toml",
          "[wind]\nwind_speed = 7\n\n[motion]\nperiod = 2\nfps = 5\n\n[[objects]]\nname = \"tree\"\nsource = "
          "\"sapling\"\n" +
              more);
  }
};

TEST_F(Render, APlantAloneFillsMuchOfItsPicture) {
  const Outcome outcome = run(folder, "render sapling --period 2 --size 96x54 --samples 4 -o a.png");
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  const test::Picture picture = test::read_picture(folder / "a.png");
  ASSERT_EQ(picture.width, 96);
  ASSERT_EQ(picture.height, 54);
  // Sky above, ground below, and a tree from near the top to near the bottom of the middle.
  const auto sky = picture.mean(0, 0, 20, 8), ground = picture.mean(0, 46, 20, 8);
  EXPECT_GT(sky[2], ground[2] + 30);
  EXPECT_GT(ground[1], ground[2]);
  EXPECT_GT(sky[2], 90) << "a clear day is bright";
}

TEST_F(Render, SceneAndFlagsMakeTheSamePictureWhereTheySayTheSame) {
  write_scene("[ground]\nheight = 0\n");
  ASSERT_EQ(run(folder, "render s.toml" + small + "-o a.png").code, 0);
  write(folder / "t.toml",
        "[motion]\nperiod = 3\nfps = 5\n[[objects]]\nname = \"tree\"\nsource = \"sapling\"\n[ground]\nheight "
        "= 0\n");
  ASSERT_EQ(run(folder, "render t.toml --wind-speed 7 --period 2" + small + "-o b.png").code, 0);
  EXPECT_EQ(contents(folder / "a.png"), contents(folder / "b.png"));
}

TEST_F(Render, TheBytesAreThoseOfAnyNumberOfThreads) {
  write_scene();
  ASSERT_EQ(run(folder, "render s.toml --threads 1 --size 64x36 --samples 3 -o a.png").code, 0);
  ASSERT_EQ(run(folder, "render s.toml --threads 3 --size 64x36 --samples 3 -o b.png").code, 0);
  EXPECT_EQ(contents(folder / "a.png"), contents(folder / "b.png"));
}

TEST_F(Render, FramesGoIntoAFolderThatIsMadeForThem) {
  write_scene();
  const Outcome outcome = run(folder, "render s.toml --frames 2-4" + small + "-o new/frame_%03d.png");
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  for (const char* name : {"new/frame_002.png", "new/frame_003.png", "new/frame_004.png"})
    EXPECT_TRUE(std::filesystem::exists(folder / name)) << name;
  EXPECT_FALSE(std::filesystem::exists(folder / "new/frame_005.png"));
  EXPECT_NE(contents(folder / "new/frame_002.png"), contents(folder / "new/frame_004.png")) << "it moves";
}

TEST_F(Render, AFilmIsTheSameWhetherMadeAtOnceOrInParts) {
  write_scene();
  ASSERT_EQ(run(folder, "render s.toml --frames 0-3" + small + "-o all/%d.png").code, 0);
  ASSERT_EQ(run(folder, "render s.toml --frames 2-3" + small + "-o parts/%d.png").code, 0);
  ASSERT_EQ(run(folder, "render s.toml --frames 0-1" + small + "-o parts/%d.png").code, 0);
  for (const char* frame : {"0.png", "1.png", "2.png", "3.png"})
    EXPECT_EQ(contents(folder / ("all/" + std::string(frame))),
              contents(folder / ("parts/" + std::string(frame))));
}

TEST_F(Render, ResumeMakesWhatIsMissingAndLeavesTheRest) {
  write_scene();
  std::filesystem::create_directory(folder / "f");
  write(folder / "f/1.png", "mine");
  ASSERT_EQ(run(folder, "render s.toml --frames 0-2 --resume" + small + "-o f/%d.png").code, 0);
  EXPECT_EQ(contents(folder / "f/1.png"), "mine");
  EXPECT_EQ(test::read_picture(folder / "f/0.png").width, 32);
  EXPECT_EQ(test::read_picture(folder / "f/2.png").width, 32);
}

TEST_F(Render, TheFrameAfterTheLastIsTheFirst) {
  write_scene("[picture]\ndenoise = false\n");
  ASSERT_EQ(run(folder, "animate s.toml -o a.csv --frames 0").code, 0);
  ASSERT_EQ(run(folder, "animate s.toml -o b.csv --frames 10").code, 0);  // 2 s at 5 a second
  const std::string first = contents(folder / "a.csv"), last = contents(folder / "b.csv");
  const auto after_time = [](const std::string& text) {
    std::string row = text.substr(text.find('\n') + 1);
    row = row.substr(0, row.find('\n'));
    row = row.substr(row.find(',') + 1);
    return row.substr(row.find(',') + 1);
  };
  EXPECT_EQ(after_time(first), after_time(last));
}

TEST_F(Render, ASheetShowsTheLoopInCells) {
  write_scene();
  ASSERT_EQ(run(folder, "render s.toml --sheet 3x2" + small + "-o s.png").code, 0);
  const test::Picture sheet = test::read_picture(folder / "s.png");
  EXPECT_GE(sheet.width, 96);
  EXPECT_GE(sheet.height, 36);
  EXPECT_EQ(run(folder, "render s.toml --sheet 4x4" + small + "-o t.png").code, 2) << "there are ten frames";
}

TEST_F(Render, LinearLightAndPictureAreWrittenTogether) {
  if (!has_exr()) GTEST_SKIP() << "built without OpenEXR";
  write_scene();
  ASSERT_EQ(run(folder, "render s.toml" + small + "-o a.exr -o a.png").code, 0);
  EXPECT_EQ(contents(folder / "a.exr").substr(0, 4), "\x76\x2f\x31\x01");
}

TEST_F(Render, AFilmHasEveryFrameOfTheLoop) {
  if (std::system("ffmpeg -version > /dev/null 2>&1") != 0) GTEST_SKIP() << "no ffmpeg";
  write_scene();
  const Outcome outcome = run(folder, "render s.toml" + small + "-o a.gif");
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  EXPECT_EQ(contents(folder / "a.gif").substr(0, 6), "GIF89a");
}

TEST_F(Render, GustsStandAsArrowsInTheSceneOrTintItsGround) {
  const std::string soil = "[ground]\nkind = \"soil\"\n";
  const std::string area = "[gusts]\nlow = [-3, -3]\nhigh = [3, 3]\nspacing = 1\n";
  const auto picture_with = [&](const std::string& gusts, int arrows) {
    write_scene(soil + gusts);
    const Outcome outcome = run(folder, "render s.toml" + small + "--report r.json -o a.png");
    EXPECT_EQ(outcome.code, 0) << outcome.messages;
    const auto report = nlohmann::json::parse(contents(folder / "r.json"));
    EXPECT_EQ(report.at("objects").back().value("count", -1), arrows) << gusts;
    return contents(folder / "a.png");
  };
  const std::string bare = picture_with("", -1), arrows = picture_with(area, 49),
                    both = picture_with(area + "tint = true\n", 49),
                    tint = picture_with(area + "tint = true\narrows = false\n", 0);
  EXPECT_NE(arrows, bare);
  EXPECT_NE(tint, bare);
  EXPECT_NE(both, arrows);
  write_scene(soil + area + "arrows = false\n");
  Outcome outcome = run(folder, "render s.toml" + small + "-o b.png");
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.messages, HasSubstr("neither arrows nor tint"));
  EXPECT_THAT(outcome.messages, HasSubstr("s.toml:"));
  write_scene(soil + "[gusts]\nlow = [-500, -500]\nhigh = [500, 500]\nspacing = 1\n");
  outcome = run(folder, "render s.toml" + small + "-o b.png");
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.messages, HasSubstr("a larger spacing"));
}

TEST_F(Render, TellsRaysCopiesAndSecondsInTheReport) {
  write_scene("[[objects.grid]]\ncolumns = 3\nrows = 2\nspacing = 4\n");
  ASSERT_EQ(run(folder, "render s.toml" + small + "-o a.png --report r.json").code, 0);
  const nlohmann::json report = nlohmann::json::parse(contents(folder / "r.json"));
  EXPECT_EQ(report["instances"], 6);
  EXPECT_EQ(report["objects"][0]["name"], "tree");
  EXPECT_GE(report["rays"], 32 * 18);
  EXPECT_EQ(report["wind_speed_m_s"], 7);
}

TEST_F(Render, NoOutputIsLeftWhereAnythingIsWrong) {
  write_scene();
  struct Wrong {
    const char *arguments, *said;
  };
  const Wrong wrongs[] = {
      {"render s.toml", "no output"},
      {"render s.toml -o a.jpg", ".png"},
      {"render s.toml -o f/%x.png", "%04d"},
      {"render s.toml -o f/%d%d.png", "%04d"},
      {"render s.toml -o f%d.mp4", "frames/%04d.png"},
      {"render s.toml -o a.png --size 0x3", "--size"},
      {"render s.toml -o a.png --size 12", "960x540"},
      {"render s.toml -o a.png --size 99999x3", "16384"},
      {"render s.toml -o a.png --samples 0", "--samples"},
      {"render s.toml -o a.png --shutter 2", "--shutter"},
      {"render s.toml -o a.png --frames 10", "0-9"},
      {"render s.toml -o a.png --frames 3-5", "one frame"},
      {"render s.toml -o f/%d.png --frames 5-3", "--frames"},
      {"render s.toml -o f/%d.png --frames 0-9:0", "--frames"},
      {"render s.toml -o a.png --resume", "--resume"},
      {"render s.toml -o a.png --sheet 2x2 --frames 0", "--sheet"},
      {"render s.toml -o a.exr --sheet 2x2", "--sheet"},
      {"render s.toml -o s.toml", ".png"},
      {"render s.toml -o a.png -o a.png", "of its own"},
      {"render nothing.toml -o a.png", "nothing.toml"},
      {"render s.toml -o a.png --wind-speed -3", "--wind-speed"},
      {"render s.toml -o a.png --report r.txt", "json"},
      {"render s.toml -o a.png --denoiser magic", "oidn"},
      {"render s.toml -o a.png --denoiser own --no-denoise", "one of them"},
  };
  for (const Wrong& wrong : wrongs) {
    const Outcome outcome = run(folder, wrong.arguments);
    EXPECT_EQ(outcome.code, 2) << wrong.arguments << ": " << outcome.messages;
    EXPECT_THAT(outcome.messages, HasSubstr(wrong.said)) << wrong.arguments;
    EXPECT_EQ(std::count(outcome.messages.begin(), outcome.messages.end(), '\n'), 1) << outcome.messages;
    EXPECT_EQ(file_count(folder), 1U) << wrong.arguments;
  }
}

TEST_F(Render, WhatIsStoppedLeavesWholeFramesAlone) {
  write_scene();
  std::filesystem::create_directory(folder / "f");
  const Outcome outcome =
      run(folder, "render s.toml --size 640x360 --samples 16 -o f/%d.png", "timeout -s INT 3 ");
  EXPECT_NE(outcome.code, 0) << "ten frames take longer";
  for (const auto& entry : std::filesystem::directory_iterator(folder / "f")) {
    EXPECT_EQ(entry.path().extension(), ".png");
    EXPECT_EQ(test::read_picture(entry.path()).width, 640) << entry.path();
  }
  ASSERT_EQ(run(folder, "render s.toml --resume" + small + "-o f/%d.png").code, 0);
  EXPECT_TRUE(std::filesystem::exists(folder / "f/9.png"));
}

class Scene : public Render {};

// What the settings of the motion are worth is known where the motion is made; the place is that of the file.
TEST_F(Scene, SettingsThatAreWrongAreSaidWithTheirPlace) {
  struct Wrong {
    const char *lines, *said;
  };
  const Wrong wrongs[] = {
      {"[wind]\nwind_speed = -3\n", "s.toml:2:14: wind_speed: "},
      {"[wind]\n\nprofile = \"steep\"\n", "s.toml:3:11: profile: "},
      {"[wind]\nwind = \"stam\"\nterrain = \"city\"\nspectrum = \"kaimal\"\n", "s.toml:4:12: spectrum: "},
      {"[motion]\nperiod = 0\n", "s.toml:2:10: period: "},
      {"[motion]\nperiod = 1e5\nfps = 1000\n", "s.toml:2:10: period"},
      {"[motion]\nmaterial = \"oack\"\n", "s.toml:2:12: material: "},
      {"[motion]\ndynamics = \"modul\"\n", "s.toml:2:12: dynamics: "},
      {"[motion]\nmode_damping = [0.05, -1]\n", "s.toml:2:16: mode_damping: "},
      {"[motion]\ndynamics = \"oscillators\"\nmodes = 3\n", "s.toml:3:9: modes: "},
  };
  for (const Wrong& wrong : wrongs) {
    write(folder / "s.toml", wrong.lines + std::string("[[objects]]\nsource = \"sapling\"\n"));
    for (const char* command : {"check s.toml", "render s.toml -o a.png"}) {
      const Outcome outcome = run(folder, command);
      EXPECT_EQ(outcome.code, 2) << wrong.lines << outcome.messages;
      EXPECT_THAT(outcome.messages, HasSubstr(wrong.said)) << command;
      EXPECT_THAT(outcome.messages, HasSubstr("wanted")) << command;
      EXPECT_EQ(file_count(folder), 1U);
    }
  }
}

TEST_F(Scene, WhatAFlagSaysCountsInsteadOfTheFile) {
  write(folder / "s.toml",
        "[wind]\nwind_speed = -3\n[motion]\nperiod = 2\nfps = 5\n[[objects]]\nsource = \"sapling\"\n");
  EXPECT_EQ(run(folder, "render s.toml --wind-speed 3" + small + "-o a.png").code, 0);
}

TEST_F(Scene, OfMorePlantsOneIsAnimatedByName) {
  write_scene("\n[[objects]]\nsource = \"birch\"\n");
  const Outcome both = run(folder, "animate s.toml -o a.csv");
  EXPECT_EQ(both.code, 2);
  EXPECT_THAT(both.messages, HasSubstr("tree, birch"));
  const Outcome misspelt = run(folder, "animate s.toml --object brich -o a.csv");
  EXPECT_THAT(misspelt.messages, HasSubstr("did you mean birch"));
  ASSERT_EQ(run(folder, "animate s.toml --object tree -o a.csv").code, 0);
  ASSERT_EQ(run(folder, "animate sapling --wind-speed 7 --period 2 --fps 5 -o b.csv").code, 0);
  EXPECT_EQ(contents(folder / "a.csv"), contents(folder / "b.csv"));
}

// One wind: what is added to a scene changes nothing of what was there.
TEST_F(Scene, MovesAnObjectAsBeforeWhateverIsAddedToIt) {
  write_scene("");
  ASSERT_EQ(run(folder, "animate s.toml -o alone.csv").code, 0);
  write_scene(
      "\n[[objects]]\nsource = \"birch\"\nname = \"other\"\n[[objects.instances]]\nposition = [40, 30]\n"
      "\n[[drift]]\nlow = [-5, -5, 0]\nhigh = [5, 5, 4]\n[gusts]\nlow = [-50, -50]\nhigh = [50, 50]\n");
  const Outcome beside = run(folder, "animate s.toml --object tree -o beside.csv");
  ASSERT_EQ(beside.code, 0) << beside.messages;
  EXPECT_EQ(contents(folder / "alone.csv"), contents(folder / "beside.csv"));
}

TEST_F(Scene, CheckSaysWhatIsInIt) {
  write_scene("[[objects.grid]]\ncolumns = 3\nrows = 2\nspacing = 4\n");
  const Outcome outcome = run(folder, "check s.toml");
  EXPECT_EQ(outcome.code, 0) << outcome.messages;
  EXPECT_THAT(outcome.output, HasSubstr("tree: a tree from sapling, 6 copies"));
  EXPECT_THAT(run(folder, "check --keys").output, HasSubstr("wind_speed"));
}

// The scenes of the project, small.
class SceneOfTheProject : public testing::TestWithParam<std::string> {};

TEST_P(SceneOfTheProject, LooksAsItDid) {
  if (!can_trace()) GTEST_SKIP() << "built without Embree";
  const test::TemporaryFolder folder;
  const std::string scene = std::string(TREMULA_SCENES) + "/" + GetParam() + ".toml";
  const Outcome outcome = run(folder, "render '" + scene + "' --size 96x54 --samples 16 -o a.png");
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  const test::Picture now = test::read_picture(folder / "a.png");
  const test::Picture then = test::read_picture(std::string(TREMULA_GOLDEN) + "/" + GetParam() + ".png");
  // In blocks of six pixels, as the eye sees them from far: noise and other libraries move single pixels.
  const test::Difference difference = test::difference_in_blocks(now, then, 6);
  EXPECT_LT(difference.mean, 2.5) << "of 255";
  EXPECT_LT(difference.largest, 20) << "of 255";
}

std::vector<std::string> scene_names() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(TREMULA_SCENES)) {
    if (entry.path().extension() == ".toml") names.push_back(entry.path().stem().string());
  }
  std::ranges::sort(names);
  return names;
}

std::string name_of(const testing::TestParamInfo<std::string>& scene) {
  std::string name = scene.param;
  std::ranges::replace(name, '-', '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(All, SceneOfTheProject, testing::ValuesIn(scene_names()), name_of);

}  // namespace
}  // namespace tremula
