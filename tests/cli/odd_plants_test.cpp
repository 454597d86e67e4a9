// Plants that nobody drew, from the command line.
#include "cli/program.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace tremula {
namespace {

using test::contents;
using test::run;
using testing::HasSubstr;

TEST(OddPlants, GiveFiniteModesAllOfThemAndMotionOrOneLineThatSaysWhyNot) {
  const std::string plants = (test::data_folder() / "../tools/odd_plants.py").string();
  if (!std::filesystem::exists(plants)) GTEST_SKIP() << "no " << plants;
  const test::TemporaryFolder folder;
  const std::string command =
      "python3 '" + plants + "' '" TREMULA_PROGRAM "' > '" + (folder / "found") + "' 2>&1";
  EXPECT_EQ(std::system(command.c_str()), 0) << contents(folder / "found");
}

TEST(OddPlants, AListOfModesThatEndsInAClusterSaysSo) {
  const test::TemporaryFolder folder;
  std::ofstream clump(folder / "clump.swc");
  for (int k = 0; k < 20; ++k)
    clump << 2 * k + 1 << " 1 " << k << " 0 0 0.01 -1\n"
          << 2 * k + 2 << " 2 " << k << " 0 1 0.01 " << 2 * k + 1 << "\n";
  clump.close();
  // Twenty round culms bend in two directions each.
  EXPECT_THAT(
      run(folder, "modes clump.swc --count 12").output,
      HasSubstr("the list ends within a cluster of 40 equal modes; 28 more lie at the same frequency\n"));
  EXPECT_THAT(
      run(folder, "modes clump.swc --count 39").output,
      HasSubstr("the list ends within a cluster of 40 equal modes; 1 more lies at the same frequency\n"));
  EXPECT_THAT(run(folder, "modes clump.swc --count 40").output, testing::Not(HasSubstr("cluster")));
  EXPECT_THAT(run(folder, "modes clump.swc --count 12 --format json").output,
              testing::AllOf(HasSubstr("\"equal_to_last\": 40"), HasSubstr("\"equal_left_out\": 28")));
}

TEST(OddPlants, ModesThatDoNotFitTheMemoryAreRefusedWithTheNumber) {
  const test::TemporaryFolder folder;
  const test::Outcome outcome = run(folder, "modes oak --count -1 --max-memory 500MB");
  EXPECT_EQ(outcome.code, 2);
  EXPECT_THAT(outcome.messages,
              testing::AllOf(HasSubstr("tremula: error: "), HasSubstr(" modes of "),
                             HasSubstr("wanted at least "), HasSubstr(" MB, or fewer modes")));
}

}  // namespace
}  // namespace tremula
