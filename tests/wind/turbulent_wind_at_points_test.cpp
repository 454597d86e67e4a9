#include "tremula/wind/turbulent_wind_at_points.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <vector>

#include <tbb/parallel_for.h>

#include "tremula/base/error.hpp"
#include "wind/points.hpp"

namespace tremula {
namespace {

const TimeAxis loop{20, 400};

TurbulentWind wind_of(SpectrumKind kind, std::uint64_t seed = 1) {
  TurbulentWind wind = turbulent_wind({.speed = 6}, 0.2, kind);
  wind.seed = seed;
  return wind;
}

// A loop whose first bin is the bin wanted of the other.
TimeAxis only(int bin) { return {loop.period / bin, 3}; }

TEST(TurbulentWindAtPoints, HasTheSpectrumOfItsHeightWhereverAPointLiesBetweenNodes) {
  const Eigen::Matrix3Xd points = test::random_points(40, 12);
  constexpr int seeds = 2000;
  for (const int bin : {2, 20, 150}) {
    Eigen::Matrix3Xd power = Eigen::Matrix3Xd::Zero(3, points.cols());
    for (std::uint64_t seed = 0; seed < seeds; ++seed) {
      power += TurbulentWindAtPoints(wind_of(SpectrumKind::simiu_scanlan, seed), only(bin), points,
                                     {.largest_plane = 400})
                   .velocity(1)
                   .cwiseAbs2() /
               seeds;
    }
    for (Eigen::Index k = 0; k < points.cols(); ++k) {
      const Vec3 wanted =
          spectrum_at(wind_of(SpectrumKind::simiu_scanlan), points(2, k), loop.frequency(bin)) /
          (2 * only(bin).period);
      for (int c = 0; c < 3; ++c) {
        // |v|^2 is exponential: its mean over n seeds has a standard error of 1/sqrt(n).
        EXPECT_NEAR(power(c, k) / wanted[c], 1, 4.2 / std::sqrt(static_cast<double>(seeds)))
            << bin << ", " << k;
      }
    }
  }
}

struct CoherenceErrors {
  double far = 0, near = 0;  // from 1.5 spacings of the nodes on, and closer
};

// The largest differences of the root-coherence of u from the model's, over the pairs of some points in a
// plane across the wind, less what chance makes of it.
CoherenceErrors coherence_errors(double resolution, int bin) {
  Eigen::Matrix3Xd points = test::random_points(14, 4);
  points.row(0).setZero();
  points.row(2).array() += 4;
  points.col(13) = points.col(12) + Vec3(0, 0.02, 0);
  constexpr int seeds = 4000;
  Eigen::MatrixXcd unit(seeds, points.cols());
  double spacing = 0;
  for (int seed = 0; seed < seeds; ++seed) {
    const TurbulentWindAtPoints at_points(wind_of(SpectrumKind::iec_kaimal, static_cast<std::uint64_t>(seed)),
                                          only(bin), points,
                                          {.resolution = resolution, .largest_plane = 1 << 14});
    unit.row(seed) = at_points.velocity(1).row(0);
    spacing = std::max(at_points.plane(1).row_spacing, at_points.plane(1).column_spacing);
  }
  unit.array().rowwise() /= unit.colwise().norm().array().cast<std::complex<double>>();
  const Eigen::MatrixXd found = (unit.adjoint() * unit).real();
  CoherenceErrors largest;
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    for (Eigen::Index j = 0; j < i; ++j) {
      const Vec3 apart = points.col(i) - points.col(j);
      const double wanted = root_coherence(wind_of(SpectrumKind::iec_kaimal).coherence, 0,
                                           loop.frequency(bin), apart[1], apart[2]);
      const double chance = 3.5 * (1 - wanted * wanted) / std::sqrt(2.0 * seeds);
      double& worst = apart.norm() > 1.5 * spacing ? largest.far : largest.near;
      worst = std::max(worst, std::abs(found(i, j) - wanted) - chance);
    }
  }
  return largest;
}

TEST(TurbulentWindAtPoints, HasTheCoherenceOfTheModelFromOneAndAHalfSpacingsOnAndNearlySoCloser) {
  for (const int bin : {2, 8, 20}) {
    const CoherenceErrors errors = coherence_errors(0.3, bin);
    EXPECT_LT(errors.far, 0.03) << bin;
    EXPECT_LT(errors.near, 0.13) << bin;
  }
  EXPECT_GT(coherence_errors(2, 20).near, 0.13) << "then the test is blind";
}

TEST(TurbulentWindAtPoints, BlowsFromPointToPointWithTheSpeedOfTheReferenceHeight) {
  Eigen::Matrix3Xd points = Eigen::Matrix3Xd::Zero(3, 3);
  points.row(0) << 0, 4.2, 11;
  points.row(2).setConstant(7);
  const TurbulentWindAtPoints at_points(wind_of(SpectrumKind::simiu_scanlan), loop, points);
  for (const int bin : {1, 9, 200}) {
    const Eigen::Matrix3Xcd v = at_points.velocity(bin);
    for (int k = 1; k < 3; ++k) {
      // u(x, t) = u(0, t - x/U)
      const auto delay = std::polar(1.0, -loop.omega(bin) * points(0, k) / 6);
      EXPECT_LT((v.col(k) - delay * v.col(0)).norm() / v.col(0).norm(), 2e-5) << bin;
    }
  }
}

TEST(TurbulentWindAtPoints, TurnsWithItsHeading) {
  const Eigen::Matrix3Xd points = test::random_points(700, 8);
  const double angle = 1.1;
  const Mat3 turn = Eigen::AngleAxisd(angle, Vec3::UnitZ()).toRotationMatrix();
  TurbulentWind turned = wind_of(SpectrumKind::simiu_scanlan);
  turned.mean.heading = angle * 180 / std::numbers::pi;
  const TurbulentWindAtPoints east(wind_of(SpectrumKind::simiu_scanlan), loop, points);
  const TurbulentWindAtPoints other(turned, loop, turn * points);
  for (const int bin : {1, 50}) {
    const Eigen::Matrix3Xcd wanted = turn * east.velocity(bin);
    EXPECT_LT((other.velocity(bin) - wanted).norm() / wanted.norm(), 1e-3) << bin;
  }
}

TEST(TurbulentWindAtPoints, InterpolatesAmplitudesOfManyHeightsToAThousandth) {
  // The same box and planes, few points (each with its own amplitude) and many (a table of heights).
  const Eigen::Matrix3Xd many = test::random_points(2000, 15);
  Eigen::Matrix3Xd few(3, 60);
  few.leftCols(54) = many.leftCols(54);
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::Index least, most;
    many.row(axis).minCoeff(&least);
    many.row(axis).maxCoeff(&most);
    few.col(54 + 2 * axis) = many.col(least);
    few.col(55 + 2 * axis) = many.col(most);
  }
  const WindAtPointsOptions options{.largest_plane = 4096};
  for (const SpectrumKind kind : {SpectrumKind::simiu_scanlan, SpectrumKind::iec_kaimal}) {
    const TurbulentWindAtPoints at_many(wind_of(kind), loop, many, options);
    const TurbulentWindAtPoints at_few(wind_of(kind), loop, few, options);
    for (const int bin : {1, 30, 200}) {
      const Eigen::Matrix3Xcd wanted = at_few.velocity(bin).leftCols(54);
      const Eigen::Matrix3Xcd found = at_many.velocity(bin).leftCols(54);
      EXPECT_LT((found - wanted).cwiseAbs().maxCoeff(), 1e-3 * wanted.cwiseAbs().maxCoeff()) << bin;
    }
  }
}

TEST(TurbulentWindAtPoints, GivesTheSameFromSeveralThreadsAtOnce) {
  const Eigen::Matrix3Xd points = test::random_points(300, 8);
  const TurbulentWindAtPoints at_points(wind_of(SpectrumKind::simiu_scanlan), loop, points);
  std::vector<Eigen::Matrix3Xcd> found(static_cast<std::size_t>(loop.bin_count()));
  tbb::parallel_for(0, loop.bin_count(),
                    [&](int bin) { found[static_cast<std::size_t>(bin)] = at_points.velocity(bin); });
  const TurbulentWindAtPoints again(wind_of(SpectrumKind::simiu_scanlan), loop, points);
  for (int bin = loop.bin_count() - 1; bin >= 0; --bin) {
    ASSERT_TRUE(found[static_cast<std::size_t>(bin)] == again.velocity(bin)) << bin;
  }
}

TEST(TurbulentWindAtPoints, WithoutCoherenceMovesEveryPointForItself) {
  Eigen::Matrix3Xd points = test::random_points(2, 0.001);
  points.row(2).array() += 3;
  std::complex<double> v_cross = 0, u_cross = 0;
  double v_power = 0, u_power = 0;
  constexpr int seeds = 1000;
  for (std::uint64_t seed = 0; seed < seeds; ++seed) {
    TurbulentWind wind = wind_of(SpectrumKind::iec_kaimal, seed);
    wind.coherence.iec_for_u_only = true;
    const Eigen::Matrix3Xcd v = TurbulentWindAtPoints(wind, loop, points).velocity(5);
    u_cross += v(0, 0) * std::conj(v(0, 1));
    v_cross += v(1, 0) * std::conj(v(1, 1));
    u_power += std::norm(v(0, 0));
    v_power += std::norm(v(1, 0));
  }
  EXPECT_GT(u_cross.real() / u_power, 0.99);
  EXPECT_LT(std::abs(v_cross) / v_power, 4 / std::sqrt(1.0 * seeds));
  EXPECT_NEAR(v_power / seeds * 2 * loop.period,
              spectrum_at(wind_of(SpectrumKind::iec_kaimal), 3, loop.frequency(5))[1],
              4 / std::sqrt(1.0 * seeds) * v_power / seeds * 2 * loop.period);
}

TEST(TurbulentWindAtPoints, KeepsItsPlanesWithinTheSizeAllowedAndItsSpacingWhereItCan) {
  const Eigen::Matrix3Xd points = test::random_points(100, 20);
  const TurbulentWind wind = wind_of(SpectrumKind::simiu_scanlan);
  const TurbulentWindAtPoints at_points(wind, loop, points, {.resolution = 0.5, .largest_plane = 5000});
  bool reached = false;
  for (int bin = 1; bin < loop.bin_count(); ++bin) {
    const auto plane = at_points.plane(bin);
    EXPECT_LE(plane.rows * plane.columns, 5000) << bin;
    const double finest = coherence_decay(wind.coherence, 2, loop.frequency(bin)).y * plane.column_spacing;
    if (bin < 10) {
      EXPECT_LE(finest, 0.5 * (1 + 1e-6)) << bin;
    }
    reached = reached || finest > 0.5;
  }
  EXPECT_TRUE(reached) << "then the cap was not tried";
}

TEST(TurbulentWindAtPoints, WorksForOnePointForNoneAndForNoWind) {
  const TurbulentWindAtPoints one(wind_of(SpectrumKind::simiu_scanlan), loop, Vec3(1, 2, 0.01));
  EXPECT_GT(one.velocity(3).norm(), 0);
  EXPECT_TRUE(one.velocity(3).allFinite());
  EXPECT_GT(one.velocity(0).norm(), 0);  // slow gusts
  EXPECT_GT((one.velocity(3) - one.velocity(3, 1)).norm(), 0.1 * one.velocity(3).norm());
  EXPECT_EQ(TurbulentWindAtPoints(wind_of(SpectrumKind::simiu_scanlan), loop, Eigen::Matrix3Xd(3, 0))
                .velocity(3)
                .cols(),
            0);
  const TurbulentWindAtPoints calm(turbulent_wind({.speed = 0}, 0.2), loop, test::random_points(4, 2));
  EXPECT_EQ(calm.velocity(3).norm(), 0);
  for (const double speed : {1e-300, 1e-12, 1e-3}) {
    const TurbulentWindAtPoints breath(turbulent_wind({.speed = speed}, 0.2), {1e-3, 10},
                                       test::random_points(600, 1e6));
    EXPECT_TRUE(breath.velocity(4).allFinite()) << speed;
  }
}

TEST(TurbulentWindAtPoints, OfABoxAsThinAsNothingIsThatOfAFlatOne) {
  Eigen::Matrix3Xd flat = test::random_points(20, 4);
  flat.row(1).setZero();
  const TurbulentWind wind = turbulent_wind({.speed = 6}, 0.2);
  const TurbulentWindAtPoints wanted(wind, loop, flat);
  for (const double thickness : {5e-324, 3.4e-41, 1e-30, 1e-9}) {
    Eigen::Matrix3Xd thin = flat;
    thin(1, 7) = thickness;
    const TurbulentWindAtPoints found(wind, loop, thin);
    for (const int bin : {0, 3, 40})
      EXPECT_LT((found.velocity(bin) - wanted.velocity(bin)).norm(), 1e-6 * wanted.velocity(bin).norm())
          << thickness << " m, bin " << bin;
  }
}

TEST(TurbulentWindAtPoints, RefusesPointsAndSettingsThatCannotBe) {
  const Eigen::Matrix3Xd points = test::random_points(4, 2);
  const TurbulentWind wind = wind_of(SpectrumKind::simiu_scanlan);
  Eigen::Matrix3Xd broken = points;
  broken(1, 2) = std::numeric_limits<double>::infinity();
  EXPECT_THROW(TurbulentWindAtPoints(wind, loop, broken), InputError);
  EXPECT_THROW(TurbulentWindAtPoints(wind, {0, 10}, points), InputError);
  EXPECT_THROW(TurbulentWindAtPoints(wind, {10, 0}, points), InputError);
  EXPECT_THROW(TurbulentWindAtPoints(wind, loop, points, {.resolution = 0}), InputError);
  EXPECT_THROW(TurbulentWindAtPoints(wind, loop, points, {.largest_plane = -1}), InputError);
}

TEST(TurbulentWindAtPoints, HasTheCovarianceOfUAndWThatWasAskedForInEveryBin) {
  const Eigen::Matrix3Xd points = test::random_points(30, 12);
  constexpr int seeds = 1500;
  for (const CoherenceKind coherence :
       {CoherenceKind::shinya_fournier, CoherenceKind::iec, CoherenceKind::none}) {
    TurbulentWind wind = turbulent_wind({.speed = 6}, 0.2, SpectrumKind::simiu_scanlan, coherence);
    wind.covariance_uw = -0.5 * largest_covariance_uw(wind.spectrum, 10, 6);
    for (const int bin : {2, 20}) {
      double cross = 0, squares = 0, u = 0, w = 0;
      for (std::uint64_t seed = 0; seed < seeds; ++seed) {
        wind.seed = seed;
        const Eigen::Matrix3Xcd v = TurbulentWindAtPoints(wind, only(bin), points).velocity(1);
        double of_seed = 0;
        for (Eigen::Index k = 0; k < points.cols(); ++k) {
          const Vec3 s = spectrum_at(wind, points(2, k), loop.frequency(bin)) / (2 * only(bin).period);
          of_seed += (v(0, k) * std::conj(v(2, k))).real() / std::sqrt(s[0] * s[2]) / 30;
          u += std::norm(v(0, k)) / s[0] / 30 / seeds;
          w += std::norm(v(2, k)) / s[2] / 30 / seeds;
        }
        cross += of_seed / seeds;
        squares += of_seed * of_seed / seeds;
      }
      const double error = std::sqrt((squares - cross * cross) / seeds);
      EXPECT_LT(error, 0.03);
      // Between nodes u and w lose and regain different parts: that is worth up to 0.02.
      EXPECT_NEAR(cross, -0.5, 4 * error + 0.02) << name_of(coherence) << ", " << bin;
      EXPECT_NEAR(u, 1, 0.12);
      EXPECT_NEAR(w, 1, 0.12);
    }
  }
}

TEST(TurbulentWindAtPoints, ThatVeersIsTheWindThatDoesNotTurnedAtEveryHeight) {
  const Eigen::Matrix3Xd points = test::random_points(20, 12);
  TurbulentWind straight = wind_of(SpectrumKind::simiu_scanlan);
  straight.mean = {
      .speed = 6, .heading = 20, .profile = ProfileKind::table, .table = {{0, 1, 0}, {10, 6, 0}, {12, 7, 0}}};
  TurbulentWind veering = straight;
  veering.mean.table[0].turn = 50;
  const TurbulentWindAtPoints plain(straight, loop, points), turned(veering, loop, points);
  for (const int bin : {0, 3, 90}) {
    const Eigen::Matrix3Xcd a = plain.velocity(bin), b = turned.velocity(bin);
    for (Eigen::Index k = 0; k < points.cols(); ++k) {
      const double angle = std::max(0.0, 5 * (10 - points(2, k))) * std::numbers::pi / 180;
      const double error = 1e-5 * a.col(k).norm();
      EXPECT_NEAR(std::abs(std::cos(angle) * a(0, k) - std::sin(angle) * a(1, k) - b(0, k)), 0, error);
      EXPECT_NEAR(std::abs(std::sin(angle) * a(0, k) + std::cos(angle) * a(1, k) - b(1, k)), 0, error);
    }
  }
}

}  // namespace
}  // namespace tremula
