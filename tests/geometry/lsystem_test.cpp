#include "tremula/geometry/lsystem.hpp"

#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "complaint.hpp"

namespace tremula {
namespace {

using ::testing::HasSubstr;

std::string message_of(const std::string& text) {
  return test::complaint_of([&] { parse_lsystem(text, "plant.lsys"); });
}

TEST(ParseLSystem, ReadsEveryKindOfStatement) {
  const LSystem system = parse_lsystem(
      "# a plant\n"
      "width = 0.1   # comment\n"
      "half = width / 2\n"
      "axiom: !(width) A(3)\n"
      "steps: 4\n"
      "seed: 18446744073709551615\n"
      "radius: pipe\n"
      "tip_radius: half\n"
      "bark_color: 0.1, 0.2, 0.3\n"
      "A(n) : n > 0 -> 0.25 F(1) [ +(30) A(n - 1) ]\n"
      "   A(n - 1)\n"
      "\n"
      "# in between\n"
      "   F(2)\n"
      "A(n) : n > 0 -> (1 - 0.25) F(1)\n"
      "A(n) ->\n",
      "plant.lsys");
  ASSERT_EQ(system.constants.size(), 2U);
  EXPECT_EQ(system.constants[1].name, "half");
  EXPECT_EQ(system.seed, 18446744073709551615ULL);
  EXPECT_TRUE(system.pipe_radii);
  EXPECT_TRUE(system.tip_radius.has_value());
  EXPECT_TRUE(system.bark_color.has_value());
  EXPECT_FALSE(system.leaf_color.has_value());
  ASSERT_EQ(system.axiom.size(), 2U);
  EXPECT_EQ(system.axiom[0].command, TurtleCommand::radius);
  EXPECT_EQ(system.axiom[1].rule, 0);
  ASSERT_EQ(system.rules.size(), 1U);
  ASSERT_EQ(system.rules[0].alternatives.size(), 3U);
  const Production& first = system.rules[0].alternatives[0];
  EXPECT_EQ(first.line, 10);
  EXPECT_TRUE(first.condition.has_value());
  ASSERT_EQ(first.successor.size(), 7U);
  EXPECT_EQ(first.successor[6].line, 14);
  EXPECT_TRUE(system.rules[0].alternatives[2].successor.empty());
}

TEST(ParseLSystem, DoesNotMindLineEndingsTabsOrAByteOrderMark) {
  const LSystem system = parse_lsystem(
      "\xEF\xBB\xBF# plant\r\nsteps: 1\r\naxiom: !(0.1) A\r\nA ->\tF(1)\r\n\t+(3)\r\n", "plant.lsys");
  ASSERT_EQ(system.rules.size(), 1U);
  EXPECT_EQ(system.rules[0].alternatives[0].successor.size(), 2U);
}

TEST(ParseLSystem, TellsLettersApartByTheirNumberOfParameters) {
  const LSystem system = parse_lsystem(
      "steps: 1\naxiom: A A(1) A(1, 2)\nA -> F(1)\nA(n) -> F(n)\nA(n, m) -> F(m)\n", "plant.lsys");
  EXPECT_EQ(system.rules.size(), 3U);
  EXPECT_EQ(system.axiom[0].rule, 0);
  EXPECT_EQ(system.axiom[1].rule, 1);
  EXPECT_EQ(system.axiom[2].rule, 2);
}

TEST(ParseLSystem, LetsProductionsStandAboveTheConstantsAndSettingsTheyUse) {
  EXPECT_NO_THROW(parse_lsystem("A -> F(long)\naxiom: A\nsteps: many\nlong = 2\nmany = 3\n", "plant.lsys"));
}

struct BadFile {
  const char* text;
  const char* message;
};

TEST(ParseLSystem, RefusesMalformedFilesWithPlaceFoundAndWanted) {
  const std::string good = "steps: 1\naxiom: F(1, 1)\n";  // two lines, so that what follows stands in line 3
  ASSERT_EQ(message_of(good), "");
  const std::vector<BadFile> files = {
      {"A(n -> F(1)", "plant.lsys:3: found '-', wanted ',' or ')'"},
      {"A(1) -> F(1)", "plant.lsys:3: found '1', wanted the name of a parameter"},
      {"A(n, n) -> F(1)", "plant.lsys:3: two parameters named 'n', wanted different names"},
      {"A(n) : n > -> F(1)", "plant.lsys:3: found '-', wanted a number, a name or '('"},
      {"A(n) n > 1 -> F(1)", "plant.lsys:3: found 'n', wanted '->'"},
      {"A -> F(1) ]", "plant.lsys:3: ']' without '[', wanted brackets in pairs"},
      {"A -> [ F(1)\n  [ F(1) ]", "plant.lsys:3: '[' without ']', wanted brackets in pairs"},
      {"A -> G(1)",
       "plant.lsys:3: 'G' with 1 parameter, wanted a letter with a production, or one of F f L T"},
      {"A -> FF", "plant.lsys:3: 'FF' with 0 parameters, wanted a letter with a production"},
      {"A -> F",
       "plant.lsys:3: 'F' with 0 parameters, wanted F(length), F(length, end radius) or F(length, end "
       "radius, wall)"},
      {"A -> +", "plant.lsys:3: '+' with 0 parameters, wanted +(degrees)"},
      {"A -> L(1)", "plant.lsys:3: 'L' with 1 parameter, wanted L(length, width)"},
      {"A -> T(1, 2)", "plant.lsys:3: 'T' with 2 parameters, wanted T(strength)"},
      {"A -> F(1", "plant.lsys:3: found the end of the statement, wanted ',' or ')'"},
      {"A -> F(1 2)", "plant.lsys:3: found '2', wanted ',' or ')'"},
      {"A -> F()", "plant.lsys:3: found ')', wanted a number, a name or '('"},
      {"A -> F(m)", "plant.lsys:3: unknown name 'm'"},
      {"A -> F(1) @", "plant.lsys:3: found '@', wanted a letter such as F(1)"},
      {"A -> F(1)\n  B -> F(1)", "plant.lsys:4: a second '->' in one statement"},
      {"A -> (0.5 F(1)", "plant.lsys:3: found 'F', wanted ')'"},
      {"[ -> F(1)", "plant.lsys:3: a production for '[', wanted a letter that may be rewritten"},
      {"$ -> F(1)", "plant.lsys:3: a production for '$'"},
      {"-> F(1)", "plant.lsys:3: found '>', wanted '->'"},
      {"3 -> F(1)", "plant.lsys:3: found '3', wanted a letter to rewrite"},
      {"A F(1)", "plant.lsys:3: found 'A' at the beginning of a statement, wanted 'name = value'"},
      {"\x80", "plant.lsys:3: found the byte 0x80 at the beginning"},
      {"a =", "plant.lsys:3: found the end of the statement, wanted a number"},
      {"a = b", "plant.lsys:3: unknown name 'b', wanted a number: no constant is known here"},
      {"a = 1 2", "plant.lsys:3: found '2', wanted the end of the statement"},
      {"a = 1\na = 2", "plant.lsys:4: a second constant 'a', wanted one"},
      {"a = b\nb = 1", "plant.lsys:3: unknown name 'b'"},
      {"min = 1", "plant.lsys:3: a constant named like the function 'min', wanted another name"},
      {"a = 1\nA(a) -> F(1)", "plant.lsys:4: parameter 'a' has the name of a constant, wanted another name"},
      {"stpes: 3", "plant.lsys:3: unknown setting 'stpes', wanted one of axiom, steps"},
      {"steps: 2", "plant.lsys:3: a second 'steps', wanted one"},
      {"seed: -1", "plant.lsys:3: found '-', wanted a whole number from 0 to"},
      {"seed: 99999999999999999999", "wanted a whole number from 0 to"},
      {"seed: 1.5", "plant.lsys:3: found '.', wanted the end of the statement"},
      {"radius: pip", "plant.lsys:3: found 'pip', wanted 'pipe' or 'drawn'"},
      {"radius: pipe", "plant.lsys: no 'tip_radius'"},
      {"medium: mud", "plant.lsys:3: found 'mud', wanted 'air' or 'water'"},
      {"medium: water", "plant.lsys: no 'water_depth', wanted 'water_depth: 5'"},
      {"current: 0.3", "plant.lsys: no 'medium', wanted 'medium: water', where there is 'current'"},
      {"shape: bent", "plant.lsys:3: found 'bent', wanted 'loaded' or 'unloaded'"},
      {"material: 3", "plant.lsys:3: found '3', wanted the name of a material"},
      {"A -> ~(1, 2, 3)", "plant.lsys:3: '~' with 3 parameters, wanted ~(width) or ~(width, end width)"},
      {"bark_color: 1, 2", "plant.lsys:3: found the end of the statement, wanted ',': a colour is"},
      {"A(a,b,c,d,e,f,g,h,i,j,k,l,m,n,o,p,q) -> F(1)", "plant.lsys:3: more parameters than 16, wanted fewer"},
      {"A -> F(1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16,17)", "plant.lsys:3: more parameters than 16"},
  };
  for (const BadFile& file : files) {
    const std::string text = good + file.text;
    EXPECT_THAT(message_of(text), HasSubstr(file.message)) << text;
    EXPECT_THAT(message_of(text + "\n\n# the end\n"), HasSubstr(file.message)) << text;
  }
}

TEST(ParseLSystem, MissesAnAxiomAndSteps) {
  EXPECT_THAT(message_of(""), HasSubstr("plant.lsys: no 'axiom', wanted"));
  EXPECT_THAT(message_of("axiom: F(1, 1)"), HasSubstr("plant.lsys: no 'steps', wanted"));
  EXPECT_THAT(message_of("axiom:\nsteps: 1"),
              HasSubstr("plant.lsys:1: found the end of the statement, wanted at least"));
}

TEST(ParseLSystem, RefusesMoreConstantsThanItCanLookUpQuickly) {
  std::string text;
  for (int i = 0; i < 1001; ++i) text.append("c").append(std::to_string(i)).append(" = 1\n");
  EXPECT_THAT(message_of(text), HasSubstr("plant.lsys:1001: more constants than 1000, wanted fewer"));
}

}  // namespace
}  // namespace tremula
