#include <algorithm>
#include <filesystem>
#include <string>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli/program.hpp"
#include "pictures.hpp"
#include "tremula/raytrace/raytrace.hpp"

namespace tremula {
namespace {

using test::contents;
using test::Outcome;
using testing::HasSubstr;

class Volumes : public testing::Test {
 protected:
  void SetUp() override {
    if (!can_trace()) GTEST_SKIP() << "built without Embree";
  }

  // A picture of a field of 12 m x 12 m, looked down upon.
  Outcome draw(const std::string& volume, const std::string& flags = "-o a.png") const {
    test::write(folder / "s.toml",
                "[wind]\nwind_speed = 7\n[motion]\nperiod = 2\nfps = 5\n[ground]\nkind = \"soil\"\n"
                "[camera]\neye = [0, -14, 6]\nlook_at = [0, 0, 0]\n"
                "[[volumes]]\nlow = [-6, -6]\nhigh = [6, 6]\n" +
                    volume);
    return run(folder, "render s.toml --size 64x36 --samples 4 --no-denoise " + flags);
  }

  test::TemporaryFolder folder;
};

TEST_F(Volumes, AreGreenWhereTheyGrowAndMoveInTheWind) {
  ASSERT_EQ(draw("texel_size = 0.04\n", "-o %04d.png --frames 0,3").code, 0);
  const auto field = test::read_picture(folder / "0000.png").mean(28, 16, 8, 4);
  EXPECT_GT(field[1], field[2] + 20);
  EXPECT_NE(contents(folder / "0000.png"), contents(folder / "0003.png"));
}

TEST_F(Volumes, AreTheSameOnAnyNumberOfThreads) {
  ASSERT_EQ(draw("texel_size = 0.05\n", "--threads 1 -o a.png").code, 0);
  ASSERT_EQ(draw("texel_size = 0.05\n", "--threads 3 -o b.png").code, 0);
  EXPECT_EQ(contents(folder / "a.png"), contents(folder / "b.png"));
}

TEST_F(Volumes, ThatCannotBeAreRefusedWithTheirPlaceInOneLine) {
  for (const auto& [volume, complaint] :
       {std::pair<std::string, std::string>{"texel_size = 0.0001\n", "texel_size"},
        {"inside = [[[20, 20], [30, 20], [30, 30]]]\n", "nothing of the field is left"},
        {"species = \"rise\"\n", "rice"}}) {
    const Outcome outcome = draw(volume);
    EXPECT_EQ(outcome.code, 2) << volume;
    EXPECT_THAT(outcome.messages, HasSubstr(complaint));
    EXPECT_THAT(outcome.messages, HasSubstr("s.toml:1"));
    EXPECT_EQ(std::count(outcome.messages.begin(), outcome.messages.end(), '\n'), 1) << outcome.messages;
    EXPECT_FALSE(std::filesystem::exists(folder / "a.png"));
  }
}

}  // namespace
}  // namespace tremula
