// A gust that is slow enough is another mean wind: what the loop makes of it must be how leans differ.
#include <gtest/gtest.h>

#include <string>

#include "tremula/deformation/bent_pose.hpp"
#include "tremula/dynamics/gauge.hpp"
#include "tremula/geometry/grow.hpp"
#include "tremula/geometry/plants.hpp"
#include "tremula/pipeline.hpp"

namespace tremula {
namespace {

// The same everywhere, along x: a mean speed and a cosine of one period a loop.
Wind one_slow_gust(double speed, double amplitude) {
  Wind wind;
  wind.reference = {.speed = speed};
  const Vec3 mean(speed, 0, 0);
  wind.statistics = [mean](const Vec3&) { return GustStatistics{mean, Mat3::Zero()}; };
  wind.at_points = [mean, amplitude](const TimeAxis&, const Eigen::Matrix3Xd& points) {
    PointWind result{.mean = mean.replicate(1, points.cols()), .velocity = {}};
    result.velocity = [amplitude, count = points.cols()](int bin, int) {
      Eigen::Matrix3Xcd velocity = Eigen::Matrix3Xcd::Zero(3, count);
      if (bin == 1) velocity.row(0).setConstant(amplitude / 2);
      return velocity;
    };
    result.has_draws = result.has_slow_gusts = false;
    return result;
  };
  return wind;
}

struct State {
  double moment;  // along the wind, at the base [N m]
  Vec3 tip;       // the end of the branch that reaches highest [m]
};

class SlowGusts : public testing::TestWithParam<std::string> {
 protected:
  SlowGusts()
      : skeleton_(grow(parse_lsystem(find_preset(GetParam()).text, GetParam())).skeleton),
        subject_(bake(skeleton_, {.modes = {.count = 10}})) {
    const BeamTree& tree = *subject_.structure.tree;
    for (int k = 0; k < tree.branch_count(); ++k) {
      if (tree.members[index_of(k)].point(1).z() > tree.members[index_of(tip_)].point(1).z()) tip_ = k;
    }
  }

  Motion motion(const Wind& wind) const {
    // The crown leaves of a gust what it leaves of the mean wind, another one in a gust: not here.
    Weather weather{.wind = wind, .lean = {.shelter = {.on = false}}, .loop = {1e5, 8}};
    weather.gauges = {place_gauge(skeleton_, "base")};
    return set_in_motion(subject_, weather);
  }

  State state(const Motion& motion, int sample) const {
    return {
        gauge_series(motion.readings[0], motion, 0).along_wind[sample],
        bent_at(subject_.structure, motion, sample * motion.period / motion.sample_count())[index_of(tip_)]
            .end};
  }

  Skeleton skeleton_;
  Subject subject_;
  int tip_ = 0;
};

TEST_P(SlowGusts, OfTenModesSwayAsTheLeansOfFasterAndSlowerWindsDiffer) {
  for (const double speed : {8.0, 16.0}) {
    const double gust = 0.01 * speed;
    const State fast = state(motion(one_slow_gust(speed + gust, 0)), 0),
                slow = state(motion(one_slow_gust(speed - gust, 0)), 0);
    const Motion loop = motion(one_slow_gust(speed, gust));
    const State most = state(loop, 0), least = state(loop, 4);
    const double moment = fast.moment - slow.moment;
    EXPECT_NEAR(most.moment - least.moment, moment, 0.003 * moment) << speed;
    const Vec3 went = fast.tip - slow.tip;
    EXPECT_LT((most.tip - least.tip - went).norm(), 0.01 * went.norm()) << speed;
  }
}

INSTANTIATE_TEST_SUITE_P(Presets, SlowGusts, testing::Values("sapling", "birch", "willow"),
                         [](const auto& preset) { return preset.param; });

}  // namespace
}  // namespace tremula
