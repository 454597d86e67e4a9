#include "tremula/wind/field_at_points.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "complaint.hpp"
#include "tremula/numerics/fft.hpp"
#include "tremula/numerics/random.hpp"

namespace tremula {
namespace {

constexpr double pi = std::numbers::pi;

double gaussian(std::uint32_t what, std::uint64_t place) {
  return std::numbers::sqrt2 * complex_gaussian({13, RandomStream::test, what, place}).real();
}

// Another noise at every point, with a mean that grows with height.
WindField noise_field(WindGrid grid) {
  WindField field;
  field.grid = grid;
  for (std::size_t c = 0; c < 3; ++c) {
    std::uint64_t place = 0;
    for (int t = 0; t < grid.step_count; ++t) {
      for (int i = 0; i < grid.z_count; ++i) {
        for (int j = 0; j < grid.y_count; ++j) {
          field.velocity[c].push_back(
              static_cast<float>((c == 0 ? 5 + i : 0) + gaussian(static_cast<std::uint32_t>(c), place++)));
        }
      }
    }
  }
  return field;
}

double at(const WindField& field, std::size_t component, int step, int row, int column) {
  const WindGrid& grid = field.grid;
  return static_cast<double>(field.velocity[component][static_cast<std::size_t>(
      (step * grid.z_count + row) * grid.y_count + column)]);
}

// The loop as samples (M x 3) at one point, mean included.
Eigen::MatrixXd samples(const FieldAtPoints& wind, const TimeAxis& loop, Eigen::Index point) {
  Eigen::MatrixXcd spectra(loop.bin_count(), 3);
  for (int p = 0; p < loop.bin_count(); ++p) spectra.row(p) = wind.velocity(p).col(point).transpose();
  Eigen::MatrixXd series = samples_from_half_spectra(spectra, loop.sample_count);
  series.rowwise() += wind.mean_velocity().col(point).transpose();
  return series;
}

const WindGrid small{.y_count = 4,
                     .z_count = 3,
                     .step_count = 40,
                     .y_spacing = 2,
                     .z_spacing = 3,
                     .bottom = 1.5,
                     .step = 0.25,
                     .mean_speed = 8};

TEST(FieldAtPoints, AreTheFieldItselfAtItsGridPointsAndTimes) {
  for (const int step_count : {40, 41}) {
    WindGrid grid = small;
    grid.step_count = step_count;
    const WindField field = noise_field(grid);
    Eigen::Matrix3Xd points(3, 12);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 4; ++j) points.col(4 * i + j) << 0, grid.y(j), grid.z(i);
    const TimeAxis loop{grid.period(), step_count};
    const FieldAtPoints wind(field, 0, loop, points);
    EXPECT_EQ(wind.outside_count(), 0U);
    EXPECT_TRUE(wind.warnings().empty());
    EXPECT_EQ(wind.velocity(0).norm(), 0);
    for (int k = 0; k < 12; ++k) {
      const Eigen::MatrixXd series = samples(wind, loop, k);
      for (int t = 0; t < step_count; ++t) {
        for (std::size_t c = 0; c < 3; ++c)
          ASSERT_NEAR(series(t, static_cast<Eigen::Index>(c)), at(field, c, t, k / 4, k % 4), 2e-6);
      }
    }
  }
}

// A finer loop passes through the same values and adds nothing above the field's Nyquist frequency; a coarser
// one has the same bins as far as it goes.
TEST(FieldAtPoints, HaveTheSameBinsInFinerAndCoarserLoops) {
  const WindField field = noise_field(small);
  Eigen::Matrix3Xd points(3, 1);
  points << 0, small.y(2), small.z(1);
  const TimeAxis fine{10, 160}, coarse{10, 16};
  const FieldAtPoints in_fine(field, 0, fine, points), in_coarse(field, 0, coarse, points);
  const Eigen::MatrixXd series = samples(in_fine, fine, 0);
  for (int t = 0; t < 40; ++t) EXPECT_NEAR(series(4 * t, 1), at(field, 1, t, 1, 2), 2e-6);
  for (int p = 21; p < fine.bin_count(); ++p) EXPECT_EQ(in_fine.velocity(p).norm(), 0);
  for (int p = 0; p < coarse.bin_count(); ++p)
    EXPECT_EQ((in_coarse.velocity(p) - in_fine.velocity(p)).norm(), 0) << "bin " << p;
}

TEST(FieldAtPoints, CarryTheGustsAlongWithTheMeanSpeed) {
  const WindField field = noise_field(small);
  Eigen::Matrix3Xd points(3, 3);
  points << 0, 7 * 0.25 * 8, -3 * 0.25 * 8,  // seven steps downwind, three upwind
      -1, -1, -1, 4.5, 4.5, 4.5;
  const TimeAxis loop{10, 40};
  const FieldAtPoints wind(field, 0, loop, points);
  for (int t = 0; t < 40; ++t) {
    for (std::size_t c = 0; c < 3; ++c) {
      const auto column = static_cast<Eigen::Index>(c);
      EXPECT_NEAR(samples(wind, loop, 1)((t + 7) % 40, column), at(field, c, t, 1, 1), 4e-6);
      EXPECT_NEAR(samples(wind, loop, 2)((t + 37) % 40, column), at(field, c, t, 1, 1), 4e-6);
    }
  }
}

// The plant and its wind turned together: the same wind, turned.
TEST(FieldAtPoints, TurnWithTheHeading) {
  const WindField field = noise_field(small);
  Eigen::Matrix3Xd points(3, 5);
  for (Eigen::Index i = 0; i < points.size(); ++i)
    points.data()[i] = 1 + gaussian(7, static_cast<std::uint64_t>(i));
  const TimeAxis loop{10, 40};
  const double heading = 130;
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(heading * pi / 180, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const FieldAtPoints straight(field, 0, loop, points), turned(field, heading, loop, turn * points);
  for (int p = 0; p < loop.bin_count(); ++p)
    EXPECT_LT((turned.velocity(p) - turn * straight.velocity(p)).norm(), 1e-6);
  EXPECT_LT((turned.mean_velocity() - turn * straight.mean_velocity()).norm(), 1e-6);
  EXPECT_GT(straight.mean_velocity().row(0).minCoeff(), 4);
}

TEST(FieldAtPoints, InterpolateLinearlyAndTakeTheEdgeBeyondIt) {
  const WindField field = noise_field(small);
  Eigen::Matrix3Xd points(3, 4);
  points << 0, 0, 0, 0,                                  //
      small.y(1) + 0.5, small.y(3), small.y(0) - 50, 0,  //
      small.z(1) + 0.75, small.z(2), small.z(0) - 1, small.z(2) + 0.1;
  const TimeAxis loop{10, 40};
  const FieldAtPoints wind(field, 0, loop, points);
  EXPECT_EQ(wind.outside_count(), 2U);
  for (int t = 0; t < 40; ++t) {
    for (std::size_t c = 0; c < 3; ++c) {
      const auto column = static_cast<Eigen::Index>(c);
      const double between = 0.75 * (0.75 * at(field, c, t, 1, 1) + 0.25 * at(field, c, t, 1, 2)) +
                             0.25 * (0.75 * at(field, c, t, 2, 1) + 0.25 * at(field, c, t, 2, 2));
      EXPECT_NEAR(samples(wind, loop, 0)(t, column), between, 4e-6);
      EXPECT_NEAR(samples(wind, loop, 1)(t, column), at(field, c, t, 2, 3), 4e-6);
      EXPECT_NEAR(samples(wind, loop, 2)(t, column), at(field, c, t, 0, 0), 4e-6);
      EXPECT_NEAR(samples(wind, loop, 3)(t, column), 0.5 * (at(field, c, t, 2, 1) + at(field, c, t, 2, 2)),
                  4e-6);
    }
  }
}

TEST(FieldAtPoints, BlowTheSameEverywhereFromAFieldOfOnePoint) {
  WindGrid grid = small;
  grid.y_count = grid.z_count = 1;
  const WindField field = noise_field(grid);
  Eigen::Matrix3Xd points(3, 2);
  points << 0, 0, 0, 30, 1.5, 99;
  const FieldAtPoints wind(field, 0, {10, 40}, points);
  for (int p = 0; p <= 20; ++p) EXPECT_EQ((wind.velocity(p).col(0) - wind.velocity(p).col(1)).norm(), 0);
  EXPECT_EQ(wind.outside_count(), 0U);
}

TEST(FieldAtPoints, TakeThePeriodAskedForWhenItIsTheFieldsToHalfAStep) {
  WindGrid grid = small;
  grid.step = static_cast<double>(0.1F);  // as in a TurbSim file
  const WindField field = noise_field(grid);
  Eigen::Matrix3Xd points(3, 1);
  points << 0, 0, 3;
  const FieldAtPoints asked(field, 0, {4, 40}, points), own(field, 0, {grid.period(), 40}, points);
  EXPECT_TRUE(asked.warnings().empty());
  for (int p = 0; p <= 20; ++p) EXPECT_EQ((asked.velocity(p) - own.velocity(p)).norm(), 0);
}

// A slow wave, far from whole in the loop: the first nine tenths are left as they are, and nowhere, the seam
// included, does the loop make a larger step than the fade between two phases of the wave can.
TEST(FieldAtPoints, CloseALoopThatIsShorterThanTheField) {
  for (const bool periodic : {true, false}) {
    WindGrid grid = small;
    grid.step_count = 400;
    grid.periodic = periodic;
    WindField field = noise_field(grid);
    const double omega = 2 * pi / 36.4;  // per step
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::size_t n = 0; n < field.velocity[c].size(); ++n)
        field.velocity[c][n] = static_cast<float>(3 + std::sin(omega * static_cast<double>(n / 12) + 0.4));
    }
    Eigen::Matrix3Xd points(3, 1);
    points << 0, 0, 3;
    const TimeAxis loop{200 * grid.step, 200};
    const FieldAtPoints wind(field, 0, loop, points);
    ASSERT_EQ(wind.warnings().size(), 1U);
    EXPECT_EQ(
        wind.warnings()[0],
        "the loop of 50 s takes the beginning of a wind field of 100 s and fades its end into its start over "
        "5 s; gusts slower than the loop are cut off");
    const Eigen::MatrixXd series = samples(wind, loop, 0);
    for (int t = 0; t < 180; ++t) ASSERT_NEAR(series(t, 0), at(field, 0, t, 0, 0), 4e-6) << t;
    // |d/dt (c x + s y)| <= sqrt2 (|x'| + angle'), with waves and their parts about the mean below 1.1.
    const double largest_step = std::numbers::sqrt2 * 1.1 * (omega + 0.5 * pi / 21);
    for (int t = 0; t < 200; ++t)
      EXPECT_LT(std::abs(series((t + 1) % 200, 0) - series(t, 0)), largest_step) << "step " << t;
  }
}

TEST(FieldAtPoints, KeepTheVarianceWhereTheLoopIsFaded) {
  WindGrid grid = small;
  grid.step_count = 200;
  grid.y_count = 20;
  grid.z_count = 20;
  grid.periodic = false;
  const WindField field = noise_field(grid);
  Eigen::Matrix3Xd points(3, 400);
  for (int k = 0; k < 400; ++k) points.col(k) << 0, grid.y(k % 20), grid.z(k / 20);
  const TimeAxis loop{grid.period(), 200};
  const FieldAtPoints wind(field, 0, loop, points);
  ASSERT_EQ(wind.warnings().size(), 1U);
  EXPECT_EQ(wind.warnings()[0], "the wind field is not periodic: its last 5 s fade into its start");
  Eigen::MatrixXcd spectra(loop.bin_count(), 400);  // of v
  for (int p = 0; p < loop.bin_count(); ++p) spectra.row(p) = wind.velocity(p).row(1);
  const Eigen::MatrixXd series = samples_from_half_spectra(spectra, loop.sample_count);
  // Of the 20 faded steps, of white noise of variance 1.
  const double variance = series.bottomRows(20).squaredNorm() / (20 * 400);
  // Of 8000 squares the mean scatters by sqrt(2/8000); the fluctuation is about a mean of 200 steps.
  EXPECT_NEAR(variance, 1, 5 * std::sqrt(2.0 / 8000) + 1.0 / 200);
}

TEST(FieldAtPoints, AreRefusedWhereThereIsNoSuchLoop) {
  const WindField field = noise_field(small);
  const Eigen::Matrix3Xd points = Eigen::Matrix3Xd::Zero(3, 1);
  const auto complaint = [&](const WindField& of, double heading, const TimeAxis& loop,
                             const Eigen::Matrix3Xd& where) {
    return test::complaint_of([&] { FieldAtPoints(of, heading, loop, where); });
  };
  EXPECT_EQ(complaint(field, 0, {10, 40}, points), "");
  EXPECT_EQ(complaint(field, 0, {10.1, 40}, points), "");
  EXPECT_EQ(complaint(field, 0, {10.2, 40}, points),
            "period of the loop: 10.2 s, wanted at most the 10 s of the wind field (or a longer field)");
  EXPECT_EQ(complaint(field, 0, {0.1, 40}, points),
            "period of the loop: 0.1 s, wanted at least a step of the wind field, 0.25 s");
  EXPECT_EQ(complaint(field, 0, {std::nan(""), 40}, points),
            "period of the loop: nan s, wanted at least a step of the wind field, 0.25 s");
  EXPECT_EQ(complaint(field, 0, {10, 0}, points), "samples of the loop: 0, wanted 1 or more");
  EXPECT_EQ(complaint(field, std::nan(""), {10, 40}, points), "heading: nan, wanted an angle in degrees");
  WindField calm = field;
  calm.grid.mean_speed = 0;
  EXPECT_EQ(complaint(calm, 0, {10, 40}, points),
            "mean speed of the wind field: 0, wanted above 0 m/s, to carry the gusts along");
  Eigen::Matrix3Xd nowhere = points;
  nowhere(1, 0) = std::nan("");
  EXPECT_EQ(complaint(field, 0, {10, 40}, nowhere), "point 0: not finite, wanted a place in metres");
}

TEST(FieldAtPoints, GiveLoopsOfOneAndOfThreeSteps) {
  const WindField field = noise_field(small);
  Eigen::Matrix3Xd points(3, 1);
  points << 0, small.y(0), small.z(0);
  for (const int steps : {1, 3}) {
    const TimeAxis loop{steps * small.step, steps};
    const FieldAtPoints wind(field, 0, loop, points);
    const Eigen::MatrixXd series = samples(wind, loop, 0);
    for (int t = 0; t < steps; ++t) EXPECT_NEAR(series(t, 0), at(field, 0, t, 0, 0), 2e-6);
  }
}

}  // namespace
}  // namespace tremula
