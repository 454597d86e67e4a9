#include "tremula/io/sheet_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "complaint.hpp"
#include "support.hpp"

namespace tremula {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const std::string plate = R"(name = "plate"
[sheet]
width = 2
height = 1.5
thickness = 0.01
youngs_modulus = 70e9
poisson_ratio = 0.33
density = 2700
elements = [8, 6]
clamp = ["left", "top"]
pin = ["bottom"]
points = [[2, 0.5]]
tension = [40, 10]
cloth = true
corner = [1, 2, 3]
heading = 90
)";

std::string complaint_about(const std::string& text) {
  return test::complaint_of([&] { parse_sheet(text, "sheet.toml"); });
}

std::string changed(const std::string& from, const std::string& to) {
  std::string text = plate;
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(SheetFile, SaysAllOfASheet) {
  const SheetFile file = parse_sheet(plate, "sheet.toml");
  EXPECT_EQ(file.name, "plate");
  const Sheet& sheet = file.sheet;
  EXPECT_EQ(sheet.width, 2);
  EXPECT_EQ(sheet.height, 1.5);
  EXPECT_EQ(sheet.thickness, 0.01);
  EXPECT_EQ(sheet.youngs_modulus, 70e9);
  EXPECT_EQ(sheet.poisson_ratio, 0.33);
  EXPECT_EQ(sheet.density, 2700);
  EXPECT_THAT(sheet.elements, ElementsAre(8, 6));
  EXPECT_THAT(sheet.clamped, ElementsAre(SheetEdge::left, SheetEdge::top));
  EXPECT_THAT(sheet.pinned, ElementsAre(SheetEdge::bottom));
  ASSERT_EQ(sheet.pinned_points.size(), 1U);
  EXPECT_EQ(sheet.pinned_points[0], Eigen::Vector2d(2, 0.5));
  EXPECT_EQ(sheet.tension.x, 40);
  EXPECT_EQ(sheet.tension.y, 10);
  EXPECT_TRUE(sheet.wrinkles);
  EXPECT_EQ(sheet.corner, Vec3(1, 2, 3));
  EXPECT_LT((sheet.along_width - Vec3::UnitY()).norm(), 1e-15);
}

TEST(SheetFile, NeedsNoMoreThanSizesMaterialAndAHeldEdge) {
  const SheetFile file = parse_sheet(
      "[sheet]\nwidth = 1\nheight = 1\nthickness = 0.01\nyoungs_modulus = 1e9\ndensity = 1000\nclamp = "
      "[\"left\"]\n",
      "sheet.toml");
  EXPECT_EQ(file.name, "");
  EXPECT_EQ(file.sheet.poisson_ratio, 0.3);
  EXPECT_FALSE(file.sheet.wrinkles);
}

TEST(SheetFile, IsKnownByItsTable) {
  EXPECT_TRUE(is_sheet_file(plate));
  EXPECT_TRUE(is_sheet_file("sheet = 3"));
  EXPECT_FALSE(is_sheet_file("clamped = [\"foot\"]\n[points]\n"));
  EXPECT_FALSE(is_sheet_file("[sheet"));
}

TEST(SheetFile, OfTheExamplesCanBeRead) {
  const Sheet sheet = read_sheet((test::source_folder() / "examples/sheets/sign.toml").string()).sheet;
  EXPECT_THAT(sheet.clamped, ElementsAre(SheetEdge::bottom));
}

TEST(SheetFile, ErrorsNameLineAndColumnAndWhatIsWanted) {
  EXPECT_THAT(complaint_about(changed("thickness = 0.01", "thickness = 0")),
              testing::StartsWith("sheet.toml:5:13: thickness: 0, wanted a number above 0 [m]"));
  EXPECT_THAT(complaint_about(changed("thickness = 0.01\n", "")),
              HasSubstr("sheet.toml:2:1: sheet: no thickness"));
  EXPECT_THAT(complaint_about(changed("thickness", "thicknes")),
              testing::AllOf(HasSubstr("sheet.toml:5:"), HasSubstr("did you mean thickness?")));
  EXPECT_THAT(complaint_about(changed("name = ", "nam = ")), HasSubstr("did you mean name?"));
  EXPECT_THAT(complaint_about(changed("\"left\", \"top\"", "\"lift\"")),
              testing::AllOf(HasSubstr("sheet.toml:10:10: clamp: no edge 'lift'; did you mean left?"),
                             HasSubstr("left, right, bottom, top")));
  EXPECT_THAT(complaint_about(changed("[8, 6]", "[8, 0]")), HasSubstr("sheet.toml:9:16: elements: 0"));
  EXPECT_THAT(complaint_about(changed("[8, 6]", "[8]")), HasSubstr("elements: a list of 1"));
  EXPECT_THAT(complaint_about(changed("[8, 6]", "8")), HasSubstr("elements: 8"));
  EXPECT_THAT(complaint_about(changed("[8, 6]", "[8.5, 6]")), HasSubstr("elements: 8.5"));
  EXPECT_THAT(complaint_about(changed("width = 2", "width = \"2\"")), HasSubstr("width: '2'"));
  EXPECT_THAT(complaint_about(changed("width = 2", "width = nan")), HasSubstr("sheet.toml:3:9: width: nan"));
  EXPECT_THAT(complaint_about(changed("width = 2", "width = -2")), HasSubstr("width: -2"));
  EXPECT_THAT(complaint_about(changed("0.33", "0.6")), HasSubstr("poisson_ratio: 0.6"));
  EXPECT_THAT(complaint_about(changed("cloth = true", "cloth = 1")),
              HasSubstr("cloth: 1, wanted true or false"));
  EXPECT_THAT(complaint_about(changed("[[2, 0.5]]", "[[3, 0.5]]")), HasSubstr("sheet point: 3, 0.5 m"));
  EXPECT_THAT(complaint_about(changed("[40, 10]", "[40, inf]")), HasSubstr("tension: inf"));
  EXPECT_THAT(complaint_about(changed("[sheet]", "[sheet")), HasSubstr("sheet.toml:2:"));
  EXPECT_THAT(complaint_about("sheet = 3"), HasSubstr("sheet: 3, wanted a table"));
  EXPECT_THAT(complaint_about("name = \"x\""), HasSubstr("no sheet"));
}

TEST(SheetFile, RefusesASheetThatNothingHolds) {
  std::string text = changed("clamp = [\"left\", \"top\"]\n", "");
  const std::string held = "pin = [\"bottom\"]\npoints = [[2, 0.5]]\n";
  text.replace(text.find(held), held.size(), "");
  EXPECT_THAT(complaint_about(text),
              HasSubstr("sheet.toml:2:1: sheet: clamped nowhere, wanted clamp or pin"));
}

}  // namespace
}  // namespace tremula
