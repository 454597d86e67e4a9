// tremula load and the gauges of tremula animate, as a user runs them.
#include "cli/program.hpp"

#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

namespace tremula {
namespace {

using test::contents;
using test::Outcome;
using test::run;
using testing::HasSubstr;
using testing::StartsWith;

const std::string steady = " --profile constant --turbulence-intensity 0.2 --period 10";

TEST(Load, AsJsonHasWhatScriptsRelyOn) {
  const test::TemporaryFolder folder;
  const Outcome outcome = run(folder, "load sapling --wind-speed 5:20:5 --format json" + steady);
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  const auto json = nlohmann::json::parse(outcome.output);
  ASSERT_EQ(json["rows"].size(), 4U);
  double drag = 0, moment = 0, lean = 0;
  for (const auto& row : json["rows"]) {
    EXPECT_GT(row["mean_drag_n"].get<double>(), drag);
    EXPECT_GT(row["mean_base_moment_n_m"].get<double>(), moment);
    EXPECT_GT(row["lean_m"].get<double>(), lean);
    EXPECT_GT(row["rms_base_moment_n_m"].get<double>(), 0);
    EXPECT_GT(row["peak_base_moment_n_m"].get<double>(), row["mean_base_moment_n_m"].get<double>());
    EXPECT_GT(row["drag_exponent"].get<double>(), 1.1);
    EXPECT_LT(row["drag_exponent"].get<double>(), 2);
    drag = row["mean_drag_n"], moment = row["mean_base_moment_n_m"], lean = row["lean_m"];
  }
  EXPECT_EQ(json["rows"][3]["wind_speed_m_s"], 20);
}

TEST(Load, WithQuadraticDragLeansToTheSideOfTheGusts) {
  const test::TemporaryFolder folder;
  const std::string command =
      "load sapling --wind-speed 8 --profile constant --turbulence-intensity 0.3 "
      "--period 300 --format json";
  const auto linear = nlohmann::json::parse(run(folder, command).output),
             quadratic = nlohmann::json::parse(run(folder, command + " --drag quadratic").output);
  EXPECT_EQ(quadratic["settings"]["drag"], "quadratic");
  const auto of = [](const nlohmann::json& json, const char* what) {
    return json["rows"][0][what].get<double>();
  };
  EXPECT_NEAR(of(quadratic, "mean_base_moment_n_m") / of(linear, "mean_base_moment_n_m"), 1, 0.05);
  EXPECT_NEAR(of(quadratic, "rms_base_moment_n_m") / of(linear, "rms_base_moment_n_m"), 1, 0.1);
  EXPECT_GT(of(quadratic, "skewness_of_base_moment"), of(linear, "skewness_of_base_moment") + 0.2);
}

TEST(Load, WithQuadraticDragOfLoadsAsPrintedIsRefused) {
  const test::TemporaryFolder folder;
  const Outcome outcome = run(folder, "load sapling --loads paper --drag quadratic");
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.messages, HasSubstr("--drag"));
  EXPECT_EQ(std::count(outcome.messages.begin(), outcome.messages.end(), '\n'), 1);
}

TEST(Load, NamesTheBranchThatBearsMost) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "waist.swc")
      << "1 1 0 0 0 0.1 -1\n2 1 0 0 1 0.1 1\n3 1 0 0 1.2 0.03 2\n4 1 0 0 4 0.03 3\n";
  const auto json = nlohmann::json::parse(
      run(folder, "load waist.swc --wind-speed 12 --format json --shape loaded" + steady).output);
  const auto& row = json["rows"][0];
  EXPECT_GT(row["most_stressed_branch"], 0);
  EXPECT_GT(row["peak_stress_of_that_branch_pa"].get<double>(), 2 * row["peak_stress_pa"].get<double>());
}

TEST(Report, ListsTheBranchesThatBearMost) {
  const test::TemporaryFolder folder;
  ASSERT_EQ(run(folder, "animate sapling --material oak --wind-speed 15 --period 4 --report r.json").code, 0);
  const auto list = nlohmann::json::parse(contents(folder / "r.json"))["most_stressed_branches"];
  ASSERT_EQ(list.size(), 10U);
  for (const auto& branch : list) {
    EXPECT_GT(branch["stress_pa"]["expected_peak_of_600_s"].get<double>(), 0);
    EXPECT_GT(branch["share_of_modulus_of_rupture"].get<double>(), 0);
  }
  EXPECT_GE(list[0]["stress_pa"]["expected_peak_of_600_s"].get<double>(),
            0.9 * list[9]["stress_pa"]["expected_peak_of_600_s"].get<double>());
}

// A stiff bare stem in a wind that is the same at all heights: q L, q L^2/2.
TEST(Load, OfAStiffStemIsTheDragOfACylinderAndHalfItsLengthTimesThat) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "stem.swc") << "1 1 0 0 0 0.1 -1\n2 1 0 0 4 0.1 1\n";
  const auto json = nlohmann::json::parse(
      run(folder,
          "load stem.swc --wind-speed 8,16 --profile constant --turbulence-intensity 0.0001 --period 5 "
          "--format json")
          .output);
  const double drag = 0.5 * 1.2 * 1.2 * 0.2 * 4 * 64;
  EXPECT_NEAR(json["rows"][0]["mean_drag_n"].get<double>(), drag, 1e-4 * drag);
  EXPECT_NEAR(json["rows"][0]["mean_base_moment_n_m"].get<double>(), 2 * drag, 0.02 * drag);
  EXPECT_NEAR(json["rows"][1]["drag_exponent"].get<double>(), 2, 1e-3);
}

TEST(Load, TellsTheWindThatBreaksTheStemAndThatTurnsTheRoot) {
  const test::TemporaryFolder folder;
  const std::string command = "load sapling --wind-speed 5,10,15 --format json" + steady;
  const auto plain = nlohmann::json::parse(run(folder, command).output);
  const double stress = plain["rows"][1]["peak_stress_pa"], moment = plain["rows"][1]["peak_base_moment_n_m"];
  std::ostringstream limits;
  limits.precision(17);
  limits << " --modulus-of-rupture " << stress << " --root-moment-capacity " << moment;
  const auto json = nlohmann::json::parse(run(folder, command + limits.str()).output);
  EXPECT_NEAR(json["breaks_at_m_s"].get<double>(), 10, 1e-6);
  EXPECT_NEAR(json["root_turns_at_m_s"].get<double>(), 10, 1e-6);
  EXPECT_TRUE(plain["root_turns_at_m_s"].is_null());
}

TEST(Load, AsTableAndCsvHasARowASpeed) {
  const test::TemporaryFolder folder;
  const std::string command = "load stam-17 --wind-speed 4,6" + steady;
  const std::string table = run(folder, command).output;
  EXPECT_THAT(table, HasSubstr("mean_drag_n"));
  EXPECT_THAT(table, HasSubstr("peaks are those of 600 s"));
  ASSERT_EQ(run(folder, command + " -o loads.csv").code, 0);
  const std::string csv = test::contents(folder / "loads.csv");
  EXPECT_THAT(csv, StartsWith("wind_speed_m_s,mean_drag_n,mean_base_moment_n_m,"));
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 3);
}

TEST(Load, RefusesInOneLineWhatIsNoListOfSpeeds) {
  const test::TemporaryFolder folder;
  for (const char* speeds :
       {"10,5", "5:1:1", "5:40", "5:40:0", "0", "-3", "5,,6", "a", "5:4000:1", "1:2:1e-9"}) {
    const Outcome outcome = run(folder, std::string("load sapling --wind-speed=") + speeds);
    EXPECT_EQ(outcome.code, 2) << speeds;
    EXPECT_THAT(outcome.messages, HasSubstr("--wind-speed")) << speeds;
    EXPECT_EQ(std::count(outcome.messages.begin(), outcome.messages.end(), '\n'), 1) << outcome.messages;
    EXPECT_EQ(outcome.output, "");
  }
  EXPECT_EQ(run(folder, "load sapling --root-moment-capacity -5").code, 2);
  EXPECT_EQ(run(folder, "load sapling --no-shelter --shelter-cell 1").code, 2);
}

TEST(Gauges, AreWrittenAsATableAndReported) {
  const test::TemporaryFolder folder;
  const Outcome outcome =
      run(folder,
          "animate sapling --gauge base --gauge stem:0.5 --period 2 --fps 10 -o gauges.csv "
          "--report report.json");
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  const std::string csv = test::contents(folder / "gauges.csv");
  EXPECT_THAT(csv, StartsWith("frame,time_s,gauge,bending_moment_n_m,"));
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 2 * 20);
  const auto gauges = nlohmann::json::parse(test::contents(folder / "report.json"))["gauges"];
  ASSERT_EQ(gauges.size(), 2U);
  EXPECT_EQ(gauges[1]["gauge"], "stem:0.5");
  EXPECT_GT(gauges[0]["along_n_m"]["mean"].get<double>(), gauges[1]["along_n_m"]["mean"].get<double>());
}

TEST(Gauges, ThatNothingWouldTellAreRefused) {
  const test::TemporaryFolder folder;
  const Outcome outcome = run(folder, "animate sapling --gauge base -o a.png");
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.messages, HasSubstr("--gauge"));
  EXPECT_EQ(test::file_count(folder), 0U);
}

TEST(Gauges, OffThePlantAreRefused) {
  const test::TemporaryFolder folder;
  for (const char* gauge : {"stem:1000", "stem:-1", "branch:99999:0.5", "branch:1:2", "crown", ""}) {
    const Outcome outcome = run(folder, std::string("animate sapling -o g.csv --gauge '") + gauge + "'");
    EXPECT_EQ(outcome.code, 2) << gauge;
    EXPECT_EQ(std::count(outcome.messages.begin(), outcome.messages.end(), '\n'), 1) << outcome.messages;
    EXPECT_EQ(test::file_count(folder), 0U) << gauge;
  }
}

TEST(Shape, UnloadedIsBentByItsWeightFirst) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "arm.swc") << "1 1 0 0 1 0.02 -1\n2 1 1 0 1 0.015 1\n3 1 2 0 1 0.01 2\n";
  const auto lowest = [&](const std::string& flags) {
    const Outcome outcome =
        run(folder, "animate arm.swc --wind-speed 0 --period 1 --fps 1 --format csv -o -" + flags);
    EXPECT_EQ(outcome.code, 0) << outcome.messages;
    std::istringstream rows(outcome.output);
    std::string row;
    double z = 1;
    for (std::getline(rows, row); std::getline(rows, row);) {
      std::istringstream cells(row);
      std::string cell;
      for (int i = 0; i < 6; ++i) std::getline(cells, cell, ',');
      z = std::min(z, std::stod(cell));
    }
    return z;
  };
  EXPECT_NEAR(lowest(""), 1, 1e-12);
  EXPECT_LT(lowest(" --shape unloaded"), 0.99);
  EXPECT_EQ(run(folder, "modes arm.swc --shape unloaded --gravity 0").code, 2);
}

}  // namespace
}  // namespace tremula
