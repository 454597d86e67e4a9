// Clips with a beginning and an end: what is pulled and let go, and what stands in a wind that changes.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <span>
#include <utility>

#include "tremula/base/error.hpp"
#include "tremula/deformation/bent_pose.hpp"
#include "tremula/deformation/fit_rig.hpp"
#include "tremula/deformation/loop.hpp"
#include "tremula/deformation/morph_targets.hpp"
#include "tremula/geometry/grow.hpp"
#include "tremula/geometry/lsystem.hpp"
#include "tremula/geometry/plants.hpp"
#include "tremula/pipeline.hpp"
#include "tremula/reference/large_motion.hpp"

namespace tremula {
namespace {

Skeleton preset(const char* name) { return grow(parse_lsystem(find_preset(name).text, name)).skeleton; }

Weather calm() {
  Weather weather;
  weather.wind = turbulent_wind({.speed = 0}, 0);
  return weather;
}

Weather gust_over(double base, const OneMinusCosine& gust, const TimeAxis& axis) {
  Weather weather;
  weather.loop = axis;
  weather.script = GustScript{.rows = {{0, base, 0}}, .gust = gust};
  weather.wind = turbulent_wind({.speed = mean_of(*weather.script, axis).speed}, 0);
  return weather;
}

TEST(Clip, PullAndReleaseFindsTheModesOfSaplingAndOakAgain) {
  for (const auto& [name, force] : {std::pair{"sapling", "1.3m:10N"}, std::pair{"oak", "1.3m:2kN"}}) {
    const Skeleton skeleton = preset(name);
    const Subject subject = bake(skeleton, {.modes = {.count = 20}});
    for (const double heading : {0.0, 45.0}) {
      Weather weather = calm();
      weather.pull = place_pull(skeleton, force, heading);
      const Motion motion = set_in_motion(subject, weather);
      EXPECT_FALSE(motion.repeats);
      ASSERT_TRUE(motion.pull && motion.pull->of_mode) << name;
      const PullTest& test = *motion.pull;
      const double ratio = test.of_structure + test.of_medium;
      EXPECT_NEAR(test.of_mode->frequency, test.frequency, 0.01 * test.frequency) << name;
      EXPECT_NEAR(test.of_mode->damping_ratio, ratio, 0.05 * ratio) << name;
      EXPECT_GT(test.of_mode->cycles, 5) << name;
      std::printf("%s pulled to %g: %.4f Hz (%.4f), damping %.4f (%.4f), %.0f %% of the energy in mode %d\n",
                  name, heading, test.of_mode->frequency, test.frequency, test.of_mode->damping_ratio, ratio,
                  100 * test.energy, test.mode + 1);
    }
  }
}

TEST(Clip, APullInWindDiesFasterByWhatTheWindDamps) {
  const Skeleton skeleton = preset("sapling");
  const Subject subject = bake(skeleton, {.modes = {.count = 20}});
  Weather weather = calm();
  weather.wind = turbulent_wind({.speed = 5}, 0);
  weather.pull = place_pull(skeleton, "1.3m:10N", 0);
  const PullTest test = set_in_motion(subject, weather).pull.value();
  EXPECT_GT(test.of_medium, 0.02);
  ASSERT_TRUE(test.of_mode);
  const double ratio = test.of_structure + test.of_medium;
  EXPECT_NEAR(test.of_mode->frequency, test.frequency, 0.02 * test.frequency);
  EXPECT_NEAR(test.of_mode->damping_ratio, ratio, 0.1 * ratio);
}

TEST(Clip, FromRestTheFirstFrameIsThePlantAtRest) {
  const Skeleton skeleton = preset("sapling");
  const Subject subject = bake(skeleton, {.modes = {.count = 10}});
  Weather weather = gust_over(5, {4, 1, 0.5}, {.period = 2, .sample_count = 30});
  weather.from_rest = true;
  Motion motion = set_in_motion(subject, weather);
  EXPECT_FALSE(motion.repeats);
  const Loop clip = make_loop(subject.structure, mesh_surface(skeleton), motion, {});
  EXPECT_FALSE(clip.repeats);
  EXPECT_LT(clip.nodes_at(0).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_GT(clip.nodes_at(1).topRows<3>().cwiseAbs().maxCoeff(), 0.01);
}

TEST(Clip, StandsAsInItsLastFrameBehindItsEndInEveryForm) {
  const Skeleton skeleton = preset("sapling");
  const Subject subject = bake(skeleton, {.modes = {.count = 10}});
  const TimeAxis axis{.period = 2, .sample_count = 30};
  Weather weather = gust_over(3, {6, 1.8, 0.5}, axis);
  const Motion motion = set_in_motion(subject, weather);
  const double last_time = axis.period * 29 / 30;
  EXPECT_EQ(displacement_at(motion, 2), displacement_at(motion, last_time));
  EXPECT_EQ(displacement_at(motion, 7), displacement_at(motion, last_time));
  EXPECT_EQ(displacement_at(motion, -1), displacement_at(motion, 0));
  EXPECT_GT((displacement_at(motion, 2) - displacement_at(motion, 0)).norm(), 1e-3);

  const Surface surface = mesh_surface(skeleton);
  Loop clip = make_loop(subject.structure, surface, motion, {});
  const MorphTargets morphs = make_morph_targets(clip, MorphForm::biased);
  const std::size_t end = morphs.key_count() - 1;
  for (std::size_t t = 0; t < morphs.target_count(); ++t)
    EXPECT_EQ(morphs.weight(end, t), morphs.weight(end - 1, t)) << t;

  const ClipSource source{"clip", &motion, 5};
  const Rig rig = fit_rig(subject.structure, surface, std::span(&source, 1), {.tolerance = 0.01});
  EXPECT_FALSE(rig.clips[0].repeats);
  EXPECT_LE(rig.largest_error, 0.01);
  const auto at_end = skin_on_rig(rig, rig.clips[0], surface, 2),
             long_after = skin_on_rig(rig, rig.clips[0], surface, 9);
  EXPECT_EQ(at_end, long_after);

  clip.instances[0].time_shift = 0.5;
  EXPECT_THROW(make_morph_targets(clip, MorphForm::biased), InputError);
}

// The whole tree in time, which bends and turns as far as it likes, in the same gust.
TEST(Clip, AGustOnTheSaplingIsThatOfTheTreeThatBendsAsFarAsItLikes) {
  const Skeleton skeleton = preset("sapling");
  const Subject subject = bake(skeleton, {.modes = {.count = 40}});
  const BeamTree& tree = *subject.structure.tree;
  std::size_t tip = 0;
  for (std::size_t k = 0; k < tree.members.size(); ++k)
    if (tree.members[k].point(1).z() > tree.members[tip].point(1).z()) tip = k;
  const TimeAxis axis{.period = 6, .sample_count = 180};
  struct Case {
    double base, amplitude;
    bool from_rest;
    double limit;
  };
  for (const auto& [base, amplitude, from_rest, limit] :
       {Case{4, 6, false, 0.03}, Case{4, 6, true, 0.03}, Case{8, 12, false, 0.03}, Case{8, 12, true, 0.03}}) {
    Weather weather = gust_over(base, {amplitude, 2, 1}, axis);
    weather.from_rest = from_rest;
    weather.damping = {.ratio = 0.05};
    const Motion motion = set_in_motion(subject, weather);
    const BentLean lean = bend_lean(subject.structure, motion);

    const auto mean_wind = [&](const Vec3& place) { return weather.wind.statistics(place).mean; };
    const WindAt in_mean = [&](Eigen::Index, const Vec3& place) {
      return GustStatistics{mean_wind(place), Mat3::Zero()};
    };
    const double speed = weather.wind.reference.speed;
    const Lean found = find_lean(subject.structure, in_mean, weather.loads, weather.lean);
    const WeightAndDrag outside{
        .leaves = tree.blades,
        .leaf_drag_coefficient =
            [&](double at) {
              return weather.loads.leaf_drag_coefficient * folding_factor(weather.loads.foliage, at);
            },
        .wind = [&](std::size_t site, double time, const Vec3& place) -> Vec3 {
          return found.loads.sites[site].gust_share *
                 (change_of_wind(wind_at_time(*weather.script, time), speed, 0) * mean_wind(place));
        }};
    // As it stands in the first wind.
    const WindAt first_wind = [&](Eigen::Index, const Vec3& place) {
      return GustStatistics{
          Vec3(change_of_wind(wind_at_time(*weather.script, 0), speed, 0) * mean_wind(place)), Mat3::Zero()};
    };
    const Eigen::VectorXd straight = Eigen::VectorXd::Zero(tree.size());
    WeightAndDrag weight = outside;
    weight.fluid_density = 0;
    const std::vector<BentBranch> given = bend(tree, straight);
    const double frequency = subject.modes.frequency[0], step = 0.01;
    const LargeMotionSettings settings{
        .step = step,
        .step_count = 590,
        .high_frequency_radius = 0.8,
        .damping = rayleigh_damping(0.05, frequency, 4 * frequency),
        .at_rest = forces_on_strains(tree, straight, given,
                                     sum_wrenches(tree, given, loads_at_rest(tree, weight)).at_end),
        .strains = from_rest ? straight
                             : find_lean(subject.structure, first_wind, weather.loads, weather.lean).strains,
        .tolerance = 1e-7};
    double difference = 0, size = 0, largest = 0, largest_there = 0;
    integrate_large_motion(tree, outside, settings, [&](int at, const LargeMotionState& state) {
      const double here = bent_at(lean, motion, at * step)[tip].end.x() - tree.members[tip].point(1).x();
      const double there = state.bent[tip].end.x() - tree.members[tip].point(1).x();
      difference += (here - there) * (here - there);
      size += there * there;
      largest = std::max(largest, here);
      largest_there = std::max(largest_there, there);
    });
    const double relative = std::sqrt(difference / size);
    EXPECT_LT(relative, limit) << base << ' ' << from_rest;
    EXPECT_NEAR(largest, largest_there, limit * largest_there) << base << ' ' << from_rest;
    std::printf(
        "%g + %g m/s %s: the tip goes %.4f m at most, %.4f m by large motion; the difference is %.1f %% "
        "rms\n",
        base, amplitude, from_rest ? "from rest" : "about the lean", largest, largest_there, 100 * relative);
  }
}

}  // namespace
}  // namespace tremula
