#include "tremula/io/wind_plot.hpp"

#include "tremula/io/turbsim.hpp"

#include <cmath>

#include <gmock/gmock.h>

#include "io/input_files.hpp"

namespace tremula {
namespace {

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = 0; (at = text.find(part, at)) != std::string::npos; at += part.size()) ++count;
  return count;
}

WindReport report_of(const WindGrid& grid) {
  WindField field;
  field.grid = grid;
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t n = 0; n < grid.point_count() * static_cast<std::size_t>(grid.step_count); ++n)
      field.velocity[c].push_back(static_cast<float>(std::sin(1.7 * static_cast<double>(n * n + c))));
  }
  return {.title = "a <wind>", .statistics = field_statistics(field)};
}

const WindGrid grid{.y_count = 4, .z_count = 3, .step_count = 64};

TEST(PlotWind, DrawsALineForEveryProfileRowAndSeparation) {
  const std::string svg = plot_wind(report_of(grid));
  EXPECT_THAT(svg, testing::StartsWith("<?xml"));
  EXPECT_THAT(svg, testing::HasSubstr("a &lt;wind&gt;"));
  EXPECT_THAT(svg, testing::Not(testing::HasSubstr("nan")));
  // 1 mean, 3 deviations, 1 covariance; per component 3 rows, 2 separations across (1, 2) and 2 upward.
  EXPECT_EQ(count_of(svg, "stroke-width=\"1.3\""),
            5U + 3 * (3 + 2 + 2) + 3 + 3 * (3 + 2 + 2));  // and the legends
  EXPECT_EQ(count_of(svg, "stroke-dasharray"), 0U);
  EXPECT_EQ(count_of(svg, "dashed"), 0U);
  EXPECT_EQ(plot_wind(report_of(grid)), svg);
}

TEST(PlotWind, DrawsTheTargetsThatBelongToWhatIsShown) {
  WindReport report = report_of(grid);
  const Curve line{{0.1, 1}, {1, 0.2}};
  report.targets.mean = line;
  report.targets.deviation[2] = line;
  report.targets.spectra = {{.row = 2, .component = 1, .curve = line},
                            {.row = 9, .component = 1, .curve = line}};
  report.targets.coherence = {{.vertical = true, .cells = 2, .component = 0, .curve = line},
                              {.vertical = true, .cells = 16, .component = 0, .curve = line}};
  EXPECT_EQ(count_of(plot_wind(report), "stroke-dasharray"), 4U);
  EXPECT_EQ(count_of(plot_wind(report), "target: dashed"), 1U);
}

TEST(PlotWind, DrawsAFieldThatHasNoSpectrumAndNoPairs) {
  const std::string svg = plot_wind(report_of({.y_count = 1, .z_count = 1, .step_count = 1}));
  EXPECT_THAT(svg, testing::EndsWith("</svg>\n"));
  EXPECT_THAT(svg, testing::Not(testing::HasSubstr("nan")));
}

}  // namespace
}  // namespace tremula
