#include "tremula/io/gust_plot.hpp"

#include "tremula/base/error.hpp"

#include <cmath>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include "complaint.hpp"
#include "io/xml.hpp"

namespace tremula {
namespace {

using test::complaint_of;
using testing::HasSubstr;

// u = 5 + sin over time and columns, v a little, w none, in two rows.
WindField wavy_field() {
  WindField field{.grid = {.y_count = 9, .z_count = 2, .step_count = 40, .y_spacing = 0.5, .z_spacing = 2},
                  .velocity = {}};
  field.grid.mean_speed = 5;
  for (auto& component : field.velocity)
    component.assign(field.grid.point_count() * static_cast<std::size_t>(field.grid.step_count), 0);
  for (int p = 0; p < 40; ++p) {
    for (int i = 0; i < 2; ++i) {
      for (int j = 0; j < 9; ++j) {
        const auto at = static_cast<std::size_t>((p * 2 + i) * 9 + j);
        const double phase = 2 * 3.14159265358979 * (p / 40.0 + j / 9.0);
        field.velocity[0][at] = static_cast<float>(5 + i + std::sin(phase));
        field.velocity[1][at] = static_cast<float>(0.5 * std::cos(phase));
      }
    }
  }
  return field;
}

// Pixels that are as dark as the ink of the arrows.
int dark_pixels(const Image& image) {
  int count = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) count += image.pixel(x, y)[0] < 40 && image.pixel(x, y)[2] < 60;
  }
  return count;
}

TEST(TravellingRow, HasTheVelocitiesOfTheNearestRowUpwindAtTheTimesAtWhichTheyArrive) {
  const WindField field = wavy_field();
  const TravellingField row = travelling_row(field, 2.4);  // rows at 1 and 3 m
  EXPECT_EQ(row.plane.heights, std::vector<double>{3});
  for (const int step : {0, 7, 39}) {
    for (const int column : {0, 3, 8}) {
      for (const int before : {0, 5}) {  // steps that the gust still needs to the plane
        const Vec3 place(-5 * before * field.grid.step, field.grid.y(column), 3);
        const auto at = static_cast<std::size_t>(((step + before) % 40 * 2 + 1) * 9 + column);
        const Vec3 found = value_at(row, place, step * field.grid.step);
        for (std::size_t c = 0; c < 3; ++c)
          EXPECT_NEAR(found[static_cast<int>(c)], static_cast<double>(field.velocity[c][at]), 1e-5);
      }
    }
  }
}

TEST(ViewOfGusts, IsAsLongAsWideButNoLongerThanTheLoop) {
  TravellingField row = travelling_row(wavy_field(), 1);
  GustView view = view_of_gusts(row);
  EXPECT_EQ(view.low, Eigen::Vector2d(-4, -2));
  EXPECT_EQ(view.high, Eigen::Vector2d(0, 2));
  row.speed = 0.5;  // 2 m in 4 s
  view = view_of_gusts(row);
  EXPECT_EQ(view.low.x(), -2);
  EXPECT_LE(view_of_gusts(row, 2).spacing, 2);
  EXPECT_GE(view_of_gusts(row, 2).spacing, 2);
}

TEST(SpeedsOf, HoldNearlyAllOfTheField) {
  const TravellingField row = travelling_row(wavy_field(), 1);
  const SpeedRange range = speeds_of(row);
  EXPECT_LT(range.slowest, 4.01);
  EXPECT_GT(range.fastest, 5.99);
  EXPECT_GT(range.slowest, 3);
  EXPECT_LT(range.fastest, 7);
}

TEST(PlotGusts, IsWellFormedAndSaysHeightTimeAndAxes) {
  const TravellingField row = travelling_row(wavy_field(), 1);
  GustView view = view_of_gusts(row);
  view.time = 1.25;
  const std::string svg = plot_gusts(row, view);
  EXPECT_FALSE(test::read_xml(svg).empty());
  for (const char* text : {"Wind 1 m above the ground, t = 1.25 s", "along the wind [m]", "across [m]", "m/s",
                           "data:image/png;base64,"})
    EXPECT_THAT(svg, HasSubstr(text));
  EXPECT_EQ(svg, plot_gusts(row, view));
  view.time += row.loop.period;
  EXPECT_EQ(svg.substr(svg.find("<image")),
            plot_gusts(row, view).substr(plot_gusts(row, view).find("<image")));
}

TEST(PictureOfGusts, IsOfTheSizeThatIsAskedForAndClosesWithTheLoop) {
  TravellingField row = travelling_row(wavy_field(), 1);
  row.speed = 0.5;
  GustView view = view_of_gusts(row);
  const Image picture = picture_of_gusts(row, view, 200);
  EXPECT_EQ(picture.width, 100);
  EXPECT_EQ(picture.height, 200);
  view.time = row.loop.period;
  EXPECT_EQ(picture_of_gusts(row, view, 200).rgb, picture.rgb);
  view.time = 1;
  EXPECT_NE(picture_of_gusts(row, view, 200).rgb, picture.rgb);
}

TEST(PictureOfGusts, HasLongerArrowsInAStrongerWind) {
  TravellingField row = travelling_row(wavy_field(), 1);
  GustView view = view_of_gusts(row, 6);
  const int before = dark_pixels(picture_of_gusts(row, view, 400));
  view.scale *= 0.5;
  EXPECT_GT(before, 1.5 * dark_pixels(picture_of_gusts(row, view, 400)));
}

TEST(GustColor, IsDarkerTheStrongerTheWind) {
  for (double share = 0; share < 0.95; share += 0.1)
    EXPECT_GT(gust_color(share).sum(), gust_color(share + 0.1).sum());
  EXPECT_EQ(gust_color(-1), gust_color(0));
  EXPECT_EQ(gust_color(7), gust_color(1));
}

TEST(PlotGusts, RefusesWhatCannotBeShown) {
  const TravellingField row = travelling_row(wavy_field(), 1);
  const GustView good = view_of_gusts(row);
  const auto complaint = [&](const auto& change) {
    GustView view = good;
    change(view);
    return complaint_of([&] { plot_gusts(row, view); });
  };
  EXPECT_EQ(complaint([](GustView&) {}), "");
  EXPECT_THAT(complaint([](GustView& view) { view.high = view.low; }), HasSubstr("view of the gusts: 0 m"));
  EXPECT_THAT(complaint([](GustView& view) { view.spacing = 1e-4; }), HasSubstr("a larger spacing"));
  EXPECT_THAT(complaint([](GustView& view) { view.scale = 0; }), HasSubstr("scale of the arrows"));
  EXPECT_THAT(complaint([](GustView& view) { view.fastest = view.slowest; }), HasSubstr("range of the tint"));
  EXPECT_THAT(complaint_of([&] { picture_of_gusts(row, good, 9000); }), HasSubstr("16 to 8192"));
  TravellingField narrow = row;
  narrow.plane.columns = 1;
  narrow.values.resize(40);
  EXPECT_THAT(complaint_of([&] { view_of_gusts(narrow); }), HasSubstr("columns of the field: 1"));
  TravellingField calm = row;
  calm.speed = 0;
  EXPECT_THAT(complaint_of([&] { view_of_gusts(calm); }), HasSubstr("speed of the field"));
}

}  // namespace
}  // namespace tremula
