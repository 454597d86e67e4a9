// Grass, as a user asks for it.
#include "cli/program.hpp"

#include <filesystem>
#include <string>

#include <gmock/gmock.h>

#include "tremula/io/html.hpp"

namespace tremula {
namespace {

using test::contents;
using test::Outcome;
using test::run;
using test::write;
using testing::HasSubstr;

const std::string short_loop = " --period 2 --fps 5 ";

struct Grass : testing::Test {
  test::TemporaryFolder folder;

  void write_scene(const std::string& more = "") const {
    write(folder / "s.toml",
          "[motion]\nperiod = 2\nfps = 5\n[[grass]]\nspecies = \"lawn\"\nlow = [0, 0]\nhigh = [0.3, 0.3]\n" +
              more);
  }
};

TEST_F(Grass, OfASpeciesIsAModelWhoseWeightsMove) {
  const Outcome outcome = run(folder, "animate wheat" + short_loop + "-o w.glb --report w.json");
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  EXPECT_THAT(contents(folder / "w.glb"), HasSubstr("\"weights\""));
  EXPECT_THAT(contents(folder / "w.json"), HasSubstr("\"species\": \"wheat\""));
}

TEST_F(Grass, IsTheSameByNameAndFromASceneThatSaysTheSame) {
  write(folder / "s.toml",
        "[motion]\nperiod = 2\nfps = 5\n[[grass]]\nspecies = \"lawn\"\nlow = [-0.5, -0.5]\nhigh = [0.5, "
        "0.5]\n");
  ASSERT_EQ(run(folder, "animate s.toml -o a.glb").code, 0);
  ASSERT_EQ(run(folder, "animate lawn" + short_loop + "-o b.glb").code, 0);
  EXPECT_EQ(contents(folder / "a.glb"), contents(folder / "b.glb"));
}

TEST_F(Grass, RefusesFlagsThatShapePlantsAndTablesOfNodes) {
  const auto complaint = [&](const std::string& arguments) {
    const Outcome outcome = run(folder, "animate meadow" + short_loop + arguments);
    EXPECT_EQ(outcome.code, 2) << arguments;
    return outcome.messages;
  };
  EXPECT_THAT(complaint("--modes 5 -o a.glb"), HasSubstr("--modes: given with meadow"));
  EXPECT_THAT(complaint("--form skin -o a.glb"), HasSubstr("--form: given with meadow"));
  EXPECT_THAT(complaint("--gust 1-cosine:3:1 -o a.glb"), HasSubstr("--gust: given with meadow"));
  EXPECT_THAT(complaint("-o a.csv"), HasSubstr("-o a.csv"));
  EXPECT_FALSE(std::filesystem::exists(folder / "a.glb"));
}

TEST_F(Grass, OfASceneWithMoreIsNamed) {
  write_scene("[[impressions]]\nname = \"far\"\n");
  ASSERT_EQ(run(folder, "animate s.toml --object lawn -o a.glb").code, 0);
  EXPECT_EQ(run(folder, "animate s.toml -o b.glb").code, 2);
}

TEST_F(Grass, TooMuchOfItForMorphTargetsIsRefusedWithItsNumber) {
  write(folder / "s.toml",
        "[motion]\nperiod = 2\nfps = 5\n[[grass]]\nspecies = \"lawn\"\nlow = [0, 0]\nhigh = [4, 4]\n");
  const Outcome outcome = run(folder, "animate s.toml -o a.glb");
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.messages, HasSubstr("vertices"));
  EXPECT_FALSE(std::filesystem::exists(folder / "a.glb"));
}

TEST_F(Grass, OfAPageIsAWholeFieldAndSaysHowManyBlades) {
  if (!can_write_html()) GTEST_SKIP() << "built without node and npm";
  write(folder / "s.toml",
        "[motion]\nperiod = 2\nfps = 5\n[[grass]]\nspecies = \"lawn\"\nlow = [0, 0]\nhigh = [4, 4]\n");
  const Outcome outcome = run(folder, "animate s.toml -o a.html --report a.json");
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  EXPECT_THAT(outcome.messages, HasSubstr(" blades"));
  EXPECT_THAT(contents(folder / "a.json"), HasSubstr("\"page\": {"));
}

TEST_F(Grass, MoreThanAPageHoldsIsRefusedWithItsNumber) {
  if (!can_write_html()) GTEST_SKIP() << "built without node and npm";
  write(folder / "s.toml",
        "[motion]\nperiod = 2\nfps = 5\n[[grass]]\nspecies = \"meadow\"\nlow = [0, 0]\nhigh = [40, 40]\n");
  const Outcome outcome = run(folder, "animate s.toml -o a.html");
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.messages, HasSubstr("at most 1500000"));
  EXPECT_FALSE(std::filesystem::exists(folder / "a.html"));
}

TEST_F(Grass, OfAMaskThatLeavesNothingIsRefusedWithItsPlaceInTheScene) {
  test::write(folder / "s.toml",
              "[wind]\nseed = 2\n[[grass]]\nlow = [0, 0]\nhigh = [1, 1]\n"
              "inside = [[5, 5], [6, 5], [6, 6]]\n");
  const test::Outcome outcome = test::run(folder, "animate s.toml -o a.glb");
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.messages, HasSubstr("s.toml:3:1: field of grass: no blade in it"));
  EXPECT_FALSE(std::filesystem::exists(folder / "a.glb"));
}

}  // namespace
}  // namespace tremula
