// The three ways from wind to motion, side by side.
#include "tremula/pipeline.hpp"

#include "tremula/base/error.hpp"

#include <cmath>

#include <gtest/gtest.h>
#include "trees.hpp"

namespace tremula {
namespace {

Weather breeze(Dynamics dynamics) {
  Weather weather;
  weather.wind = turbulent_wind({.speed = 6}, 0.2);
  weather.loop = {.period = 16, .sample_count = 640};
  weather.transfer = Transfer::sampled;
  weather.dynamics = dynamics;
  return weather;
}

// Where the tip goes about the lean: (3 x M).
Eigen::Matrix3Xd path(const Motion& motion) {
  Eigen::Matrix3Xd moved(3, motion.sample_count());
  const Eigen::Index tip = motion.basis.columns.rows() - 6;
  for (int p = 0; p < motion.sample_count(); ++p) {
    const Eigen::VectorXd about =
        displacement_at(motion, p * motion.period / motion.sample_count()) - motion.basis.columns.col(0);
    moved.col(p) = about.segment<3>(tip);
  }
  return moved;
}

double rms(const Eigen::Matrix3Xd& moved) {
  const Eigen::Matrix3Xd about_mean = moved.colwise() - moved.rowwise().mean();
  return std::sqrt(about_mean.squaredNorm() / static_cast<double>(moved.cols()));
}

TEST(Dynamics, ALoopInTimeIsTheSynthesisedOneWithinOnePercent) {
  const Subject subject = bake(test::straight_stem(10, 2, 0.01, 0.006), {.modes = {.count = 8}});
  const Eigen::Matrix3Xd modal = path(set_in_motion(subject, breeze(Dynamics::modal)));
  const Eigen::Matrix3Xd time = path(set_in_motion(subject, breeze(Dynamics::time)));
  EXPECT_GT(rms(modal), 0);
  EXPECT_LT((modal - time).norm() / modal.norm(), 0.01);
}

TEST(Dynamics, OfOneStemOscillatorsAreItsModes) {
  const BakeOptions options{.structure = test::weightless(), .modes = {.count = 8}};
  const Subject subject = bake(test::straight_stem(10, 2, 0.01, 0.01), options);
  Weather by_branch = breeze(Dynamics::oscillators);
  by_branch.oscillators.modes = 4;
  const Eigen::Matrix3Xd oscillators = path(set_in_motion(subject, by_branch));
  const Eigen::Matrix3Xd modal = path(set_in_motion(subject, breeze(Dynamics::modal)));
  EXPECT_LT((modal - oscillators).norm() / modal.norm(), 0.03);
}

TEST(Dynamics, OscillatorsRefuseFramesAndQuadraticDrag) {
  const Subject subject = bake(test::straight_stem(3, 1, 0.01, 0.01), {.modes = {.count = 4}});
  Weather weather = breeze(Dynamics::oscillators);
  weather.drag = Drag::quadratic;
  EXPECT_THROW(set_in_motion(subject, weather), InputError);
}

}  // namespace
}  // namespace tremula
