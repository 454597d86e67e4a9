// What drifts, as a user asks for it.
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

struct Drifting : testing::Test {
  test::TemporaryFolder folder;

  void write_scene(const std::string& more = "", const std::string& motion = "") const {
    write(folder / "s.toml", "[motion]\nperiod = 2\nfps = 5\n" + motion +
                                 "[[drift]]\nkind = \"snow\"\nlow = [0, 0, 0]\nhigh = [2, 2, 2]\n" + more);
  }
  std::string complaint(const std::string& arguments) const {
    return test::refusal(folder, "animate s.toml " + arguments);
  }
};

TEST_F(Drifting, IsAPageThatSaysHowManyAreSeen) {
  if (!can_write_html()) GTEST_SKIP() << "built without node and npm";
  write_scene();
  const Outcome outcome = run(folder, "animate s.toml -o a.html --report a.json");
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  EXPECT_THAT(outcome.messages, HasSubstr(" seen at a time"));
  EXPECT_THAT(contents(folder / "a.json"), HasSubstr("\"share\": 1.0"));
  ASSERT_EQ(run(folder, "animate s.toml --object snow -o b.html").code, 0);
  EXPECT_EQ(contents(folder / "a.html"), contents(folder / "b.html"));
}

TEST_F(Drifting, IsForPagesAndPicturesAlone) {
  write_scene();
  for (const char* extension : {"glb", "csv", "png"}) {
    EXPECT_THAT(complaint(std::string("-o a.html -o b.") + extension),
                HasSubstr(std::string("no ") + extension + " holds that, wanted .html, or tremula render"));
  }
  EXPECT_THAT(complaint("--modes 5 -o a.html"), HasSubstr("--modes: given with snow"));
  EXPECT_FALSE(std::filesystem::exists(folder / "a.html"));
}

TEST_F(Drifting, SaysThePlaceInTheFileOfWhatIsWrong) {
  write_scene("density = 3\nintensity = 2\n");
  EXPECT_THAT(complaint("-o a.html"), HasSubstr("s.toml:4:1: density and intensity of snow: both"));
  write_scene();
  EXPECT_THAT(complaint("--gust 1-cosine:3:1 -o a.html"), HasSubstr("--gust: given with snow"));
  EXPECT_FALSE(std::filesystem::exists(folder / "a.html"));
}

TEST_F(Drifting, IsAmongWhatCouldBeMeantByANameThatNothingHas) {
  write_scene("[[grass]]\nlow = [0, 0]\nhigh = [1, 1]\n");
  EXPECT_THAT(complaint("--object snwo -o a.html"),
              HasSubstr("one of what is in the scene: meadow, snow; did you mean snow?"));
  EXPECT_THAT(complaint("-o a.html"),
              HasSubstr("--object: not given, wanted one of what is in the scene: meadow, snow"));
}

TEST_F(Drifting, DoesNotPlayAClipWithAnEnd) {
  write_scene("[[objects]]\nsource = \"sapling\"\n", "pull = \"1m:10N\"\n");
  EXPECT_THAT(complaint("--object snow -o a.html"), HasSubstr("a clip, wanted a loop"));
  EXPECT_FALSE(std::filesystem::exists(folder / "a.html"));
}

}  // namespace
}  // namespace tremula
