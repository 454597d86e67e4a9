#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>

#include "trees.hpp"
#include "tremula/base/error.hpp"
#include "tremula/dynamics/gauge.hpp"
#include "tremula/geometry/grow.hpp"
#include "tremula/geometry/plants.hpp"
#include "tremula/numerics/fft.hpp"
#include "tremula/numerics/random.hpp"
#include "tremula/pipeline.hpp"

namespace tremula {
namespace {

const Subject& sapling() {
  static const Subject subject =
      bake(grow(parse_lsystem(find_preset("sapling").text, "sapling")).skeleton, {.modes = {.count = 12}});
  return subject;
}

// Gusts along x, the same everywhere and the same power in all bins, of this standard deviation.
Wind gusts_everywhere(double speed, double deviation) {
  Wind wind;
  wind.reference = {.speed = speed};
  wind.at_points = [=](const TimeAxis& loop, const Eigen::Matrix3Xd& points) {
    PointWind result{.mean = Vec3(speed, 0, 0).replicate(1, points.cols()), .velocity = {}};
    const double of_bin = deviation / std::sqrt(2.0 * (loop.bin_count() - 1));
    result.velocity = [=, count = points.cols()](int bin, int draw) {
      const auto gust = of_bin * complex_gaussian({.seed = 17, .bin = bin_of_draw(bin, draw)});
      Eigen::Matrix3Xcd velocity = Eigen::Matrix3Xcd::Zero(3, count);
      velocity.row(0).setConstant(gust);
      return velocity;
    };
    result.has_slow_gusts = false;
    return result;
  };
  return wind;
}

// What is sampled of it.
Eigen::VectorXd speeds_of(const Wind& wind, const TimeAxis& loop) {
  const PointWind at_point = wind_at_points(wind, loop, Vec3::Zero());
  Eigen::VectorXcd spectrum = Eigen::VectorXcd::Zero(loop.bin_count());
  for (int bin = 1; bin < loop.bin_count(); ++bin) spectrum[bin] = at_point.velocity(bin, 0)(0, 0);
  return samples_from_half_spectra(spectrum, loop.sample_count).col(0).array() + at_point.mean(0, 0);
}

double quantile(Eigen::VectorXd values, double share) {
  const auto place = values.data() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size()));
  std::nth_element(values.data(), place, values.data() + values.size());
  return *place;
}

// Of a stub far too stiff to vibrate in these gusts, in pieces short enough for loads to count at their ends.
Eigen::VectorXd base_moments(const Wind& wind, const TimeAxis& loop, Drag drag) {
  const Skeleton stub = test::straight_stem(8, 0.3, 0.05, 0.05);
  const Subject subject = bake(stub, {.structure = test::weightless(), .modes = {.count = all_modes}});
  Weather weather{.wind = wind, .drag = drag, .lean = {.shelter = {.on = false}}, .loop = loop};
  weather.gauges = {place_gauge(stub, "base")};
  const Motion motion = set_in_motion(subject, weather);
  return gauge_series(motion.readings[0], motion, 0).along_wind;
}

TEST(QuadraticDrag, HasTheQuantilesOfTheSquareOfItsWind) {
  // (1 + I z)^2 with the quantile z of a Gaussian: at I = 1/3 4.12 of the drag without gusts, where the best
  // linear fit has 3.2.
  constexpr double speed = 8, intensity = 1.0 / 3, z = 3.0902;
  const TimeAxis loop{(1 << 17) / 30.0, 1 << 17};
  const Wind wind = gusts_everywhere(speed, intensity * speed);
  const double at_mean_speed = 0.5 * 1.2 * 1.2 * 0.1 * 0.3 * 0.15 * speed * speed;
  const double wanted = std::pow(1 + intensity * z, 2) * at_mean_speed;
  const Eigen::VectorXd quadratic = base_moments(wind, loop, Drag::quadratic),
                        linear = base_moments(wind, loop, Drag::linear);
  EXPECT_NEAR(quantile(quadratic, 0.999), wanted, 0.03 * wanted);
  EXPECT_LT(quantile(linear, 0.999), 0.85 * wanted);

  const Eigen::ArrayXd speeds = speeds_of(wind, loop).array();
  const Eigen::VectorXd squared = at_mean_speed / (speed * speed) * speeds.abs() * speeds;
  EXPECT_LT((quadratic - squared).cwiseAbs().maxCoeff(), 0.01 * wanted);
  EXPECT_NEAR(quadratic.mean(), (1 + intensity * intensity) * at_mean_speed, 0.01 * at_mean_speed);
}

TEST(QuadraticDrag, TendsToTheLinearOneInSmallGusts) {
  double differs[2];
  for (const int i : {0, 1}) {
    const double intensity = i == 0 ? 0.02 : 0.002;
    Weather weather{.wind = gusts_everywhere(8, 8 * intensity),
                    .loop = {8, 95}};  // no bin at the end of which half is lost
    const Motion linear = set_in_motion(sapling(), weather);
    weather.drag = Drag::quadratic;
    const Motion quadratic = set_in_motion(sapling(), weather);
    differs[i] = (quadratic.coordinates - linear.coordinates).norm() /
                 (linear.coordinates.rightCols(linear.basis.count() - 1)).norm();
  }
  EXPECT_LT(differs[0], 0.03);
  EXPECT_LT(differs[1], 0.15 * differs[0]);
}

TEST(QuadraticDrag, DoesNotDependOnTheNumberOfThreads) {
  Eigen::MatrixXd coordinates[2];
  for (const std::size_t threads : {std::size_t{1}, std::size_t{2}}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    coordinates[threads - 1] =
        set_in_motion(sapling(), {.drag = Drag::quadratic, .loop = {8, 96}}).coordinates;
  }
  EXPECT_EQ(coordinates[0], coordinates[1]);
}

}  // namespace
}  // namespace tremula
