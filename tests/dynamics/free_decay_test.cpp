#include "tremula/dynamics/free_decay.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "complaint.hpp"

namespace tremula {
namespace {

using std::numbers::pi;

// Let go from `size` at rest: the closed form of one oscillator.
Eigen::VectorXd released(double size, double frequency, double ratio, double step, int count) {
  const double omega = 2 * pi * frequency, damped = omega * std::sqrt(1 - ratio * ratio);
  Eigen::VectorXd record(count);
  for (int p = 0; p < count; ++p) {
    const double t = p * step;
    record[p] = size * std::exp(-ratio * omega * t) *
                (std::cos(damped * t) + ratio * omega / damped * std::sin(damped * t));
  }
  return record;
}

TEST(EvaluateDecay, FindsFrequencyAndDampingOfOneOscillatorInClosedForm) {
  for (const double ratio : {0.002, 0.02, 0.1, 0.25}) {
    for (const double step : {0.01, 0.02}) {
      const FreeDecay found = evaluate_decay(released(-0.3, 0.7, ratio, step, 4000), step);
      EXPECT_NEAR(found.frequency, 0.7, 1e-4 * 0.7) << ratio;
      EXPECT_NEAR(found.damping_ratio, ratio, 2e-3 * ratio) << ratio;
      EXPECT_LT(found.scatter, 1e-3) << ratio;
      EXPECT_GE(found.cycles, 2) << ratio;
    }
  }
}

TEST(EvaluateDecay, HighModesThatDieFirstHardlyDisturbIt) {
  const double step = 0.005;
  const Eigen::VectorXd record = released(1, 1, 0.03, step, 4000) + released(0.1, 6.3, 0.03, step, 4000);
  const FreeDecay found = evaluate_decay(record, step);
  EXPECT_NEAR(found.frequency, 1, 0.01);
  EXPECT_NEAR(found.damping_ratio, 0.03, 0.05 * 0.03);
}

TEST(EvaluateDecay, ScatterTellsThatTwoNearModesBeat) {
  const double step = 0.01;
  const Eigen::VectorXd one = released(1, 1, 0.01, step, 3000);
  const Eigen::VectorXd two = one + released(0.7, 1.1, 0.01, step, 3000);
  EXPECT_LT(evaluate_decay(one, step).scatter, 1e-3);
  EXPECT_GT(evaluate_decay(two, step).scatter, 0.1);
}

TEST(EvaluateDecay, CountsNoMoreThanItIsTold) {
  const Eigen::VectorXd record = released(1, 1, 0.002, 0.01, 10000);
  EXPECT_EQ(evaluate_decay(record, 0.01, {.most_cycles = 7}).cycles, 7);
  const FreeDecay down_to_half = evaluate_decay(record, 0.01, {.lowest = 0.5, .most_cycles = 1000});
  EXPECT_NEAR(down_to_half.cycles, std::log(2) / (2 * pi * 0.002), 1);
}

TEST(EvaluateDecay, RefusesWhatIsNoDecayInOneLine) {
  const auto complaint = [](const Eigen::VectorXd& record, double step) {
    return test::complaint_of([&] { evaluate_decay(record, step); });
  };
  EXPECT_EQ(complaint(released(1, 1, 0.05, 0.01, 90), 0.01),
            "record of a decay: 0 cycles of it, wanted 2 or more: a longer record, or less damping");
  EXPECT_EQ(complaint(Eigen::VectorXd::Zero(100), 0.01),
            "record of a decay: 0 cycles of it, wanted 2 or more: a longer record, or less damping");
  EXPECT_EQ(complaint(released(1, 20, 0.01, 0.01, 500), 0.01).substr(0, 17), "record of a decay");
  EXPECT_EQ(complaint(Eigen::VectorXd::Ones(2), 0.01), "samples of a decay: 2, wanted at least 3");
  EXPECT_EQ(complaint(Eigen::VectorXd::Ones(9), 0), "step of a decay: 0 s, wanted above 0 s");
  EXPECT_EQ(complaint(Eigen::VectorXd::Constant(9, std::numeric_limits<double>::quiet_NaN()), 0.1),
            "record of a decay: a number that is not finite, wanted finite numbers");
}

}  // namespace
}  // namespace tremula
