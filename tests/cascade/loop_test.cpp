#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <mutex>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "in_wind.hpp"
#include "trees.hpp"
#include "tremula/base/error.hpp"
#include "tremula/deformation/loop.hpp"
#include "tremula/deformation/pose.hpp"
#include "tremula/dynamics/basis.hpp"
#include "tremula/geometry/grow.hpp"
#include "tremula/geometry/plants.hpp"
#include "tremula/io/pose_table.hpp"
#include "tremula/pipeline.hpp"
#include "tremula/wind/synthesis.hpp"

namespace tremula {
namespace {

Subject sapling() {
  static const Subject subject =
      bake(grow(parse_lsystem(find_preset("sapling").text, "sapling")).skeleton, {.modes = {.count = 12}});
  return subject;
}

const Weather weather{.loop = {8, 96}};

// The coordinates of all that moves: that of the lean, the first, is always 1.
Eigen::MatrixXd moving(const Motion& motion) {
  return motion.coordinates.rightCols(motion.basis.count() - 1);
}

TEST(Loop, ClosesBitForBit) {
  const Subject subject = sapling();
  const Motion motion = set_in_motion(subject, weather);
  EXPECT_EQ(displacement_at(motion, 0), displacement_at(motion, motion.period));
  EXPECT_EQ(displacement_at(motion, 1), displacement_at(motion, 1 + 5 * motion.period));
}

TEST(Loop, HasNoJumpAtTheSeamThatItDoesNotHaveElsewhere) {
  const Subject subject = sapling();
  const Motion motion = set_in_motion(subject, weather);
  const int count = motion.sample_count();
  double largest = 0;
  for (int p = 0; p + 1 < count; ++p) {
    largest = std::max(largest, (motion.coordinates.row(p + 1) - motion.coordinates.row(p)).norm());
  }
  EXPECT_LE((motion.coordinates.row(0) - motion.coordinates.row(count - 1)).norm(), largest);
}

TEST(Loop, AFrameAloneIsTheFrameOfTheWholeToTheLastBit) {
  const Subject subject = sapling();
  const Motion motion = set_in_motion(subject, weather);
  std::vector<int> all(96);
  for (int p = 0; p < 96; ++p) all[static_cast<std::size_t>(p)] = p;
  const Loop loop = make_loop(subject.structure, {}, motion, {});
  const std::string whole = encode_pose_table(loop, all);
  const int one[] = {57};
  const std::string alone = encode_pose_table(loop, one);
  const std::string rows = alone.substr(alone.find('\n') + 1);
  ASSERT_GT(rows.size(), 1000U);
  EXPECT_NE(whole.find(rows), std::string::npos);
}

TEST(Loop, DoesNotDependOnTheNumberOfThreads) {
  const Subject subject = sapling();
  Eigen::MatrixXd coordinates[2];
  for (const std::size_t threads : {std::size_t{1}, std::size_t{2}}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    coordinates[threads - 1] = set_in_motion(subject, weather).coordinates;
  }
  EXPECT_EQ(coordinates[0], coordinates[1]);
}

TEST(Loop, DependsOnTheSeedAndOnNothingElse) {
  const Subject subject = sapling();
  Weather other = weather;
  TurbulentWind gusts = turbulent_wind({}, 0.2);
  gusts.seed = 2;
  other.wind = gusts;
  const Motion first = set_in_motion(subject, weather), again = set_in_motion(subject, weather);
  EXPECT_EQ(first.coordinates, again.coordinates);
  EXPECT_GT((moving(first) - moving(set_in_motion(subject, other))).norm(), 0.1 * moving(first).norm());
}

TEST(Loop, OfStamsWindIsOneToo) {
  const Subject subject = sapling();
  for (const StamRows rows : {StamRows::unit_variance, StamRows::as_printed}) {
    Weather stam = weather;
    stam.wind = StamWind{.rows = rows};
    for (const Transfer transfer : {Transfer::sampled, Transfer::bin_averaged}) {
      stam.transfer = transfer;
      const Motion motion = set_in_motion(subject, stam);
      EXPECT_TRUE(motion.coordinates.allFinite());
      EXPECT_GT(moving(motion).norm(), 0);
      const bool has_mean = moving(motion).colwise().mean().norm() > 1e-9 * moving(motion).norm();
      EXPECT_EQ(has_mean, transfer == Transfer::bin_averaged || rows == StamRows::as_printed);
    }
  }
}

TEST(Loop, OfAGivenFieldRepeatsItsGustsAndHasNoMeanOfItsOwn) {
  const Subject subject = sapling();
  const WindGrid grid{.y_count = 5,
                      .z_count = 6,
                      .step_count = 80,
                      .y_spacing = 1,
                      .z_spacing = 1,
                      .bottom = 0.5,
                      .step = 0.1};
  const auto field =
      std::make_shared<const WindField>(synthesise_wind(turbulent_wind({.speed = 6}, 0.2), grid));
  Weather given = weather;
  given.wind = GivenWind{field};
  std::vector<std::string> warnings;
  const Motion motion = set_in_motion(subject, given, {}, &warnings);
  EXPECT_GT(lean_of(motion.basis).norm(), 0);
  EXPECT_GT(moving(motion).norm(), 0);
  EXPECT_LT(moving(motion).colwise().mean().norm(), 1e-9 * moving(motion).norm());
  EXPECT_THROW(set_in_motion(subject, {.wind = GivenWind{}}), InputError);
}

TEST(Loop, OfFewModesLeansIntoASlowGustAsFarAsAllModesDo) {
  // The static shapes say what the modes left out: the tip's slow motion hardly depends on how many there
  // are.
  const Skeleton skeleton = grow(parse_lsystem(find_preset("sapling").text, "sapling")).skeleton;
  for (const LeanOptions& lean : {test::small_and_free, LeanOptions{}}) {
    const auto spread = [&](int modes, bool correction) {
      Weather slow = weather;
      slow.loop = {600, 10};  // bins far below the first mode
      slow.static_correction = correction;
      slow.damping.aerodynamic = false;  // all modes are many: keep them apart
      slow.transfer = Transfer::sampled;
      slow.lean = lean;
      const Subject subject = bake(skeleton, {.modes = {.count = modes}});
      const Motion motion = set_in_motion(subject, slow);
      double sum = 0;
      for (int p = 0; p < 10; ++p) {
        sum += (displacement_at(motion, 60.0 * p) - lean_of(motion.basis)).squaredNorm();
      }
      return std::sqrt(sum);
    };
    const double all = spread(all_modes, false);
    EXPECT_NEAR(spread(all_modes, true) / all, 1, 1e-6);
    EXPECT_NEAR(spread(1, true) / all, 1, 0.1);
    EXPECT_GT(std::abs(spread(1, false) / all - 1), 2 * std::abs(spread(1, true) / all - 1));
  }
}

TEST(Advice, SaysWhatTheLoopCannotShowAndWhatTheModelsCannot) {
  const Subject subject = sapling();
  const auto lines = [&](const Weather& conditions, const MotionStatistics& statistics) {
    std::string all;
    for (const std::string& line : advice(subject, conditions, statistics)) all += line + '\n';
    return all;
  };
  Weather calm = weather;
  calm.wind = turbulent_wind({.speed = 5}, 0.2);
  calm.loop = {120, 120 * 60};
  EXPECT_EQ(lines(calm, {}), "");
  Weather coarse = calm;
  coarse.loop = {120, 60};
  EXPECT_NE(lines(coarse, {}).find("highest mode"), std::string::npos);
  Weather brief = calm;
  brief.loop = {1, 60};
  EXPECT_NE(lines(brief, {}).find("variance of the wind"), std::string::npos);
  Weather rough = calm;
  rough.wind = turbulent_wind({.speed = 5}, 0.5);
  EXPECT_EQ(lines(rough, {}), "") << "loads are averaged over the gusts";
  rough.loads.model = LoadModel::linearised;
  EXPECT_NE(lines(rough, {}).find("turbulence intensity of 0.5"), std::string::npos);
  EXPECT_NE(lines(calm, {.about_lean = {.rotation = 0.35}}).find("0.35 rad rms"), std::string::npos);
  EXPECT_NE(
      lines(calm, {.largest_stretch = 0.27, .most_stretched_branch = 12}).find("branch 12 by up to 27 %"),
      std::string::npos);
  Weather still = calm;
  still.wind = turbulent_wind({.speed = 5}, 0);
  still.loop = {1, 60};
  EXPECT_EQ(lines(still, {}), "") << "no gusts, none too slow for the loop";
}

// The stretch that frame after frame of the poses has, without motion_statistics.
double stretch_of_frames(const Skeleton& skeleton, const Structure& structure, const Motion& motion) {
  double largest = 0;
  for (int p = 0; p < motion.sample_count(); ++p) {
    const Eigen::VectorXd u = displacement_at(motion, motion.period * p / motion.sample_count());
    for (int k = 0; k < skeleton.branch_count(); ++k) {
      const Branch& branch = skeleton.branches[static_cast<std::size_t>(k)];
      const Member& member = structure.members[static_cast<std::size_t>(k)];
      const Vec3 start = branch.start + member_point(member, u, 0).displacement;
      const Vec3 end = branch.end + member_point(member, u, 1).displacement;
      largest = std::max(largest, (end - start).norm() / branch.length() - 1);
    }
  }
  return largest;
}

TEST(Advice, WarnsOfPlantsThatSmallDisplacementsStretch) {
  const auto in_a_wind_of = [](const char* preset, double speed) {
    const Skeleton skeleton = grow(parse_lsystem(find_preset(preset).text, preset)).skeleton;
    const Subject subject = bake(skeleton, {});
    Weather conditions;
    conditions.wind = turbulent_wind({.speed = speed}, 0.2);
    conditions.loop = {20, 120};
    conditions.lean = test::small_and_free;
    const Motion motion = set_in_motion(subject, conditions);
    const MotionStatistics statistics = motion_statistics(subject.structure, motion);
    EXPECT_NEAR(statistics.largest_stretch, stretch_of_frames(skeleton, subject.structure, motion), 1e-9);
    std::string all;
    for (const std::string& line : advice(subject, conditions, statistics)) all += line + '\n';
    return std::pair{statistics.largest_stretch, all};
  };
  for (const auto& [preset, speed] : {std::pair{"birch", 8.0}, {"bamboo", 14.0}}) {
    const auto [stretch, lines] = in_a_wind_of(preset, speed);
    EXPECT_GT(stretch, 0.2) << preset;
    EXPECT_NE(lines.find("superposed stretch branch"), std::string::npos) << lines;
    EXPECT_NE(lines.find("lower wind speed"), std::string::npos) << lines;
  }
  const auto [stretch, lines] = in_a_wind_of("sapling", 2);
  EXPECT_LT(stretch, 0.05);
  EXPECT_EQ(lines.find("stretch"), std::string::npos) << lines;
}

TEST(Loop, WithoutGustsIsTheLeanAloneInEveryKindOfWind) {
  const Subject subject = sapling();
  const MeanWind mean{.speed = 6};
  const WindGrid grid{.y_count = 9,
                      .z_count = 9,
                      .step_count = 80,
                      .y_spacing = 1,
                      .z_spacing = 0.5,
                      .bottom = 0.25,
                      .step = 0.1};
  const auto field = std::make_shared<const WindField>(synthesise_wind(turbulent_wind(mean, 0), grid));
  const struct {
    const char* name;
    Wind wind;
    double rounding;  // of a field that is the same at all times the transform may leave one
  } winds[] = {{"turbulent", turbulent_wind(mean, 0), 0},
               {"turbulent, calm", turbulent_wind({.speed = 0}, 0.2), 0},
               {"Stam's", StamWind{.mean = mean, .turbulence_intensity = 0}, 0},
               {"Stam's, calm", StamWind{.mean = {.speed = 0}}, 0},
               {"given", GivenWind{field}, 1e-9}};
  const Sites sites = subject.structure.find_sites();
  for (const auto& [name, wind, rounding] : winds) {
    for (const Transfer transfer : {Transfer::bin_averaged, Transfer::sampled}) {
      Weather without_gusts = weather;
      without_gusts.wind = wind;
      without_gusts.transfer = transfer;
      without_gusts.lean = test::small_and_free;
      const Motion motion = set_in_motion(subject, without_gusts);
      EXPECT_LE(moving(motion).cwiseAbs().maxCoeff(), rounding) << name;
      Eigen::Matrix3Xd points = sites.points;
      points.row(2).array() -= ground_height(subject.structure);
      const Eigen::Matrix3Xd static_wind = wind_at_points(wind, without_gusts.loop, points).mean;
      const Eigen::VectorXd lean =
          subject.structure.flexibility(mean_force(sites, linearise_loads(sites, static_wind)));
      EXPECT_TRUE(lean.allFinite());
      EXPECT_EQ(lean_of(motion.basis), lean) << name;
    }
  }
}

TEST(Loop, IsItsBasisTimesItsWeightsAndTheStaticShapesArePartOfIt) {
  const Subject subject = sapling();
  const Motion motion = set_in_motion(subject, weather);
  const Basis& basis = motion.basis;
  ASSERT_GT(basis.count(ShapeKind::static_shape), 0);
  const Eigen::VectorXd lean = lean_of(basis);
  double without = 0;
  for (const double time : {0.0, 1.0, 3.21}) {
    const Eigen::VectorXd now = coordinates_at(motion, time, Interpolation::linear);
    const Eigen::VectorXd pose = displacement_at(motion, time);
    EXPECT_LT((basis.columns * now - pose).norm(), 1e-13 * pose.norm());
    const Eigen::VectorXd modes_alone = lean + subject.modes.shapes * now.segment(1, subject.modes.count());
    without = std::max(without, (modes_alone - pose).norm() / (pose - lean).norm());
  }
  EXPECT_GT(without, 0.01);
}

TEST(Loop, LeansDownwindAndStandsStillWithoutWind) {
  const Subject subject = sapling();
  for (const double heading : {0.0, 120.0}) {
    Weather turned = weather;
    const MeanWind mean{.heading = heading};
    turned.wind = turbulent_wind(mean, 0.2);
    const Motion motion = set_in_motion(subject, turned);
    const Eigen::VectorXd lean = lean_of(motion.basis);
    Vec3 sum = Vec3::Zero();
    for (Eigen::Index k = 0; k < lean.size() / 6; ++k) sum += lean.segment<3>(6 * k);
    EXPECT_GT(sum.normalized().dot(heading_direction(mean)), 0.95);
  }
  Weather calm = weather;
  calm.wind = turbulent_wind({.speed = 0}, 0.2);
  const Motion still = set_in_motion(subject, calm);
  EXPECT_EQ(lean_of(still.basis).norm(), 0);
  EXPECT_EQ(moving(still).norm(), 0);
}

TEST(Loop, WorksForOneBranchOneModeAndOneSample) {
  const Subject subject = bake(test::straight_stem(1, 1, 0.01, 0.005), {.modes = {.count = 1}});
  Weather tiny = weather;
  tiny.loop = {1, 1};
  const Motion motion = set_in_motion(subject, tiny);
  EXPECT_EQ(motion.coordinates.rows(), 1);
  EXPECT_TRUE(motion.coordinates.allFinite());
  EXPECT_TRUE(lean_of(motion.basis).allFinite());
}

TEST(Loop, ShorterThanTheSlowestModeStillIsALoop) {
  const Subject subject = bake(test::straight_stem(4, 6, 0.02, 0.004), {.modes = {.count = 6}});
  Weather brief = weather;
  brief.loop = {0.5 / subject.modes.frequency[0], 40};
  const Motion motion = set_in_motion(subject, brief);
  EXPECT_TRUE(motion.coordinates.allFinite());
  EXPECT_GT(moving(motion).norm(), 0);
}

TEST(Loop, RefusesPeriodsAndRatesThatMakeNone) {
  const Subject subject = sapling();
  for (const TimeAxis& bad : {TimeAxis{0, 10}, TimeAxis{-1, 10}, TimeAxis{NAN, 10}, TimeAxis{1, 0},
                              TimeAxis{1, 1 << 25}, TimeAxis{1e9, 10}, TimeAxis{1e-16, 4}}) {
    Weather refused = weather;
    refused.loop = bad;
    EXPECT_THROW(set_in_motion(subject, refused), InputError);
  }
}

TEST(Loop, TellsItsProgress) {
  const Subject subject = sapling();
  std::vector<std::string> stages;
  double last = 0;
  std::mutex mutex;
  set_in_motion(subject, weather, [&](std::string_view stage, double done) {
    const std::lock_guard lock(mutex);
    if (stages.empty() || stages.back() != stage) stages.emplace_back(stage);
    last = std::max(last, done);
  });
  EXPECT_EQ(stages, (std::vector<std::string>{"lean", "wind", "loads", "response"}));
  EXPECT_EQ(last, 1);
}

TEST(DampingBySource, IsWhatTheWoodWasGivenAndWhatTheWindAdds) {
  const Subject subject = sapling();
  Weather vacuum = weather;
  vacuum.damping = {.ratio = 0.03, .aerodynamic = false};
  const Motion alone = set_in_motion(subject, vacuum);
  const Eigen::VectorXd omega = 2 * std::numbers::pi * alone.basis.frequency.tail(alone.basis.count() - 1);
  EXPECT_LT((alone.damping.structure - 0.06 * omega).norm(), 1e-13 * omega.norm());
  EXPECT_TRUE(alone.damping.medium.isZero(0));
  const auto of_wind = [&](double speed) {
    Weather windy = weather;
    windy.wind = turbulent_wind({.speed = speed}, 0.2);
    return set_in_motion(subject, windy).damping.medium[0];
  };
  // Grows with the wind, a little less than with its speed: the sapling bends out of it.
  EXPECT_GT(of_wind(2), 0);
  EXPECT_GT(of_wind(4) / of_wind(2), 1.5);
  EXPECT_LT(of_wind(4) / of_wind(2), 2);
}

}  // namespace
}  // namespace tremula
