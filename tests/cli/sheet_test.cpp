#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>

#include "cli/program.hpp"

namespace tremula {
namespace {

using nlohmann::json;
using test::Outcome;
using test::run;
using testing::HasSubstr;

const std::string steel =
    "[sheet]\nwidth = 1\nheight = 1\nthickness = 0.005\nyoungs_modulus = 200e9\npoisson_ratio = 0.3\n"
    "density = 7850\nelements = [12, 12]\n";

void write(const test::TemporaryFolder& folder, const std::string& text) {
  std::ofstream(folder / "sheet.toml") << text;
}

TEST(ProgramOnSheets, FindsTheModesOfAPinnedSquare) {
  const test::TemporaryFolder folder;
  write(folder, steel + "pin = [\"left\", \"right\", \"bottom\", \"top\"]\n");
  const Outcome outcome = run(folder, "modes sheet.toml --count 6 --gravity 0 --medium vacuum --format json");
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  const json found = json::parse(outcome.output);
  ASSERT_EQ(found["modes"].size(), 6U);
  EXPECT_EQ(found["count_found"], found["count_by_inertia"]);
  const double D = 200e9 * std::pow(0.005, 3) / (12 * (1 - 0.09)), unit = std::sqrt(D / (7850 * 0.005));
  const double squares[] = {2, 5, 5, 8, 10, 10};
  for (std::size_t r = 0; r < 6; ++r) {
    const double wanted = std::numbers::pi / 2 * squares[r] * unit;
    // Twelve elements a side: the error goes with the square of their number in a wave.
    EXPECT_NEAR(found["modes"][r]["frequency_hz"].get<double>() / wanted, 1, 0.0025 * squares[r]) << r;
  }
  EXPECT_NEAR(found["total_mass_kg"].get<double>(), 7850 * 0.005, 1e-9);
  EXPECT_EQ(found["sheet"]["elements"][0], 12);
}

TEST(ProgramOnSheets, SlowsThemInAirAndMoreInWater) {
  const test::TemporaryFolder folder;
  write(folder, steel + "clamp = [\"left\"]\n");
  double before = 1e9;
  for (const std::string medium : {"vacuum", "air", "water"}) {
    const Outcome outcome =
        run(folder, "modes sheet.toml --count 1 --gravity 0 --format json --medium " + medium);
    ASSERT_EQ(outcome.code, 0) << outcome.messages;
    const double frequency = json::parse(outcome.output)["modes"][0]["frequency_hz"];
    EXPECT_LT(frequency, before);
    before = frequency;
  }
}

TEST(ProgramOnSheets, RefusesInOneLine) {
  const test::TemporaryFolder folder;
  const auto expect_refused = [&](const std::string& text, const std::string& arguments,
                                  const std::vector<std::string>& parts) {
    write(folder, text);
    const Outcome outcome = run(folder, arguments);
    EXPECT_EQ(outcome.code, 2) << outcome.messages;
    EXPECT_EQ(std::count(outcome.messages.begin(), outcome.messages.end(), '\n'), 1) << outcome.messages;
    EXPECT_EQ(outcome.output, "");
    for (const std::string& part : parts) EXPECT_THAT(outcome.messages, HasSubstr(part));
  };
  const std::string modes = "modes sheet.toml --gravity 0 ", held = steel + "clamp = [\"left\"]\n";
  expect_refused(steel, modes, {"sheet.toml:1:1: sheet: clamped nowhere"});
  expect_refused(held + "tension = [-1e8, 0]\n", modes, {"sheet.toml: sheet: it buckles", "it bears"});
  expect_refused(steel + "pin = [\"left\"]\n", modes, {"sheet.toml: sheet: free to turn"});
  expect_refused(steel + "clmp = [\"left\"]\n", modes, {"sheet.toml:9:", "did you mean clamp?"});
  expect_refused(held, modes + "--density 3", {"--density: given with the sheet sheet.toml"});
  expect_refused(held, "modes sheet.toml --modes 2000", {"1 to 468"});
  expect_refused(held, "animate sheet.toml -o a.glb --medium vacuum", {"--medium vacuum: given with a wind"});
  expect_refused(held, "load sheet.toml", {"a sheet, wanted a tree"});
  expect_refused(held, "grow sheet.toml -o a.swc", {"a sheet, wanted a tree"});
  expect_refused(held, "animate sheet.toml -o a.glb --form skin", {"given with a sheet"});
}

TEST(ProgramOnSheets, InfoTellsWhatIsInTheFile) {
  const test::TemporaryFolder folder;
  write(folder, steel + "clamp = [\"left\"]\n");
  const Outcome outcome = run(folder, "info sheet.toml --format json");
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  EXPECT_EQ(json::parse(outcome.output)["sheet"]["width_m"], 1);
}

TEST(ProgramOnSheets, AnimatesEveryPreset) {
  const test::TemporaryFolder folder;
  for (const std::string preset : {"flag", "banner", "curtain", "sail", "sign"}) {
    const Outcome outcome =
        run(folder, "animate " + preset + " --wind-speed 4 --period 4 --fps 10 -o a.csv -o a.glb");
    EXPECT_EQ(outcome.code, 0) << preset << outcome.messages;
    EXPECT_THAT(test::contents(folder / "a.glb"), testing::StartsWith("glTF"));
    const std::string table = test::contents(folder / "a.csv");
    EXPECT_THAT(table, testing::Not(HasSubstr("nan")));
  }
}

TEST(ProgramOnSheets, PlotsTheModesOfSheetAndSign) {
  const test::TemporaryFolder folder;
  write(folder, steel + "clamp = [\"left\"]\n");
  for (const std::string input : {"sheet.toml", "sign"}) {
    const Outcome outcome = run(folder, "modes " + input + " --count 3 --format json --plot a.svg");
    ASSERT_EQ(outcome.code, 0) << outcome.messages;
    EXPECT_THAT(test::contents(folder / "a.svg"), HasSubstr("id=\"mode-3\""));
    const json found = json::parse(outcome.output);
    if (input == "sign") {
      EXPECT_EQ(found["panels"][0]["height_m"], 0.9);
    }
  }
}

TEST(ProgramOnSheets, SaysHowAFlagWasMoved) {
  const test::TemporaryFolder folder;
  const auto dynamics = [&](const std::string& arguments) {
    const Outcome outcome = run(
        folder, "animate " + arguments + " --period 2 --fps 15 --turbulence-intensity 0.1 --report r.json");
    EXPECT_EQ(outcome.code, 0) << outcome.messages;
    return json::parse(test::contents(folder / "r.json"))["settings"]["dynamics"].get<std::string>();
  };
  EXPECT_EQ(dynamics("flag --wind-speed 6"), "flapping");
  EXPECT_EQ(dynamics("flag --wind-speed 6 --heading 70"), "flapping");
  EXPECT_EQ(dynamics("flag --wind-speed 6 --dynamics modal"), "modal");
  EXPECT_EQ(dynamics("curtain --wind-speed 1"), "modal");
  write(folder, steel + "clamp = [\"left\"]\n");
  EXPECT_EQ(dynamics("sheet.toml --wind-speed 6"), "modal");
  write(folder,
        "[sheet]\nwidth = 1\nheight = 0.5\nthickness = 0.0001\nyoungs_modulus = 3e9\ndensity = 1400\n"
        "clamp = [\"left\"]\n");
  EXPECT_EQ(dynamics("sheet.toml --wind-speed 12 --gravity 0"), "flapping");
}

TEST(ProgramOnSheets, AFlagRisesInAGustFromRest) {
  const test::TemporaryFolder folder;
  const Outcome outcome =
      run(folder,
          "animate flag --gust 1-cosine:12:4 --from-rest --wind-speed 0.5 --period 4 --fps 10 "
          "-o a.glb --report r.json");
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  const json settings = json::parse(test::contents(folder / "r.json"))["settings"];
  EXPECT_EQ(settings["dynamics"], "flapping");
  EXPECT_EQ(settings["repeats"], false);
  EXPECT_EQ(run(folder, "animate banner --gust 1-cosine:8:2 -o b.glb").code, 2);
  EXPECT_EQ(run(folder, "animate flag --pull 4.5m:2N -o b.glb").code, 2);
}

TEST(ProgramOnSheets, AFlagThatFlapsRefusesWhatBelongsToModes) {
  const test::TemporaryFolder folder;
  for (const std::string flag : {"--modes 3", "--drag quadratic", "--transfer sampled",
                                 "--no-static-correction", "--no-aerodynamic-damping"}) {
    const Outcome outcome = run(folder, "animate flag -o a.glb " + flag);
    EXPECT_EQ(outcome.code, 2) << flag;
    EXPECT_THAT(outcome.messages, HasSubstr("--dynamics modal")) << flag;
  }
}

TEST(ProgramOnSheets, RefusesToFlapWhatIsNoFlag) {
  const test::TemporaryFolder folder;
  for (const std::string plant : {"sapling", "banner"}) {
    const Outcome outcome = run(folder, "animate " + plant + " --dynamics flapping -o a.glb");
    EXPECT_EQ(outcome.code, 2);
    EXPECT_THAT(outcome.messages, HasSubstr("flapping"));
    EXPECT_EQ(std::count(outcome.messages.begin(), outcome.messages.end(), '\n'), 1) << outcome.messages;
  }
}

}  // namespace
}  // namespace tremula
