#include "tremula/scene/scene_keys.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <sstream>
#include <string>

#include "scene/vocabulary.hpp"
#include "support.hpp"

namespace tremula {
namespace {

using testing::HasSubstr;

// The lines of one table of the reference: key, value, unit, default.
std::vector<std::vector<std::string>> rows_below(const std::string& header) {
  std::istringstream text(scene_reference());
  std::vector<std::vector<std::string>> rows;
  bool here = false;
  for (std::string line; std::getline(text, line);) {
    if (line.starts_with("### ")) here = line == "### `" + header + "`";
    if (!here || !line.starts_with("| `")) continue;
    std::vector<std::string> cells;
    std::istringstream all(line.substr(2));
    for (std::string cell; std::getline(all, cell, '|');) {
      const std::size_t first = cell.find_first_not_of(' '), last = cell.find_last_not_of(' ');
      cells.push_back(first == std::string::npos ? "" : cell.substr(first, last - first + 1));
    }
    rows.push_back(cells);
  }
  return rows;
}

TEST(SceneReference, StandsInTheGuide) {
  std::ifstream file(test::source_folder() / "docs/guide/scenes.md");
  const std::string guide((std::istreambuf_iterator<char>(file)), {});
  EXPECT_THAT(guide, HasSubstr(scene_reference())) << "tremula check --keys prints it";
}

TEST(SceneReference, SaysDefaultsThatTheReaderTakesForWhatTheyAre) {
  const Scene otherwise = test::parsed("[[objects]]\nsource = 'oak'\n");
  for (const std::string header : {"[ground]", "[sky]", "[medium]", "[picture]"}) {
    const auto rows = rows_below(header);
    ASSERT_GE(rows.size(), 2U) << header;
    for (const auto& row : rows) {
      const std::string key = row[0].substr(1, row[0].size() - 2), value = row[3];
      if (key == "uniform" || key == "visibility" || key == "color")
        continue;  // none, or beside another only
      const Scene said =
          test::parsed(header + "\n" + key + " = " + value + "\n[[objects]]\nsource = 'oak'\n");
      EXPECT_EQ(said.ground.kind, otherwise.ground.kind);
      EXPECT_EQ(said.ground.height, otherwise.ground.height);
      EXPECT_NEAR(said.sky.sun_elevation, otherwise.sky.sun_elevation, 1e-12);
      EXPECT_EQ(said.sky.turbidity, otherwise.sky.turbidity);
      EXPECT_EQ(said.medium.kind, otherwise.medium.kind);
      EXPECT_EQ(said.picture.size, otherwise.picture.size);
      EXPECT_EQ(said.picture.samples, otherwise.picture.samples);
      EXPECT_EQ(said.picture.bounces, otherwise.picture.bounces);
      EXPECT_EQ(said.picture.shutter, otherwise.picture.shutter);
      EXPECT_EQ(said.picture.exposure, otherwise.picture.exposure);
      EXPECT_EQ(said.picture.denoise, otherwise.picture.denoise);
      EXPECT_EQ(said.picture.seed, otherwise.picture.seed);
    }
  }
}

TEST(SceneReference, HasTheSettingsOfWhoeverKnowsThem) {
  const std::string text = scene_reference(test::vocabulary().settings);
  EXPECT_THAT(text, HasSubstr("| `wind_speed` | a number | Mean wind speed [m/s] |"));
  EXPECT_THAT(text, HasSubstr("| `no_shelter` | true or false | No shelter |"));
}

}  // namespace
}  // namespace tremula
