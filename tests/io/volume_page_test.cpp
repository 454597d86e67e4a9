#include "tremula/io/volume_page.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "io/page_block.hpp"
#include "tremula/base/error.hpp"
#include "tremula/deformation/volume.hpp"
#include "tremula/io/html.hpp"
#include "tremula/wind/point_wind.hpp"

namespace tremula {
namespace {

using Eigen::Vector2d;
using test::PageBlock;
using ::testing::HasSubstr;

StrandField some_field() {
  StrandField field;
  for (int variant = 0; variant < 2; ++variant)
    field.patches.push_back(grow_strands(VolumePlant::fur, {.variant = variant}));
  field.height = static_cast<double>(field.patches.front().height);
  const Vector2d size = field.patches.front().size.cast<double>();
  field.low = -0.6 * size;
  field.high = 1.3 * size;
  const Wind wind(turbulent_wind({.speed = 6, .heading = 20}, 0.3));
  const std::vector<Vec3> corners{{field.low.x(), field.low.y(), 0}, {field.high.x(), field.high.y(), 0}};
  const TravellingField gusts = gust_field(wind, TimeAxis{4, 100}, plane_across(corners, 20, 0.3, {0.5}));
  field.sway = canopy_sway(gusts, {.frequency = 6, .give = 2e-4});
  return field;
}

std::string encoded(const StrandField& field) { return encode_volume(field, {.name = "coat"}); }

TEST(EncodeVolume, LaysTheSamePatchesInTheSameSquaresAsATexture) {
  const StrandField field = some_field();
  const PageBlock block("TRMV", encoded(field));
  const std::size_t count = block.head["squares"]["count"];
  EXPECT_EQ(count, 9U);
  const Eigen::Vector2f size = field.patches.front().size;
  Eigen::AlignedBox2d covered;
  for (const auto& [x, y, variant, unused] : block.values<std::array<float, 4>>("squares", count)) {
    const auto column = static_cast<int>(std::lround(x / size.x())),
               row = static_cast<int>(std::lround(y / size.y()));
    EXPECT_EQ(variant, static_cast<float>(variant_at(2, field.seed, column, row)));
    covered.extend(Vector2d(x, y));
    covered.extend(Vector2d(x + size.x(), y + size.y()));
  }
  EXPECT_TRUE(covered.contains(Eigen::AlignedBox2d(field.low, field.high)));
}

TEST(EncodeVolume, HoldsStrandsAsTheyAreWhereAllAreShownAndElseAsMuchWider) {
  StrandField field = some_field();
  field.high = field.low + 0.2 * Vector2d(field.patches.front().size.cast<double>());
  for (const double scale : {1.0, 12.0}) {
    StrandField larger = field;
    larger.high = field.low + scale * 0.2 * Vector2d(field.patches.front().size.cast<double>());
    const double share = share_of_page(larger);
    const PageBlock block("TRMV", encoded(larger));
    EXPECT_NEAR(block.head["share"].get<double>(), share, 1e-12);
    const std::size_t strands = block.head["strands"]["count"], points = block.head["points"]["count"];
    const auto held = block.values<std::array<float, 8>>("strands", strands);
    const auto at = block.values<std::array<float, 4>>("points", points);
    std::size_t next = 0;
    for (std::size_t variant = 0; variant < larger.patches.size(); ++variant) {
      const StrandPatch& patch = larger.patches[variant];
      for (const std::size_t number : strands_left(larger, variant, share)) {
        const Strand& strand = patch.strands[number];
        const auto& one = held[next++];
        ASSERT_EQ(one[1], static_cast<float>(strand.points.size()));
        EXPECT_EQ(one[2], patch.feet[strand.plant].x());
        EXPECT_EQ(one[4], strand.held);
        for (std::size_t i = 0; i < strand.points.size(); ++i) {
          const auto& point = at[static_cast<std::size_t>(one[0]) + i];
          EXPECT_EQ(point[2], strand.points[i].z());
          EXPECT_EQ(point[3], static_cast<float>(1 / share) * strand.widths[i]);
        }
      }
    }
    EXPECT_EQ(next, strands);
    EXPECT_EQ(share == 1, scale == 1);
  }
}

TEST(StrandsLeft, AreTheShareOfAllAndTheSameOnesStayInASmallerShare) {
  StrandField field = some_field();
  field.low *= 4;  // there are whole squares of either variant
  field.high *= 3;
  const auto half = strands_left(field, 0, 0.5), tenth = strands_left(field, 0, 0.1);
  const auto all = static_cast<double>(field.patches[0].strands.size());
  EXPECT_NEAR(static_cast<double>(half.size()) / all, 0.5, 0.03);
  EXPECT_NEAR(static_cast<double>(tenth.size()) / all, 0.1, 0.02);
  EXPECT_TRUE(std::includes(half.begin(), half.end(), tenth.begin(), tenth.end()));
  EXPECT_EQ(strands_left(field, 0, 1).size(), field.patches[0].strands.size());
}

TEST(StrandsLeft, AreThoseThatStandSomewhereInTheField) {
  StrandField field = some_field();
  const Eigen::Vector2f size = field.patches[0].size;
  field.low = 0.1 * size.cast<double>();
  field.high = 0.4 * size.cast<double>();
  const std::size_t variant = squares_of(field).front().variant;
  ASSERT_EQ(squares_of(field).size(), 1U);
  const StrandPatch& patch = field.patches[variant];
  std::vector<std::size_t> wanted;
  for (std::size_t i = 0; i < patch.strands.size(); ++i) {
    const Vector2d foot = patch.feet[patch.strands[i].plant].cast<double>();
    if ((foot.array() >= field.low.array()).all() && (foot.array() <= field.high.array()).all())
      wanted.push_back(i);
  }
  EXPECT_EQ(strands_left(field, variant, 1), wanted);
  EXPECT_TRUE(strands_left(field, 1 - variant, 1).empty());
  EXPECT_EQ(shown_strands(field, 1), wanted.size());
}

TEST(EncodeVolume, HoldsHowTallPlantsAreTo255Parts) {
  StrandField field = some_field();
  field.tallness = [&](const Vector2d& place) { return 0.3 + 0.5 * (place.x() - field.low.x()); };
  const PageBlock block("TRMV", encoded(field));
  const auto& told = block.head["tallness"];
  const std::size_t columns = told["columns"], rows = told["rows"];
  const double spacing = told["spacing_m"];
  EXPECT_GE(static_cast<double>(columns - 1) * spacing, field.high.x() - field.low.x());
  const auto values = block.values<std::uint8_t>("tallness", columns * rows);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double wanted = 0.3 + 0.5 * spacing * static_cast<double>(i % columns);
    EXPECT_NEAR(values[i] / 255.0, wanted, 0.5 / 255 + 1e-9);
  }
}

TEST(EncodeVolume, HoldsTheSwayOfTheTops) {
  const StrandField field = some_field();
  const PageBlock block("TRMV", encoded(field));
  const TravellingField& sway = field.sway.field;
  const std::size_t count = block.head["sway"]["count"];
  ASSERT_EQ(count, sway.values.size());
  const auto numbers = block.values<std::int16_t>("sway", 2 * count);
  const double step = block.head["sway"]["step_m"];
  for (std::size_t i = 0; i < 2 * count; ++i)
    EXPECT_NEAR(numbers[i] * step, static_cast<double>(sway.values[i / 2][i % 2]), 0.51 * step);
  // The mean of all that a top does is d U^2.
  EXPECT_NEAR(block.head["sway"]["lean_m"][0].get<double>(), 0.5 * sway.mean.front().x(), 1e-12);
}

std::string refusal(const StrandField& field) {
  try {
    encoded(field);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(EncodeVolume, RefusesWhatAPageCannotHold) {
  StrandField field = some_field();
  field.high = field.low + Vector2d(5, 5);
  EXPECT_THAT(refusal(field), HasSubstr("wanted at most"));
  field = some_field();
  field.patches.clear();
  EXPECT_THAT(refusal(field), HasSubstr("no patch"));
  field = some_field();
  field.high.x() = field.low.x();
  EXPECT_THAT(refusal(field), HasSubstr("no area"));
  field = some_field();
  field.low += Vector2d(1e9, 0);
  field.high += Vector2d(1e9, 0);
  EXPECT_THAT(refusal(field), HasSubstr("m from the origin"));
  field = some_field();
  field.high = field.low + Vector2d(1e-5, 1e-5);
  EXPECT_THAT(refusal(field), HasSubstr("no strand that stands in the field"));
  field = some_field();
  field.sway.field.values[3][0] = std::numeric_limits<float>::infinity();
  EXPECT_THAT(refusal(field), HasSubstr("page: sway"));
  field = some_field();
  field.patches[0].strands[5].points[1].x() = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(refusal(field), HasSubstr("page: points"));
}

TEST(EncodeVolumePage, HoldsTheNameAndNoMarks) {
  if (!can_write_html()) GTEST_SKIP() << "built without node and npm";
  const std::string html = encode_volume_page(some_field(), {.name = "a <coat>"});
  EXPECT_THAT(html, HasSubstr("<title>a &lt;coat></title>"));
  EXPECT_EQ(html.find("@TREMULA_"), std::string::npos);
}

}  // namespace
}  // namespace tremula
