#include "tremula/geometry/expression.hpp"

#include <cmath>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "complaint.hpp"

namespace tremula {
namespace {

const std::vector<std::string> constants = {"two", "ten"};
const std::vector<double> constant_values = {2, 10};
const std::vector<std::string> parameters = {"n"};
const std::vector<double> parameter_values = {7};

Expression parse(const std::string& text) {
  TextCursor cursor(text, "test.lsys");
  ExpressionScope scope{constants, parameters};
  Expression expression = parse_expression(cursor, scope);
  if (!cursor.at_end()) cursor.fail("the end");
  return expression;
}

double value_of(const std::string& text, ExpressionValues values = {}) {
  values.constants = constant_values;
  values.parameters = parameter_values;
  return evaluate(parse(text), values, "test.lsys");
}

std::string message_of(const std::string& text) {
  return test::complaint_of([&] { value_of(text); });
}

TEST(Expression, BindsOperatorsInTheOrderOfArithmetic) {
  EXPECT_EQ(value_of("1 + 2 * 3"), 7);
  EXPECT_EQ(value_of("(1 + 2) * 3"), 9);
  EXPECT_EQ(value_of("10 - 4 - 3"), 3);
  EXPECT_EQ(value_of("24 / 4 / 3"), 2);
  EXPECT_EQ(value_of("24 / 4 * 3"), 18);
  EXPECT_EQ(value_of("2 ^ 3 ^ 2"), 512);
  EXPECT_EQ(value_of("-2 ^ 2"), -4);
  EXPECT_EQ(value_of("2 ^ -1"), 0.5);
  EXPECT_EQ(value_of("2 * -3"), -6);
  EXPECT_EQ(value_of("2 * 3 ^ 2"), 18);
  EXPECT_EQ(value_of("7 % 4 * 2"), 6);
  EXPECT_EQ(value_of("+3 - -4"), 7);
}

TEST(Expression, BindsComparisonsLooserThanSumsAndLogicLooserStill) {
  EXPECT_EQ(value_of("1 + 1 < 3"), 1);
  EXPECT_EQ(value_of("1 < 2 == 2 > 1"), 1);
  EXPECT_EQ(value_of("1 || 0 && 0"), 1);
  EXPECT_EQ(value_of("(1 || 0) && 0"), 0);
  EXPECT_EQ(value_of("!1 + 1"), 1);
  EXPECT_EQ(value_of("!(1 + 1)"), 0);
  EXPECT_EQ(value_of("n >= 7 && n <= 7 && n != 8"), 1);
  EXPECT_EQ(value_of("n == 8 || n > 8"), 0);
}

TEST(Expression, KnowsNamesAndFunctions) {
  EXPECT_EQ(value_of("n * two + ten"), 24);
  EXPECT_EQ(value_of("min(3, 2) + max(3, 2)"), 5);
  EXPECT_EQ(value_of("floor(2.7) + ceil(2.2) + round(2.5) + floor(-0.5)"), 2 + 3 + 3 - 1);
  EXPECT_EQ(value_of("sqrt(9) + abs(-2) + pow(2, 5)"), 3 + 2 + 32);
  EXPECT_NEAR(value_of("sin(30)"), 0.5, 1e-15);
  EXPECT_NEAR(value_of("cos(60)"), 0.5, 1e-15);
  EXPECT_EQ(value_of("exp(1)"), std::exp(1.0));
  EXPECT_NEAR(value_of("log(exp(2))"), 2, 1e-15);
  EXPECT_EQ(value_of("if(n > 5, 1, 2)"), 1);
  EXPECT_EQ(value_of("1.5e2 + .5"), 150.5);
  EXPECT_EQ(value_of("height()", {.height = 3.5}), 3.5);
}

TEST(Expression, GivesTheRemainderTheSignOfTheDivisor) {
  EXPECT_EQ(value_of("-90 % 360"), 270);
  EXPECT_EQ(value_of("7 % -4"), -1);
  EXPECT_EQ(value_of("5.5 % 2"), 1.5);
}

TEST(Expression, EvaluatesOnlyTheBranchThatCounts) {
  EXPECT_EQ(value_of("if(n > 0, n, log(0))"), 7);
  EXPECT_EQ(value_of("n < 0 && 1 / 0 > 1"), 0);
  EXPECT_EQ(value_of("n > 0 || 1 / 0 > 1"), 1);
}

TEST(Expression, StopsAtTheArrowOfAProduction) {
  const std::string text = "n - 3 -> F";
  TextCursor cursor(text, "test.lsys");
  ExpressionScope scope{constants, parameters};
  const Expression expression = parse_expression(cursor, scope);
  EXPECT_TRUE(cursor.take("->"));
  EXPECT_EQ(evaluate(expression, {.parameters = parameter_values}, "test.lsys"), 4);
}

TEST(Expression, RefusesWhatIsNotInItsGrammarWithItsPlace) {
  using ::testing::HasSubstr;
  EXPECT_THAT(message_of("1 +"),
              HasSubstr("test.lsys:1: found the end of the statement, wanted a number, a name"));
  EXPECT_THAT(message_of("\n1 + *"), HasSubstr("test.lsys:2: found '*'"));
  EXPECT_THAT(message_of("(1 + 2"), HasSubstr("wanted ')'"));
  EXPECT_THAT(message_of("m + 1"), HasSubstr("unknown name 'm', wanted one of n, two, ten"));
  EXPECT_THAT(message_of("tan(3)"), HasSubstr("unknown function 'tan'"));
  EXPECT_THAT(message_of("min(1)"), HasSubstr("found ')', wanted ',': min(a, b)"));
  EXPECT_THAT(message_of("sqrt(1, 2)"), HasSubstr("found ',', wanted ')': sqrt(a)"));
  EXPECT_THAT(message_of("1e999"), HasSubstr("wanted a number that a double can hold"));
  EXPECT_THAT(message_of("3 \x01"), HasSubstr("found the byte 0x01"));
}

TEST(Expression, RefusesValuesThatAreNotFinite) {
  using ::testing::HasSubstr;
  EXPECT_THAT(message_of("ten / (n - 7)"), HasSubstr("'ten / (n - 7)' is not finite where parameter 1 is 7"));
  EXPECT_THAT(message_of("log(0)"), HasSubstr("not finite"));
  EXPECT_THAT(message_of("sqrt(-1) > 0"), HasSubstr("not finite"));
  EXPECT_THAT(message_of("min(1, 0 / 0)"), HasSubstr("not finite"));
  EXPECT_THAT(message_of("exp(1000)"), HasSubstr("not finite"));
  EXPECT_THAT(message_of("5 % 0"), HasSubstr("not finite"));
}

TEST(Expression, RefusesDeepNestingInsteadOfRunningOutOfStack) {
  using ::testing::HasSubstr;
  const std::size_t many = 100'000;
  EXPECT_THAT(message_of(std::string(many, '(')), HasSubstr("nested more than 200 deep"));
  EXPECT_THAT(message_of(std::string(many, '-') + "1"), HasSubstr("nested more than 200 deep"));
  std::string sum = "1";
  for (std::size_t i = 0; i < many; ++i) sum += "+1";
  EXPECT_THAT(message_of(sum), HasSubstr("nested more than 200 deep"));
  std::string power = "1";
  for (std::size_t i = 0; i < many; ++i) power += "^1";
  EXPECT_THAT(message_of(power), HasSubstr("nested more than 200 deep"));
}

TEST(Expression, DrawsUniformNumbersOfTheRangeItIsGiven) {
  const Expression expression = parse("rand(2, 5)");
  const int count = 20000;
  double sum = 0, squares = 0;
  for (int i = 0; i < count; ++i) {
    const double x = evaluate(expression, {.seed = 3, .key = static_cast<std::uint64_t>(i)}, "test.lsys");
    ASSERT_GE(x, 2);
    ASSERT_LT(x, 5);
    sum += x;
    squares += (x - 3.5) * (x - 3.5);
  }
  // Five standard errors: variance of the mean w^2/(12 n), of the squares w^4/(180 n) (w = 3).
  EXPECT_NEAR(sum / count, 3.5, 5 * std::sqrt(9.0 / 12 / count));
  EXPECT_NEAR(squares / count, 9.0 / 12, 5 * std::sqrt(81.0 / 180 / count));
}

TEST(Expression, DrawsNormalNumbersOfTheMeanAndDeviationItIsGiven) {
  const Expression expression = parse("normal(10, 2)");
  const int count = 20000;
  double sum = 0, squares = 0, fourth = 0;
  for (int i = 0; i < count; ++i) {
    const double x = evaluate(expression, {.seed = 3, .key = static_cast<std::uint64_t>(i)}, "test.lsys");
    sum += x;
    squares += std::pow((x - 10) / 2, 2);
    fourth += std::pow((x - 10) / 2, 4);
  }
  EXPECT_NEAR(sum / count, 10, 5 * 2 / std::sqrt(count));
  EXPECT_NEAR(squares / count, 1, 5 * std::sqrt(2.0 / count));  // variance of z^2 is 2
  EXPECT_NEAR(fourth / count, 3, 5 * std::sqrt(96.0 / count));  // of z^4: 105 - 9
}

TEST(Expression, DrawsOtherNumbersForOtherSeedsLettersAndPlaces) {
  const Expression expression = parse("rand(0, 1)");
  const auto draw = [&](const ExpressionValues& values) { return evaluate(expression, values, "test.lsys"); };
  const ExpressionValues base = {.seed = 1, .key = 2, .statement = 3};
  EXPECT_EQ(draw(base), draw(base));
  EXPECT_NE(draw(base), draw({.seed = 2, .key = 2, .statement = 3}));
  EXPECT_NE(draw(base), draw({.seed = 1, .key = 3, .statement = 3}));
  EXPECT_NE(draw(base), draw({.seed = 1, .key = 2, .statement = 4}));
  EXPECT_NE(draw(base), draw_choice(base));
  EXPECT_NE(value_of("rand(0, 1) - rand(0, 1)"), 0);
}

}  // namespace
}  // namespace tremula
