#include "tremula/dynamics/oscillators.hpp"

#include "tremula/base/error.hpp"
#include "tremula/reference/newmark.hpp"

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/LU>
#include "complaint.hpp"

namespace tremula {
namespace {

using std::numbers::pi;
using test::complaint_of;
using Sparse = Eigen::SparseMatrix<double>;

OscillatorNetwork network_of(const Eigen::VectorXd& mass, const Eigen::MatrixXd& damping,
                             const Eigen::MatrixXd& coupling) {
  return {mass, damping.sparseView(), coupling.sparseView()};
}

OscillatorNetwork single(double omega, double rate) {
  return network_of(Eigen::VectorXd::Ones(1), Eigen::MatrixXd::Constant(1, 1, rate),
                    Eigen::MatrixXd::Constant(1, 1, omega * omega));
}

// Masses on springs in a row, the first tied to the ground.
OscillatorNetwork chain(Eigen::Index count, double damping) {
  Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(count, count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const double spring = 40.0 + 10.0 * static_cast<double>(k);
    stiffness(k, k) += spring;
    if (k == 0) continue;
    stiffness(k - 1, k - 1) += spring;
    stiffness(k, k - 1) -= spring;
    stiffness(k - 1, k) -= spring;
  }
  return network_of(Eigen::VectorXd::LinSpaced(count, 1, 0.3), damping * stiffness, stiffness);
}

// A stem, limbs on it and twigs on those: each acts on what carries it, and on the stem itself.
OscillatorNetwork one_way_tree() {
  const std::vector<int> parent = {-1, 0, 0, 1, 1, 2, 3};
  const std::vector<double> omega = {3, 11, 9, 40, 11, 70, 160};  // two of 11: no eigenvectors to rely on
  const auto count = static_cast<Eigen::Index>(parent.size());
  Eigen::MatrixXd coupling = Eigen::MatrixXd::Zero(count, count), damping = coupling;
  Eigen::VectorXd mass(count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const auto i = static_cast<std::size_t>(k);
    mass[k] = 2.0 / (1 + static_cast<double>(k));
    coupling(k, k) = mass[k] * omega[i] * omega[i];
    damping(k, k) = mass[k] * 2 * (k == 5 ? 1.4 : 0.05) * omega[i];  // one is over-damped
    if (parent[i] >= 0) coupling(parent[i], k) = -0.7 * coupling(k, k);
    if (parent[i] > 0) coupling(0, k) = -0.2 * coupling(k, k);
  }
  return network_of(mass, damping, coupling);
}

Eigen::MatrixXd random_forces(Eigen::Index rows, Eigen::Index columns) {
  std::mt19937 generator(7);
  std::normal_distribution<double> normal;
  return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return normal(generator); });
}

// The same straight lines between the same instants, looked at `times` as often.
Eigen::MatrixXd refined(const Eigen::MatrixXd& forces, int times) {
  Eigen::MatrixXd fine(forces.rows(), (forces.cols() - 1) * times + 1);
  for (Eigen::Index p = 0; p < fine.cols(); ++p) {
    const Eigen::Index coarse = std::min(p / times, forces.cols() - 2);
    const double part = static_cast<double>(p - coarse * times) / times;
    fine.col(p) = (1 - part) * forces.col(coarse) + part * forces.col(coarse + 1);
  }
  return fine;
}

void expect_independent_of_the_step(const OscillatorNetwork& network, double step) {
  const Eigen::MatrixXd forces = random_forces(network.size(), 60);
  const Eigen::MatrixXd coarse = respond_in_time(network, step, forces);
  for (const int times : {2, 5, 16}) {
    const Eigen::MatrixXd fine = respond_in_time(network, step / times, refined(forces, times));
    double largest = 0;
    for (Eigen::Index p = 0; p < coarse.cols(); ++p)
      largest = std::max(largest, (fine.col(p * times) - coarse.col(p)).cwiseAbs().maxCoeff());
    EXPECT_LT(largest / coarse.cwiseAbs().maxCoeff(), 1e-10) << times;
  }
}

TEST(OscillatorStep, IsTheClosedFormOfAFreeSwingAtAnyDamping) {
  const double omega = 7;
  for (const double ratio : {0.0, 0.02, 0.7, 0.999999, 1.0, 1.000001, 1.5, 30.0}) {
    for (const double step : {1e-3, 0.05, 0.4, 3.0}) {
      const OscillatorStep s = oscillator_step(omega, 2 * ratio * omega, step);
      double x = 0;  // of a release from 1
      const double g = ratio * omega;
      if (ratio < 1) {
        const double w = omega * std::sqrt(1 - ratio * ratio);
        const double sine = std::sin(w * step) / (w * step);
        x = std::exp(-g * step) * (std::cos(w * step) + g * step * sine);
      } else if (ratio == 1) {
        x = std::exp(-g * step) * (1 + g * step);
      } else {
        const double k = omega * std::sqrt(ratio * ratio - 1), slow = -omega * omega / (g + k), fast = -g - k;
        x = (slow * std::exp(fast * step) - fast * std::exp(slow * step)) / (slow - fast);
      }
      EXPECT_NEAR(s.state(0, 0), x, 1e-9 * std::abs(x) + 1e-14) << ratio << ", " << step;
      // Liouville: volumes of states shrink by the damping alone.
      EXPECT_NEAR(s.state.determinant(), std::exp(-2 * g * step), 1e-10) << ratio << ", " << step;
    }
  }
}

TEST(OscillatorStep, UnderAForceThatStaysEndsWhereItHolds) {
  for (const double rate : {0.5, 14.0, 300.0}) {
    const OscillatorStep s = oscillator_step(7, rate, 0.1);
    const Eigen::Vector2d held(1.0 / 49, 0);
    EXPECT_NEAR((s.state * held + s.force * Eigen::Vector2d(1, 1) - held).norm(), 0, 1e-15);
  }
}

// Two steps with the force's middle between are one.
TEST(OscillatorStep, TwoOfHalfTheStepAreOne) {
  for (const double ratio : {0.0, 0.05, 1.0, 1.0000001, 4.0, 500.0}) {
    for (const double step : {1e-4, 0.02, 0.3, 0.9, 2.0, 20.0}) {
      const double omega = 6;
      const OscillatorStep whole = oscillator_step(omega, 2 * ratio * omega, step);
      const OscillatorStep half = oscillator_step(omega, 2 * ratio * omega, step / 2);
      const Eigen::Matrix2d early{{1, 0}, {0.5, 0.5}}, late{{0.5, 0.5}, {0, 1}};
      const Eigen::Matrix2d force = half.state * half.force * early + half.force * late;
      EXPECT_LT((whole.state - half.state * half.state).norm(), 1e-11 * omega) << ratio << ", " << step;
      EXPECT_LT((whole.force - force).norm(), 1e-11 * whole.force.norm()) << ratio << ", " << step;
    }
  }
}

TEST(Oscillators, OfOneAreItsClosedForm) {
  for (const double ratio : {0.05, 1.0, 3.0}) {
    const double omega = 12, rate = 2 * ratio * omega, step = 1.0 / 30;
    const Eigen::MatrixXd forces = random_forces(1, 40);
    const OscillatorStep s = oscillator_step(omega, rate, step);
    const Eigen::MatrixXd found = respond_in_time(single(omega, rate), step, forces);
    Eigen::Vector2d state(0, 0);
    for (Eigen::Index p = 1; p < forces.cols(); ++p) {
      state = s.state * state + s.force * Eigen::Vector2d(forces(0, p - 1), forces(0, p));
      EXPECT_NEAR(found(0, p), state[0], 1e-13 / omega) << ratio << ", " << p;
    }
  }
}

TEST(Oscillators, DoNotDependOnTheStepOfTime) {
  expect_independent_of_the_step(single(9, 0.9), 0.1);
  expect_independent_of_the_step(one_way_tree(), 1.0 / 30);
  expect_independent_of_the_step(chain(6, 0.002), 0.1);
}

TEST(Oscillators, OfAOneWayTreeMoveAsTheFullExponentialSays) {
  OscillatorNetwork tree = one_way_tree();
  ASSERT_TRUE(is_one_way(tree));
  const OscillatorIntegrator sparse(tree, 0.05);
  EXPECT_LT(sparse.pair_count(), 7U * 7U);
  // The same turned round, so that it is not seen to be one-way.
  const Eigen::PermutationMatrix<Eigen::Dynamic> turned(Eigen::VectorXi::LinSpaced(7, 6, 0));
  const Eigen::MatrixXd coupling = turned * Eigen::MatrixXd(tree.coupling) * turned.transpose();
  const Eigen::MatrixXd damping = turned * Eigen::MatrixXd(tree.damping) * turned.transpose();
  const OscillatorNetwork full = network_of(turned * tree.mass, damping, coupling);
  ASSERT_FALSE(is_one_way(full));
  const Eigen::MatrixXd forces = random_forces(7, 50);
  const Eigen::MatrixXd one = respond_in_time(tree, 0.05, forces);
  const Eigen::MatrixXd other = respond_in_time(full, 0.05, turned * forces);
  EXPECT_LT((turned * one - other).cwiseAbs().maxCoeff() / one.cwiseAbs().maxCoeff(), 1e-11);
}

TEST(Oscillators, WithoutForceLoseTheEnergyThatTheirDampersTake) {
  const OscillatorNetwork network = chain(5, 0.004);
  const auto energy = [&](const OscillatorState& s) {
    return 0.5 * s.velocity.dot(network.mass.asDiagonal() * s.velocity) +
           0.5 * s.displacement.dot(network.coupling * s.displacement);
  };
  const double step = 0.002;
  const OscillatorIntegrator integrator(network, step);
  OscillatorState state = at_rest(network);
  state.displacement[4] = 0.1;
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(5);
  double before = energy(state);
  const double begun = before;
  for (int i = 0; i < 500; ++i) {
    const double power_before = state.velocity.dot(network.damping * state.velocity);
    integrator.advance(state, none, none);
    const double now = energy(state), power = state.velocity.dot(network.damping * state.velocity);
    EXPECT_LE(now, before);
    EXPECT_NEAR(before - now, 0.5 * step * (power_before + power), 2e-4 * begun);
    before = now;
  }
  // Without dampers none is lost.
  const OscillatorNetwork free = chain(5, 0);
  OscillatorState swinging = at_rest(free);
  swinging.displacement[4] = 0.1;
  const OscillatorIntegrator forever(free, 0.37);
  for (int i = 0; i < 1000; ++i) forever.advance(swinging, none, none);
  EXPECT_NEAR(energy(swinging) / begun, 1, 1e-11);
}

TEST(Oscillators, OfAFreeSwingFallByTheDampingTimeOfEquation9) {
  const double omega = 2 * pi * 2, tau = 1;  // F section 6.1
  const OscillatorNetwork branch = single(omega, 2 / tau);
  OscillatorState state = at_rest(branch);
  state.displacement[0] = 1;
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(1);
  const double swing = 2 * pi / std::sqrt(omega * omega - 1);
  const OscillatorIntegrator integrator(branch, swing);
  for (int i = 1; i <= 3; ++i) {
    integrator.advance(state, none, none);
    EXPECT_NEAR(state.displacement[0], std::exp(-i * swing / tau), 1e-12);
  }
}

TEST(Oscillators, OfAClampedChainSettleWhereNewmarksMethodDoesAsItsStepShrinks) {
  const OscillatorNetwork network = chain(4, 0.003);
  const SparseMatrices matrices{network.coupling,
                                Sparse(Eigen::MatrixXd(network.mass.asDiagonal()).sparseView())};
  const double step = 0.05;
  const Eigen::MatrixXd forces = random_forces(4, 41);
  const Eigen::MatrixXd exact = respond_in_time(network, step, forces);
  std::vector<double> errors;
  for (const int times : {20, 40}) {
    const Eigen::MatrixXd fine = refined(forces, times);
    double error = 0;
    const TimeState start{Eigen::VectorXd::Zero(4), Eigen::VectorXd::Zero(4), {}};
    integrate_newmark(
        matrices, network.damping,
        [&](double t) {
          const auto p = static_cast<Eigen::Index>(std::lround(t / step * times));
          return Eigen::VectorXd(fine.col(std::min(p, fine.cols() - 1)));
        },
        start, {step / times, 40 * times},
        [&](int i, const TimeState& state) {
          if (i % times == 0)
            error = std::max(error, (state.displacement - exact.col(i / times)).cwiseAbs().maxCoeff());
        });
    errors.push_back(error / exact.cwiseAbs().maxCoeff());
  }
  EXPECT_LT(errors[1], 1e-3);
  EXPECT_NEAR(errors[0] / errors[1], 4, 0.2);  // Newmark's order, so that the limit is ours
}

TEST(Oscillators, RepeatAsIfTheForcesHadGoneOnForEver) {
  for (const OscillatorNetwork& network : {one_way_tree(), chain(4, 0.05)}) {
    const Eigen::Index samples = 48;
    const Eigen::MatrixXd forces = random_forces(network.size(), samples);
    const Eigen::MatrixXd loop = repeat_in_time(network, 4, forces);
    Eigen::MatrixXd for_long(network.size(), 60 * samples + 1);
    for (Eigen::Index p = 0; p < for_long.cols(); ++p) for_long.col(p) = forces.col(p % samples);
    const Eigen::MatrixXd settled = respond_in_time(network, 4.0 / samples, for_long);
    EXPECT_LT(
        (settled.middleCols(59 * samples, samples) - loop).cwiseAbs().maxCoeff() / loop.cwiseAbs().maxCoeff(),
        1e-9);
  }
}

// Forces that are a few low harmonics: straight lines between samples lose little of those.
TEST(Oscillators, OfALoopAreTheSameInTimeAndInFrequency) {
  for (const OscillatorNetwork& network : {one_way_tree(), chain(4, 0.01)}) {
    const TimeAxis axis{.period = 6, .sample_count = 1200};
    Eigen::MatrixXcd coefficients = Eigen::MatrixXcd::Zero(axis.bin_count(), network.size());
    coefficients.row(1).setConstant({0.3, -0.2});
    coefficients.row(4).setConstant({-0.1, 0.5});
    coefficients.row(11).setConstant({0.2, 0.1});
    const auto in_time = [&](const Eigen::MatrixXcd& of) {
      Eigen::MatrixXd samples(of.cols(), axis.sample_count);
      for (int p = 0; p < axis.sample_count; ++p) {
        samples.col(p).setZero();
        for (const int bin : {1, 4, 11}) {
          const std::complex<double> turn =
              std::polar(1.0, axis.omega(bin) * p * axis.period / axis.sample_count);
          samples.col(p) += (of.row(bin).transpose() * turn).real();
        }
      }
      return samples;
    };
    const Eigen::MatrixXd direct = in_time(respond_in_frequency(network, axis, coefficients));
    const Eigen::MatrixXd loop = repeat_in_time(network, axis.period, in_time(coefficients));
    EXPECT_LT((direct - loop).norm() / direct.norm(), 1e-3);
  }
}

TEST(Oscillators, ThatGrowOrFloatAreRefusedInOneLine) {
  EXPECT_THAT(complaint_of([] { OscillatorIntegrator(single(5, -1), 0.1); }),
              testing::HasSubstr("oscillators: the motion of oscillator 0 grows by 0.5 1/s"));
  EXPECT_THAT(complaint_of([] { check_network(single(0, 1)); }),
              testing::HasSubstr("oscillator 0: nothing holds it"));
  // A follower force: two that drive each other in turn flutter although each is damped.
  Eigen::MatrixXd coupling{{100, 60}, {-60, 110}};
  const auto flutter = [&](double damping) {
    return network_of(Eigen::VectorXd::Ones(2), damping * Eigen::MatrixXd::Identity(2, 2), coupling);
  };
  EXPECT_THAT(complaint_of([&] { check_network(flutter(0.1)); }),
              testing::AllOf(testing::HasSubstr("oscillators: a motion grows by"),
                             testing::HasSubstr(", wanted a network whose motions stay or die"),
                             testing::Not(testing::HasSubstr("\n"))));
  EXPECT_EQ(complaint_of([&] { check_network(flutter(8)); }), "");
  EXPECT_THAT(complaint_of([&] {
                check_network(network_of(Eigen::VectorXd::Ones(2), Eigen::MatrixXd::Identity(2, 2),
                                         Eigen::MatrixXd{{1, -1}, {-1, 1}}));
              }),
              testing::HasSubstr("nothing holds"));
  EXPECT_THAT(complaint_of([&] { repeat_in_time(single(2 * pi, 0), 1, Eigen::MatrixXd::Ones(1, 8)); }),
              testing::HasSubstr("never dies"));
}

TEST(Oscillators, ThatDoNotFitAreRefused) {
  OscillatorNetwork network = single(5, 1);
  EXPECT_THROW(OscillatorIntegrator(network, 0), InputError);
  EXPECT_THROW(respond_in_time(network, 0.1, Eigen::MatrixXd::Zero(2, 3)), InputError);
  network.mass[0] = 0;
  EXPECT_THROW(check_network(network), InputError);
  network.mass = Eigen::VectorXd::Ones(2);
  EXPECT_THROW(check_network(network), InputError);
  EXPECT_THROW(oscillator_step(1, -1, 1), InputError);
}

}  // namespace
}  // namespace tremula
