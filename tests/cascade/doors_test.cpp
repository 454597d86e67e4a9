// What a program may hand over by mistake: an error that says what is wrong, and no crash.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "complaint.hpp"
#include "trees.hpp"
#include "tremula/base/error.hpp"
#include "tremula/pipeline.hpp"

namespace tremula {
namespace {

using test::complaint_of;

TEST(Bake, RefusesSkeletonsThatAreNone) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const struct {
    std::function<void(Skeleton&)> spoil;
    const char* message;
  } cases[] = {
      {[](Skeleton& s) { s = {}; }, "no root"},
      {[](Skeleton& s) { s.branches.clear(); }, "no branch"},
      {[](Skeleton& s) { s.roots.clear(); }, "no root"},
      {[](Skeleton& s) { s.branches[3].start_radius = -0.01; }, "branch 3: start radius is -0.01"},
      {[&](Skeleton& s) { s.branches[3].end_radius = nan; }, "branch 3: end radius is nan"},
      {[&](Skeleton& s) { s.branches[2].end.y() = nan; }, "branch 2: end y is nan"},
      {[](Skeleton& s) { s.branches[4].start_node = -5; }, "branch 4: start node is -5"},
      {[](Skeleton& s) { s.branches[4].start_node = 400; }, "branch 4: start node is 400"},
      {[](Skeleton& s) { s.leaves[0].branch = 9999; }, "leaf 0: branch is 9999"},
      {[](Skeleton& s) { s.leaves[0].position = 3; }, "leaf 0: position is 3"},
      {[](Skeleton& s) { s.branches[1].start_radius = s.branches[1].end_radius = 1e100; },
       "branch 1: a compliance"},
  };
  Skeleton good = test::random_tree(6, 2);
  Leaf leaf;
  leaf.branch = 5;
  leaf.length = leaf.width = leaf.area = leaf.mass = 0.01;
  good.leaves.push_back(leaf);
  EXPECT_EQ(complaint_of([&] { bake(good, {.modes = {.count = 3}}); }), "");
  for (const auto& [spoil, message] : cases) {
    Skeleton bad = good;
    spoil(bad);
    EXPECT_THAT(complaint_of([&] { bake(bad, {.modes = {.count = 3}}); }), testing::HasSubstr(message));
    EXPECT_THAT(complaint_of([&] { assemble(bad, {}); }), testing::HasSubstr(message));
  }
}

TEST(Bake, RefusesOptionsThatAreNone) {
  const Skeleton skeleton = test::random_tree(6, 2);
  for (const int count : {0, -7, 1000}) {
    EXPECT_THROW(bake(skeleton, {.modes = {.count = count}}), InputError) << count;
  }
  for (const double tolerance : {0.0, -1.0, static_cast<double>(NAN)}) {
    EXPECT_THROW(bake(skeleton, {.modes = {.count = 3, .tolerance = tolerance}}), InputError) << tolerance;
  }
}

TEST(SetInMotion, RefusesSubjectsWhosePartsDoNotFit) {
  const Subject subject = bake(test::random_tree(6, 2), {.modes = {.count = 3}});
  const Weather weather{.loop = {.period = 2, .sample_count = 16}};
  EXPECT_EQ(set_in_motion(subject, weather).sample_count(), 16);
  EXPECT_THROW(set_in_motion(Subject{}, weather), InputError);
  Subject bad = subject;
  bad.structure = assemble(test::random_tree(7, 2), {});
  EXPECT_THAT(complaint_of([&] { set_in_motion(bad, weather); }),
              testing::HasSubstr("rows of the mode shapes: 36, wanted 42"));
  bad = subject;
  bad.modes = bake(test::random_tree(7, 2), {.modes = {.count = 3}}).modes;
  EXPECT_THAT(complaint_of([&] { set_in_motion(bad, weather); }),
              testing::HasSubstr("rows of the mode shapes: 42, wanted 36"));
  bad = subject;
  bad.modes.frequency.conservativeResize(2);
  EXPECT_THROW(set_in_motion(bad, weather), InputError);
  for (const TimeAxis& loop : {TimeAxis{0, 16}, TimeAxis{NAN, 16}, TimeAxis{2, 0}, TimeAxis{2, -3}}) {
    EXPECT_THROW(set_in_motion(subject, {.loop = loop}), InputError);
  }
}

TEST(WindAtPoints, RefusesNoPointsAndPointsThatAreNowhere) {
  const TimeAxis loop{.period = 2, .sample_count = 16};
  const Wind winds[] = {turbulent_wind({}, 0.2), StamWind{}};
  for (const Wind& wind : winds) {
    EXPECT_THROW(wind_at_points(wind, loop, Eigen::Matrix3Xd(3, 0)), InputError);
    EXPECT_THROW(wind_at_points(wind, loop, Eigen::Matrix3Xd::Constant(3, 2, NAN)), InputError);
    EXPECT_THROW(wind_at_points(wind, {.period = 0, .sample_count = 16}, Eigen::Matrix3Xd::Ones(3, 2)),
                 InputError);
    EXPECT_THROW(wind_at_points(wind, {.period = 2, .sample_count = 0}, Eigen::Matrix3Xd::Ones(3, 2)),
                 InputError);
  }
  EXPECT_THROW(wind_at_points(GivenWind{}, loop, Eigen::Matrix3Xd::Ones(3, 2)), InputError);
}

}  // namespace
}  // namespace tremula
