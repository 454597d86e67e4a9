#include "cli/program.hpp"
#include "io/xml.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <nlohmann/json.hpp>
#include <sstream>

namespace tremula {
namespace {

using test::contents;
using test::file_count;
using test::Outcome;
using test::run;
using testing::HasSubstr;
using testing::StartsWith;

void expect_refused(const std::string& arguments, const std::vector<std::string>& parts) {
  const test::TemporaryFolder folder;
  const Outcome outcome = run(folder, arguments);
  EXPECT_EQ(outcome.code, 2) << arguments << "\n" << outcome.messages;
  EXPECT_THAT(outcome.messages, StartsWith("tremula: error: ")) << arguments;
  EXPECT_EQ(std::count(outcome.messages.begin(), outcome.messages.end(), '\n'), 1) << outcome.messages;
  for (const std::string& part : parts) EXPECT_THAT(outcome.messages, HasSubstr(part)) << arguments;
  EXPECT_EQ(outcome.output, "") << arguments;
  EXPECT_EQ(file_count(folder), 0U) << arguments << " left a file";
}

TEST(Program, AnimateWritesEveryTenthFrameWhereThatIsAskedFor) {
  const test::TemporaryFolder folder;
  ASSERT_EQ(run(folder, "animate sapling --period 2 --fps 10 --frames 0-20:10 -o a.csv").code, 0);
  const std::string table = contents(folder / "a.csv");
  for (const char* row : {"\n0,", "\n10,", "\n20,"}) EXPECT_THAT(table, HasSubstr(row));
  for (const char* row : {"\n1,", "\n9,", "\n11,"}) EXPECT_THAT(table, testing::Not(HasSubstr(row)));
}

TEST(Program, HelpOfEveryCommandHasExamples) {
  const test::TemporaryFolder folder;
  for (const std::string command : {"", "animate", "modes", "grow", "wind", "info", "beam"}) {
    const Outcome outcome = run(folder, command + " --help");
    EXPECT_EQ(outcome.code, 0) << command;
    EXPECT_THAT(outcome.output, HasSubstr("Examples:\n  tremula ")) << command;
    EXPECT_EQ(outcome.messages, "") << command;
  }
}

TEST(Program, RefusesBadUsageInOneLine) {
  expect_refused("", {"no command", "animate"});
  expect_refused("dance", {"dance"});
  expect_refused("modes", {"INPUT"});
  expect_refused("modes no_such_tree.swc", {"no_such_tree.swc", "no such file or preset", "sapling"});
  expect_refused("modes sapling --count 0", {"mode count", "0", "1 to "});
  expect_refused("modes sapling --count 99999", {"mode count", "99999", "1 to "});
  expect_refused("modes sapling --material cheese", {"'cheese'", "walnut"});
  expect_refused("modes sapling --youngs-modulus -1", {"--youngs-modulus", "'-1'", "1 to 1e+15 Pa"});
  expect_refused("modes sapling --shear-modulus 0", {"--shear-modulus", "'0'", "Pa"});
  expect_refused("modes sapling --density nan", {"--density", "'nan'", "kg/m^3"});
  expect_refused("modes sapling --root-rotation-stiffness 0",
                 {"--root-rotation-stiffness", "'0'", "N m/rad"});
  expect_refused("modes sapling --root-translation-stiffness -3",
                 {"--root-translation-stiffness", "'-3'", "N/m"});
  expect_refused("animate sapling -o a.csv --root-rotation-stiffness nan",
                 {"--root-rotation-stiffness", "nan"});
  for (const std::string bad : {"-1", "1001", "nan"})
    expect_refused("modes sapling --gravity " + bad, {"--gravity", "'" + bad + "'", "0 to 1000 m/s^2"});
  expect_refused(
      "modes " + (test::source_folder() / "examples/frames/pergola.toml").string() + " --gravity 1",
      {"--gravity", "given with the frame"});
  expect_refused("modes sapling --youngs-modulus 1e6", {"branch ", "buckles", "gravity 0"});
  expect_refused("modes sapling --format xml", {"xml", "json"});
  expect_refused("modes sapling --plot modes.pdf", {"--plot modes.pdf", "'.pdf'", ".svg"});
  expect_refused("grow sapling", {"no output", ".swc"});
  expect_refused("grow sapling -o tree.obj", {"'.obj'", ".swc"});
  expect_refused("grow sapling -o tree.swc --set nonsense", {"nonsense", "NAME=NUMBER"});
  expect_refused("grow sapling -o tree.swc --set no_such_constant=3", {"no_such_constant"});
  expect_refused("animate sapling", {"no output", ".glb"});
  expect_refused("animate sapling -o tree.xyz", {"'.xyz'", ".glb"});
  expect_refused("animate sapling -o a.csv --wind-speed -3", {"--wind-speed", "'-3'", "to 100 m/s"});
  expect_refused("animate sapling -o a.csv --wind-speed nan", {"--wind-speed", "nan"});
  expect_refused("animate sapling -o a.csv --period 0", {"--period", "'0'", " s"});
  expect_refused("animate sapling -o a.csv --period nan", {"--period"});
  expect_refused("animate sapling -o a.csv --fps 1e6 --period 1000", {"--fps", "16777216"});
  expect_refused("animate sapling -o a.csv --frames 9-2", {"--frames", "9-2"});
  expect_refused("animate sapling -o a.csv --frames 601", {"--frames", "601", "0-600"});
  expect_refused("animate sapling -o a.csv --damping-ratio 0", {"--damping-ratio", "'0'"});
  expect_refused("animate sapling -o a.csv --modes 0", {"mode count", "0"});
  expect_refused("animate sapling -o a.csv --turbulence-intensity -1", {"--turbulence-intensity", "'-1'"});
  expect_refused("animate sapling -o a.csv --correlation-time 2", {"--correlation-time", "--wind stam"});
  expect_refused("animate sapling -o a.csv --wind gale", {"--wind", "'gale'", ".bts"});
  expect_refused("animate sapling -o a.csv --wind missing.bts", {"missing.bts"});
  expect_refused("animate sapling -o a.csv --stiffness-damping 0", {"--stiffness-damping", "'0'"});
  expect_refused("animate sapling -o a.csv --transfer exact", {"exact", "sampled"});
  expect_refused("modes sapling --max-memory 1kB", {"memory limit", "at least"});
  expect_refused("animate sapling -o a.csv --wind stam --correlation-length 0",
                 {"--correlation-length", "'0'"});
  expect_refused("animate sapling -o a.csv --roughness-length 20", {"roughness length", "20"});
}

TEST(Program, CannotWriteWhereThereIsNoFolder) {
  const test::TemporaryFolder folder;
  const Outcome outcome = run(folder, "animate sapling --period 1 -o nowhere/tree.glb");
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.messages, HasSubstr("nowhere/tree.glb"));
  EXPECT_EQ(file_count(folder), 0U);
}

TEST(Program, ModesAsJsonHasWhatScriptsRelyOn) {
  const test::TemporaryFolder folder;
  const Outcome outcome =
      run(folder,
          "modes stam-62 --count 12 --youngs-modulus 8e9 --shear-modulus 6e8 --density 900 --format json "
          "--section paper --no-rotatory-inertia --threads 1");
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  const auto json = nlohmann::json::parse(outcome.output);
  EXPECT_EQ(json["branches"], 62);
  EXPECT_EQ(json["dof"], 6 * 62);
  EXPECT_EQ(json["modes"].size(), 12U);
  EXPECT_EQ(json["count_found"], 12);
  double previous = 0;
  for (const auto& mode : json["modes"]) {
    EXPECT_GE(mode["frequency_hz"].get<double>(), previous);
    previous = mode["frequency_hz"];
    EXPECT_LT(mode["residual"].get<double>(), 1e-9);
    EXPECT_TRUE(mode["error_bound"].is_number());
  }
  EXPECT_TRUE(json["seconds"]["setup"].is_number());
  EXPECT_TRUE(json["seconds"]["solve"].is_number());
  EXPECT_TRUE(json["seconds"]["quality"].is_number());
  EXPECT_GT(json["peak_bytes"].get<double>(), 0);
}

TEST(Program, ModesAsJsonSayWhatEachModeIs) {
  const test::TemporaryFolder folder;
  const auto json = nlohmann::json::parse(run(folder, "modes stam-17 --count -1 --format json").output);
  const double total = json["total_mass_kg"];
  std::array<double, 3> sum{};
  for (const auto& mode : json["modes"]) {
    const auto& energy = mode["strain_energy"];
    EXPECT_NEAR(energy["trunk"].get<double>() + energy["branch"].get<double>() +
                    energy["torsion"].get<double>() + energy["axial"].get<double>(),
                1, 1e-12);
    const std::string kind = mode["kind"];
    EXPECT_EQ(kind == "torsion", energy["torsion"].get<double>() > 0.5);
    EXPECT_EQ(kind == "axial", energy["axial"].get<double>() > 0.5);
    for (std::size_t d = 0; d < 3; ++d) {
      const double gamma = mode["participation"][d], share = mode["effective_mass_share"][d];
      EXPECT_NEAR(mode["effective_mass_kg"][d].get<double>(), gamma * gamma, 1e-12 * total);
      EXPECT_NEAR(share, gamma * gamma / total, 1e-12);
      sum[d] += share;
    }
  }
  for (std::size_t d = 0; d < 3; ++d) {
    EXPECT_NEAR(json["effective_mass_share_of_all_listed"][d].get<double>(), sum[d], 1e-12);
    EXPECT_GT(sum[d], 0.5);
    EXPECT_LT(sum[d], 1);
  }
}

TEST(Program, AFieldFromAFileDrivesAPlant) {
  const test::TemporaryFolder folder;
  const Outcome made =
      run(folder, "wind --points 5x5 --size 6x6 --center-height 4 --steps 100 --step 0.1 -o f.bts");
  ASSERT_EQ(made.code, 0) << made.messages;
  const Outcome outcome = run(folder, "animate sapling --wind f.bts --period 10 --report r.json");
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  const auto json = nlohmann::json::parse(std::ifstream(folder / "r.json"));
  EXPECT_EQ(json["settings"]["wind_settings"]["points"], (nlohmann::json{5, 5}));
  EXPECT_GT(json["motion"]["rms_about_lean"]["largest_m"].get<double>(), 0);
  const Outcome longer = run(folder, "animate sapling --wind f.bts --period 20 --report s.json");
  EXPECT_EQ(longer.code, 2);
  EXPECT_THAT(longer.messages, testing::HasSubstr("at most the 10 s"));
}

// The poses of a frame, without its number and time.
std::vector<std::string> poses_of_frame(const std::string& table, const std::string& frame) {
  std::istringstream lines(table);
  std::vector<std::string> rows;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with(frame + ",")) rows.push_back(line.substr(line.find(',', frame.size() + 1)));
  }
  return rows;
}

TEST(Program, AWindWithoutGustsIsTheLeanAlone) {
  const test::TemporaryFolder folder;
  const Outcome field = run(folder,
                            "wind --points 5x5 --size 6x6 --center-height 4 --steps 100 --step 0.1 "
                            "--turbulence-intensity 0 -o still.bts");
  ASSERT_EQ(field.code, 0) << field.messages;
  for (const std::string flags :
       {"--turbulence-intensity 0", "--friction-velocity 0", "--wind stam --turbulence-intensity 0",
        "--wind stam --friction-velocity 0", "--wind-speed 0 --friction-velocity 0", "--wind still.bts"}) {
    const Outcome outcome =
        run(folder, "animate sapling --period 10 --fps 3 -o a.csv --report r.json " + flags);
    ASSERT_EQ(outcome.code, 0) << flags << "\n" << outcome.messages;
    const std::string table = contents(folder / "a.csv");
    EXPECT_THAT(table, testing::Not(HasSubstr("nan"))) << flags;
    const std::vector<std::string> first = poses_of_frame(table, "0");
    EXPECT_EQ(first.size(), 96U);
    EXPECT_EQ(first, poses_of_frame(table, "17")) << flags;
    const auto motion = nlohmann::json::parse(contents(folder / "r.json"))["motion"];
    EXPECT_LT(motion["rms_about_lean"]["largest_m"].get<double>(), 1e-9) << flags;
    EXPECT_EQ(motion["largest_lean_m"].get<double>() > 0.05, flags.find("speed 0") == std::string::npos);
  }
}

TEST(Program, NumbersBeyondAllMeasureAreRefusedOrStayNumbers) {
  expect_refused("animate sapling -o a.csv --period 1e-16 --fps 4e16", {"--period", "1e-16", "1e-06"});
  expect_refused("animate sapling -o a.csv --youngs-modulus 1e-25", {"--youngs-modulus", "1e-25", "Pa"});
  expect_refused("animate sapling -o a.csv --wind-speed 0 --friction-velocity 0.3", {"--friction-velocity"});
  const test::TemporaryFolder folder;
  const Outcome soft = run(
      folder, "animate sapling --youngs-modulus 1 --shear-modulus 1 --gravity 0 -o a.csv --report r.json");
  EXPECT_EQ(soft.code, 1) << soft.messages;
  EXPECT_THAT(soft.messages, HasSubstr("does not come to rest"));
  EXPECT_THAT(soft.messages, HasSubstr("stiffer wood"));
  EXPECT_EQ(file_count(folder), 0U);
  const Outcome superposed =
      run(folder,
          "animate sapling --youngs-modulus 1 --shear-modulus 1 --gravity 0 --pose linear "
          "-o a.csv --report r.json");
  ASSERT_EQ(superposed.code, 0) << superposed.messages;
  EXPECT_THAT(contents(folder / "a.csv"), testing::Not(HasSubstr("nan")));
  const auto motion = nlohmann::json::parse(contents(folder / "r.json"))["motion"];
  EXPECT_GT(motion["rms_about_lean"]["largest_m"].get<double>(), 0.1);
}

TEST(Program, AFieldAsWindGivesItsOwnSpeedAndHeadingToAllThatNameThem) {
  const test::TemporaryFolder folder;
  ASSERT_EQ(run(folder,
                "wind --speed 12 --reference-height 8 --points 5x5 --size 6x6 --center-height 4 --steps 100 "
                "--step 0.1 -o f.bts")
                .code,
            0);
  const Outcome outcome =
      run(folder, "animate sapling --wind f.bts --heading 30 --period 10 --fps 5 -o a.glb --report r.json");
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  // The JSON of a .glb: its length at byte 12, itself from byte 20 on.
  const std::string glb = contents(folder / "a.glb");
  std::uint32_t length = 0;
  std::memcpy(&length, glb.data() + 12, sizeof length);
  const auto facts = nlohmann::json::parse(glb.substr(20, length))["scenes"][0]["extras"]["tremula"];
  EXPECT_EQ(facts["wind_speed_m_s"], 12);
  EXPECT_EQ(facts["heading_deg"], 30);
  const auto json = nlohmann::json::parse(contents(folder / "r.json"));
  const auto& wind = json["settings"]["wind_settings"];
  EXPECT_NEAR(wind["wind_speed_m_s"].get<double>(), 12, 1e-6);
  EXPECT_NEAR(wind["reference_height_m"].get<double>(), 8, 1e-6);
  EXPECT_NEAR(wind["turbulence_intensity"].get<double>(), 0.2, 0.1);
}

TEST(Program, AModelBendsOnBonesUnlessTargetsAreAskedFor) {
  const test::TemporaryFolder folder;
  const auto glb_of = [&](const std::string& flags) {
    const Outcome outcome =
        run(folder, "animate sapling --period 4 --fps 15 -o a.glb --report r.json " + flags);
    EXPECT_EQ(outcome.code, 0) << outcome.messages;
    auto glb = nlohmann::json::parse(contents(folder / "r.json"))["glb"];
    EXPECT_EQ(glb["bytes"], contents(folder / "a.glb").size());
    EXPECT_EQ(glb["clips"], 1);
    glb["told"] = outcome.messages;
    return glb;
  };
  const auto gale = glb_of("--wind-speed 12"), breath = glb_of("--wind-speed 0.5"),
             by_hand = glb_of("--wind-speed 12 --form morph"), few = glb_of("--wind-speed 12 --max-joints 8");
  EXPECT_EQ(gale["form"], "skin");
  EXPECT_THAT(gale["told"].get<std::string>(),
              HasSubstr("wrote a.glb: " + std::to_string(gale["joints"].get<int>()) + " joints"));
  EXPECT_GT(gale["keys"], gale["joints"]);
  EXPECT_EQ(breath["form"], "skin");
  EXPECT_GT(breath["joints"], 1);  // and does not stand still
  EXPECT_LT(breath["largest_error_m"], 0.1 * gale["largest_error_m"].get<double>());
  EXPECT_EQ(by_hand["form"], "morph");
  EXPECT_EQ(by_hand["joints"], 0);
  EXPECT_GT(by_hand["largest_error_m"], gale["largest_error_m"]);
  EXPECT_THAT(by_hand["told"].get<std::string>(), HasSubstr("wrote a.glb: morph targets, "));
  EXPECT_LE(few["joints"], 8);
  EXPECT_GT(few["largest_error_m"], gale["largest_error_m"]);
  EXPECT_THAT(few["told"].get<std::string>(), HasSubstr("m off the poses, and --tolerance wants"));
}

TEST(Program, AStemOnASoftSpringSwaysSlower) {
  const test::TemporaryFolder folder;
  const auto modes = [&](const std::string& flags) {
    const Outcome outcome = run(folder, "modes stam-17 --count 3 --format json " + flags);
    EXPECT_EQ(outcome.code, 0) << outcome.messages;
    return nlohmann::json::parse(outcome.output);
  };
  const auto first = [](const nlohmann::json& json) {
    return json["modes"][0]["frequency_hz"].get<double>();
  };
  const auto clamped = modes(""), tilting = modes("--root-rotation-stiffness 2e2"),
             shifting = modes("--root-translation-stiffness 2e2"),
             held = modes("--root-rotation-stiffness inf --root-translation-stiffness inf");
  EXPECT_LT(first(tilting), 0.9 * first(clamped));
  EXPECT_LT(first(shifting), 0.9 * first(clamped));
  EXPECT_EQ(first(held), first(clamped));
  EXPECT_EQ(tilting["structure"]["root_rotation_stiffness_n_m_rad"], 2e2);
  EXPECT_EQ(tilting["structure"]["root_translation_stiffness_n_m"], nullptr);
  EXPECT_EQ(held["structure"], clamped["structure"]);
}

TEST(Program, APlantSwaysSlowerUnderItsWeightAndSaysHowOftenItCouldCarryIt) {
  const test::TemporaryFolder folder;
  const auto modes = [&](const std::string& flags) {
    return nlohmann::json::parse(run(folder, "modes stam-17 --count 3 --format json " + flags).output);
  };
  const auto light = modes("--gravity 0"), normal = modes(""), heavy = modes("--gravity 30");
  const auto first = [](const nlohmann::json& json) {
    return json["modes"][0]["frequency_hz"].get<double>();
  };
  EXPECT_LT(first(normal), first(light));
  EXPECT_LT(first(heavy), first(normal));
  EXPECT_EQ(light["structure"]["load_margin"], nullptr);
  EXPECT_EQ(normal["load_margin"], normal["structure"]["load_margin"]);
  const double margin = normal["structure"]["load_margin"];
  EXPECT_NEAR(margin * 9.81, heavy["structure"]["load_margin"].get<double>() * 30, 1e-6 * margin);
  char wanted[40];
  std::snprintf(wanted, sizeof wanted, "load margin %.4g\n", margin);
  EXPECT_THAT(run(folder, "modes stam-17 --count 3").output, HasSubstr(wanted));
  EXPECT_THAT(run(folder, "modes stam-17 --count 3 --gravity 0").output,
              testing::Not(HasSubstr("load margin")));
}

TEST(Program, ModesAsTableAndCsvSayTheSameAsJson) {
  const test::TemporaryFolder folder;
  const auto json = nlohmann::json::parse(run(folder, "modes stam-17 --count 3 --format json").output);
  std::istringstream csv(run(folder, "modes stam-17 --count 3 --format csv").output);
  std::istringstream table(run(folder, "modes stam-17 --count 3").output);
  std::string line, row;
  std::getline(csv, line);
  EXPECT_EQ(line,
            "mode,frequency_hz,residual,error_bound,kind,effective_mass_share_x,effective_mass_share_y,"
            "effective_mass_share_z");
  std::getline(table, row);
  EXPECT_THAT(row, StartsWith("stam-17: 17 branches, "));
  std::getline(table, row);
  EXPECT_THAT(row, HasSubstr("frequency_hz"));
  for (std::size_t r = 0; r < 3; ++r) {
    const auto& wanted = json["modes"][r];
    std::getline(csv, line);
    std::getline(table, row);
    int mode = 0, row_mode = 0;
    double frequency = 0, row_frequency = 0, share[3], percent[3];
    char kind[20], row_kind[20];
    ASSERT_EQ(std::sscanf(line.c_str(), "%d,%lf,%*f,%*f,%19[a-z],%lf,%lf,%lf", &mode, &frequency, kind,
                          &share[0], &share[1], &share[2]),
              6)
        << line;
    ASSERT_EQ(std::sscanf(row.c_str(), "%d %lf %*f %*f %*f %19s %lf %lf %lf", &row_mode, &row_frequency,
                          row_kind, &percent[0], &percent[1], &percent[2]),
              6)
        << row;
    EXPECT_EQ(mode, static_cast<int>(r) + 1);
    EXPECT_EQ(row_mode, mode);
    EXPECT_NEAR(frequency / wanted["frequency_hz"].get<double>(), 1, 1e-14);
    EXPECT_NEAR(row_frequency, frequency, 1e-6);
    EXPECT_EQ(kind, wanted["kind"].get<std::string>());
    EXPECT_EQ(row_kind, wanted["kind"].get<std::string>());
    for (std::size_t d = 0; d < 3; ++d) {
      EXPECT_NEAR(share[d], wanted["effective_mass_share"][d].get<double>(), 1e-6);
      EXPECT_NEAR(percent[d], 100 * share[d], 1e-3);
    }
  }
}

TEST(Program, ModesDrawAPlotBesidesTheTable) {
  const test::TemporaryFolder folder;
  const Outcome outcome = run(folder, "modes stam-62 --count 12 --plot modes.svg");
  EXPECT_EQ(outcome.code, 0);
  EXPECT_EQ(outcome.messages, "");
  EXPECT_EQ(outcome.output, run(folder, "modes stam-62 --count 12").output);
  const auto elements = test::read_xml(contents(folder / "modes.svg"));
  EXPECT_EQ(elements.front().name, "svg");
  EXPECT_EQ(std::count_if(elements.begin(), elements.end(), [](const auto& e) { return e.name == "g"; }), 10);
  EXPECT_EQ(run(folder, "modes stam-62 --count 12 --plot nowhere/modes.svg").code, 1);
}

TEST(Program, AnimateWritesEveryFormAndTheSameBytesOnAnyNumberOfThreads) {
  const test::TemporaryFolder folder;
  const std::string settings = "animate sapling --period 4 --fps 15 --modes 8 --seed 5 --frames 3-5 ";
  ASSERT_EQ(run(folder, settings + "-o one.glb -o one.csv -o one.png --threads 1").code, 0);
  ASSERT_EQ(run(folder, settings + "-o two.glb -o two.csv -o two.png --threads 2").code, 0);
  for (const std::string extension : {".glb", ".csv", ".png"}) {
    const std::string one = contents(folder / ("one" + extension)),
                      two = contents(folder / ("two" + extension));
    EXPECT_GT(one.size(), 1000U) << extension;
    EXPECT_TRUE(one == two) << extension << " differs between one and two threads";
  }
}

TEST(Program, AFrameAskedForAloneIsThatOfTheWhole) {
  const test::TemporaryFolder folder;
  ASSERT_EQ(run(folder, "animate stam-17 --period 4 --fps 15 -o all.csv").code, 0);
  ASSERT_EQ(run(folder, "animate stam-17 --period 4 --fps 15 --frames 17 -o one.csv").code, 0);
  const std::string all = contents(folder / "all.csv"), one = contents(folder / "one.csv");
  const std::string rows = one.substr(one.find('\n') + 1);
  EXPECT_EQ(std::count(rows.begin(), rows.end(), '\n'), 18);
  EXPECT_NE(all.find(rows), std::string::npos);
}

TEST(Program, ReportSaysWhatWasDone) {
  const test::TemporaryFolder folder;
  ASSERT_EQ(
      run(folder, "animate sapling --period 3 --wind-speed 5 --seed 9 --modes 6 --report r.json -o a.csv")
          .code,
      0);
  const auto json = nlohmann::json::parse(contents(folder / "r.json"));
  EXPECT_EQ(json["settings"]["seed"], 9);
  EXPECT_EQ(json["settings"]["wind_settings"]["wind_speed_m_s"], 5.0);
  EXPECT_EQ(json["settings"]["samples"], 90);
  EXPECT_EQ(json["frequencies_hz"].size(), 6U);
  const auto& sway = json["motion"];
  EXPECT_GT(sway["rms_about_loop_mean"]["largest_m"].get<double>(), 0);
  EXPECT_GT(sway["rms_about_lean"]["largest_m"], sway["rms_about_loop_mean"]["largest_m"]);
  EXPECT_EQ(sway["rms_about_lean"]["coordinates_m_sqrt_kg"].size(),
            6U + json["settings"]["static_shapes"].get<std::size_t>());
  EXPECT_GT(sway["largest_stretch"].get<double>(), 0);
  std::vector<std::string> stages;
  for (const auto& stage : json["stages"]) {
    stages.push_back(stage["stage"]);
    EXPECT_GE(stage["seconds"].get<double>(), 0);
    EXPECT_GT(stage["peak_bytes"].get<double>(), 0);
  }
  EXPECT_THAT(stages, testing::ElementsAre("read", "surface", "structure", "modes", "lean", "wind", "loads",
                                           "response", "write .csv"));
}

TEST(Program, GrownTreesAnimateTheSameFromTheirFileAsFromThePreset) {
  const test::TemporaryFolder folder;
  ASSERT_EQ(run(folder, "grow sapling -o sapling.swc").code, 0);
  const auto of_file = nlohmann::json::parse(run(folder, "modes sapling.swc --count 5 --format json").output);
  const auto of_preset = nlohmann::json::parse(run(folder, "modes sapling --count 5 --format json").output);
  EXPECT_EQ(of_file["branches"], of_preset["branches"]);
  for (std::size_t r = 0; r < 5; ++r) {
    EXPECT_NEAR(of_file["modes"][r]["frequency_hz"].get<double>() /
                    of_preset["modes"][r]["frequency_hz"].get<double>(),
                1, 1e-9);
  }
}

TEST(Program, InfoTellsTheSizeOfEveryStamTree) {
  const test::TemporaryFolder folder;
  for (const int count : {17, 55, 62, 212, 692, 2257}) {
    const Outcome outcome = run(folder, "info stam-" + std::to_string(count) + " --format json");
    EXPECT_EQ(nlohmann::json::parse(outcome.output)["branches"], count);
  }
}

TEST(Program, InfoTellsTheLoadMarginThatModesTells) {
  const test::TemporaryFolder folder;
  for (const std::string plant : {"sapling", "willow"}) {
    const auto info = nlohmann::json::parse(run(folder, "info " + plant + " --format json").output),
               modes =
                   nlohmann::json::parse(run(folder, "modes " + plant + " --modes 1 --format json").output);
    EXPECT_EQ(info["load_margin"], modes["load_margin"]) << plant;
  }
  std::ofstream(folder / "reed.swc") << "1 1 0 0 0 0.005 -1\n2 1 0 0 9 0.005 1\n";
  const Outcome reed = run(folder, "info reed.swc --format json");
  EXPECT_EQ(reed.code, 0);
  EXPECT_TRUE(nlohmann::json::parse(reed.output)["load_margin"].is_null());
  EXPECT_THAT(reed.messages, HasSubstr("buckles under the weight"));
}

TEST(Program, ScansAnimateWithStatedRepairs) {
  const std::string scan = (test::data_folder() / "qsm/itsme_tree2_treeqsm_v240_two_roots.mat").string();
  TREMULA_NEED_DATA("qsm/itsme_tree2_treeqsm_v240_two_roots.mat");
  const test::TemporaryFolder folder;
  const Outcome outcome =
      run(folder, "animate '" + scan + "' --period 2 --wind-speed 6 -o tree.glb --report r.json");
  EXPECT_EQ(outcome.code, 0);
  EXPECT_THAT(outcome.messages,
              HasSubstr("tremula: warning: 1 segment without parent joined to the nearest branch"));
  const auto json = nlohmann::json::parse(contents(folder / "r.json"));
  EXPECT_EQ(json["plant"]["branches"], 106);
  EXPECT_EQ(json["plant"]["roots"], 1);
}

TEST(Program, AMalformedFileLeavesNoOutput) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "bad.swc") << "1 1 0 0 0 0.1 -1\n2 1 0 0 1 -0.1 1\n";
  const Outcome outcome = run(folder, "animate bad.swc -o tree.glb -o tree.csv --report r.json");
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.messages,
              testing::AllOf(HasSubstr("bad.swc:2"), HasSubstr("-0.1"), HasSubstr("wanted")));
  EXPECT_EQ(file_count(folder), 1U);
}

}  // namespace
}  // namespace tremula
