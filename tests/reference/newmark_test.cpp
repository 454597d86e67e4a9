#include "tremula/reference/newmark.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <vector>

#include "trees.hpp"
#include "tremula/base/error.hpp"
#include "tremula/numerics/random.hpp"

namespace tremula {
namespace {

using std::numbers::pi;
using Sparse = Eigen::SparseMatrix<double>;
using Vector1 = Eigen::Matrix<double, 1, 1>;

Sparse sparse(const Eigen::MatrixXd& dense) { return dense.sparseView(); }
Sparse number(double value) { return sparse(Vector1(value)); }
Eigen::VectorXd value(double number) { return Vector1(number); }

const double mass = 1.7, omega = 2 * pi * 0.8;
SparseMatrices oscillator() { return {number(mass * omega * omega), number(mass)}; }
Sparse damped(double ratio) { return number(2 * ratio * omega * mass); }
const ForceAtTime no_force = [](double) { return value(0); };

TimeState at(double displacement, double velocity) { return {value(displacement), value(velocity), {}}; }

TEST(IntegrateNewmark, SwingsWithTheFrequencyItSaysItDoes) {
  // The rotation of (omega u, u') by omega h becomes its Cayley transform: one by 2 atan(omega h/2).
  for (const double h : {0.001, 0.1, 3.0}) {
    const double angle = 2 * std::atan(omega * h / 2);
    integrate_newmark(oscillator(), damped(0), no_force, at(0.3, -0.9), {h, 50},
                      [&](int i, const TimeState& state) {
                        EXPECT_NEAR(state.displacement[0],
                                    0.3 * std::cos(i * angle) - 0.9 / omega * std::sin(i * angle), 1e-12)
                            << "step " << i << " of " << h << " s";
                      });
  }
}

TEST(IntegrateNewmark, ElongatesThePeriodByATwelfthOfTheSquareOfTheAngleOfAStep) {
  // The step where u = cos(omega t) falls through zero the tenth time, between two instants by the line.
  const double h = 0.02;
  std::vector<double> crossings;
  double before = 1;
  integrate_newmark(oscillator(), damped(0), no_force, at(1, 0), {h, 700},
                    [&](int i, const TimeState& state) {
                      const double here = state.displacement[0];
                      if (before > 0 && here <= 0) crossings.push_back((i - here / (here - before)) * h);
                      before = here;
                    });
  ASSERT_GE(crossings.size(), 11U);
  const double elongation = (crossings[10] - crossings[0]) / 10 * omega / (2 * pi) - 1;
  EXPECT_NEAR(elongation, std::pow(omega * h, 2) / 12, 0.02 * elongation);
}

// The error at 2 s of a damped oscillator that starts with a blow, under a force that grows.
double error_of_step(int step_count) {
  const double ratio = 0.07, decay = ratio * omega, swing = omega * std::sqrt(1 - ratio * ratio);
  const double slope = 2.3, t = 2, stiffness = mass * omega * omega;
  // u = slope (t - 2 zeta/omega)/k + e^(-decay t) (a cos + b sin)
  const double lag = 2 * ratio / omega, a = 0.2 + slope * lag / stiffness,
               b = (0.4 - slope / stiffness + decay * a) / swing;
  const double wanted = slope * (t - lag) / stiffness +
                        std::exp(-decay * t) * (a * std::cos(swing * t) + b * std::sin(swing * t));
  const TimeState end =
      integrate_newmark(oscillator(), damped(ratio), [&](double time) { return value(slope * time); },
                        at(0.2, 0.4), {t / step_count, step_count});
  return std::abs(end.displacement[0] - wanted);
}

TEST(IntegrateNewmark, IsOfSecondOrder) {
  EXPECT_LT(error_of_step(4000), 1e-6);
  for (const int count : {250, 500, 1000}) {
    EXPECT_NEAR(error_of_step(count) / error_of_step(2 * count), 4, 0.05) << count << " steps";
  }
}

TEST(IntegrateNewmark, KeepsTheEnergyOfATreeWithoutDamping) {
  const SparseMatrices matrices = assemble_sparse(assemble_tree(test::awkward_tree(), {}));
  const Eigen::Index size = matrices.mass.rows();
  TimeState initial{Eigen::VectorXd::Zero(size), Eigen::VectorXd::Zero(size), {}};
  for (Eigen::Index i = 0; i < size; ++i) {
    initial.velocity[i] = uniform({3, RandomStream::test, 0, static_cast<std::uint64_t>(i)}) - 0.5;
  }
  const auto energy = [&](const TimeState& state) {
    return 0.5 * state.velocity.dot(matrices.mass * state.velocity) +
           0.5 * state.displacement.dot(matrices.stiffness * state.displacement);
  };
  const double before = energy(initial);
  const auto still = [&](double) -> Eigen::VectorXd { return Eigen::VectorXd::Zero(size); };
  // Also over steps much longer than the fastest periods.
  integrate_newmark(matrices, Sparse(size, size), still, initial, {0.01, 300},
                    [&](int i, const TimeState& state) {
                      EXPECT_NEAR(energy(state), before, 1e-9 * before) << "step " << i;
                    });
}

TEST(IntegrateNewmark, LosesTheEnergyThatTheDampersTake) {
  // E(end) - E(0) = -integral of v C v; both sides with the velocity at the middle of the step, exactly.
  double taken = 0;
  Eigen::VectorXd last = value(0.5);
  const TimeState end = integrate_newmark(oscillator(), damped(0.1), no_force, at(0, 0.5), {0.05, 40},
                                          [&](int i, const TimeState& state) {
                                            const double middle = 0.5 * (last[0] + state.velocity[0]);
                                            if (i > 0)
                                              taken += 0.05 * 2 * 0.1 * omega * mass * middle * middle;
                                            last = state.velocity;
                                          });
  const double energy =
      0.5 * mass * (std::pow(end.velocity[0], 2) + std::pow(omega * end.displacement[0], 2));
  EXPECT_NEAR(0.5 * mass * 0.25 - energy, taken, 1e-13);
  EXPECT_GT(taken, 0.05 * mass * 0.25);
}

TEST(IntegrateNewmark, TellsOfEveryInstantAndReturnsTheLast) {
  std::vector<int> steps;
  TimeState last;
  const TimeState end = integrate_newmark(
      oscillator(), damped(0.1), no_force, at(1, 0), {0.1, 3}, [&](int i, const TimeState& state) {
        steps.push_back(i);
        last = state;
        // M u'' + C u' + K u = f holds at every instant.
        EXPECT_NEAR(
            state.acceleration[0] + 0.2 * omega * state.velocity[0] + omega * omega * state.displacement[0],
            0, 1e-12);
      });
  EXPECT_EQ(steps, (std::vector<int>{0, 1, 2, 3}));
  EXPECT_EQ(end.displacement, last.displacement);
  EXPECT_EQ(end.velocity, last.velocity);
}

TEST(PeriodicResponse, OfAnOscillatorIsTheClosedFormOfTheSteadyState) {
  const TimeAxis axis{5, 20};
  const double ratio = 0.06, forced = 2 * pi * 3 / axis.period;  // 0.6 Hz, below the resonance
  const PeriodicResponse response = periodic_response(
      oscillator(), damped(ratio), [&](double t) { return value(std::cos(forced * t) + 2); }, axis,
      {.steps_per_sample = 200, .tolerance = 1e-7});
  const double stiff = mass * (omega * omega - forced * forced), drag = 2 * ratio * omega * mass * forced;
  for (int p = 0; p < 20; ++p) {
    const double t = p * axis.period / 20;
    const double wanted =
        2 / (mass * omega * omega) + std::cos(forced * t - std::atan2(drag, stiff)) / std::hypot(stiff, drag);
    EXPECT_NEAR(response.displacement(0, p), wanted, 1e-4 / std::hypot(stiff, drag)) << "sample " << p;
  }
}

TEST(PeriodicResponse, MissesNoMoreThanItSays) {
  // After 2.5 s what is left of the start is nearly in phase with what was, and the bound is the thing
  // itself.
  for (const double period : {2.0, 2.5}) {
    const auto blow = [&](double t) { return value(std::fmod(t, period) < 0.3 ? 1 : 0); };
    const auto response = [&](double tolerance) {
      return periodic_response(oscillator(), damped(0.02), blow, {period, 16},
                               {.steps_per_sample = 8, .tolerance = tolerance, .largest_loop_count = 300});
    };
    const PeriodicResponse late = response(1e-10);
    for (const double tolerance : {1e-2, 1e-3}) {
      const PeriodicResponse early = response(tolerance);
      const double missing = (early.displacement - late.displacement).norm() / late.displacement.norm();
      EXPECT_LE(early.missing, tolerance);
      EXPECT_LE(missing, 1.01 * early.missing) << "after " << early.loop_count << " loops of " << period;
      if (period == 2.5) {
        EXPECT_NEAR(early.missing, missing, 0.05 * missing);
      }
      EXPECT_LT(early.loop_count, late.loop_count);
    }
  }
}

TEST(PeriodicResponse, AnswersEveryFrequencyAsTheStructureDoesTheWarpedOne) {
  // u' = s u with s = (2/h) (z - 1)/(z + 1), z = e^(i omega h), so s = i (2/h) tan(omega h/2): exact,
  // whatever the step, and for dampers that are not symmetric. Complex LU is the second method.
  const Eigen::Index size = 5;
  const auto draw = [&](std::uint32_t what) {
    Eigen::MatrixXd matrix(size, size);
    for (Eigen::Index i = 0; i < matrix.size(); ++i) {
      matrix.data()[i] = uniform({4, RandomStream::test, what, static_cast<std::uint64_t>(i)}) - 0.5;
    }
    return matrix;
  };
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(size, size),
                        skew = draw(2) - draw(2).transpose();
  const Eigen::MatrixXd inertia = identity + draw(0) * draw(0).transpose();
  const Eigen::MatrixXd stiffness = 400 * (identity + draw(1) * draw(1).transpose());
  const Eigen::MatrixXd dampers = 8 * inertia + 10 * skew;
  const TimeAxis axis{1, 10};
  const int steps_per_sample = 4;
  const double h = axis.period / 40;
  Eigen::MatrixXcd force(size, 3);
  for (Eigen::Index i = 0; i < force.size(); ++i) {
    force.data()[i] = complex_gaussian({4, RandomStream::test, 3, static_cast<std::uint64_t>(i)});
  }
  const int bins[3] = {0, 1, 3};
  Eigen::MatrixXcd answer(size, 3);
  for (int b = 0; b < 3; ++b) {
    const double warped = 2 / h * std::tan(pi * bins[b] / axis.period * h);
    Eigen::MatrixXcd dynamic(size, size);
    dynamic.real() = stiffness - warped * warped * inertia;
    dynamic.imag() = warped * dampers;
    answer.col(b) = dynamic.lu().solve(force.col(b));
  }
  const auto series = [&](const Eigen::MatrixXcd& coefficients, double t) {
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(size);
    for (int b = 0; b < 3; ++b) {
      sum += (coefficients.col(b) * std::polar(1.0, 2 * pi * bins[b] * t / axis.period)).real();
    }
    return sum;
  };
  const PeriodicResponse response = periodic_response(
      {sparse(stiffness), sparse(inertia)}, sparse(dampers), [&](double t) { return series(force, t); }, axis,
      {.steps_per_sample = steps_per_sample, .tolerance = 1e-11});
  Eigen::MatrixXd wanted(size, 10);
  for (int p = 0; p < 10; ++p) wanted.col(p) = series(answer, p * 0.1);
  for (Eigen::Index i = 0; i < size; ++i) {
    EXPECT_LT((response.displacement.row(i) - wanted.row(i)).norm(), 1e-8 * wanted.row(i).norm())
        << "row " << i;
  }
}

TEST(PeriodicResponse, OfNoForceIsRestAndOfOneSampleIsNot) {
  EXPECT_EQ(periodic_response(oscillator(), damped(0.1), no_force, {2, 5}).displacement,
            Eigen::MatrixXd::Zero(1, 5));
  const PeriodicResponse leaning = periodic_response(
      oscillator(), damped(0.1), [](double) { return value(3); }, {2, 1}, {.tolerance = 1e-9});
  EXPECT_NEAR(leaning.displacement(0, 0), 3 / (mass * omega * omega), 1e-8);
}

TEST(PeriodicResponse, OfAForceThatHoldsStillIsStillFromTheStart) {
  const BeamTree tree = assemble_tree(test::awkward_tree(), {});
  const SparseMatrices matrices = assemble_sparse(tree);
  const Eigen::VectorXd force = Eigen::VectorXd::LinSpaced(tree.size(), -1, 2);
  const Eigen::VectorXd wanted = solve_static(tree, force);
  const PeriodicResponse response =
      periodic_response(matrices, Sparse(2 * matrices.mass), [&](double) { return force; }, {1, 6});
  EXPECT_EQ(response.loop_count, 2);
  for (int p = 0; p < 6; ++p) {
    EXPECT_LT((response.displacement.col(p) - wanted).norm(), 1e-8 * wanted.norm()) << "sample " << p;
  }
}

TEST(PeriodicResponse, GivesUpWhereNothingDies) {
  const auto resonant = [](double t) { return value(std::cos(omega * t)); };
  EXPECT_THROW(periodic_response(oscillator(), damped(0), resonant, {2 * pi / omega, 8}), Error);
  EXPECT_THROW(periodic_response(oscillator(), damped(0), resonant, {1, 8}), Error);
  EXPECT_THROW(periodic_response(oscillator(), damped(-0.5), resonant, {1, 8}, {.largest_loop_count = 1000}),
               Error);
}

TEST(IntegrateNewmark, RefusesWhatIsNoEquationOfMotion) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto integrate = [](const SparseMatrices& matrices, const Sparse& damping, const TimeState& initial,
                            const TimeIntegration& settings, const ForceAtTime& force = no_force) {
    integrate_newmark(matrices, damping, force, initial, settings);
  };
  const TimeIntegration good{0.1, 2};
  EXPECT_NO_THROW(integrate(oscillator(), damped(0), at(0, 0), good));
  for (const double step : {0.0, -1.0, nan, std::numeric_limits<double>::infinity()}) {
    EXPECT_THROW(integrate(oscillator(), damped(0), at(0, 0), {step, 2}), InputError);
  }
  EXPECT_THROW(integrate(oscillator(), damped(0), at(0, 0), {0.1, 0}), InputError);
  EXPECT_THROW(integrate(oscillator(), Sparse(2, 2), at(0, 0), good), InputError);
  EXPECT_THROW(integrate(oscillator(), number(nan), at(0, 0), good), InputError);
  EXPECT_THROW(integrate({Sparse(2, 2), number(1)}, damped(0), at(0, 0), good), InputError);
  EXPECT_THROW(integrate({Sparse(0, 0), Sparse(0, 0)}, Sparse(0, 0), {}, good), InputError);
  EXPECT_THROW(integrate(oscillator(), damped(0), {Eigen::Vector2d(0, 0), value(0), {}}, good), InputError);
  EXPECT_THROW(integrate(oscillator(), damped(0), at(0, nan), good), InputError);
  EXPECT_THROW(integrate(oscillator(), damped(0), at(0, 0), good, [=](double) { return value(nan); }),
               InputError);
  EXPECT_THROW(integrate(oscillator(), damped(0), at(0, 0), good,
                         [](double) -> Eigen::VectorXd { return Eigen::Vector2d(1, 1); }),
               InputError);
  EXPECT_THROW(integrate({number(1), number(-1)}, damped(0), at(0, 0), good), Error);
  EXPECT_THROW(integrate({number(-16), number(1)}, damped(0), at(0, 0), {0.5, 2}), Error);  // K + 4/h^2 M = 0
}

TEST(PeriodicResponse, RefusesSettingsThatMakeNoLoop) {
  const auto respond_to = [](const TimeAxis& axis, const PeriodicIntegration& settings) {
    periodic_response(oscillator(), damped(0.1), no_force, axis, settings);
  };
  EXPECT_NO_THROW(respond_to({1, 4}, {}));
  EXPECT_THROW(respond_to({0, 4}, {}), InputError);
  EXPECT_THROW(respond_to({NAN, 4}, {}), InputError);
  EXPECT_THROW(respond_to({1, 0}, {}), InputError);
  EXPECT_THROW(respond_to({1, 4}, {.steps_per_sample = 0}), InputError);
  EXPECT_THROW(respond_to({1, 4}, {.tolerance = 0}), InputError);
  EXPECT_THROW(respond_to({1, 4}, {.tolerance = NAN}), InputError);
  EXPECT_THROW(respond_to({1, 4}, {.largest_loop_count = 0}), InputError);
  EXPECT_THROW(periodic_response({number(-1), number(1)}, damped(0.1), no_force, {1, 4}), Error);
}

}  // namespace
}  // namespace tremula
