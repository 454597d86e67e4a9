#include "tremula/io/modes_plot.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "io/xml.hpp"
#include "panels.hpp"
#include "sheets.hpp"
#include "trees.hpp"
#include "tremula/modes/solve_modes.hpp"

namespace tremula {
namespace {

using test::read_xml;
using test::XmlElement;
using testing::Contains;

using Segments = std::vector<std::vector<Eigen::Vector2d>>;

struct Shape {
  Segments at_rest, moved;
};

struct Drawn {
  Modes modes;
  ModeQuality quality;
  std::string svg;
  std::vector<std::string> texts;
  std::vector<Shape> shapes;
};

void add_segments(const std::string& path, Segments& segments) {
  std::istringstream stream(path);
  char letter;
  Eigen::Vector2d point;
  while (stream >> letter >> point.x() >> point.y()) {
    if (letter == 'M') segments.emplace_back();
    segments.back().push_back(point);
  }
}

Drawn draw(const Skeleton& skeleton, int count, const ModesPlotOptions& options = {},
           const RootSpring& root = {}) {
  const Structure structure = assemble(skeleton, test::weightless({.root = root}));
  Drawn drawn;
  drawn.modes = solve_modes(structure, {.count = count});
  drawn.quality = assess_modes(structure, drawn.modes, trunk_branches(skeleton));
  drawn.svg = plot_modes(structure, drawn.modes, drawn.quality, options);
  for (const XmlElement& element : read_xml(drawn.svg)) {
    if (element.name == "text") drawn.texts.push_back(element.text);
    if (element.name == "g") {
      drawn.shapes.emplace_back();
      EXPECT_EQ(element.attributes.at("id"), "mode-" + std::to_string(drawn.shapes.size()));
    }
    if (drawn.shapes.empty() || element.name != "path") continue;
    Shape& shape = drawn.shapes.back();
    if (element.attributes.at("stroke") == "#333") continue;  // the scale, after the last shape
    add_segments(element.attributes.at("d"),
                 element.attributes.at("stroke") == "#dedede" ? shape.at_rest : shape.moved);
  }
  return drawn;
}

// How far the points reach along the page and down it.
Eigen::Vector2d reach(const Segments& segments) {
  Eigen::Vector2d low = segments.front().front(), high = low;
  for (const auto& segment : segments) {
    for (const Eigen::Vector2d& point : segment) {
      low = low.cwiseMin(point);
      high = high.cwiseMax(point);
    }
  }
  return high - low;
}

TEST(PlotModes, NamesFrequencyAndKindOfEveryShape) {
  const Drawn drawn = draw(test::awkward_tree(), 14, {.title = "<a> & b", .shape_count = 5});
  EXPECT_THAT(drawn.texts, Contains("<a> & b"));
  for (int r = 0; r < 5; ++r) {
    char text[40];
    std::snprintf(text, sizeof text, "%d \u00b7 %#.4g Hz", r + 1, drawn.modes.frequency[r]);
    EXPECT_THAT(drawn.texts, Contains(text));
    EXPECT_THAT(drawn.texts,
                Contains(testing::StartsWith(
                    std::string(name_of(drawn.quality.kind[static_cast<std::size_t>(r)])) + ", ")));
  }
  EXPECT_THAT(drawn.texts, testing::Not(Contains(testing::StartsWith("6 \u00b7"))));
}

TEST(PlotModes, SeesEveryModeFromTheSideThatShowsItsMotion) {
  const double length = 2;
  const Drawn drawn =
      draw(test::straight_stem(8, length, 0.01, 0.01), 4, {.displacement = 0.1, .largest_rotation = 10});
  ASSERT_EQ(drawn.shapes.size(), 4U);
  for (std::size_t r = 0; r < 4; ++r) {
    const Shape& shape = drawn.shapes[r];
    const double scale = reach(shape.at_rest).y() / length;
    // The tip moves most. The second pair swings out to the other side too, at 0.7 of the length by 0.7 of
    // it.
    const double wanted = 0.1 * length * (r < 2 ? 1 : 1.71);
    EXPECT_NEAR(reach(shape.moved).x() / scale, wanted, 0.01 * length) << "mode " << r + 1;
    EXPECT_EQ(reach(shape.at_rest).x(), 0);
  }
}

// A stem that only slides on its spring moves all along its length by as much as its tip.
TEST(PlotModes, AFootOnASpringMoves) {
  const Skeleton stem = test::straight_stem(4, 2, 0.05, 0.05);
  const auto shift = [](const Shape& shape) {  // of the foot, the point lowest on the page
    const auto lowest = [](const Segments& segments) {
      Eigen::Vector2d low = segments.front().front();
      for (const auto& segment : segments) {
        for (const Eigen::Vector2d& point : segment) low = point.y() > low.y() ? point : low;
      }
      return low;
    };
    return std::abs(lowest(shape.moved).x() - lowest(shape.at_rest).x());
  };
  const Drawn clamped = draw(stem, 2), sliding = draw(stem, 2, {.displacement = 0.1}, {.translation = 10});
  EXPECT_EQ(shift(clamped.shapes[0]), 0);
  const double scale = reach(sliding.shapes[0].at_rest).y() / 2;
  EXPECT_NEAR(shift(sliding.shapes[0]) / scale, 0.1 * 2, 0.01);
}

TEST(PlotModes, TurnsNothingByMoreThanTheLargestRotation) {
  const Drawn drawn =
      draw(test::straight_stem(8, 2, 0.01, 0.01), 8, {.displacement = 1, .largest_rotation = 0.3});
  for (const Shape& shape : drawn.shapes) {
    double steepest = 0;
    for (const auto& segment : shape.moved) {
      for (std::size_t i = 1; i < segment.size(); ++i) {
        const Eigen::Vector2d step = segment[i] - segment[i - 1];
        if (step.norm() > 8) steepest = std::max(steepest, std::abs(step.x() / step.y()));
      }
    }
    EXPECT_NEAR(steepest, 0.3, 0.03);
  }
}

TEST(PlotModes, DrawsNoMoreBranchesThanAsked) {
  const Skeleton skeleton = test::awkward_tree();
  const Drawn all = draw(skeleton, 6), some = draw(skeleton, 6, {.branch_count = 5});
  for (std::size_t r = 0; r < 6; ++r) {
    EXPECT_EQ(all.shapes[r].at_rest.size(), static_cast<std::size_t>(skeleton.branch_count()));
    EXPECT_EQ(some.shapes[r].at_rest.size(), 5U);
    EXPECT_EQ(some.shapes[r].moved.size(), 5U);
  }
  EXPECT_THAT(some.texts, Contains(testing::HasSubstr("5 branches that move most or are thickest")));
  EXPECT_THAT(all.texts, testing::Not(Contains(testing::HasSubstr("thickest"))));
}

TEST(PlotModes, ShowsTorsionOfAStemThoughNothingOfItMoves) {
  // All modes of one branch: two pairs of bending, one of torsion, one axial.
  const Drawn drawn = draw(test::straight_stem(1, 2, 0.1, 0.1), 6);
  EXPECT_EQ(drawn.shapes.size(), 6U);
  EXPECT_THAT(drawn.texts,
              testing::AllOf(Contains("1 branch, 67.36 kg; 6 modes"), Contains("torsion, heading 0\u00b0"),
                             Contains("axial, heading 0\u00b0")));
  EXPECT_THAT(drawn.svg, testing::Not(testing::HasSubstr("nan")));
}

// Of a sheet or a frame.
Drawn draw(const Structure& structure, int count) {
  Drawn drawn;
  drawn.modes = solve_modes(structure, {.count = count});
  drawn.quality = assess_modes(structure, drawn.modes, std::vector<bool>(structure.members.size(), false));
  drawn.svg = plot_modes(structure, drawn.modes, drawn.quality);
  for (const XmlElement& element : read_xml(drawn.svg)) {
    if (element.name == "text") drawn.texts.push_back(element.text);
    if (element.name == "g") drawn.shapes.emplace_back();
    if (drawn.shapes.empty() || element.name != "path" || element.attributes.at("stroke") == "#333") continue;
    add_segments(element.attributes.at("d"), element.attributes.at("stroke") == "#dedede"
                                                 ? drawn.shapes.back().at_rest
                                                 : drawn.shapes.back().moved);
  }
  return drawn;
}

TEST(PlotModes, DrawsASheetAsTheLinesAlongItsElements) {
  Sheet sheet = test::steel_sheet(6, 4);
  sheet.clamped = {SheetEdge::left};
  const Drawn drawn = draw(assemble(sheet, {.gravity = 0}), 3);
  EXPECT_THAT(drawn.texts, Contains(testing::StartsWith("24 elements, ")));
  EXPECT_THAT(drawn.texts, Contains("bending, slanting"));
  ASSERT_EQ(drawn.shapes.size(), 3U);
  for (const Shape& shape : drawn.shapes) {
    EXPECT_EQ(shape.at_rest.size(), 7U + 5U);
    EXPECT_GE(shape.moved.size(), 7U + 5U) << "a line is cut where its shade changes";
    EXPECT_GT((reach(shape.moved) - reach(shape.at_rest)).cwiseAbs().maxCoeff(), 2) << "pixels";
  }
}

TEST(PlotModes, DrawsPostAndPanelInOnePicture) {
  const Material wood{"wood", 9e9, 7e8, 950, ""};
  const Drawn drawn = draw(assemble(test::post_with_panel(2, 0.02, wood, test::panel_sheet(), 4)), 2);
  EXPECT_THAT(drawn.texts, Contains(testing::StartsWith("4 branches, 12 elements, ")));
  ASSERT_EQ(drawn.shapes.size(), 2U);
  EXPECT_EQ(drawn.shapes[0].at_rest.size(), 4U + 5U + 4U);
}

}  // namespace
}  // namespace tremula
