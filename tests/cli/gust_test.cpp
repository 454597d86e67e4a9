// Winds that change and pulls, as a user asks for them.
#include "cli/program.hpp"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tremula/io/html.hpp"

namespace tremula {
namespace {

using test::contents;
using test::Outcome;
using test::run;
using test::write;
using testing::HasSubstr;

nlohmann::json report_in(const test::TemporaryFolder& folder) {
  return nlohmann::json::parse(contents(folder / "r.json"));
}

nlohmann::json document_of(const std::string& path) {
  const std::string bytes = contents(path);
  std::uint32_t size = 0;
  std::memcpy(&size, bytes.data() + 12, 4);
  return nlohmann::json::parse(bytes.substr(20, size));
}

TEST(PullFlag, SaysFrequencyAndDampingBesideThoseOfTheMode) {
  const test::TemporaryFolder folder;
  const Outcome outcome =
      run(folder, "animate sapling --pull 1.3m:10N --period 12 -o p.csv --frames 0 --report r.json");
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  EXPECT_THAT(outcome.messages, HasSubstr("by logarithmic decrement"));
  const nlohmann::json pull = report_in(folder)["pull"];
  const nlohmann::json &found = pull["by_logarithmic_decrement"], &mode = pull["modal"];
  EXPECT_NEAR(found["frequency_hz"], mode["frequency_hz"], 0.01 * double(mode["frequency_hz"]));
  EXPECT_NEAR(found["damping_ratio"], mode["damping_ratio"], 0.05 * double(mode["damping_ratio"]));
  EXPECT_NEAR(mode["damping_ratio"], 0.05, 1e-9);  // in still air the wood's alone
  EXPECT_GT(found["cycles"], 5);
  EXPECT_EQ(report_in(folder)["settings"]["repeats"], false);
}

TEST(GustFlag, MakesAClipInEveryFormOfOutput) {
  const test::TemporaryFolder folder;
  write(folder / "squall.csv", "time_s,speed_m_s,heading_deg\n0,2,0\n1,9,30\n2,4,10\n");
  std::string outputs = "-o g.glb -o g.csv -o g.png --report r.json";
  if (can_write_html()) outputs += " -o g.html";
  const Outcome outcome = run(folder, "animate sapling --gust squall.csv " + outputs);
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  const nlohmann::json document = document_of(folder / "g.glb"), report = report_in(folder);
  EXPECT_EQ(document["animations"][0]["name"], "clip");
  EXPECT_EQ(document["scenes"][0]["extras"]["tremula"]["repeats"], false);
  EXPECT_EQ(document["scenes"][0]["extras"]["tremula"]["period_s"], 2);
  EXPECT_EQ(report["settings"]["period_s"], 2);
  EXPECT_EQ(report["settings"]["gust"]["rows"].size(), 3U);
  EXPECT_EQ(report["settings"]["wind_settings"]["turbulence_intensity"], 0);
  const std::string table = contents(folder / "g.csv");
  EXPECT_THAT(table, HasSubstr("\n59,"));
  EXPECT_THAT(table, testing::Not(HasSubstr("\n60,")));
}

TEST(GustFlag, FromRestTheFirstFrameIsTheRest) {
  const test::TemporaryFolder folder;
  const Outcome outcome =
      run(folder,
          "animate sapling --gust 1-cosine:8:1 --from-rest --period 2 -o g.csv --frames 0 --report r.json");
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  ASSERT_EQ(
      run(folder, "animate sapling --wind-speed 0 --turbulence-intensity 0 --period 1 -o rest.csv --frames 0")
          .code,
      0);
  EXPECT_EQ(contents(folder / "g.csv"), contents(folder / "rest.csv"));
  EXPECT_NEAR(report_in(folder)["settings"]["gust"]["one_minus_cosine"]["amplitude_m_s"], 8, 0);
}

TEST(GustFlag, RefusesInOneLineWhatItHasNoUseFor) {
  const test::TemporaryFolder folder;
  write(folder / "late.csv", "time_s,speed_m_s\n0,2\n3,4\n2,5\n");
  write(folder / "good.csv", "time_s,speed_m_s\n0,2\n3,4\n");
  const auto refuses = [&](const std::string& flags, const std::string& message) {
    const Outcome outcome = run(folder, "animate sapling " + flags + " -o x.glb");
    EXPECT_EQ(outcome.code, 2) << flags;
    EXPECT_THAT(outcome.messages, HasSubstr(message)) << flags;
    EXPECT_EQ(std::count(outcome.messages.begin(), outcome.messages.end(), '\n'), 1) << outcome.messages;
    EXPECT_FALSE(std::filesystem::exists(folder / "x.glb")) << flags;
  };
  refuses("--gust late.csv", "late.csv:4: time is 2, wanted more than the 3 s of the row before");
  refuses("--gust none.csv", "--gust: 'none.csv', wanted 1-cosine:AMPLITUDE:DURATION[:START] or a table");
  for (const std::string gust :
       {"1-cosine:8", "1-cosine:8:", "1-cosine:8:2:", "1-cosine:a:2", "1-cosine:8:2:1:4"})
    refuses("--gust " + gust, "--gust: '" + gust + "', wanted an amplitude");
  refuses("--gust 1-cosine:8:0", "duration of the gust: 0 s, wanted above 0 s");
  refuses("--gust good.csv --wind-speed 4", "--wind-speed: given with --gust");
  refuses("--gust good.csv --seed 4", "--seed: given with --gust without turbulence");
  refuses("--gust good.csv --pull 1.3m:10N", "--gust: given with --pull");
  refuses("--gust good.csv --dynamics modal", "--dynamics: given with --gust");
  refuses("--gust good.csv --transfer sampled", "--transfer: given with --gust");
  refuses("--gust good.csv --wind stam", "--wind: given with --gust");
  refuses("--gust good.csv --loads paper", "--loads: given with --gust");
  refuses("--gust good.csv --clip calm:2", "--clip: given with --gust");
  refuses("--gust good.csv --drag linear", "--drag: given with --gust");
  refuses("--from-rest --dynamics oscillators", "--dynamics: given with --from-rest");
  refuses("--pull 1.3m:10", "pull: '1.3m:10', wanted PLACE:FORCE");
  refuses("--pull 9m:10N", "wanted a height above 0 m");
  refuses("--pull 1.3m:10N --turbulence-intensity 0.2", "--turbulence-intensity: given with --pull");
  refuses("--pull 1.3m:10N --from-rest", "--from-rest: given with --pull");
  refuses("--pull-heading 30", "--pull-heading: given without --pull");
  EXPECT_EQ(run(folder, "animate flag --pull 1m:1N -o x.glb").code, 2);
  EXPECT_EQ(run(folder, "animate banner --gust good.csv -o x.glb").code, 2);
  EXPECT_EQ(run(folder, "animate sapling --gust good.csv -o x.csv --frames 90").code, 2);
}

}  // namespace
}  // namespace tremula
