#include "tremula/io/impression_page.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "io/page_block.hpp"
#include "tremula/base/error.hpp"
#include "tremula/io/html.hpp"
#include "tremula/wind/point_wind.hpp"

namespace tremula {
namespace {

using test::PageBlock;
using ::testing::HasSubstr;

struct Some {
  ImpressionistTree tree = impressionist_tree("pine", 9);
  std::vector<Instance> instances = {{.position = {1, 2, 0.25}, .turn = 0.7, .scale = 1.5},
                                     {.position = {-6, 8, 0}, .turn = 3, .time_shift = 0.4}};
  ImpressionMotion motion;

  Some() {
    std::vector<Vec3> places;
    for (const Instance& at : instances) places.push_back(at.position);
    const Wind wind(turbulent_wind({.speed = 7, .heading = 20}, 0.3));
    const TravellingField gusts = gust_field(wind, TimeAxis{4, 100}, plane_across(places, 20, 2, {6.0}));
    motion.heading = 20;
    for (int i = 0; i <= 8; ++i) {
      const double share = i / 8.0;
      motion.heights.push_back(tree.trunk_height * share);
      motion.lean.emplace_back(0.2 * share * share, 0);
      motion.share.emplace_back(share * share, std::pow(share, 1.7));
    }
    const FieldResponse sway{.along = oscillator_impedance(0.6, 0.08, 0.03),
                             .across = oscillator_impedance(0.6, 0.08, 0.02)};
    motion.sway = std::make_shared<const TravellingField>(respond(gusts, sway));
    motion.tremble = std::make_shared<const TravellingField>(respond(gusts, tremble_response()));
  }
};

std::string encoded(const Some& some) {
  return encode_impressions(some.tree, some.instances, some.motion, {.name = "pines"});
}

// A field of the block, and how it is looked up there: for a reader of the description in the header.
float read_top(const PageBlock& block, const std::vector<std::int16_t>& sway, const Vec3& foot, double time,
               std::size_t k) {
  const auto& field = block.head["field"];
  const double heading = field["heading_deg"].get<double>() * std::numbers::pi / 180;
  const int samples = field["samples"], columns = field["columns"];
  const double along = foot.x() * std::cos(heading) + foot.y() * std::sin(heading);
  const double across = foot.y() * std::cos(heading) - foot.x() * std::sin(heading);
  double at = (time - along / field["gust_speed_m_s"].get<double>()) / 4.0 * samples;
  at -= samples * std::floor(at / samples);
  const double column =
      std::clamp((across - field["first_column_m"].get<double>()) / field["spacing_m"].get<double>(), 0.0,
                 columns - 1.0);
  const int p = static_cast<int>(at), c = std::min(static_cast<int>(column), columns - 2);
  const auto value = [&](int sample, int of) {
    return static_cast<double>(sway[2 * static_cast<std::size_t>(sample % samples * columns + of) + k]);
  };
  const double t = at - p, w = column - c;
  return static_cast<float>(block.head["sway"]["step_m"].get<double>() *
                            ((1 - t) * ((1 - w) * value(p, c) + w * value(p, c + 1)) +
                             t * ((1 - w) * value(p + 1, c) + w * value(p + 1, c + 1))));
}

TEST(EncodeImpressions, HoldsTheSwayOfEveryTopToAStep) {
  const Some some;
  const PageBlock block("TRMI", encoded(some));
  const std::size_t count = block.head["sway"]["count"];
  ASSERT_EQ(count, some.motion.sway->values.size());
  const auto sway = block.values<std::int16_t>("sway", 2 * count);
  const double step = block.head["sway"]["step_m"];
  EXPECT_GT(step, 0);
  double most = 0;
  for (const double time : {0.0, 1.37, 3.9}) {
    for (const Instance& at : some.instances) {
      const Eigen::Vector2f top = top_of(some.motion, at, time);
      for (int k = 0; k < 2; ++k) {
        const auto read =
            read_top(block, sway, at.position, time + at.time_shift, static_cast<std::size_t>(k));
        EXPECT_NEAR(read, top[k], step);
        most = std::max(most, std::abs(static_cast<double>(top[k])));
      }
    }
  }
  EXPECT_GT(most, 1000 * step) << "nothing sways here";
}

TEST(EncodeImpressions, HoldsCopiesTrunkAndPaintAsTheyAre) {
  const Some some;
  const PageBlock block("TRMI", encoded(some));
  const auto copies = block.values<std::array<float, 8>>("copies", 2);
  for (std::size_t i = 0; i < 2; ++i) {
    const Instance& at = some.instances[i];
    const std::array<double, 8> wanted{
        at.position.x(),   at.position.y(),   at.position.z(), at.scale,
        std::cos(at.turn), std::sin(at.turn), at.time_shift,   static_cast<double>(texture_shift(i))};
    for (std::size_t k = 0; k < 8; ++k) EXPECT_EQ(copies[i][k], static_cast<float>(wanted[k]));
  }
  const TrunkCurve curve = trunk_curve(some.motion);
  ASSERT_EQ(block.head["curve"]["knots"].size(), curve.knots.size());
  for (std::size_t i = 0; i < curve.knots.size(); ++i) {
    for (std::size_t k = 0; k < 4; ++k)
      EXPECT_EQ(block.head["curve"]["knots"][i][k].get<float>(), curve.knots[i][static_cast<int>(k)]);
  }
  const std::vector<Quadric> quadrics = quadrics_of(some.tree);
  ASSERT_EQ(block.head["paint"].size(), quadrics.size());
  for (std::size_t q = 0; q < quadrics.size(); ++q) {
    const QuadricPaint paint = paint_of(quadrics[q], q, some.tree.seed);
    const auto& told = block.head["paint"][q];
    for (std::size_t i = 0; i < 9; ++i) {
      const auto row = static_cast<int>(i / 3), column = static_cast<int>(i % 3);
      EXPECT_EQ(told["turn"][i].get<float>(), paint.turn(row, column));
      EXPECT_EQ(told["root"][i].get<float>(), paint.root(row, column));
    }
  }
  const ImpressionMesh mesh = mesh_for_page(some.tree, 2);
  const auto positions = block.values<std::array<float, 3>>("positions", mesh.positions.size());
  for (std::size_t i = 0; i < positions.size(); ++i)
    EXPECT_EQ(Eigen::Vector3f::Map(positions[i].data()), mesh.positions[i]);
  EXPECT_EQ(block.values<std::uint32_t>("triangles", mesh.triangles.size()), mesh.triangles);
  EXPECT_EQ(block.values<std::uint32_t>("quadrics", mesh.quadric.size()), mesh.quadric);
}

TEST(EncodeImpressions, IsOfTreesThatStandStillWhereNothingMovesThem) {
  const Some some;
  const PageBlock block("TRMI", encode_impressions(some.tree, some.instances, {}, {}));
  EXPECT_EQ(block.head["field"]["samples"], 1);
  EXPECT_TRUE(block.head["curve"]["knots"].empty());
  EXPECT_EQ(block.values<std::int16_t>("sway", 2), std::vector<std::int16_t>(2, 0));
}

TEST(MeshForPage, IsTheCoarserTheMoreTreesThereAreAndRefusesTooMany) {
  const ImpressionistTree tree = impressionist_tree("oak", 12);
  const std::size_t one = mesh_for_page(tree, 1).triangles.size(),
                    many = mesh_for_page(tree, 2000).triangles.size();
  EXPECT_GT(one, 2 * many);
  const std::size_t most = most_triangles_of_impressions / (many / 3);
  EXPECT_NO_THROW(mesh_for_page(tree, most));
  try {
    mesh_for_page(tree, most + 1);
    ADD_FAILURE() << "too many trees";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("at most " + std::to_string(most) + " such trees"));
  }
  EXPECT_THROW(mesh_for_page(tree, 0), InputError);
}

TEST(EncodeImpressions, RefusesWhatIsNotFiniteAndFieldsThatDoNotBelongTogether) {
  Some some;
  auto field = std::make_shared<TravellingField>(*some.motion.sway);
  field->values[7][1] = std::numeric_limits<float>::quiet_NaN();
  some.motion.sway = field;
  EXPECT_THROW(encoded(some), Error);
  some = Some();
  field = std::make_shared<TravellingField>(*some.motion.tremble);
  field->plane.first_column += 1;
  some.motion.tremble = field;
  EXPECT_THROW(encoded(some), InputError);
  some = Some();
  some.instances[0].scale = 0;
  EXPECT_THROW(encoded(some), InputError);
  some = Some();
  some.motion.lean.pop_back();
  EXPECT_THROW(encoded(some), InputError);
}

TEST(EncodeImpressionsPage, HoldsTheNameAndNoMarks) {
  if (!can_write_html()) GTEST_SKIP() << "built without node and npm";
  const Some some;
  const std::string html =
      encode_impressions_page(some.tree, some.instances, some.motion, {.name = "a <wood>"});
  EXPECT_THAT(html, HasSubstr("<title>a &lt;wood></title>"));
  EXPECT_EQ(html.find("@TREMULA_"), std::string::npos);
}

}  // namespace
}  // namespace tremula
