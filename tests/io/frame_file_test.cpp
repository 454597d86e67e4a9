#include "tremula/io/frame_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "complaint.hpp"
#include "support.hpp"
#include "tremula/io/sheet_file.hpp"
#include "tremula/modes/solve_modes.hpp"
#include "tremula/structure/frame_presets.hpp"
#include "tremula/structure/structure.hpp"

namespace tremula {
namespace {

using testing::HasSubstr;

const std::string arch = R"(name = "arch"
material = "oak"
pieces = 3
clamped = ["left", "right"]
[points]
left = [0, 0, 0]
right = [2, 0, 0]
top = [1, 0, 1.5]
[[beams]]
through = ["left", "top", "right"]
radius = [0.04, 0.02]
[[beams]]
through = ["left", "right"]
radius = 0.01
material = "birch"
pieces = 1
[[masses]]
at = "top"
mass = 2
)";

std::string complaint_about(const std::string& text) {
  return test::complaint_of([&] { parse_frame(text, "frame.toml"); });
}

// The arch with one piece of its text changed.
std::string changed(const std::string& from, const std::string& to) {
  std::string text = arch;
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(FrameFile, IsBeamsInPiecesBetweenPoints) {
  const FrameFile file = parse_frame(arch, "frame.toml");
  EXPECT_EQ(file.name, "arch");
  const Frame& frame = file.frame;
  ASSERT_EQ(frame.elements.size(), 7U);
  EXPECT_EQ(frame.nodes.size(), 3U + 4U);
  double length = 0;
  for (const FrameElement& element : frame.elements) {
    length += (frame.nodes[static_cast<std::size_t>(element.end_node)] -
               frame.nodes[static_cast<std::size_t>(element.start_node)])
                  .norm();
  }
  EXPECT_NEAR(length, 2 * std::hypot(1, 1.5) + 2, 1e-12);
  EXPECT_EQ(frame.elements.front().start_radius, 0.04);
  EXPECT_NEAR(frame.elements[3].start_radius, 0.03, 1e-15) << "half way, at the top";
  EXPECT_NEAR(frame.elements[5].end_radius, 0.02, 1e-15);
  EXPECT_EQ(frame.elements[5].material.name, "oak");
  EXPECT_EQ(frame.elements[6].material.name, "birch");
  EXPECT_EQ(frame.clamped.size(), 2U);
  ASSERT_EQ(frame.masses.size(), 1U);
  EXPECT_EQ(frame.nodes[static_cast<std::size_t>(frame.masses[0].node)], Vec3(1, 0, 1.5));
}

TEST(FrameFile, OfKeysInKeysWithoutEndIsRefused) {
  std::string deep;
  for (int i = 0; i < 200'000; ++i) deep += "a.";
  EXPECT_THAT(complaint_about(deep + "a = 1\n"), HasSubstr("frame.toml:1:512: a key: more than 256 levels"));
  EXPECT_FALSE(is_sheet_file("[" + deep + "a]\n"));
  // What only looks like it: texts and comments.
  EXPECT_THAT(complaint_about("# " + deep + "\nname = \"" + deep + "\"\n"), HasSubstr("no points"));
}

TEST(FrameFile, OfACantileverHasTheFrequencyOfTheClosedForm) {
  const FrameFile file = parse_frame(
      "clamped = ['foot']\nmaterial = 'oak'\npieces = 12\n[points]\nfoot = [0, 0, 0]\ntip = [0, 0, 3]\n"
      "[[beams]]\nthrough = ['foot', 'tip']\nradius = 0.02\n",
      "rod.toml");
  const Material oak = find_material("oak");
  const double first = 1.8751040687, EI_over_m = oak.youngs_modulus * 0.02 * 0.02 / (4 * oak.density);
  const double wanted = first * first * std::sqrt(EI_over_m) / (9 * 2 * M_PI);
  const Modes modes = solve_modes(assemble(file.frame), {.count = 2});
  EXPECT_NEAR(modes.frequency[0] / wanted, 1, 1e-4);
}

const std::string sign = R"(name = "sign"
material = {youngs_modulus = 210e9, shear_modulus = 81e9, density = 7850}
clamped = ["foot"]
[points]
foot = [0, 0, 0]
low = [0, 0, 2]
top = [0, 0, 2.5]
[[beams]]
through = ["foot", "low", "top"]
radius = [0.03, 0.02]
wall = 0.002
[[panels]]
corner = [-0.04, -0.3, 1.9]
along_width = [0, 2, 0]
width = 0.6
height = 0.6
thickness = 0.002
youngs_modulus = 70e9
density = 2700
elements = [6, 6]
fixed = [[0.3, 0.1, "low"], [0.3, 0.5, "top"]]
)";

std::string changed_sign(const std::string& from, const std::string& to) {
  std::string text = sign;
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(FrameFile, HasTubesAndPanels) {
  const Frame frame = parse_frame(sign, "sign.toml").frame;
  EXPECT_EQ(frame.elements.front().material.shear_modulus, 81e9);
  // The wall is as thick all along: over the radius it is thicker where the beam is thinner.
  for (const FrameElement& element : frame.elements)
    EXPECT_NEAR(element.wall * (element.start_radius + element.end_radius) / 2, 0.002, 1e-15);
  EXPECT_EQ(outline_of(frame).branches[2].wall, frame.elements[2].wall);
  ASSERT_EQ(frame.panels.size(), 1U);
  const Panel& panel = frame.panels[0];
  EXPECT_EQ(panel.sheet.corner, Vec3(-0.04, -0.3, 1.9));
  EXPECT_EQ(panel.sheet.normal(), Vec3::UnitX());
  EXPECT_EQ(panel.sheet.poisson_ratio, 0.3);
  ASSERT_EQ(panel.fixed.size(), 2U);
  EXPECT_EQ(frame.nodes[static_cast<std::size_t>(panel.fixed[1].node)], Vec3(0, 0, 2.5));
  EXPECT_GT(solve_modes(assemble(frame), {.count = 1}).frequency[0], 1);
}

TEST(FrameFile, NamesWhatIsWrongWithTubesAndPanels) {
  EXPECT_THAT(complaint_about(changed_sign("wall = 0.002", "wall = 0.025")),
              HasSubstr("frame.toml:11:8: wall: 0.025 m, wanted a thickness above 0 m and up to the radius, "
                        "0.02 m"));
  EXPECT_THAT(complaint_about(changed_sign("wall = 0.002", "wall = 0")), HasSubstr("11:8: wall: 0, wanted"));
  EXPECT_THAT(complaint_about(changed_sign("0.5, \"top\"", "0.5, \"tip\"")),
              HasSubstr("frame.toml:21:40: fixed: no point 'tip'; did you mean top?"));
  EXPECT_THAT(complaint_about(changed_sign("[0.3, 0.5, \"top\"]", "[0.3, 0.7, \"top\"]")),
              HasSubstr("frame.toml:12:1: frame panel 0: fixing at 0.3, 0.7 m: off the panel"));
  EXPECT_THAT(complaint_about(changed_sign("[0.3, 0.5, \"top\"]", "[0.3, \"top\"]")),
              HasSubstr("fixed: a list of 2"));
  EXPECT_THAT(complaint_about(changed_sign("[[0.3, 0.1, \"low\"], [0.3, 0.5, \"top\"]]", "[]")),
              HasSubstr("fixed nowhere"));
  EXPECT_THAT(complaint_about(changed_sign("thickness = 0.002", "thickness = 0")),
              HasSubstr("17:13: thickness: 0, wanted a number above 0 [m]"));
  EXPECT_THAT(complaint_about(changed_sign("along_width = [0, 2, 0]", "along_width = [0, 0, 0]")),
              HasSubstr("along_width: no direction"));
  EXPECT_THAT(complaint_about(changed_sign("along_width = [0, 2, 0]", "along_width = [0, 2, 1]")),
              HasSubstr("two unit vectors at right angles"));
  EXPECT_THAT(complaint_about(changed_sign("corner = [-0.04, -0.3, 1.9]\n", "")),
              HasSubstr("panel: no corner"));
  EXPECT_THAT(complaint_about(changed_sign("density = 7850}", "density = 0}")), HasSubstr("density"));
  EXPECT_THAT(complaint_about(changed_sign("shear_modulus = 81e9, ", "")),
              HasSubstr("material: no shear_modulus"));
  EXPECT_THAT(complaint_about(changed_sign("width = 0.6\n", "width = 0.6\nclamp = [\"left\"]\n")),
              HasSubstr("a panel has no 'clamp'"));
}

TEST(FrameFile, NamesLineAndColumnOfWhatIsWrong) {
  EXPECT_THAT(complaint_about(changed("\"left\", \"top\", \"right\"", "\"left\", \"topp\"")),
              HasSubstr("frame.toml:10:20: through: no point 'topp'; did you mean top?"));
  EXPECT_THAT(complaint_about(changed("radius = 0.01", "radius = -0.01")),
              HasSubstr("frame.toml:14:10: radius: -0.01, wanted"));
  EXPECT_THAT(complaint_about(changed("radius = 0.01", "radius = 'thick'")), HasSubstr("'thick'"));
  EXPECT_THAT(complaint_about(changed("radius = 0.01", "radius = nan")), HasSubstr("radius"));
  EXPECT_THAT(complaint_about(changed("radius = 0.01", "radius = [1, 2, 3]")), HasSubstr("3 numbers"));
  EXPECT_THAT(complaint_about(changed("radius = 0.01", "raduis = 0.01")),
              HasSubstr("a beam has no 'raduis'; did you mean radius?"));
  EXPECT_THAT(complaint_about(changed("radius = 0.01\n", "")), HasSubstr("beam: no radius"));
  EXPECT_THAT(complaint_about(changed("right = [2, 0, 0]", "right = [2, 0]")), HasSubstr("2 numbers"));
  EXPECT_THAT(complaint_about(changed("right = [2, 0, 0]", "right = [2, 0, inf]")), HasSubstr("inf"));
  EXPECT_THAT(complaint_about(changed("\"birch\"", "\"brick\"")), HasSubstr("frame.toml:15:12: "));
  EXPECT_THAT(complaint_about(changed("pieces = 1", "pieces = 0")), HasSubstr("pieces: 0, wanted"));
  EXPECT_THAT(complaint_about(changed("pieces = 1", "pieces = 1.5")), HasSubstr("pieces: 1.5, wanted"));
  EXPECT_THAT(complaint_about(changed("mass = 2", "mass = -2")), HasSubstr("mass: -2, wanted"));
  EXPECT_THAT(complaint_about(changed("through = [\"left\", \"right\"]", "through = [\"left\"]")),
              HasSubstr("1 points, wanted two or more"));
  EXPECT_THAT(complaint_about(changed("[points]", "[points")), HasSubstr("frame.toml:5:"));
}

// Found by the fuzzer: beams of a hundredth of a micrometre under a mass of 0.4 kg.
TEST(FrameFile, WhoseModesCannotBeCountedIsRefused) {
  const FrameFile file = parse_frame(
      "clamped = ['a', 'b']\n[points]\na = [0, 0, 1]\nb = [1, 0, 0]\ntop = [0.5, 0.3, 1]\n"
      "[[beams]]\nthrough = ['a', 'top', 'b', 'a']\nradius = 1e-8\npieces = 2\n[[masses]]\nat = 'top'\nmass "
      "= 0.4\n",
      "frame.toml");
  EXPECT_THAT(test::complaint_of([&] { solve_modes(assemble(file.frame), {.count = 3}); }),
              testing::HasSubstr("cannot be counted, wanted parts and masses nearer to each other in size"));
}

TEST(FrameFile, OfThreadsWhoseStiffnessRoundingTakesIsRefused) {
  const FrameFile file = parse_frame(
      "clamped = ['a', 'b']\n[points]\na = [0, 0, 0]\nb = [1, 0, 0]\ntop = [1.5, 0.2, 1]\n"
      "[[beams]]\nthrough = ['a', 'top', 'b', 'a']\nradius = 2e-9\npieces = 1\n[[masses]]\nat = 'top'\nmass "
      "= 0.5\n",
      "frame.toml");
  EXPECT_THAT(test::complaint_of([&] { assemble(file.frame); }),
              testing::HasSubstr("rounding takes all of their stiffness"));
}

TEST(FrameFile, ComplainsInPrintableLettersWhateverStandsThere) {
  for (const char* text :
       {"name =na\a", "name = \"a\"\n\"b\\u0007\\n\" = 1\n", "\xff = 1", "a\x1b = [1,\n\n"}) {
    const std::string complaint = complaint_about(text);
    EXPECT_THAT(complaint, testing::StartsWith("frame.toml:"));
    for (const char c : complaint) EXPECT_TRUE(c >= ' ' && c <= '~') << complaint;
  }
}

TEST(FrameFile, RefusesWhatWouldFloatAwayOrHasNoLength) {
  EXPECT_THAT(complaint_about(changed("clamped = [\"left\", \"right\"]", "clamped = []")),
              HasSubstr("no node is clamped"));
  EXPECT_THAT(complaint_about(changed("top = [1, 0, 1.5]", "top = [1, 0, 1.5]\nlost = [5, 5, 5]")),
              HasSubstr("nothing connects it"));
  EXPECT_THAT(complaint_about(changed("top = [1, 0, 1.5]", "top = [2, 0, 0]")),
              HasSubstr("two points at one place"));
}

TEST(FrameFile, OfTheExamplesHaveModes) {
  const FrameFile file = read_frame((test::source_folder() / "examples/frames/pergola.toml").string());
  EXPECT_EQ(file.name, "pergola");
  EXPECT_GT(solve_modes(assemble(file.frame), {.count = 1}).frequency[0], 1);
}

TEST(FrameFile, OfTheExampleSignIsThePreset) {
  const FrameFile file = read_frame((test::source_folder() / "examples/frames/sign-on-post.toml").string());
  const Modes modes = solve_modes(assemble(file.frame), {.count = 6}),
              preset = solve_modes(assemble(frame_presets()[0].frame), {.count = 6});
  for (int r = 0; r < 6; ++r) EXPECT_NEAR(modes.frequency[r] / preset.frequency[r], 1, 1e-6) << r;
}

}  // namespace
}  // namespace tremula
