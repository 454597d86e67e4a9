// Several winds in one .glb, as a user asks for them.
#include "cli/program.hpp"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tremula/io/html.hpp"

namespace tremula {
namespace {

using test::contents;
using test::Outcome;
using test::run;
using testing::ElementsAre;
using testing::HasSubstr;

nlohmann::json document_of(const std::string& path) {
  const std::string bytes = contents(path);
  std::uint32_t size = 0;
  std::memcpy(&size, bytes.data() + 12, 4);
  return nlohmann::json::parse(bytes.substr(20, size));
}

std::vector<std::string> names_of(const nlohmann::json& document) {
  std::vector<std::string> names;
  for (const auto& animation : document["animations"]) names.push_back(animation["name"]);
  return names;
}

TEST(Clips, ShareOneSkeletonAndPeriodInOneFile) {
  const test::TemporaryFolder folder;
  const Outcome outcome = run(folder,
                              "animate sapling --clip calm:2 --clip a:b:6 --clip gale:16 --period 4 -o s.glb "
                              "--report r.json");
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  const nlohmann::json document = document_of(folder / "s.glb");
  EXPECT_THAT(names_of(document), ElementsAre("calm", "a:b", "gale"));
  ASSERT_EQ(document["skins"].size(), 1U);
  const nlohmann::json& joints = document["skins"][0]["joints"];
  for (const auto& animation : document["animations"]) {
    for (const auto& channel : animation["channels"])
      EXPECT_NE(std::find(joints.begin(), joints.end(), channel["target"]["node"]), joints.end());
    double last = 0;
    int most_keys = 0;
    for (const auto& sampler : animation["samplers"]) {
      const auto& times = document["accessors"][sampler["input"].get<std::size_t>()];
      last = std::max(last, times["max"][0].get<double>());
      most_keys = std::max(most_keys, times["count"].get<int>());
    }
    EXPECT_EQ(last, 4);
    EXPECT_GT(most_keys, 10) << animation["name"];  // the calm one is no still, either
  }
  const auto report = nlohmann::json::parse(contents(folder / "r.json"));
  EXPECT_EQ(report["glb"]["clips"], 3);
  EXPECT_EQ(report["glb"]["form"], "skin");
  EXPECT_EQ(report["clips"], nlohmann::json({"calm:2", "a:b:6", "gale:16"}));
  EXPECT_EQ(report["settings"]["wind_settings"]["wind_speed_m_s"], 2);
}

TEST(Clips, OfTheMeanStandStill) {
  const test::TemporaryFolder folder;
  ASSERT_EQ(run(folder, "animate sapling --clip calm:2 --clip gale:16 --mean-only --period 4 -o s.glb").code,
            0);
  const nlohmann::json document = document_of(folder / "s.glb");
  EXPECT_THAT(names_of(document), ElementsAre("calm", "gale"));
  for (const auto& animation : document["animations"]) {
    for (const auto& sampler : animation["samplers"])
      EXPECT_EQ(document["accessors"][sampler["input"].get<std::size_t>()]["count"], 2);
  }
}

TEST(Clips, GoIntoThePageToo) {
  if (!can_write_html()) GTEST_SKIP() << "built without node and npm";
  const test::TemporaryFolder folder;
  const Outcome outcome = run(folder, "animate sapling --clip calm:2 --clip gale:16 --period 4 -o s.html");
  EXPECT_EQ(outcome.code, 0) << outcome.messages;
  EXPECT_GT(std::filesystem::file_size(folder / "s.html"), 500'000U);
}

TEST(Clips, ThatCannotBeAreRefusedInOneLine) {
  const test::TemporaryFolder folder;
  for (const auto& [flags, says] : std::vector<std::pair<std::string, std::string>>{
           {"--clip calm -o s.glb", "--clip: 'calm', wanted a name and a wind speed"},
           {"--clip :2 -o s.glb", "--clip: ':2', wanted a name and a wind speed"},
           {"--clip calm:x -o s.glb", "--clip: 'calm:x', wanted a wind speed from 0 to 100 m/s"},
           {"--clip calm:-1 -o s.glb", "--clip: 'calm:-1', wanted a wind speed from 0 to 100 m/s"},
           {"--clip calm:nan -o s.glb", "--clip: 'calm:nan', wanted a wind speed from 0 to 100 m/s"},
           {"--clip calm:2 --clip calm:3 -o s.glb", "--clip: 'calm:3', wanted a name that no other clip has"},
           {"--clip calm:2 --wind-speed 3 -o s.glb", "--wind-speed: given with --clip"},
           {"--clip calm:2 --form morph -o s.glb", "--clip: given with --form morph"},
           {"--clip calm:2 --morphs paired -o s.glb", "--morphs: given with --clip"},
           {"--clip calm:2 --pose linear -o s.glb", "--clip: given where displacements superpose"},
           {"--clip calm:2 -o s.glb -o s.csv", "s.csv: given with --clip"},
           {"--clip calm:2 --report r.json", "--clip: given without a .glb or a page"},
           {"--mean-only -o s.glb", "--mean-only: given without --clip"}}) {
    const Outcome outcome = run(folder, "animate sapling --period 1 " + flags);
    EXPECT_EQ(outcome.code, 2) << flags;
    EXPECT_THAT(outcome.messages, HasSubstr(says)) << flags;
    EXPECT_EQ(std::count(outcome.messages.begin(), outcome.messages.end(), '\n'), 1) << flags;
    EXPECT_FALSE(std::filesystem::exists(folder / "s.glb")) << flags;
  }
}

}  // namespace
}  // namespace tremula
