#include "tremula/dynamics/gust_response.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include <tbb/global_control.h>
#include "complaint.hpp"
#include "trees.hpp"
#include "tremula/dynamics/damping.hpp"
#include "tremula/dynamics/free_decay.hpp"
#include "tremula/dynamics/oscillators.hpp"
#include "tremula/modes/solve_modes.hpp"
#include "tremula/wind/gust_script.hpp"

namespace tremula {
namespace {

using std::numbers::pi;

constexpr double speed = 8;

// A limp stem in an even wind along x, by a few of its modes.
struct Stem {
  Structure structure = assemble(test::straight_stem(8, 2, 0.008, 0.005), {});
  LoadOptions loads = {};
  WindAt wind = [](Eigen::Index, const Vec3&) { return GustStatistics{Vec3(speed, 0, 0), Mat3::Zero()}; };
  Lean lean;
  Modes modes;
  Eigen::VectorXd omega, damping;

  explicit Stem(bool from_rest, double ratio = 0.02) {
    lean = from_rest ? lean_at_rest(structure, wind, loads) : find_lean(structure, wind, loads);
    modes = solve_modes(lean.structure, {.count = 4});
    omega = modes.omega();
    damping = 2 * ratio * omega;
  }

  ChangingWind blowing(const GustScript& script) const {
    ChangingWind changing;
    changing.mean = Vec3(speed, 0, 0).replicate(1, lean.sites.point_count());
    changing.change = [script](double time) { return change_of_wind(wind_at_time(script, time), speed, 0); };
    return changing;
  }

  Eigen::MatrixXd respond(const GustScript& script, const TimeAxis& axis,
                          GustResponseOptions options = {}) const {
    options.loads = loads;
    return respond_to_gusts(lean, modes.shapes, omega, damping, blowing(script), axis, options);
  }
};

TEST(RespondToGusts, AWindThatStaysLeavesThePlantWhereItLeans) {
  const Stem stem(false);
  const Eigen::MatrixXd still = stem.respond({.rows = {{0, speed, 0}}}, {.period = 2, .sample_count = 40});
  const Eigen::MatrixXd gone = stem.respond({.rows = {{0, 0, 0}}}, {.period = 2, .sample_count = 40});
  EXPECT_LT(still.cwiseAbs().maxCoeff(), 1e-3 * gone.cwiseAbs().maxCoeff());
  EXPECT_GT(gone.cwiseAbs().maxCoeff(), 0);
}

TEST(RespondToGusts, StandsInTheFirstWindUntilThatChanges) {
  const Stem stem(false);
  const Eigen::MatrixXd moved =
      stem.respond({.rows = {{0, 11, 0}, {1, 11, 0}, {2, 5, 0}}}, {.period = 3, .sample_count = 60});
  const double size = moved.row(0).norm();
  EXPECT_GT(size, 0);
  for (int p = 0; p < 20; ++p) EXPECT_LT((moved.row(p) - moved.row(0)).norm(), 1e-6 * size) << p;
  EXPECT_GT((moved.row(59) - moved.row(0)).norm(), 0.1 * size);
}

TEST(RespondToGusts, FromRestBeginsAtRestToTheBit) {
  const Stem stem(true);
  const Eigen::MatrixXd moved =
      stem.respond({.rows = {{0, speed, 0}}}, {.period = 2, .sample_count = 40}, {.from_rest = true});
  EXPECT_TRUE(moved.row(0).isZero(0));
  EXPECT_TRUE(stem.lean.displacement.isZero(0));
  EXPECT_GT(moved.row(39).norm(), 0);
}

// The wind's damping is not put in: what moves in the wind meets more or less of it. Small motions about a
// steady wind die as its linearised damping says.
TEST(RespondToGusts, SmallMotionsAreDampedAsTheLinearisedLoadsSay) {
  const Stem stem(false, 0.01);
  const TimeAxis axis{.period = 20, .sample_count = 2000};
  const Eigen::MatrixXd moved =
      stem.respond({.rows = {{0, 1.01 * speed, 0}, {0.2, speed, 0}}}, axis, {.turning = false});
  const Eigen::MatrixXd by_wind = aerodynamic_damping(stem.lean.sites, stem.lean.loads, stem.modes.shapes);
  Eigen::Index mode = 0;  // one of the first two bends along the wind
  moved.leftCols(2).cwiseAbs().colwise().maxCoeff().maxCoeff(&mode);
  const double ratio = (stem.damping[mode] + by_wind(mode, mode)) / (2 * stem.omega[mode]);
  const FreeDecay decay = evaluate_decay(moved.col(mode).tail(1975), 0.01, {.lowest = 0.05});
  EXPECT_GT(ratio, 0.02);
  EXPECT_NEAR(decay.damping_ratio, ratio, 0.03 * ratio);
  EXPECT_NEAR(decay.frequency, stem.modes.frequency[mode], 0.01 * decay.frequency);
}

// A second method: a gust that is small against the wind, through the linearised network.
TEST(RespondToGusts, ASmallOneMinusCosineGustIsWhatTheLinearNetworkMakesOfIt) {
  const Stem stem(false, 0.02);
  const double amplitude = 0.02 * speed;
  const TimeAxis axis{.period = 6, .sample_count = 1200};
  const GustScript script{.rows = {{0, speed, 0}}, .gust = OneMinusCosine{amplitude, 1.5, 0.5}};
  const Eigen::MatrixXd moved = stem.respond(script, axis, {.turning = false});

  const Eigen::MatrixXd by_wind = aerodynamic_damping(stem.lean.sites, stem.lean.loads, stem.modes.shapes);
  const Eigen::MatrixXd damping = by_wind + Eigen::MatrixXd(stem.damping.asDiagonal());
  const Eigen::MatrixXd coupling = stem.omega.cwiseAbs2().asDiagonal();
  const OscillatorNetwork network{Eigen::VectorXd::Ones(4), damping.sparseView(), coupling.sparseView()};
  const Eigen::MatrixXd participation =
      modal_participation(stem.lean.sites, stem.lean.loads, stem.modes.shapes);
  const Eigen::VectorXd even = Vec3(1, 0, 0).replicate(stem.lean.sites.point_count(), 1);
  Eigen::MatrixXd forces(4, axis.sample_count);
  for (int p = 0; p < axis.sample_count; ++p) {
    const double gust = wind_at_time(script, axis.period * p / axis.sample_count).speed - speed;
    forces.col(p) = gust * (participation.transpose() * even);
  }
  const Eigen::MatrixXd linear =
      respond_in_time(network, axis.period / axis.sample_count, forces).transpose();
  EXPECT_LT((moved - linear).norm(), 0.02 * linear.norm());
}

// x'' + omega^2 x = A/2 (1 - cos(2 pi t/T)) from rest, while it blows.
TEST(OneMinusCosine, DrivesOneOscillatorAsItsClosedFormSays) {
  const double amplitude = 3, duration = 2, omega = 5, step = 1e-3, driven = 2 * pi / duration;
  const OscillatorNetwork network{Eigen::VectorXd::Ones(1), Eigen::MatrixXd::Zero(1, 1).sparseView(),
                                  Eigen::MatrixXd::Constant(1, 1, omega * omega).sparseView()};
  const GustScript script{.rows = {{0, 0, 0}}, .gust = OneMinusCosine{amplitude, duration, 0}};
  Eigen::MatrixXd forces(1, 2001);
  for (int p = 0; p <= 2000; ++p) forces(0, p) = wind_at_time(script, p * step).speed;
  const Eigen::MatrixXd moved = respond_in_time(network, step, forces);
  for (int p = 0; p <= 2000; p += 50) {
    const double t = p * step;
    const double wanted =
        amplitude / (2 * omega * omega) * (1 - std::cos(omega * t)) -
        amplitude / (2 * (omega * omega - driven * driven)) * (std::cos(driven * t) - std::cos(omega * t));
    EXPECT_NEAR(moved(0, p), wanted, 1e-5) << t;
  }
}

TEST(RespondToGusts, IsOfSecondOrderInTheStep) {
  const Stem stem(true);
  const GustScript script{.rows = {{0, 4, 0}, {1, 9, 40}, {2, 3, 0}}};
  const TimeAxis axis{.period = 3, .sample_count = 60};
  const auto with = [&](double angle) {
    return stem.respond(script, axis, {.from_rest = true, .step_angle = angle});
  };
  const Eigen::MatrixXd fine = with(0.0125);
  const double coarse_error = (with(0.2) - fine).norm(), halved_error = (with(0.1) - fine).norm();
  EXPECT_LT(coarse_error, 0.02 * fine.norm());
  EXPECT_GT(coarse_error / halved_error, 3);
}

TEST(RespondToGusts, IsTheSameOnAnyNumberOfThreads) {
  const Stem stem(true);
  const GustScript script{.rows = {{0, 4, 0}, {1, 9, 40}}};
  const auto with = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return stem.respond(script, {.period = 1, .sample_count = 30}, {.from_rest = true});
  };
  EXPECT_EQ(with(1), with(4));
}

TEST(RespondToGusts, RefusesWhatHasNoSuchDrag) {
  Stem stem(true);
  stem.loads.model = LoadModel::paper;
  EXPECT_EQ(test::complaint_of([&] {
              stem.respond({.rows = {{0, 5, 0}}}, {.period = 1, .sample_count = 10});
            }),
            "gusts: loads as printed, which have no mean wind, wanted other loads");
}

}  // namespace
}  // namespace tremula
