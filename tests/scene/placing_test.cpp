#include "tremula/scene/placing.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "complaint.hpp"
#include "tremula/base/error.hpp"

namespace tremula {
namespace {

using testing::HasSubstr;

constexpr double turn_round = 2 * std::numbers::pi;

Scatter field(double density, double half_width) {
  Scatter scatter;
  scatter.density = density;
  scatter.low = {-half_width, -half_width};
  scatter.high = {half_width, half_width};
  return scatter;
}

Crowd scattered(const Scatter& scatter) { return {.scatters = {scatter}}; }

std::vector<Instance> placed(const Crowd& crowd) { return place_instances(crowd, Vec3::Zero(), 20); }

// ---- Grids

TEST(PlaceInstances, OfAGridStandInRowsAboutItsCentre) {
  Grid grid;
  grid.columns = 4;
  grid.rows = 3;
  grid.spacing = {5, 7};
  grid.centre = {100, -50, 2};
  const std::vector<Instance> copies = placed({.grids = {grid}});
  ASSERT_EQ(copies.size(), 12U);
  Vec3 mean = Vec3::Zero();
  for (const Instance& copy : copies) mean += copy.position / 12;
  EXPECT_LT((mean - grid.centre).norm(), 1e-12);
  EXPECT_EQ(copies[1].position - copies[0].position, Vec3(5, 0, 0));
  EXPECT_EQ(copies[4].position - copies[0].position, Vec3(0, 7, 0));
}

TEST(PlaceInstances, OfAGridAreOffByItsJitterAtMost) {
  Grid grid, straight;
  grid.columns = straight.columns = grid.rows = straight.rows = 30;
  grid.jitter = 0.3;
  const std::vector<Instance> copies = placed({.grids = {grid}}), places = placed({.grids = {straight}});
  double largest = 0;
  for (std::size_t i = 0; i < copies.size(); ++i)
    largest = std::max(largest, (copies[i].position - places[i].position).cwiseAbs().maxCoeff());
  EXPECT_LE(largest, 3.0);
  EXPECT_GT(largest, 2.9) << "of 1800 uniform numbers one is nearly as far as they go";
}

TEST(PlaceInstances, WithoutARuleIsOneAtTheOrigin) {
  const std::vector<Instance> copies = placed({});
  ASSERT_EQ(copies.size(), 1U);
  EXPECT_EQ(copies[0].position, Vec3(0, 0, 0));
  EXPECT_EQ(copies[0].time_shift, 0);
}

// ---- Scatters

TEST(PlaceInstances, ScatteredAreAsManyAsTheDensitySaysAndEverywhereAlike) {
  const std::vector<Instance> copies = placed(scattered(field(0.1, 200)));
  ASSERT_EQ(copies.size(), 16'000U);
  // Counts of 10 x 10 cells: chi squared of 99 degrees of freedom has the mean 99 and the deviation 14.1.
  std::vector<int> counts(100);
  for (const Instance& copy : copies) {
    const auto cell = [](double x) { return static_cast<std::size_t>((x + 200) / 40); };
    ++counts[cell(copy.position.x()) + 10 * cell(copy.position.y())];
  }
  double chi_squared = 0;
  for (const int count : counts) chi_squared += (count - 160.0) * (count - 160.0) / 160;
  EXPECT_NEAR(chi_squared, 99, 4 * 14.1);
}

TEST(PlaceInstances, ScatteredHaveTheirDensityInsideTheMasksAndNoneOutside) {
  Scatter scatter = field(0.1, 100);
  scatter.inside = {{{-90, -90}, {90, -90}, {0, 60}}, {{40, 40}, {90, 40}, {90, 90}, {40, 90}}};
  scatter.outside = {{{-10, -50}, {10, -50}, {10, -30}, {-10, -30}}};
  const double area = 180 * 150 / 2.0 + 50 * 50 - 20 * 20;
  double count = 0;
  constexpr int seeds = 10;
  for (int seed = 1; seed <= seeds; ++seed) {
    scatter.seed = static_cast<std::uint64_t>(seed);
    for (const Instance& copy : placed(scattered(scatter))) {
      const double x = copy.position.x(), y = copy.position.y();
      const bool in_triangle = y > -90 && y < -90 + (90 - std::abs(x)) * 150 / 90;
      const bool in_square = x > 40 && x < 90 && y > 40 && y < 90;
      const bool in_hole = std::abs(x) < 10 && y > -50 && y < -30;
      EXPECT_TRUE((in_triangle || in_square) && !in_hole) << x << ", " << y;
      ++count;
    }
  }
  // Every slot of the box around the masks is kept with the probability that the masks leave.
  const double box = 180.0 * 180, share = area / box, slots = seeds * 0.1 * box;
  EXPECT_NEAR(count, slots * share, 4 * std::sqrt(slots * share * (1 - share)));
}

double smallest_distance(const std::vector<Instance>& some, const std::vector<Instance>& others) {
  double smallest = std::numeric_limits<double>::infinity();
  for (const Instance& a : some) {
    for (const Instance& b : others) {
      if (&a != &b) smallest = std::min(smallest, (a.position - b.position).head<2>().norm());
    }
  }
  return smallest;
}

TEST(PlaceInstances, ScatteredKeepTheirDistanceAndTheirNumber) {
  Scatter scatter = field(0.01, 250);
  scatter.distance = 7.5;  // 44 % covered
  const std::vector<Instance> copies = placed(scattered(scatter));
  EXPECT_GE(smallest_distance(copies, copies), 7.5);
  EXPECT_EQ(copies.size(), 2500U) << "all found room";
}

TEST(PlaceObjects, ScatteredKeepTheirDistanceFromAllThatIsPlacedBefore) {
  std::vector<SceneObject> objects(3);
  objects[0].crowd.instances = {{.position = {0, 0, 0}}, {.position = {30, 10, 0}}};
  Scatter scatter = field(0.004, 100);
  scatter.distance = 6;
  objects[1].crowd = objects[2].crowd = scattered(scatter);
  const auto copies = place_objects(objects, Vec3::Zero(), 0);
  ASSERT_EQ(copies.size(), 3U);
  EXPECT_GE(smallest_distance(copies[1], copies[0]), 6);
  EXPECT_GE(smallest_distance(copies[2], copies[0]), 6);
  EXPECT_GE(smallest_distance(copies[2], copies[1]), 6);
  EXPECT_GE(smallest_distance(copies[2], copies[2]), 6);
  EXPECT_EQ(copies[1].size(), 160U);
  EXPECT_NE(copies[1][0].position, copies[2][0].position) << "objects of one seed draw numbers of their own";
}

TEST(PlaceInstances, AreTheSameForTheSameSeedAndOthersForAnother) {
  Scatter scatter = field(0.01, 100);
  scatter.turn = {0, turn_round};
  scatter.scale = {0.5, 2};
  scatter.random_shift = 5;
  const auto equal = [](const Instance& a, const Instance& b) {
    return a.position == b.position && a.turn == b.turn && a.scale == b.scale && a.time_shift == b.time_shift;
  };
  const std::vector<Instance> first = placed(scattered(scatter)), again = placed(scattered(scatter));
  ASSERT_EQ(first.size(), again.size());
  EXPECT_TRUE(std::equal(first.begin(), first.end(), again.begin(), equal));
  scatter.seed = 2;
  EXPECT_FALSE(equal(first[0], placed(scattered(scatter))[0]));
}

TEST(PlaceInstances, DifferAsMuchAsTheirRuleSays) {
  Scatter scatter = field(0.1, 150);
  scatter.scale = {0.5, 2};
  scatter.turn = {-1, 2};
  scatter.random_shift = 3;
  const std::vector<Instance> copies = place_instances(scattered(scatter), Vec3::Zero(), 20);
  const auto count = static_cast<double>(copies.size());
  double scale = 0, turn = 0, shift = 0, square = 0;
  for (const Instance& copy : copies) {
    EXPECT_TRUE(copy.scale >= 0.5 && copy.scale <= 2 && copy.turn >= -1 && copy.turn <= 2);
    const double about_zero = copy.time_shift > 10 ? copy.time_shift - 20 : copy.time_shift;
    EXPECT_LE(std::abs(about_zero), 3);
    scale += copy.scale / count;
    turn += copy.turn / count;
    shift += about_zero / count;
    square += about_zero * about_zero / count;
  }
  // Uniform numbers of width w have the deviation w / sqrt(12), their mean that over sqrt(count).
  const auto tolerance = [&](double width) { return 4 * width / std::sqrt(12 * count); };
  EXPECT_NEAR(scale, 1.25, tolerance(1.5));
  EXPECT_NEAR(turn, 0.5, tolerance(3));
  EXPECT_NEAR(shift, 0, tolerance(6));
  EXPECT_NEAR(square, 3, 4 * std::sqrt((81.0 / 5 - 9) / count));
}

TEST(PlaceInstances, OfAScatterTakeLessThanATenthOfASecondForTenThousand) {
  Scatter scatter = field(0.01, 500);
  scatter.distance = 6;
  scatter.turn = {0, turn_round};
  scatter.scale = {0.8, 1.2};
  scatter.random_shift = 2;
  const auto begin = std::chrono::steady_clock::now();
  const std::vector<Instance> copies = place_instances(scattered(scatter), {8, 0, 0}, 20);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  EXPECT_EQ(copies.size(), 10'000U);
  EXPECT_LT(seconds, 0.1) << "(several times what it takes on a machine that does nothing else)";
  RecordProperty("milliseconds", std::to_string(1e3 * seconds));
}

TEST(PlaceInstances, OfAThousandMillionAreRefusedWithTheNumberBeforeAnythingIsMade) {
  Grid grid;
  grid.columns = 1'000'000;
  grid.rows = 1000;
  EXPECT_THAT(test::complaint_of([&] { placed({.grids = {grid}}); }),
              HasSubstr("1000000000, wanted at most 10000000"));
  EXPECT_THAT(test::complaint_of([&] { placed(scattered(field(10, 5000))); }), HasSubstr("1000000000"));
}

TEST(PlaceInstances, RefuseWhatIsNoPlace) {
  Scatter scatter = field(0.01, 100);
  scatter.scale = {0, 1};
  EXPECT_NE(test::complaint_of([&] { placed(scattered(scatter)); }), "");
  scatter.scale = {1, std::nan("")};
  EXPECT_NE(test::complaint_of([&] { placed(scattered(scatter)); }), "");
  EXPECT_NE(test::complaint_of([&] { placed({.instances = {{.position = {0, std::nan(""), 0}}}}); }), "");
  EXPECT_NE(test::complaint_of([&] { place_instances({}, {std::nan(""), 0, 0}, 20); }), "");
  scatter = field(0.01, 100);
  scatter.distance = 10;  // 79 % covered
  EXPECT_THAT(test::complaint_of([&] { placed(scattered(scatter)); }), HasSubstr("at most 0.0057"));
}

// ---- Gusts

// When a copy meets what the copy at the origin meets at `time`.
double meets(const Instance& copy, double time, double period) {
  const double when = std::fmod(time - copy.time_shift, period);
  return when < 0 ? when + period : when;
}

TEST(PlaceInstances, AFrontCrossesTheWoodWithTheWindWhereverThatBlows) {
  constexpr double speed = 9, period = 20;
  Scatter scatter = field(0.002, 60);
  scatter.turn = {0, turn_round};
  for (const double heading : {0.0, 0.7, 2.5, -1.2, 4.0}) {
    const Vec3 along(std::cos(heading), std::sin(heading), 0);
    for (const Instance& copy : place_instances(scattered(scatter), speed * along, period)) {
      EXPECT_GE(copy.time_shift, 0);
      EXPECT_LT(copy.time_shift, period);
      const double wanted = 3 + copy.position.dot(along) / speed;  // a front that is at the origin at 3 s
      const double off = std::remainder(meets(copy, 3, period) - wanted, period);
      EXPECT_NEAR(off, 0, 1e-12 * period);
    }
  }
}

TEST(PlaceInstances, WhatStandsDownwindIsLaterAndWhatStandsBesideItIsNot) {
  const Crowd crowd{
      .instances = {{.position = {18, 0, 0}}, {.position = {-18, 0, 0}}, {.position = {0, 50, 0}}}};
  const std::vector<Instance> copies = place_instances(crowd, {9, 0, 0}, 20);
  EXPECT_NEAR(copies[0].time_shift, 20 - 2, 1e-12) << "two seconds behind";
  EXPECT_NEAR(copies[1].time_shift, 2, 1e-12);
  EXPECT_NEAR(copies[2].time_shift, 0, 1e-12);
}

TEST(PlaceInstances, ATimeShiftOfItsOwnComesOnTopAndWithoutTravellingGustsAlone) {
  Crowd crowd{.instances = {{.position = {18, 0, 0}, .time_shift = 5}}};
  EXPECT_NEAR(place_instances(crowd, {9, 0, 0}, 20)[0].time_shift, 3, 1e-12);
  crowd.travelling_gusts = false;
  EXPECT_NEAR(place_instances(crowd, {9, 0, 0}, 20)[0].time_shift, 5, 1e-12);
  crowd.travelling_gusts = true;
  EXPECT_NEAR(place_instances(crowd, Vec3::Zero(), 20)[0].time_shift, 5, 1e-12) << "no wind carries anything";
}

TEST(PlaceInstances, OfAClipHaveNoTimeShifts) {
  Scatter scatter = field(0.01, 50);
  scatter.random_shift = 3;
  const std::vector<Instance> copies = place_instances(scattered(scatter), {9, 0, 0}, 0);
  for (const Instance& copy : copies) EXPECT_EQ(copy.time_shift, 0);
  EXPECT_NO_THROW(check_instances(copies, false));
}

// ---- Headings

TEST(NearestHeading, LetsEveryTurnedCopyBowWithinHalfAStepOfTheWind) {
  for (const int headings : {1, 2, 7, 8, 64}) {
    const double step = turn_round / headings;
    for (double turn = -10; turn < 10; turn += 0.0317) {
      const int k = nearest_heading(turn, headings);
      ASSERT_GE(k, 0);
      ASSERT_LT(k, headings);
      // Made for the wind's heading - k step, then turned.
      EXPECT_LE(std::abs(std::remainder(turn - k * step, turn_round)), step / 2 + 1e-12);
    }
  }
}

TEST(NearestHeading, OfAWholeStepIsExact) {
  for (int k = 0; k < 8; ++k) {
    EXPECT_EQ(nearest_heading(k * turn_round / 8, 8), k);
    EXPECT_EQ(nearest_heading((k - 16) * turn_round / 8, 8), k);
  }
  EXPECT_THROW(nearest_heading(0, 0), InputError);
  EXPECT_THROW(nearest_heading(std::nan(""), 8), InputError);
}

TEST(SplitByHeading, PutsEveryCopyIntoTheListOfItsHeading) {
  Scatter scatter = field(0.01, 100);
  scatter.turn = {0, turn_round};
  const std::vector<Instance> copies = placed(scattered(scatter));
  const auto lists = split_by_heading(copies, 8);
  ASSERT_EQ(lists.size(), 8U);
  std::size_t count = 0;
  for (std::size_t k = 0; k < 8; ++k) {
    count += lists[k].size();
    for (const Instance& copy : lists[k]) EXPECT_EQ(nearest_heading(copy.turn, 8), static_cast<int>(k));
  }
  EXPECT_EQ(count, copies.size());
}

}  // namespace
}  // namespace tremula
