#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <utility>

#include "trees.hpp"
#include "tremula/numerics/fft.hpp"
#include "tremula/pipeline.hpp"

namespace tremula {
namespace {

// A stem without drag that carries one heavy leaf at its tip: an oscillator whose load falls with its angle.
struct Oscillator {
  static constexpr double length = 2, speed = 8, angle = 0.3, damping_ratio = 0.02, period = 600;
  Skeleton skeleton = test::straight_stem(1, length, 0.02, 0.02);
  BakeOptions bake_options{.structure = test::weightless(), .modes = {.count = 2}};
  LoadOptions loads{.branch_drag_coefficient = 0};
  double stiffness, mass, drag;  // [N/m], [kg], force over the square of the speed [N s^2/m^2]

  Oscillator() {
    skeleton.leaves.push_back(
        {.branch = 0, .base = skeleton.branches[0].end, .length = 0.1, .width = 0.1, .area = 1, .mass = 1});
    const Structure structure = assemble(skeleton, bake_options.structure);
    Eigen::VectorXd tip = Eigen::VectorXd::Zero(6);
    tip[0] = 1;
    stiffness = 1 / structure.flexibility(tip)[0];
    const double omega = 2 * std::numbers::pi * 0.5;
    skeleton.leaves[0].mass = mass = stiffness / (omega * omega);
    // Where the mean load holds it at x = 1: 1.5 of the displacement over the length is the angle of the tip.
    drag = 4 * stiffness * (angle * length / 1.5) / (speed * speed);
    skeleton.leaves[0].area = drag / (0.5 * loads.fluid_density * loads.leaf_drag_coefficient);
  }

  double load(double displacement, double velocity_of_air) const {
    const double x = 1.5 * displacement / length / angle;
    return drag * velocity_of_air * std::abs(velocity_of_air) / std::pow(1 + x * x, 2);
  }

  // Through two loops of the wind; the second is kept. (M) [m]
  Eigen::VectorXd integrate(const Eigen::VectorXd& gusts) const {
    const double step = period / static_cast<double>(gusts.size());
    const double damping = 2 * damping_ratio * std::sqrt(stiffness * mass);
    using State = Eigen::Vector2d;
    const auto rate = [&](const State& s, double u) {
      return State(s[1], (load(s[0], speed + u - s[1]) - damping * s[1] - stiffness * s[0]) / mass);
    };
    Eigen::VectorXd displacement(gusts.size());
    State s(angle * length / 1.5, 0);
    for (Eigen::Index i = 0; i < 2 * gusts.size(); ++i) {
      const double now = gusts[i % gusts.size()], next = gusts[(i + 1) % gusts.size()],
                   middle = 0.5 * (now + next);
      displacement[i % gusts.size()] = s[0];
      const State a = rate(s, now), b = rate(s + 0.5 * step * a, middle),
                  c = rate(s + 0.5 * step * b, middle), d = rate(s + step * c, next);
      s += step / 6 * (a + 2 * b + 2 * c + d);
    }
    return displacement;
  }
};

// About the mean; of all frequencies, and of those from 0.6 of the first mode's on.
std::pair<double, double> rms_and_resonant(const Eigen::VectorXd& series, double period) {
  Eigen::MatrixXcd spectrum = half_spectra_from_samples(series);
  spectrum.row(0).setZero();
  const double all = 2 * spectrum.squaredNorm();
  spectrum.topRows(static_cast<Eigen::Index>(0.6 * 0.5 * period)).setZero();
  return {std::sqrt(all), std::sqrt(2 * spectrum.squaredNorm())};
}

TEST(BendingOutOfTheWind, LeavesAnOscillatorTheSwayThatIntegrationInTimeGivesIt) {
  const Oscillator oscillator;
  Weather weather;
  weather.wind = turbulent_wind({.speed = Oscillator::speed, .profile = ProfileKind::constant}, 0.1,
                                SpectrumKind::iec_kaimal);
  weather.loads = oscillator.loads;
  weather.reconfiguration.angle = Oscillator::angle;
  weather.damping.ratio = Oscillator::damping_ratio;
  weather.transfer = Transfer::sampled;  // one draw a bin: the same gusts for both
  weather.static_correction = false;
  weather.loop = {Oscillator::period, 30000};
  const Subject subject = bake(oscillator.skeleton, oscillator.bake_options);
  const Motion motion = set_in_motion(subject, weather);
  EXPECT_NEAR(subject.modes.frequency[0], 0.5, 0.01);
  const Eigen::VectorXd lean = lean_of(motion.basis);
  EXPECT_NEAR(lean[4], Oscillator::angle, 1e-6);
  EXPECT_NEAR(lean[0], Oscillator::angle * Oscillator::length / 1.5, 1e-6);

  const PointWind at_point =
      wind_at_points(weather.wind, weather.loop, subject.structure.find_sites().points);
  Eigen::MatrixXcd gusts = Eigen::MatrixXcd::Zero(weather.loop.bin_count(), 1);
  for (int bin = 1; bin < weather.loop.bin_count(); ++bin) gusts(bin, 0) = at_point.velocity(bin, 0)(0, 0);
  const auto [truth, resonant_truth] = rms_and_resonant(
      oscillator.integrate(samples_from_half_spectra(gusts, weather.loop.sample_count)), Oscillator::period);
  Eigen::VectorXd tip(motion.sample_count());
  for (int p = 0; p < motion.sample_count(); ++p)
    tip[p] = subject.modes.shapes.row(0).dot(motion.coordinates.row(p).tail(2));
  const auto [found, resonant] = rms_and_resonant(tip, Oscillator::period);
  // The slope of the angle's law is a stiffness and stands here in the load: right for slow gusts, at the
  // wrong frequency for the resonance. The integrals of both linear systems over the spectrum have the ratios
  // 0.945 and 0.797. With the slope in the damping too they would be 1.138 and 1.295.
  EXPECT_NEAR(found / truth, 0.945, 0.03);
  EXPECT_NEAR(resonant / resonant_truth, 0.797, 0.06);
  EXPECT_GT(truth, 0.02);
}

}  // namespace
}  // namespace tremula
