#include "tremula/io/svg.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "io/xml.hpp"
#include "tremula/base/error.hpp"

namespace tremula {
namespace {

using test::read_xml;
using test::XmlElement;

const PlotBox frame{50, 20, 400, 200};

std::vector<XmlElement> drawn(const Plot& plot) {
  return read_xml(svg_document(500, 300, "plot", svg_plot(plot, frame)));
}

std::vector<XmlElement> all(const std::vector<XmlElement>& elements, const std::string& name) {
  std::vector<XmlElement> found;
  std::copy_if(elements.begin(), elements.end(), std::back_inserter(found),
               [&](const XmlElement& element) { return element.name == name; });
  return found;
}

// Texts centred below the frame, as numbers, with where they stand.
std::vector<std::pair<double, double>> x_ticks(const std::vector<XmlElement>& elements) {
  std::vector<std::pair<double, double>> ticks;
  for (const XmlElement& text : all(elements, "text")) {
    if (text.number("y") != frame.y + frame.height + 19) continue;
    ticks.emplace_back(std::stod(text.text), text.number("x"));
  }
  return ticks;
}

TEST(SvgPlot, PutsTicksOfALinearAxisWhereTheirNumbersBelong) {
  const auto ticks = x_ticks(drawn({"", {"t", -3, 17}, {"v", 0, 1}, {}}));
  ASSERT_GE(ticks.size(), 3U);
  for (const auto& [value, x] : ticks) EXPECT_NEAR(x, frame.x + frame.width * (value + 3) / 20, 0.051);
}

TEST(SvgPlot, PutsTicksOfALogarithmicAxisWhereTheirNumbersBelong) {
  for (const double high : {0.35, 1.9, 30., 1e5, 1e30}) {
    const auto ticks = x_ticks(drawn({"", {"f", 0.2, high, true}, {"v", 0, 1}, {}}));
    ASSERT_GE(ticks.size(), 2U) << high;
    for (const auto& [value, x] : ticks) {
      EXPECT_NEAR(x, frame.x + frame.width * std::log(value / 0.2) / std::log(high / 0.2), 0.051) << value;
    }
    for (std::size_t i = 1; i < ticks.size(); ++i) EXPECT_GT(ticks[i].second, ticks[i - 1].second + 20);
  }
}

TEST(SvgPlot, DrawsALineThroughItsPointsAndBreaksItWhereThereIsNone) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Series series{"s", "#123456", {1, 10, 2, 3, 100, 10, 1}, {0, 0.5, nan, 1, 1, 1, 0}};
  Series with_zero = series;
  with_zero.x[2] = 0;  // has no place on a logarithmic axis
  with_zero.y[2] = 0.5;
  for (const Series& s : {series, with_zero}) {
    const auto paths = all(drawn({"", {"x", 1, 100, true}, {"y", 0, 1}, {s}}), "path");
    const auto path = std::find_if(paths.begin(), paths.end(), [](const XmlElement& p) {
      return p.attributes.contains("stroke") && p.attributes.at("stroke") == "#123456" &&
             p.attributes.at("d").size() > 30;
    });
    ASSERT_NE(path, paths.end());
    EXPECT_EQ(path->attributes.at("d"), "M0 200L200 100M95.4 0L400 0L200 0L0 200");
  }
}

TEST(SvgPlot, StandsStemsOnTheAxisAndLeavesOutWhatIsBesideIt) {
  const Series series{"s", "#123456", {1, 2, 3, 5}, {50, 0, -7, 50}, Mark::stems};
  auto discs = all(drawn({"", {"x", 0, 4}, {"y", 1, 100, true}, {series}}), "circle");
  ASSERT_EQ(discs.size(), 4U);  // one is in the legend
  EXPECT_NEAR(discs[1].number("cy"), frame.y + frame.height * (1 - std::log10(50) / 2), 0.051);
  EXPECT_EQ(discs[2].number("cy"), frame.y + frame.height);
  EXPECT_EQ(discs[3].number("cy"), frame.y + frame.height);
}

TEST(SvgPlot, LeavesOutLabelsThatWouldLieOnEachOther) {
  Series series{"", "#123456", {1, 1.01, 3}, {0.5, 0.5, 0.5}, Mark::points};
  series.labels = {"first", "second", "third"};
  std::vector<std::string> texts;
  for (const XmlElement& text : all(drawn({"", {"x", 0, 4}, {"y", 0, 1}, {series}}), "text")) {
    texts.push_back(text.text);
  }
  EXPECT_THAT(texts, testing::Contains("first"));
  EXPECT_THAT(texts, testing::Contains("third"));
  EXPECT_THAT(texts, testing::Not(testing::Contains("second")));
}

TEST(SvgPlot, RefusesAxesAndSeriesThatAreNone) {
  const double infinity = std::numeric_limits<double>::infinity();
  const Plot good{"", {"x", 0, 1}, {"y", 0, 1}, {}};
  EXPECT_NO_THROW(svg_plot(good, frame));
  for (const PlotAxis& axis :
       {PlotAxis{"a", 1, 1}, PlotAxis{"a", 2, 1}, PlotAxis{"a", 0, 1, true}, PlotAxis{"a", 0, infinity}}) {
    Plot bad_x = good, bad_y = good;
    bad_x.x = bad_y.y = axis;
    EXPECT_THROW(svg_plot(bad_x, frame), Error);
    EXPECT_THROW(svg_plot(bad_y, frame), Error);
  }
  Plot bad_series = good;
  bad_series.series.push_back({"s", "#000", {1, 2}, {1}});
  EXPECT_THROW(svg_plot(bad_series, frame), Error);
}

TEST(AxisAround, HoldsAllValuesThatHaveAPlaceOnIt) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::vector<double>> cases{{},           {0},          {5}, {-3e-9}, {1, nan, 17.3},
                                               {-2, 0, 1e6}, {3, 3 + 1e-9}};
  for (const auto& values : cases) {
    for (const bool logarithmic : {false, true}) {
      const PlotAxis axis = axis_around("a", values, logarithmic);
      EXPECT_NO_THROW(svg_plot({"", axis, axis, {}}, frame));
      for (const double value : values) {
        if (std::isnan(value) || (logarithmic && value <= 0)) continue;
        EXPECT_LE(axis.low, value);
        EXPECT_GE(axis.high, value);
      }
    }
  }
}

TEST(SvgText, IsTheTextWhateverStandsInIt) {
  for (const std::string text : {"a<b & \"c\" > 'd'", "]]>", "\u00e4\u20ac\U0001F333", "&amp;"}) {
    EXPECT_EQ(all(read_xml(svg_document(9, 9, text, svg_text(1, 2, text))), "text")[0].text, text);
  }
}

TEST(SvgText, ReplacesBytesThatXmlCannotCarry) {
  const std::string mark = "\xEF\xBF\xBD";
  EXPECT_THAT(svg_text(0, 0, "a\x01z"), testing::HasSubstr(">a" + mark + "z<"));
  EXPECT_THAT(svg_text(0, 0, "a\xFFz"), testing::HasSubstr(">a" + mark + "z<"));
  EXPECT_THAT(svg_text(0, 0, "a\xC3"), testing::HasSubstr(">a" + mark + "<"));                // cut short
  EXPECT_THAT(svg_text(0, 0, "\xC0\xAF"), testing::HasSubstr(">" + mark + mark + "<"));       // overlong
  EXPECT_THAT(svg_text(0, 0, "\xED\xA0\x80"), testing::HasSubstr(">" + mark + mark + mark));  // a surrogate
}

}  // namespace
}  // namespace tremula
