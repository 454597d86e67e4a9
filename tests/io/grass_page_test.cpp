#include "tremula/io/grass_page.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include <tbb/global_control.h>

#include "io/page_block.hpp"
#include "tremula/base/error.hpp"
#include "tremula/io/html.hpp"
#include "tremula/wind/point_wind.hpp"

namespace tremula {
namespace {

using test::PageBlock;
using ::testing::HasSubstr;

TravellingField some_gusts(double height) {
  const Wind wind(turbulent_wind({.speed = 7, .heading = 20}, 0.3));
  const std::vector<Vec3> corners = {Vec3(-1, -1, 0), Vec3(1, 1, 0), Vec3(-1, 1, 0), Vec3(1, -1, 0)};
  return gust_field(wind, TimeAxis{6, 120}, plane_across(corners, 20, 0.5, {height}));
}

GrassInWind some_grass(const char* species, double ground = 0) {
  Meadow meadow =
      sow(grass_species_named(species), {.low = {-0.4, -0.3}, .high = {0.4, 0.3}, .ground = ground});
  const TravellingField gusts = some_gusts(meadow.height);
  return put_in_wind(std::move(meadow), gusts);
}

double off_by(double angle, double other) { return std::abs(std::remainder(angle - other, 2 * M_PI)); }

TEST(EncodeGrass, BladesDecodeToWithinHalfAStep) {
  for (const char* species : {"meadow", "wheat", "rice"}) {
    const GrassInWind grass = some_grass(species, 1.5);
    const Meadow& meadow = grass.meadow;
    const PageBlock block("TRMG", encode_grass(grass, {.name = species}));
    const auto& about = block.head["blades"];
    const std::size_t n = meadow.size();
    ASSERT_EQ(about["count"], n);
    const auto words = block.values<std::uint32_t>("blades", 4 * n);
    const std::array<double, 3> low = about["low_m"], step = about["step_m"];
    const double length = about["length_step_m"], width = about["width_step_m"];
    EXPECT_LT(*std::ranges::max_element(step), 1e-4);
    for (std::size_t i = 0; i < n; ++i) {
      const std::uint32_t a = words[i], b = words[n + i], c = words[2 * n + i], d = words[3 * n + i];
      const double small = 1e-6;  // [m] of floats
      EXPECT_NEAR(low[0] + step[0] * (a & 0xffffU), static_cast<double>(meadow.x[i]), step[0] / 2 + small);
      EXPECT_NEAR(low[1] + step[1] * (a >> 16U), static_cast<double>(meadow.y[i]), step[1] / 2 + small);
      EXPECT_NEAR(low[2] + step[2] * (b & 0xffffU), static_cast<double>(meadow.z[i]), step[2] / 2 + small);
      EXPECT_NEAR(length * (b >> 16U), static_cast<double>(meadow.length[i]), length / 2 + small);
      EXPECT_LE(off_by((c & 0x3fffU) * 2 * M_PI / 16384, static_cast<double>(meadow.azimuth[i])),
                M_PI / 16384 + small);
      EXPECT_LE(off_by((c >> 14U & 0x3ffU) * 2 * M_PI / 1024, static_cast<double>(meadow.facing[i])),
                M_PI / 1024 + small);
      EXPECT_NEAR(width * (c >> 24U), static_cast<double>(meadow.width[i]), width / 2 + small);
      if (meadow.attached[i] < 0) {
        EXPECT_EQ(d & 0x3ffU, 0U);
        EXPECT_EQ(d >> 19U, 0U);
      } else {
        EXPECT_NEAR(((d & 0x3ffU) - 1) / 1022.0, static_cast<double>(meadow.attached[i]), 0.5 / 1022 + small);
        const std::size_t stem = i - (d >> 19U);
        ASSERT_LT(stem, i);
        EXPECT_EQ(meadow.species.kinds[meadow.kind[stem]].form, BladeForm::stem);
        EXPECT_EQ(meadow.x[stem], meadow.x[i]);
      }
      EXPECT_EQ(d >> 10U & 7U, meadow.kind[i]);
      EXPECT_EQ(d >> 13U & 15U, meadow.trajectory[i]);
      EXPECT_EQ(d >> 17U & 3U, meadow.frequency_class[i]);
    }
  }
}

TEST(EncodeGrass, ResponsesAndBendsDecodeToWithinHalfAStep) {
  const GrassInWind grass = some_grass("wheat");
  const PageBlock block("TRMG", encode_grass(grass, {}));
  const auto& kinds = block.head["kinds"];
  ASSERT_EQ(kinds.size(), grass.bends.size());
  const std::size_t of_a_make = 2 * static_cast<std::size_t>(grass.loop.sample_count * grass.plane.columns);
  const std::size_t responses = block.head["responses"]["count"], entries = block.head["bends"]["count"];
  const auto angles = block.values<std::int16_t>("responses", of_a_make * responses);
  const auto directions = block.values<std::int16_t>("bends", 12 * entries);
  std::size_t moving = 0;
  for (std::size_t k = 0; k < kinds.size(); ++k) {
    for (std::size_t c = 0; c < frequency_classes; ++c) {
      const auto& make = kinds[k]["makes"][c];
      const GrassInWind::Follows& follows = grass.follows[k * frequency_classes + c];
      const int response = make["response"];
      EXPECT_EQ(response < 0, follows.angle.empty());
      if (response < 0) continue;
      ++moving;
      EXPECT_EQ(make["lean_rad"].get<float>(), follows.lean);
      EXPECT_EQ(make["per_length"].get<float>(), follows.per_length);
      const double step = make["step_rad"];
      EXPECT_LT(step, 1e-4);
      for (std::size_t j = 0; j < of_a_make; ++j) {
        EXPECT_NEAR(step * angles[static_cast<std::size_t>(response) * of_a_make + j],
                    static_cast<double>(follows.angle[j / 2][j % 2]), 0.501 * step);
      }
    }
    const BendTable& table = grass.bends[k];
    const std::size_t first = kinds[k]["bends"]["first"];
    EXPECT_EQ(kinds[k]["bends"]["in_plane"], table.in_plane);
    EXPECT_EQ(kinds[k]["bends"]["across"], table.across);
    for (std::size_t j = 0; j < 12 * table.directions.size(); ++j) {
      EXPECT_NEAR(directions[12 * first + j] / 32767.0, static_cast<double>(table.directions[j / 12][j % 12]),
                  0.51 / 32767);
    }
  }
  EXPECT_EQ(moving, responses);
  EXPECT_EQ(block.head["field"]["samples"], grass.loop.sample_count);
  EXPECT_EQ(block.head["field"]["columns"], grass.plane.columns);
}

TEST(EncodeGrass, TheSkinsAreThoseThatThePoseDresses) {
  const GrassInWind grass = some_grass("rice");
  const PageBlock block("TRMG", encode_grass(grass, {}));
  std::vector<std::size_t> blades(grass.bends.size(), 0);
  for (const std::uint8_t kind : grass.meadow.kind) ++blades[kind];
  std::size_t vertices = 0;
  for (std::size_t k = 0; k < blades.size(); ++k) {
    const auto& kind = block.head["kinds"][k];
    EXPECT_EQ(kind["skin"]["vertices"].size(), grass.vertex_count[k]);
    vertices += blades[k] * kind["skin"]["vertices"].size();
    double sum = 0;
    for (const double share : kind["shares"]) sum += share;
    EXPECT_NEAR(sum, 1, 1e-6);
    for (const std::size_t corner : kind["skin"]["triangles"]) EXPECT_LT(corner, grass.vertex_count[k]);
  }
  EXPECT_EQ(vertices, grass.all_vertices);
}

TEST(EncodeGrass, GivesTheSameBytesOnAnyThreads) {
  const std::string bytes = encode_grass(some_grass("meadow"), {});
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(encode_grass(some_grass("meadow"), {}), bytes);
}

std::string refusal(const GrassInWind& grass) {
  try {
    encode_grass(grass, {});
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(EncodeGrass, RefusesWhatAPageCannotHold) {
  GrassInWind grass = some_grass("meadow");
  grass.way = GrassMotion::in_time;
  EXPECT_THAT(refusal(grass), HasSubstr("blades that look their motion up"));
  grass.way = GrassMotion::looked_up;
  grass.meadow.length[3] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(refusal(grass), HasSubstr("page: blades"));
  grass = some_grass("meadow");
  grass.meadow.species.kinds.resize(9, grass.meadow.species.kinds[0]);
  EXPECT_THAT(refusal(grass), HasSubstr("kinds of blades of the page"));
  EXPECT_NO_THROW(check_blades_of_page(most_blades_of_page));
  EXPECT_THROW(check_blades_of_page(most_blades_of_page + 1), InputError);
}

TEST(EncodeGrassPage, HoldsTheNameAndNoMarks) {
  if (!can_write_html()) GTEST_SKIP() << "built without node and npm";
  const std::string html = encode_grass_page(some_grass("meadow"), {.name = "a <lawn>"});
  EXPECT_THAT(html, HasSubstr("<title>a &lt;lawn></title>"));
  EXPECT_EQ(html.find("@TREMULA_"), std::string::npos);
}

}  // namespace
}  // namespace tremula
