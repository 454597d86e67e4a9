// tremula wind and tremula info on wind fields.
#include "cli/program.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

namespace tremula {
namespace {

using nlohmann::json;
using test::contents;
using test::file_count;
using test::Outcome;
using test::run;
using test::write;
using testing::HasSubstr;
using testing::StartsWith;

template <typename T>
void append(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

// A file of 2 x 3 points and a tower of 2, in which a value at step t is the integer 1000 t + 100 c + point;
// the slope is 10, 20, 40, the offset 500. The text is no text.
std::string small_bts(std::int16_t id = 7, int steps = 4) {
  std::string bytes;
  append<std::int16_t>(bytes, id);
  for (const std::int32_t count : {3, 2, 2, steps}) append(bytes, count);
  for (const float number : {2.0F, 1.5F, 0.5F, 6.0F, 10.0F, 4.0F}) append(bytes, number);
  for (const float slope : {10.0F, 20.0F, 40.0F}) {
    append(bytes, slope);
    append(bytes, 500.0F);
  }
  append<std::int32_t>(bytes, 3);
  bytes += "a\n\xFF";
  for (int t = 0; t < steps; ++t)
    for (int p = 0; p < 8; ++p)
      for (int c = 0; c < 3; ++c) append(bytes, static_cast<std::int16_t>(1000 * (t % 4) + 100 * c + p));
  return bytes;
}

TEST(InfoOfAWindField, SaysAsJsonWhatWasRead) {
  const test::TemporaryFolder folder;
  write(folder / "a.bts", small_bts());
  const Outcome outcome = run(folder, "info a.bts --format json");
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  const json info = json::parse(outcome.output);
  EXPECT_EQ(info.at("format"), "turbsim-bts");
  EXPECT_EQ(info.at("id"), 7);
  EXPECT_EQ(info.at("text"), "a??");
  EXPECT_EQ(info.at("periodic"), false);
  EXPECT_EQ(info.at("points"), (json{{"y", 2}, {"z", 3}}));
  EXPECT_EQ(info.at("spacing_m"), (json{{"y", 1.5}, {"z", 2.0}}));
  EXPECT_EQ(info.at("steps"), 4);
  EXPECT_EQ(info.at("step_s"), 0.5);
  EXPECT_EQ(info.at("period_s"), 2);
  EXPECT_EQ(info.at("mean_speed_m_s"), 6);
  EXPECT_EQ(info.at("reference_height_m"), 10);
  EXPECT_EQ(info.at("slope"), (json{10, 20, 40}));
  EXPECT_EQ(info.at("y_m"), (json{-0.75, 0.75}));
  EXPECT_EQ(info.at("z_m"), (json{4, 6, 8}));
  EXPECT_EQ(info.at("tower").at("z_m"), (json{4, 2}));
  const double slopes[] = {10, 20, 40};
  for (int c = 0; c < 3; ++c) {
    const std::string name(1, "uvw"[c]);
    // Over t the integers are 1000 (0, 1, 2, 3) and the rest: mean 1500, deviation 1000 sqrt(1.25).
    const auto mean = [&](int point) { return (1500 + 100 * c + point - 500) / slopes[c]; };
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 2; ++j) {
        EXPECT_NEAR(info.at("mean_m_s").at(name).at(i).at(j), mean(static_cast<int>(2 * i + j)), 1e-5);
        EXPECT_NEAR(info.at("deviation_m_s").at(name).at(i).at(j), 1000 * std::sqrt(1.25) / slopes[c], 1e-5);
      }
    }
    for (std::size_t k = 0; k < 2; ++k) {
      EXPECT_NEAR(info.at("tower").at("mean_m_s").at(name).at(k), mean(6 + static_cast<int>(k)), 1e-5);
      EXPECT_NEAR(info.at("tower").at("deviation_m_s").at(name).at(k), 1000 * std::sqrt(1.25) / slopes[c],
                  1e-5);
    }
  }
}

TEST(InfoOfAWindField, IsATableByHeightFromTheTopDown) {
  const test::TemporaryFolder folder;
  write(folder / "a.BTS", small_bts(8));
  const Outcome outcome = run(folder, "info a.BTS");
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  EXPECT_THAT(outcome.output, HasSubstr("(id 8, periodic)"));
  EXPECT_THAT(outcome.output, HasSubstr("2 x 3 points"));
  const std::size_t top = outcome.output.find("     8.000   100.450"),
                    lowest = outcome.output.find("     4.000   100.050"),
                    tower = outcome.output.find("     2.000   100.700");
  ASSERT_NE(top, std::string::npos) << outcome.output;
  EXPECT_LT(top, lowest);
  EXPECT_LT(lowest, tower);
  EXPECT_NE(tower, std::string::npos) << outcome.output;
}

TEST(Wind, ChecksAndRewritesAField) {
  const test::TemporaryFolder folder;
  write(folder / "a.bts", small_bts(8, 64));
  const Outcome outcome =
      run(folder, "wind a.bts -o b.bts -o b.vti --report r.json --plot r.svg --separations 2,1 --bands 1000");
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  EXPECT_THAT(outcome.output,
              StartsWith("field      2 x 3 points (y x z), z 4 to 8 m, 64 steps of 0.5 s: 32 s\n"));
  EXPECT_THAT(outcome.output, HasSubstr("\nverdict    "));
  for (const std::string name : {"b.bts", "b.vti", "r.json", "r.svg"})
    EXPECT_THAT(outcome.messages, HasSubstr("tremula: wrote " + name));
  EXPECT_EQ(file_count(folder), 5U);
  EXPECT_THAT(contents(folder / "b.vti"), HasSubstr("WholeExtent=\"0 63 0 1 0 2\""));
  EXPECT_THAT(contents(folder / "r.svg"), HasSubstr("<title>a</title>"));

  const json report = json::parse(contents(folder / "r.json"));
  EXPECT_EQ(report.at("grid").at("steps"), 64);
  ASSERT_EQ(report.at("rows").size(), 3U);
  EXPECT_NEAR(report.at("rows").at(1).at("mean_m_s").at("u"), 100.25, 1e-4);
  EXPECT_NEAR(report.at("rows").at(1).at("deviation_m_s").at("v"), 50 * std::sqrt(1.25), 1e-4);
  ASSERT_EQ(report.at("bands").size(), 31U);
  ASSERT_EQ(report.at("spectra").size(), 9U);
  // A sawtooth of period 4 has one line below the Nyquist frequency, at bin 16: 0.5 Hz. Its amplitude is
  // |sum over t of t i^t| * 2/4 = sqrt(2) thousands, its variance 1, and the band 1/32 Hz.
  const json& u = report.at("spectra").at(0);
  EXPECT_EQ(u.at("component"), "u");
  EXPECT_EQ(report.at("bands").at(15).at("frequency_hz"), 0.5);
  for (std::size_t b = 0; b < 31; ++b)
    EXPECT_NEAR(u.at("measured_m2_s2_per_hz").at(b), b == 15 ? 32 * 1e4 : 0, 1) << b;
  ASSERT_EQ(report.at("coherence").size(), 9U);  // 1 across, 1 and 2 upward; u, v, w
  EXPECT_NEAR(report.at("coherence").at(0).at("measured_root").at(15), 1, 1e-5);

  // What was written is read as what was read.
  const Outcome before = run(folder, "info a.bts --format json"),
                after = run(folder, "info b.bts --format json");
  const json a = json::parse(before.output), b = json::parse(after.output);
  EXPECT_EQ(a.at("tower").at("z_m"), b.at("tower").at("z_m"));
  for (const std::string name : {"u", "v", "w"}) {
    EXPECT_NEAR(a.at("mean_m_s").at(name).at(2).at(1), b.at("mean_m_s").at(name).at(2).at(1), 3e-3);
    EXPECT_NEAR(a.at("tower").at("mean_m_s").at(name).at(1), b.at("tower").at("mean_m_s").at(name).at(1),
                3e-3);
  }
}

// The form of the design on a grid that takes no time.
const std::string small_field =
    "wind --model iec-kaimal --speed 12 --reference-height 90 --profile power:0.2 --points 5x4 --size 40x30 "
    "--center-height 90 --steps 64 --step 0.5 --seed 1 ";

TEST(Wind, SynthesisesAFieldInTheFormThatScriptsRelyOn) {
  const test::TemporaryFolder folder;
  const Outcome outcome = run(folder, small_field + "-o field.bts --report wind.json --plot wind.svg");
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  EXPECT_EQ(outcome.output, "");
  EXPECT_EQ(file_count(folder), 3U);
  EXPECT_THAT(contents(folder / "wind.svg"), HasSubstr("stroke-dasharray"));  // targets

  const json info = json::parse(run(folder, "info field.bts --format json").output);
  EXPECT_EQ(info.at("points"), (json{{"y", 5}, {"z", 4}}));
  EXPECT_EQ(info.at("periodic"), true);
  EXPECT_EQ(info.at("y_m"), (json{-20, -10, 0, 10, 20}));
  EXPECT_EQ(info.at("z_m"), (json{75, 85, 95, 105}));
  EXPECT_EQ(info.at("steps"), 64);
  EXPECT_EQ(info.at("mean_speed_m_s"), 12);
  EXPECT_EQ(info.at("reference_height_m"), 90);
  EXPECT_THAT(info.at("text").get<std::string>(), HasSubstr("iec-kaimal, 12 m/s at 90 m, seed 1"));

  const json report = json::parse(contents(folder / "wind.json"));
  const json& wind = report.at("settings").at("wind");
  EXPECT_EQ(wind.at("spectrum"), "iec-kaimal");
  EXPECT_EQ(wind.at("coherence"), "iec");
  EXPECT_EQ(wind.at("profile"), "power");
  EXPECT_EQ(wind.at("power_exponent"), 0.2);
  EXPECT_NEAR(wind.at("turbulence_intensity"), 0.2, 1e-12);
  EXPECT_NEAR(wind.at("length_m").at("u"), 8.1 * 42, 1e-9);
  EXPECT_EQ(wind.at("seed"), 1);
  EXPECT_EQ(report.at("settings").at("match"), "spectrum");
  const json& row = report.at("rows").at(3);
  EXPECT_NEAR(row.at("target_mean_m_s").at("u"), 12 * std::pow(105.0 / 90, 0.2), 1e-9);
  EXPECT_NEAR(row.at("mean_m_s").at("u"), row.at("target_mean_m_s").at("u"), 1e-5);
  // In the report, the share of the variance that the loop has is that of the targets.
  const double sigma = 0.2 * 12, resolved = report.at("synthesis").at("resolved_share").at("u");
  EXPECT_GT(resolved, 0.3);
  EXPECT_LT(resolved, 0.9);
  EXPECT_NEAR(row.at("target_deviation_m_s").at("u"), sigma * std::sqrt(resolved), 1e-5);
  // The first band is the first bin, 1/32 Hz.
  const double period = 8.1 * 42 / 12, f = 1.0 / 32;
  EXPECT_NEAR(report.at("spectra").at(0).at("target_m2_s2_per_hz").at(0),
              sigma * sigma * 4 * period / std::pow(1 + 6 * f * period, 5.0 / 3), 1e-9);
  const json& pair = report.at("coherence").at(0);
  EXPECT_EQ(pair.at("distance_m"), 10);
  EXPECT_NEAR(pair.at("target_root").at(0), std::exp(-12 * std::hypot(f * 10 / 12, 0.12 * 10 / (8.1 * 42))),
              1e-9);
  for (const char* key : {"clipped_share", "mean_clipped_share", "coherence_error", "largest_domain"})
    EXPECT_TRUE(report.at("synthesis").contains(key)) << key;
  EXPECT_EQ(report.at("stages").at(0).at("stage"), "synthesis");
  EXPECT_GT(report.at("peak_bytes"), 0);
}

TEST(Wind, OfOneSeedHasTheSameBytesOnAnyNumberOfThreadsAndOthersOfAnotherSeed) {
  const test::TemporaryFolder folder;
  ASSERT_EQ(run(folder, small_field + "--threads 1 -o one.bts").code, 0);
  ASSERT_EQ(run(folder, small_field + "--threads 2 -o two.bts --report two.json").code, 0);
  ASSERT_EQ(run(folder, small_field + "--threads 1 -o other.bts --seed 2").code, 2);  // given twice
  ASSERT_EQ(run(folder, "wind --points 5x4 -o other.bts --steps 64 --seed 2").code, 0);
  ASSERT_EQ(run(folder, "wind --points 5x4 -o again.bts --steps 64 --seed 2").code, 0);
  ASSERT_EQ(run(folder, "wind --points 5x4 -o third.bts --steps 64 --seed 3").code, 0);
  EXPECT_EQ(contents(folder / "one.bts"), contents(folder / "two.bts"));
  EXPECT_EQ(contents(folder / "other.bts"), contents(folder / "again.bts"));
  EXPECT_NE(contents(folder / "other.bts").substr(1000), contents(folder / "third.bts").substr(1000));
}

TEST(Wind, WithoutAGridStandsOnTheGroundWithAMetreBetweenPoints) {
  const test::TemporaryFolder folder;
  const auto grid_of = [&](const std::string& arguments) {
    const Outcome outcome = run(folder, "wind --report r.json " + arguments);
    EXPECT_EQ(outcome.code, 0) << outcome.messages;
    return json::parse(contents(folder / "r.json")).at("grid");
  };
  const json plain = grid_of("--steps 64");
  EXPECT_EQ(plain.at("points"), (json{{"y", 21}, {"z", 21}}));
  EXPECT_EQ(plain.at("spacing_m"), (json{{"y", 1.0}, {"z", 1.0}}));
  EXPECT_EQ(plain.at("bottom_m"), 0.5);
  EXPECT_EQ(plain.at("step_s"), 0.1);
  // A mast at the reference height; the loop in place of the steps, and of the step.
  const json mast = grid_of("--points 1x1 --period 25.6");
  EXPECT_EQ(mast.at("bottom_m"), 10);
  EXPECT_EQ(mast.at("steps"), 256);
  EXPECT_EQ(grid_of("--points 3x1 --period 20 --steps 600").at("step_s"), 20.0 / 600);
}

TEST(Wind, HasTheSpectraItsFlagsName) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "table.csv") << "frequency,S_u,S_v,S_w\n0.01,4,2,1\n1,4,2,1\n";
  // Without chance in powers and without coherence, measured and wanted are the same to a few roundings.
  for (const std::string wind : {"--spectrum simiu-scanlan --friction-velocity 0.5", "--spectrum von-karman",
                                 "--spectrum table.csv", "--terrain crops", "--match variance"}) {
    const Outcome outcome = run(folder,
                                "wind --coherence none --amplitudes phases --points 3x3 --period 60 "
                                "--report r.json " +
                                    wind);
    ASSERT_EQ(outcome.code, 0) << outcome.messages;
    const json report = json::parse(contents(folder / "r.json"));
    ASSERT_EQ(report.at("spectra").size(), 9U);
    for (const json& spectrum : report.at("spectra")) {
      for (std::size_t b = 0; b < report.at("bands").size(); ++b) {
        const double target = spectrum.at("target_m2_s2_per_hz").at(b);
        EXPECT_NEAR(spectrum.at("measured_m2_s2_per_hz").at(b), target, 1e-4 * target) << wind;
      }
    }
    if (wind == "--spectrum table.csv") {
      EXPECT_NEAR(report.at("spectra").at(1).at("target_m2_s2_per_hz").at(0), 2, 1e-12);
    }
    if (wind.find("friction") != std::string::npos) {
      EXPECT_NEAR(report.at("settings").at("wind").at("deviation_m_s").at("u"), 0.5 * std::sqrt(6.0), 1e-12);
    }
    if (wind == "--match variance") {
      EXPECT_NEAR(report.at("rows").at(0).at("target_deviation_m_s").at("u"), 0.2 * 6, 1e-12);
    }
  }
}

TEST(Wind, OverATerrainTakesFromItWhatIsNotGiven) {
  const test::TemporaryFolder folder;
  const auto wind_of = [&](const std::string& arguments) {
    const Outcome outcome = run(folder, "wind --points 2x2 --steps 4096 --report r.json " + arguments);
    EXPECT_EQ(outcome.code, 0) << outcome.messages;
    return json::parse(contents(folder / "r.json")).at("settings").at("wind");
  };
  const json parkland = wind_of("--terrain parkland");
  EXPECT_EQ(parkland.at("roughness_length_m"), 0.5);
  EXPECT_NEAR(parkland.at("turbulence_intensity"), std::sqrt(6.0) * 0.4 / std::log(10 / 0.5), 1e-12);
  const json changed =
      wind_of("--terrain parkland --roughness-length 0.1 --turbulence-intensity 0.3 --decay-y 1,2,3");
  EXPECT_EQ(changed.at("terrain"), "parkland");
  EXPECT_EQ(changed.at("roughness_length_m"), 0.1);
  EXPECT_NEAR(changed.at("turbulence_intensity"), 0.3, 1e-12);
  EXPECT_EQ(changed.at("decay_y"), (json{{"u", 1.0}, {"v", 2.0}, {"w", 3.0}}));
  EXPECT_EQ(changed.at("decay_z"), (json{{"u", 6.0}, {"v", 4.0}, {"w", 8.0}}));

  const Outcome list = run(folder, "wind --list-terrains");
  EXPECT_EQ(list.code, 0);
  for (const std::string name : {"open", "grass", "crops", "parkland", "forest-edge"})
    EXPECT_THAT(list.output, HasSubstr("\n" + name + " "));
}

TEST(Wind, WarnsOfWhatIsProbablyNotMeant) {
  const test::TemporaryFolder folder;
  const auto messages = [&](const std::string& arguments) {
    return run(folder, "wind --points 2x2 --report r.json " + arguments).messages;
  };
  EXPECT_EQ(messages(""), "tremula: wrote r.json\n");
  EXPECT_THAT(messages("--turbulence-intensity 0.41"),
              HasSubstr("warning: turbulence intensity 0.41: above 0.4"));
  EXPECT_THAT(messages("--period 5"), HasSubstr("warning: a loop of 5 s at 0.1 s a step holds "));
  EXPECT_EQ(messages("--period 5 --match variance"), "tremula: wrote r.json\n");
  EXPECT_THAT(messages("--displacement 2"),
              HasSubstr("warning: there is no wind in the lowest row, at 0.5 m"));
}

TEST(Wind, ChecksAFieldAgainstTheWindThatFlagsDescribe) {
  const test::TemporaryFolder folder;
  write(folder / "a.bts", small_bts(8, 64));
  ASSERT_EQ(run(folder, "wind a.bts --report r.json --spectrum von-karman").code, 0);
  const json report = json::parse(contents(folder / "r.json"));
  // The file's speed, 6 m/s at 10 m, where none is given.
  EXPECT_EQ(report.at("settings").at("wind").at("wind_speed_m_s"), 6);
  EXPECT_NEAR(report.at("rows").at(1).at("target_mean_m_s").at("u"),
              6 * std::log(6 / 0.03) / std::log(10 / 0.03), 1e-9);
  EXPECT_FALSE(report.contains("synthesis"));
  ASSERT_EQ(run(folder, "wind a.bts --report r.json --spectrum von-karman --speed 9").code, 0);
  EXPECT_EQ(json::parse(contents(folder / "r.json")).at("settings").at("wind").at("wind_speed_m_s"), 9);
  ASSERT_EQ(run(folder, "wind a.bts --report r.json").code, 0);
  EXPECT_FALSE(json::parse(contents(folder / "r.json")).at("rows").at(0).contains("target_mean_m_s"));
}

TEST(Wind, RefusesInOneLineAndLeavesNoFile) {
  const auto expect_refused = [](const std::string& arguments, const std::string& bytes,
                                 const std::string& part) {
    const test::TemporaryFolder folder;
    write(folder / "a.bts", bytes);
    const Outcome outcome = run(folder, arguments);
    EXPECT_EQ(outcome.code, 2) << arguments;
    EXPECT_THAT(outcome.messages, StartsWith("tremula: error: ")) << arguments;
    EXPECT_THAT(outcome.messages, HasSubstr(part)) << arguments;
    EXPECT_EQ(std::count(outcome.messages.begin(), outcome.messages.end(), '\n'), 1) << outcome.messages;
    EXPECT_EQ(outcome.output, "");
    EXPECT_EQ(file_count(folder), 1U) << arguments;
  };
  const std::string good = small_bts();
  expect_refused("wind a.bts -o b.wav", good, "'.wav', wanted .bts (TurbSim)");
  expect_refused("wind a.bts --plot b.png", good, "'.png', wanted .svg");
  expect_refused("wind b.bts --report r.json", good, "b.bts: cannot be opened");
  expect_refused("wind a.bts -o b.bts --report r.json --bands 0", good,
                 "bands per decade: 0, wanted 1 to 1000");
  expect_refused("wind a.bts --plot r.svg --separations 0", good,
                 "separation across: 0 cells, wanted 1 or more");
  expect_refused("wind a.bts --report r.json", good.substr(0, 100), "a.bts: 100 bytes, wanted 265");
  expect_refused("info a.bts", "tree", "a.bts: kind of file (byte 0)");
  for (const std::string flag :
       {"--points 3x3", "--tower", "--tile", "--match hub", "--seed 3", "--amplitudes phases"}) {
    const std::string name = flag.substr(0, flag.find(' '));
    expect_refused("wind a.bts " + flag, good,
                   name + ": given with the field a.bts, wanted none: it says how");
  }
  for (const std::string flag : {"--turbulence-intensity 0.2", "--wind-speed 5", "--spectrum von-karman",
                                 "--covariance-uw -0.1", "--terrain open", "--sigma-ratio-v 1"}) {
    const std::string name = flag.substr(0, flag.find(' '));
    expect_refused("wind a.bts -o b.bts " + flag, good,
                   name + ": given with -o, which writes the field a.bts");
  }
  expect_refused("wind a.bts --plot r.svg --profile cubic", good, "--profile: 'cubic', wanted log, power");

  const auto expect_no_field = [&](const std::string& arguments, const std::string& part) {
    expect_refused("wind -o b.bts " + arguments, good, part);
  };
  for (const std::string points : {"0x5", "5", "5x", "x5", "5x5x5", "5.5x5", "99999999999x1"})
    expect_no_field("--points " + points, "--points: '" + points + "', wanted points across x up");
  expect_no_field("--size -1x3", "--size: '-1x3', wanted metres across x up");
  expect_no_field("--size nanx3", "--size: 'nanx3', wanted");
  expect_no_field("--size 0x3", "--size: 0, wanted above 0 m");
  expect_no_field("--size 1e300x3", "--size: 1e+300, wanted above 0 m");
  expect_no_field("--center-height 3", "--center-height 3 of 20 m: lowest row at -7 m");
  expect_no_field("--center-height nan", "--center-height: 'nan', wanted a number");
  expect_no_field("--steps 0", "--steps: 0, wanted 1 or more");
  expect_no_field("--step 0", "--step: 0, wanted above 0 s");
  expect_no_field("--step inf", "--step: 'inf', wanted a number");
  expect_no_field("--period 20.05", "--period 20.05 at 0.1 s a step: 200.5 steps, wanted a whole number");
  expect_no_field("--period 20 --step 0.1 --steps 300", "--period: given with --steps and --step");
  expect_no_field("--points 5000x5000 --steps 1000000", "400000 GB of memory, wanted at most the ");
  expect_no_field("--spectrum rose", "--spectrum rose: there is no such model or file");
  expect_no_field("--spectrum a.bts", "a.bts");
  expect_no_field("--coherence rose", "coherence: rose, wanted shinya-fournier");
  expect_no_field("--coherence iec --decay-y 1,2,3", "--decay-y: given with --coherence iec");
  expect_no_field("--decay-y 1,2", "--decay-y");
  expect_no_field("--decay-z 1,2,-3", "--decay-z: '-3'");
  expect_no_field("--terrain mars", "terrain: mars, wanted open, grass");
  expect_no_field("--profile power:x", "--profile: 'power:x', wanted");
  expect_no_field("--profile power:0.3 --power-exponent 0.2", "wanted one exponent");
  expect_no_field("--turbulence-intensity 0.2 --friction-velocity 1", "given with --friction-velocity");
  expect_no_field("--turbulence-intensity nan", "--turbulence-intensity: 'nan'");
  expect_no_field("--speed -1", "--wind-speed: '-1'");
  expect_no_field("--power-exponent 0.2",
                  "--power-exponent: given with --profile log, wanted --profile power");
  expect_no_field("--profile power --roughness-length 0.1", "--roughness-length: given with --profile power");
  expect_no_field("--profile constant --displacement 1", "--displacement: given with --profile constant");
  expect_no_field("--profile power --turbulence-intensity 0.1 --terrain open",
                  "--terrain: given with --profile");
  expect_no_field("--canopy-decay 1", "--canopy-decay: given without a canopy");
  expect_no_field("--sigma-ratio-v -1", "--sigma-ratio-v: '-1', wanted 0 or");
  expect_no_field("--turbulence-intensity-w nan", "--turbulence-intensity-w: 'nan', wanted 0 or");
  expect_no_field("--sigma-ratio-w 1 --turbulence-intensity-w 0.1", "wanted one of them");
  expect_no_field("--covariance-uw -9", "covariance of u and w: -9 m^2/s^2, wanted at most 0.");
  expect_no_field("--covariance-uw -0.1 --amplitudes phases",
                  "covariance of u and w: -0.1 m^2/s^2, wanted none");
  expect_no_field("--tower", "--tower: a lowest row at 0.5 m, 1 m between rows, wanted room");
  expect_no_field("--tower --tile --center-height 20", "tower: under a tile");
  expect_no_field("--match hub --center-height 30", "match at the hub: a reference height of 10");
  expect_no_field("--profile a.bts", "a.bts:1");
  expect_no_field("--seed -1", "--seed");
  expect_no_field("--amplitudes big", "--amplitudes");
  expect_no_field("--match all", "--match");
}

TEST(Wind, SaysInNumbersWhetherAFieldIsTheWindThatFlagsDescribe) {
  const test::TemporaryFolder folder;
  const std::string wind = "--model IEC-Kaimal --wind-speed 12 --reference-height 30 --profile Power:0.14 ";
  ASSERT_EQ(
      run(folder, "wind " + wind + "--points 11x11 --size 40x40 --center-height 30 --steps 2048 -o a.bts")
          .code,
      0);
  const Outcome good = run(folder, "wind a.bts " + wind),
                other = run(folder, "wind a.bts " + wind + "--turbulence-intensity 0.1");
  EXPECT_EQ(good.code, 0) << good.messages;
  EXPECT_EQ(good.messages, "");
  EXPECT_THAT(good.output, HasSubstr("\nhub        y 0 m, z 30 m: U 12.000 m/s, sigma "));
  EXPECT_THAT(good.output, HasSubstr("\nverdict    as wanted\n"));
  EXPECT_THAT(other.output, HasSubstr("\nverdict    the deviation of u is "));
  EXPECT_THAT(run(folder, "wind a.bts").output, HasSubstr("nothing said what it should be"));
  EXPECT_EQ(file_count(folder), 1U);
  // One of our own is judged where nothing else is made of it.
  EXPECT_THAT(run(folder, "wind --points 5x5 --steps 256").output, HasSubstr("\nverdict    "));
  EXPECT_EQ(run(folder, "wind --points 5x5 --steps 256 --report r.json").output, "");
  EXPECT_TRUE(json::parse(contents(folder / "r.json")).at("verdict").at("faults").is_array());
}

TEST(Wind, TakesOneValueAfterAnOutputSoThatAFieldBehindItIsRead) {
  const test::TemporaryFolder folder;
  write(folder / "one.bts", small_bts(8, 64));
  const std::string before = contents(folder / "one.bts");
  ASSERT_EQ(run(folder, "wind -o y.vti --separations 1,2 one.bts").code, 0);
  EXPECT_EQ(contents(folder / "one.bts"), before);
  EXPECT_THAT(contents(folder / "y.vti"), HasSubstr("WholeExtent=\"0 63 0 1 0 2\""));
}

TEST(Wind, HasTheDeviationsOfAllComponentsThatFlagsGive) {
  const test::TemporaryFolder folder;
  const auto deviations = [&](const std::string& flags) {
    const Outcome outcome =
        run(folder, "wind --points 2x2 --steps 2048 --report r.json --wind-speed 10 " + flags);
    EXPECT_EQ(outcome.code, 0) << outcome.messages;
    const json wind = json::parse(contents(folder / "r.json")).at("settings").at("wind").at("deviation_m_s");
    return std::array<double, 3>{wind.at("u"), wind.at("v"), wind.at("w")};
  };
  for (const std::string model : {"simiu-scanlan", "iec-kaimal", "von-karman"}) {
    const auto ratios = deviations("--spectrum " + model + " --sigma-ratio-v 0.75 --sigma-ratio-w 0.25");
    EXPECT_NEAR(ratios[0], 2, 1e-12);
    EXPECT_NEAR(ratios[1], 1.5, 1e-12);
    EXPECT_NEAR(ratios[2], 0.5, 1e-12);
    const auto own =
        deviations("--spectrum " + model + " --turbulence-intensity 0.1 --turbulence-intensity-w 0.08");
    EXPECT_NEAR(own[0], 1, 1e-12);
    EXPECT_NEAR(own[2], 0.8, 1e-12);
  }
}

TEST(Wind, MatchedAtTheHubHasTheIntensityThatWasAskedForInTheFile) {
  const test::TemporaryFolder folder;
  ASSERT_EQ(
      run(folder,
          "wind --points 5x5 --steps 512 --center-height 10 --turbulence-intensity 0.15 --match HUB -o a.bts")
          .code,
      0);
  const json info = json::parse(run(folder, "info a.bts --format json").output);
  const double expected[] = {1, std::sqrt(1.5 * 15 / 9.5 / 6)};
  for (const int c : {0, 1}) {
    const double deviation = info.at("deviation_m_s").at(c == 0 ? "u" : "v").at(2).at(2);
    EXPECT_NEAR(deviation / (0.15 * 6 * expected[c]), 1, 1e-4);
  }
}

TEST(Wind, WithATowerStandsItOnTheMiddleOfTheLowestRow) {
  const test::TemporaryFolder folder;
  ASSERT_EQ(run(folder, "wind --points 5x4 --size 8x9 --center-height 12 --steps 64 --tower -o a.bts").code,
            0);
  const json info = json::parse(run(folder, "info a.bts --format json").output);
  EXPECT_EQ(info.at("z_m").at(0), 7.5);
  EXPECT_EQ(info.at("tower").at("z_m"), (json{7.5, 4.5, 1.5}));
  for (const char* component : {"u", "v", "w"}) {
    for (const char* number : {"mean_m_s", "deviation_m_s"}) {
      const double foot = info.at("tower").at(number).at(component).at(0),
                   middle = info.at(number).at(component).at(0).at(2);
      EXPECT_NEAR(foot, middle, 1e-9);
    }
  }
  const double lowest = info.at("tower").at("mean_m_s").at("u").at(2);
  EXPECT_NEAR(lowest, 6 * std::log(1.5 / 0.03) / std::log(10 / 0.03), 1e-3);
}

TEST(Wind, TakesAProfileThatVeersFromAFile) {
  const test::TemporaryFolder folder;
  write(folder / "mast.csv", "height_m,speed_m_s,direction_deg\n2,4,250\n10,8,260\n50,12,280\n");
  const Outcome outcome =
      run(folder,
          "wind --profile mast.csv --points 3x3 --size 2x8 --center-height 6 --steps 2048 --report r.json");
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  EXPECT_EQ(outcome.messages, "tremula: wrote r.json\n");
  const json report = json::parse(contents(folder / "r.json"));
  EXPECT_EQ(report.at("settings").at("wind").at("wind_speed_m_s"), 8) << "at 10 m";
  EXPECT_EQ(report.at("settings").at("wind").at("profile"), "table");
  // A compass direction grows clockwise, so the wind at the foot blows further to the left, to +y.
  const json& foot = report.at("rows").at(0).at("mean_m_s");
  const double angle = 10 * 3.14159265358979 / 180;
  EXPECT_NEAR(foot.at("u"), 4 * std::cos(angle), 1e-5);
  EXPECT_NEAR(foot.at("v"), 4 * std::sin(angle), 1e-5);
  EXPECT_NEAR(report.at("rows").at(0).at("target_mean_m_s").at("v"), 4 * std::sin(angle), 1e-9);
  ASSERT_EQ(
      run(folder, "wind --profile mast.csv --wind-speed 4 --points 1x1 --steps 2048 --report r.json").code,
      0);
  EXPECT_NEAR(json::parse(contents(folder / "r.json")).at("rows").at(0).at("mean_m_s").at("u"), 4, 1e-5);
  EXPECT_THAT(run(folder, "wind --profile mast.csv --points 2x2 --steps 2048 --report r.json").messages,
              HasSubstr("warning: the grid reaches from 0.5 to 1.5 m, the profile from 2 to 50 m"));
  for (const std::string flag : {"--terrain open", "--roughness-length 0.1", "--displacement 1",
                                 "--canopy-height 1", "--canopy-decay 1"}) {
    const Outcome refused = run(folder, "wind --profile mast.csv --report s.json " + flag);
    EXPECT_EQ(refused.code, 2);
    EXPECT_THAT(refused.messages,
                HasSubstr(flag.substr(0, flag.find(' ')) + ": given with --profile mast.csv"));
  }
}

TEST(Wind, WarnsOfAFieldWithoutWindOrWithoutGusts) {
  const test::TemporaryFolder folder;
  EXPECT_THAT(run(folder, "wind --points 2x2 --steps 1 -o a.bts").messages,
              HasSubstr("warning: a field of one step"));
  EXPECT_THAT(run(folder, "wind --points 2x2 --steps 64 --wind-speed 0 -o a.bts").messages,
              HasSubstr("warning: a wind speed of 0"));
}

TEST(Wind, DrawsItsVectorsAndSpectraFromTheFieldThatItMakesOrReads) {
  const test::TemporaryFolder folder;
  const std::string grid = "wind --points 9x1 --size 8x0 --center-height 5 --period 6.4 ";
  Outcome outcome = run(folder, grid + "-o a.bts --vectors a.svg --spectra s.svg --time 1.5");
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  EXPECT_THAT(contents(folder / "a.svg"), HasSubstr("Wind 5 m above the ground, t = 1.50 s"));
  EXPECT_THAT(contents(folder / "s.svg"), HasSubstr("Power spectra 5 m above the ground"));
  // The same picture from the file, but for its rounding of velocities: a picture of the same size.
  outcome = run(folder, "wind a.bts --vectors b.png --without-mean");
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  EXPECT_THAT(contents(folder / "b.png"), StartsWith("\x89PNG"));
  outcome = run(folder, grid + "--vectors -");
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  EXPECT_THAT(outcome.output, StartsWith("<?xml"));
}

TEST(Wind, RefusesVectorsThatItCannotDrawAndLeavesNoFile) {
  const test::TemporaryFolder folder;
  write(folder / "a.bts", small_bts());  // does not repeat; 2 s of 6 m/s
  const std::size_t before = file_count(folder);
  for (const auto& [flags, message] : std::vector<std::pair<std::string, std::string>>{
           {"--vectors a.jpg", "--vectors"},
           {"--time 3", "--time"},
           {"--points 1x3 --vectors a.svg", "2 or more, for a picture from above"},
           {"--speed 0 --points 3x1 --vectors a.svg", "a mean wind above 0"},
           {"--vectors a.svg --time nan", "--time"},
           {"--vectors a.svg --vectors-height -1", "--vectors-height"},
           {"--vectors a.gif --time 1", "--time"},
           {"a.bts --vectors a.svg --time 1.9", "in a field that does not repeat"}}) {
    const Outcome outcome = run(folder, "wind " + flags);
    EXPECT_EQ(outcome.code, 2) << flags;
    EXPECT_THAT(outcome.messages, HasSubstr(message)) << flags;
    EXPECT_EQ(file_count(folder), before) << flags;
  }
}

TEST(Animate, TakesTheWindOfTheSameFlagsAndNames) {
  const test::TemporaryFolder folder;
  write(folder / "mast.csv", "height_m,speed_m_s,heading_deg\n0,0,30\n2,3,20\n10,8,0\n");
  const auto settings = [&](const std::string& flags) {
    const Outcome outcome =
        run(folder, "animate stam-17 --period 4 --fps 8 --modes 4 --report r.json " + flags);
    EXPECT_EQ(outcome.code, 0) << outcome.messages;
    return json::parse(contents(folder / "r.json")).at("settings").at("wind_settings");
  };
  const json own = settings("--profile mast.csv --sigma-ratio-v 0.5 --covariance-uw -0.2 --model Von-Karman");
  EXPECT_EQ(own.at("spectrum"), "von-karman");
  EXPECT_EQ(own.at("wind_speed_m_s"), 8);
  EXPECT_EQ(own.at("covariance_uw_m2_s2"), -0.2);
  EXPECT_NEAR(own.at("deviation_m_s").at("v"), 0.5 * 0.2 * 8, 1e-12);
  EXPECT_EQ(own.at("profile_table").size(), 3U);
  EXPECT_EQ(settings("--speed 4 --model iec-kaimal"), settings("--wind-speed 4 --spectrum IEC-KAIMAL"));
}

}  // namespace
}  // namespace tremula
