// Painted trees, as a user asks for their page.
#include "cli/program.hpp"

#include <filesystem>
#include <string>

#include <gmock/gmock.h>

#include "tremula/io/html.hpp"

namespace tremula {
namespace {

using test::contents;
using test::Outcome;
using test::run;
using test::write;
using testing::HasSubstr;

struct PaintedTrees : testing::Test {
  test::TemporaryFolder folder;

  void write_scene(const std::string& more = "") const {
    write(folder / "s.toml",
          "[motion]\nperiod = 2\nfps = 5\n[[impressions]]\nshape = \"pine\"\nheight = 9\n" + more);
  }
  std::string complaint(const std::string& arguments) const {
    return test::refusal(folder, "animate s.toml " + arguments);
  }
};

TEST_F(PaintedTrees, AreAPageThatSaysHowManyThereAre) {
  if (!can_write_html()) GTEST_SKIP() << "built without node and npm";
  write_scene("[[impressions.grid]]\ncolumns = 3\nrows = 2\nspacing = [6, 6]\n");
  const Outcome outcome = run(folder, "animate s.toml -o a.html --report a.json");
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  EXPECT_THAT(outcome.messages, HasSubstr("6 painted trees"));
  EXPECT_THAT(contents(folder / "a.json"), HasSubstr("\"trees\": 6"));
  ASSERT_EQ(run(folder, "animate s.toml --object pine -o b.html").code, 0);
  EXPECT_EQ(contents(folder / "a.html"), contents(folder / "b.html"));
}

TEST_F(PaintedTrees, AreForPagesAndPicturesAlone) {
  write_scene();
  for (const char* extension : {"glb", "csv", "png"}) {
    EXPECT_THAT(complaint(std::string("-o a.html -o b.") + extension),
                HasSubstr(std::string("no ") + extension + " holds that, wanted .html, or tremula render"));
  }
  EXPECT_THAT(complaint("--modes 5 -o a.html"), HasSubstr("--modes: given with pine"));
  EXPECT_FALSE(std::filesystem::exists(folder / "a.html"));
}

TEST_F(PaintedTrees, StandStillInStillAir) {
  if (!can_write_html()) GTEST_SKIP() << "built without node and npm";
  write_scene("[wind]\nwind_speed = 0\n");
  const Outcome outcome = run(folder, "animate s.toml -o a.html --report a.json");
  EXPECT_EQ(outcome.code, 0) << outcome.messages;
  EXPECT_THAT(contents(folder / "a.json"), HasSubstr("\"period_s\": 2.0"));
}

TEST_F(PaintedTrees, MoreThanAPageHoldsAreRefusedWithTheirNumber) {
  if (!can_write_html()) GTEST_SKIP() << "built without node and npm";
  write_scene("[[impressions.grid]]\ncolumns = 100\nrows = 100\nspacing = [6, 6]\n");
  EXPECT_THAT(complaint("-o a.html"), HasSubstr("s.toml:4:1: impressionist trees of the page: 10000 of"));
  EXPECT_FALSE(std::filesystem::exists(folder / "a.html"));
}

}  // namespace
}  // namespace tremula
