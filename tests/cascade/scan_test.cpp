#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "support.hpp"
#include "tremula/io/skeleton_files.hpp"
#include "tremula/modes/solve_modes.hpp"

namespace tremula {
namespace {

TEST(Scan, OfOneTreeThroughTwoImportersHasTheFrequencyOfTheIndependentModel) {
  TREMULA_NEED_DATA("validation.json");
  const auto json = nlohmann::json::parse(std::ifstream(test::data_folder() / "validation.json"));
  nlohmann::json item;
  for (const auto& candidate : json["items"]) {
    if (candidate["id"] == "tree.rtwig.same_tree_two_formats") item = candidate;
  }
  const Material wood{"validation.json", 10e9, 10e9 / 2.6, 800, ""};
  double frequency[2];
  for (std::size_t i = 0; i < 2; ++i) {
    const std::string file = item["files"][i];
    const Skeleton skeleton = read_skeleton((test::data_folder() / file).string()).skeleton;
    frequency[i] =
        solve_modes(assemble(skeleton, {.material = wood, .gravity = 0}), {.count = 1}).frequency[0];
    // The two models have no weight, and hang the branches of a scan on each other in different ways.
    EXPECT_NEAR(frequency[i] / item["f1_hz"][i].get<double>(), 1, 0.03) << file;
  }
  EXPECT_LT(std::abs(frequency[0] / frequency[1] - 1), 0.16);
}

}  // namespace
}  // namespace tremula
