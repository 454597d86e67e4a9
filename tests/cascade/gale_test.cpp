// Presets in winds up to a gale: what must hold of every one of them.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tremula/deformation/bent_pose.hpp"
#include "tremula/geometry/grow.hpp"
#include "tremula/geometry/lsystem.hpp"
#include "tremula/geometry/plants.hpp"
#include "tremula/pipeline.hpp"

namespace tremula {
namespace {

Skeleton grown(const std::string& name) { return grow(parse_lsystem(find_preset(name).text, name)).skeleton; }

Wind constant_wind(double speed) {
  return turbulent_wind({.speed = speed, .profile = ProfileKind::constant}, 0.2);
}

double drag_on(const Structure& structure, double speed) {
  const Wind wind = constant_wind(speed);
  const WindAt at = [&](Eigen::Index, const Vec3& place) { return wind.statistics(place); };
  return mean_drag(find_lean(structure, at, {}).loads).x();
}

class InAGale : public testing::TestWithParam<const char*> {};

TEST_P(InAGale, NoBranchGrowsLongerAndNothingSinksIntoTheGround) {
  const Skeleton skeleton = grown(GetParam());
  const Subject subject = bake(skeleton, {.modes = {.count = 8}});
  Weather weather;
  weather.wind = constant_wind(30);
  weather.loop = {.period = 10, .sample_count = 10};
  const Motion motion = set_in_motion(subject, weather);
  const BentLean lean = bend_lean(subject.structure, motion);
  for (int p = 0; p < motion.sample_count(); ++p) {
    const std::vector<BentBranch> bent = bent_at(lean, motion, p * motion.period / motion.sample_count());
    double longest = 0, lowest = 0;
    for (std::size_t k = 0; k < bent.size(); ++k) {
      const Member& member = subject.structure.members[k];
      longest = std::max(longest, (bent[k].end - bent[k].start).norm() / member.beam.length);
      if (member.point(1).z() > 0) lowest = std::min(lowest, bent[k].end.z());
    }
    EXPECT_LT(longest, 1.001) << p;
    EXPECT_GE(lowest, 0) << p;
  }
}

INSTANTIATE_TEST_SUITE_P(Presets, InAGale, testing::Values("sapling", "oak", "birch", "willow", "bamboo"),
                         [](const auto& preset) { return preset.param; });

class LeafyCrown : public testing::TestWithParam<const char*> {};

TEST_P(LeafyCrown, HasADragThatGrowsWithLessThanTheSquareOfTheWind) {
  const Structure structure = assemble(grown(GetParam()), {});
  const double exponent = std::log(drag_on(structure, 20) / drag_on(structure, 6)) / std::log(20.0 / 6);
  EXPECT_GT(exponent, 1.2);
  EXPECT_LT(exponent, 1.9);
}

INSTANTIATE_TEST_SUITE_P(Presets, LeafyCrown, testing::Values("sapling", "oak", "birch", "willow"),
                         [](const auto& preset) { return preset.param; });

// Angelou, Dellwik & Mann 2019, Agric. For. Meteorol.: an open-grown oak, 2 to 3 times.
TEST(LeafyCrown, OfAnOakBearsTwoToThreeTimesTheDragOfTheBareOne) {
  Skeleton skeleton = grown("oak");
  const double in_leaf = drag_on(assemble(skeleton, {}), 6);
  skeleton.leaves.clear();
  const double bare = drag_on(assemble(skeleton, {}), 6);
  EXPECT_GT(in_leaf / bare, 1.9);
  EXPECT_LT(in_leaf / bare, 3);
}

}  // namespace
}  // namespace tremula
