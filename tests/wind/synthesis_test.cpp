#include "tremula/wind/synthesis.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <functional>
#include <iterator>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include <tbb/global_control.h>

#include "tremula/base/error.hpp"
#include "tremula/numerics/fft.hpp"
#include "tremula/numerics/time_axis.hpp"

namespace tremula {
namespace {

const MeanWind breeze{.speed = 10, .reference_height = 30, .roughness_length = 0.05};

TurbulentWind wind_of(SpectrumKind kind, std::uint64_t seed = 1) {
  TurbulentWind wind = turbulent_wind(breeze, 0.15, kind);
  wind.seed = seed;
  return wind;
}

// Fourier coefficients of one component: (bins x points).
Eigen::MatrixXcd coefficients(const WindField& field, int component) {
  const auto points = static_cast<Eigen::Index>(field.grid.point_count());
  const Eigen::Map<const Eigen::MatrixXf> samples(field.velocity[static_cast<std::size_t>(component)].data(),
                                                  points, field.grid.step_count);
  return half_spectra_from_samples(samples.transpose().cast<double>());
}

double variance_of(const Eigen::MatrixXcd& series, Eigen::Index point) {
  return 2 * series.col(point).tail(series.rows() - 1).cwiseAbs2().sum();  // for an odd number of samples
}

TEST(SynthesiseWind, HasTheSpectrumOfItsHeightWithinThreePercentInEveryBandAboveTheFifteenthBin) {
  const WindGrid grid{.y_count = 40,
                      .z_count = 4,
                      .step_count = 512,
                      .y_spacing = 20,
                      .z_spacing = 20,
                      .bottom = 5,
                      .step = 0.25};
  const TimeAxis axis{grid.period(), grid.step_count};
  constexpr int seeds = 25;
  for (const SpectrumKind kind : {SpectrumKind::simiu_scanlan, SpectrumKind::iec_kaimal}) {
    std::array<Eigen::MatrixXd, 3> power;  // of the rows
    power.fill(Eigen::MatrixXd::Zero(axis.bin_count(), grid.z_count));
    for (std::uint64_t seed = 0; seed < seeds; ++seed) {
      const WindField field = synthesise_wind(wind_of(kind, seed), grid);
      for (int c = 0; c < 3; ++c) {
        const Eigen::MatrixXd found = coefficients(field, c).cwiseAbs2();
        for (int row = 0; row < grid.z_count; ++row) {
          power[static_cast<std::size_t>(c)].col(row) +=
              found.middleCols(static_cast<Eigen::Index>(row) * grid.y_count, grid.y_count).rowwise().mean() /
              seeds;
        }
      }
    }
    for (int c = 0; c < 3; ++c) {
      for (int row = 0; row < grid.z_count; ++row) {
        for (const auto& [first, last] : {std::pair{16, 31}, {32, 63}, {64, 127}, {128, 256}}) {
          double sum = 0, wanted = 0;
          for (int bin = first; bin <= last; ++bin) {
            sum += power[static_cast<std::size_t>(c)](bin, row);
            wanted += spectrum_at(wind_of(kind), grid.z(row), axis.frequency(bin))[c] / (2 * grid.period());
          }
          EXPECT_NEAR(sum / wanted, 1, 0.03)
              << name_of(kind) << ", " << c << ", row " << row << ", " << first;
        }
      }
    }
  }
}

TEST(SynthesiseWind, HasTheRootCoherenceOfTheModelWithinThreeHundredths) {
  const WindGrid grid{.y_count = 6,
                      .z_count = 5,
                      .step_count = 4096,
                      .y_spacing = 6,
                      .z_spacing = 6,
                      .bottom = 10,
                      .step = 0.5};
  const TimeAxis axis{grid.period(), grid.step_count};
  constexpr int seeds = 25;
  struct Separation {
    int columns, rows;
  };
  constexpr Separation separations[] = {{1, 0}, {0, 1}, {2, 1}, {4, 0}, {0, 3}, {3, 4}};
  constexpr std::pair<int, int> bands[] = {{40, 250}, {250, 500}, {500, 800}, {1200, 1600}};
  for (const SpectrumKind kind : {SpectrumKind::simiu_scanlan, SpectrumKind::iec_kaimal}) {
    struct Sums {
      double cross = 0, power = 0;
    };
    Sums sums[3][std::size(bands)][std::size(separations)];
    for (std::uint64_t seed = 0; seed < seeds; ++seed) {
      const WindField field = synthesise_wind(wind_of(kind, 100 + seed), grid);
      for (int c = 0; c < 3; ++c) {
        Eigen::MatrixXcd unit = coefficients(field, c);
        for (int row = 0; row < grid.z_count; ++row) {
          for (int bin = 1; bin < axis.bin_count(); ++bin) {
            unit.row(bin).segment(static_cast<Eigen::Index>(row) * grid.y_count, grid.y_count) /=
                std::sqrt(spectrum_at(wind_of(kind), grid.z(row), axis.frequency(bin))[c]);
          }
        }
        for (std::size_t s = 0; s < std::size(separations); ++s) {
          const auto& [columns, rows] = separations[s];
          for (int row = 0; row + rows < grid.z_count; ++row) {
            for (int column = 0; column + columns < grid.y_count; ++column) {
              const int from = row * grid.y_count + column, to = from + rows * grid.y_count + columns;
              for (std::size_t b = 0; b < std::size(bands); ++b) {
                const auto [first, last] = bands[b];
                const auto x = unit.col(from).segment(first, last - first);
                const auto y = unit.col(to).segment(first, last - first);
                sums[c][b][s].cross += (x.array() * y.array().conjugate()).real().sum();
                sums[c][b][s].power += (x.squaredNorm() + y.squaredNorm()) / 2;
              }
            }
          }
        }
      }
    }
    for (int c = 0; c < 3; ++c) {
      for (std::size_t b = 0; b < std::size(bands); ++b) {
        for (std::size_t s = 0; s < std::size(separations); ++s) {
          const auto [first, last] = bands[b];
          double wanted = 0;
          for (int bin = first; bin < last; ++bin) {
            wanted += root_coherence(wind_of(kind).coherence, c, axis.frequency(bin),
                                     separations[s].columns * grid.y_spacing,
                                     separations[s].rows * grid.z_spacing) /
                      (last - first);
          }
          EXPECT_NEAR(sums[c][b][s].cross / sums[c][b][s].power, wanted, 0.03)
              << name_of(kind) << ", " << c << ", band " << b << ", " << separations[s].columns << " x "
              << separations[s].rows;
        }
      }
    }
  }
}

const WindGrid small{
    .y_count = 9, .z_count = 7, .step_count = 60, .y_spacing = 2, .z_spacing = 1.5, .bottom = 1, .step = 0.2};

TEST(SynthesiseWind, BlowsWithTheMeanProfileInU) {
  const WindField field = synthesise_wind(wind_of(SpectrumKind::simiu_scanlan), small);
  for (int c = 0; c < 3; ++c) {
    const Eigen::MatrixXcd series = coefficients(field, c);
    for (int k = 0; k < static_cast<int>(small.point_count()); ++k) {
      const double wanted = c == 0 ? mean_speed(breeze, small.z(k / small.y_count)) : 0;
      EXPECT_NEAR(series(0, k).real(), wanted, 2e-6);
    }
  }
  EXPECT_EQ(field.grid.mean_speed, breeze.speed);
  EXPECT_EQ(field.grid.reference_height, breeze.reference_height);
  EXPECT_TRUE(field.grid.periodic);
}

TEST(SynthesiseWind, GoesOnFromItsLastStepToItsFirstAsBetweenAnyOthers) {
  WindGrid grid = small;
  grid.y_count = 40;
  double jump = 0, step = 0;
  const auto points = grid.point_count(), steps = static_cast<std::size_t>(grid.step_count);
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const WindField field = synthesise_wind(wind_of(SpectrumKind::simiu_scanlan, seed), grid);
    const std::vector<float>& u = field.velocity[0];
    for (std::size_t k = 0; k < points; ++k) {
      for (std::size_t t = 0; t < steps; ++t) {
        const auto change = static_cast<double>(u[(t + 1) % steps * points + k] - u[t * points + k]);
        (t + 1 == steps ? jump : step) +=
            change * change / (t + 1 == steps ? 1.0 : static_cast<double>(steps - 1));
      }
    }
  }
  EXPECT_NEAR(jump / step, 1, 0.1);
}

TEST(SynthesiseWind, AsATileMeetsItselfAcrossTheSeamAsNeighboursMeet) {
  constexpr int seeds = 150, bin = 3;
  for (const bool tile : {false, true}) {
    double across_seam = 0, up_seam = 0, across = 0, up = 0, power = 0;
    for (std::uint64_t seed = 0; seed < seeds; ++seed) {
      const WindField field = synthesise_wind(wind_of(SpectrumKind::iec_kaimal, seed), small, {.tile = tile});
      const Eigen::RowVectorXcd v = coefficients(field, 0).row(bin);
      const auto at = [&](int row, int column) {
        return v[row % small.z_count * small.y_count + column % small.y_count];
      };
      for (int row = 0; row < small.z_count; ++row) {
        for (int column = 0; column < small.y_count; ++column) {
          const auto product = [&](int r, int c) { return (at(row, column) * std::conj(at(r, c))).real(); };
          power += product(row, column) / (small.z_count * small.y_count);
          (column + 1 < small.y_count ? across : across_seam) +=
              product(row, column + 1) /
              (small.z_count * (column + 1 < small.y_count ? small.y_count - 1 : 1));
          (row + 1 < small.z_count ? up : up_seam) +=
              product(row + 1, column) / (small.y_count * (row + 1 < small.z_count ? small.z_count - 1 : 1));
        }
      }
    }
    if (tile) {
      EXPECT_NEAR(across_seam / power, across / power, 0.06);
      EXPECT_NEAR(up_seam / power, up / power, 0.06);
    } else {
      EXPECT_LT(across_seam / power, across / power - 0.2) << "then the test does not tell tiles from others";
    }
  }
}

TEST(SynthesiseWind, OfPhasesOnlyHasThePowerOfTheModelInEveryBinOfATile) {
  TurbulentWind wind = wind_of(SpectrumKind::iec_kaimal);  // the same spectrum at all heights
  wind.amplitudes = Amplitudes::phases_only;
  WindGrid grid = small;
  grid.step_count = 61;
  const TimeAxis axis{grid.period(), grid.step_count};
  const WindField field = synthesise_wind(wind, grid, {.tile = true});
  for (int c = 0; c < 3; ++c) {
    const Eigen::MatrixXcd series = coefficients(field, c);
    for (int bin = 1; bin < axis.bin_count(); ++bin) {
      const double wanted = spectrum_at(wind, 5, axis.frequency(bin))[c] / (2 * axis.period);
      EXPECT_NEAR(series.row(bin).cwiseAbs2().mean() / wanted, 1, 1e-4) << c << ", " << bin;
    }
  }
}

TEST(SynthesiseWind, MatchedInVarianceHasAllOfItAtEveryHeightAndOtherwiseTheShareReported) {
  for (const SpectrumKind kind : {SpectrumKind::simiu_scanlan, SpectrumKind::von_karman}) {
    for (const bool match : {false, true}) {
      TurbulentWind wind = wind_of(kind);
      wind.amplitudes =
          Amplitudes::phases_only;  // of a column of points on its own: every amplitude is exact
      wind.coherence.kind = CoherenceKind::none;
      WindGrid grid = small;
      grid.y_count = 1;
      grid.step_count = 61;
      SynthesisReport report;
      const WindField field =
          synthesise_wind(wind, grid, {.match = match ? Match::variance : Match::spectrum}, &report);
      const Vec3 whole = spectrum_variance(wind.spectrum);
      for (int c = 0; c < 3; ++c) {
        const Eigen::MatrixXcd series = coefficients(field, c);
        for (int row = 0; row < grid.z_count; ++row) {
          const double share =
              report.resolved_share[static_cast<std::size_t>(c)][static_cast<std::size_t>(row)];
          EXPECT_LT(share, 1);
          EXPECT_NEAR(variance_of(series, row) / whole[c], match ? 1 : share, 1e-4);
        }
      }
    }
  }
}

TEST(SynthesiseWind, IsGaussianUnlessOnlyPhasesAreRandom) {
  constexpr int seeds = 100;
  for (const Amplitudes amplitudes : {Amplitudes::gaussian, Amplitudes::phases_only}) {
    double power = 0, fourth = 0;
    for (std::uint64_t seed = 0; seed < seeds; ++seed) {
      TurbulentWind wind = wind_of(SpectrumKind::iec_kaimal, seed);
      wind.coherence.kind = CoherenceKind::none;
      wind.amplitudes = amplitudes;
      const Eigen::RowVectorXcd v = coefficients(synthesise_wind(wind, small), 0).row(4);
      power += v.cwiseAbs2().mean() / seeds;
      fourth += v.cwiseAbs2().cwiseAbs2().mean() / seeds;
    }
    // E|v|^4 / (E|v|^2)^2 of a complex Gaussian is 2, its mean over n has a standard error of about
    // sqrt(20/n).
    const double n = seeds * static_cast<double>(small.point_count());
    if (amplitudes == Amplitudes::gaussian) {
      EXPECT_NEAR(fourth / (power * power), 2, 4 * std::sqrt(20 / n));
    } else {
      EXPECT_NEAR(fourth / (power * power), 1, 1e-4);
    }
  }
}

TEST(SynthesiseWind, HasItsPowerAtHalfTheSamplingRateToo) {
  double power = 0;
  constexpr int seeds = 200;
  const TimeAxis axis{small.period(), small.step_count};
  const int last = small.step_count / 2;
  for (std::uint64_t seed = 0; seed < seeds; ++seed) {
    power += coefficients(synthesise_wind(wind_of(SpectrumKind::iec_kaimal, seed), small), 1)
                 .row(last)
                 .cwiseAbs2()
                 .mean() /
             seeds;
  }
  const double wanted =
      spectrum_at(wind_of(SpectrumKind::iec_kaimal), 5, axis.frequency(last))[1] / (2 * axis.period);
  // Squares of real Gaussians: standard error sqrt(2/n).
  EXPECT_NEAR(power / wanted, 1, 4 * std::sqrt(2.0 / (seeds * static_cast<double>(small.point_count()))));
}

TEST(SynthesiseWind, IsTheSameBytesOnAnyNumberOfThreadsAndAnotherForAnotherSeed) {
  WindField fields[2];
  SynthesisReport reports[2];
  for (const std::size_t i : {0U, 1U}) {
    const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, i == 0 ? 1 : 5);
    fields[i] = synthesise_wind(wind_of(SpectrumKind::simiu_scanlan), small, {}, &reports[i]);
  }
  EXPECT_EQ(fields[0].velocity, fields[1].velocity);
  EXPECT_EQ(reports[0].clipped_share, reports[1].clipped_share);
  EXPECT_EQ(reports[0].resolved_share, reports[1].resolved_share);
  EXPECT_NE(fields[0].velocity, synthesise_wind(wind_of(SpectrumKind::simiu_scanlan, 2), small).velocity);
}

TEST(SynthesiseWind, ReportsACoherenceErrorAndAClippedShareThatAreSmallButThere) {
  SynthesisReport report;
  synthesise_wind(wind_of(SpectrumKind::simiu_scanlan), small, {}, &report);
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_GT(report.coherence_error[c], 1e-4);
    EXPECT_LT(report.coherence_error[c], 0.03);
    EXPECT_GT(report.clipped_share[c], report.mean_clipped_share[c]);
    EXPECT_LT(report.clipped_share[c], 0.03);
  }
  EXPECT_EQ(report.largest_columns, fast_length(16));
  EXPECT_EQ(report.largest_rows, fast_length(12));
}

TEST(SynthesiseWind, WorksForOnePointOneStepAndNoWind) {
  WindGrid one = small;
  one.y_count = one.z_count = one.step_count = 1;
  const WindField still = synthesise_wind(wind_of(SpectrumKind::simiu_scanlan), one);
  EXPECT_NEAR(static_cast<double>(still.velocity[0].at(0)), mean_speed(breeze, 1), 1e-6);
  EXPECT_EQ(still.velocity[2].at(0), 0);

  const TurbulentWind calm = turbulent_wind({.speed = 0}, 0.2);
  for (const std::vector<float>& component : synthesise_wind(calm, small).velocity) {
    for (const float value : component) ASSERT_EQ(value, 0);
  }
  for (const double speed : {1e-300, 1e-12, 1e-3}) {
    for (const std::vector<float>& component :
         synthesise_wind(turbulent_wind({.speed = speed}, 0.2), small).velocity) {
      for (const float value : component) ASSERT_TRUE(std::isfinite(value)) << speed;
    }
  }
}

TEST(SynthesiseWind, RefusesGridsAndSettingsThatCannotBe) {
  const TurbulentWind wind = wind_of(SpectrumKind::simiu_scanlan);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto with = [](auto change) {
    WindGrid grid = small;
    change(grid);
    return grid;
  };
  for (const WindGrid& bad :
       {with([](WindGrid& g) { g.y_count = 0; }), with([](WindGrid& g) { g.z_count = -3; }),
        with([](WindGrid& g) { g.step_count = 0; }), with([](WindGrid& g) { g.y_spacing = 0; }),
        with([&](WindGrid& g) { g.z_spacing = nan; }), with([](WindGrid& g) { g.bottom = 0; }),
        with([](WindGrid& g) { g.step = -1; }),
        with([](WindGrid& g) { g.y_count = g.z_count = g.step_count = 2000; })}) {
    EXPECT_THROW(synthesise_wind(wind, bad), InputError);
  }
  for (const double bad : {0.0, 1.0, nan}) {
    EXPECT_THROW(synthesise_wind(wind, small, {.padding_tolerance = bad}), InputError);
  }
  TurbulentWind growing = wind;
  growing.coherence.decay_y[1] = -1;
  EXPECT_THROW(synthesise_wind(growing, small), InputError);
}

TEST(SynthesiseWind, TellsHowMuchIsDoneUpToAllOfItAndStopsWhenTold) {
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const WindGrid grid{.y_count = 6, .z_count = 7, .step_count = 300};
  std::vector<double> told;
  synthesise_wind(wind_of(SpectrumKind::simiu_scanlan), grid,
                  {.progress = [&](double done) { told.push_back(done); }});
  ASSERT_GT(told.size(), 6U);
  EXPECT_TRUE(std::is_sorted(told.begin(), told.end()));
  EXPECT_GT(told.front(), 0);
  EXPECT_LT(told.front(), 0.1);
  EXPECT_NEAR(told.back(), 1, 1e-9);
  EXPECT_THROW(synthesise_wind(wind_of(SpectrumKind::simiu_scanlan), grid,
                               {.progress = [](double) { throw Error("enough"); }}),
               Error);
}

// The value of component c at a step, in a row and a column.
double value_at(const WindField& field, std::size_t c, int step, int row, int column) {
  const WindGrid& grid = field.grid;
  const int at = (step * grid.z_count + row) * grid.y_count + column;
  return static_cast<double>(field.velocity[c][static_cast<std::size_t>(at)]);
}

double tower_at(const WindField& field, std::size_t c, int step, int k) {
  return static_cast<double>(field.tower[c][static_cast<std::size_t>(field.tower_count * step + k)]);
}

TEST(SynthesiseWind, WithATowerIsTheLargerFieldThatReachesDownAtItsMiddle) {
  for (const int columns : {5, 6}) {
    const WindGrid grid{.y_count = columns,
                        .z_count = 4,
                        .step_count = 40,
                        .y_spacing = 4,
                        .z_spacing = 3,
                        .bottom = 7.5,
                        .step = 0.5};
    ASSERT_EQ(tower_points_above_ground(grid), 3);
    const WindField field = synthesise_wind(wind_of(SpectrumKind::simiu_scanlan), grid, {.tower_count = 3});
    ASSERT_EQ(field.tower_count, 3);
    // The tower stands between two of an even number of columns: then on the grid of twice as many.
    const int stride = columns % 2 == 0 ? 2 : 1;
    WindGrid larger = grid;
    larger.z_count = 6;
    larger.bottom = 1.5;
    larger.y_count = stride * (columns - 1) + 1;
    larger.y_spacing /= stride;
    const WindField whole = synthesise_wind(wind_of(SpectrumKind::simiu_scanlan), larger);
    for (std::size_t c = 0; c < 3; ++c) {
      for (int step = 0; step < 40; ++step) {
        for (int row = 0; row < 4; ++row) {
          for (int column = 0; column < columns; ++column) {
            ASSERT_NEAR(value_at(field, c, step, row, column),
                        value_at(whole, c, step, row + 2, stride * column), 1e-5);
          }
        }
        for (int k = 0; k < 3; ++k) {
          ASSERT_NEAR(tower_at(field, c, step, k), value_at(whole, c, step, 2 - k, larger.y_count / 2), 1e-5);
        }
      }
    }
  }
  const WindGrid low{.y_count = 3, .z_count = 3, .bottom = 0.5};
  EXPECT_EQ(tower_points_above_ground(low), 1);
  EXPECT_THROW(synthesise_wind(wind_of(SpectrumKind::iec_kaimal), low, {.tower_count = 2}), InputError);
  EXPECT_THROW(synthesise_wind(wind_of(SpectrumKind::iec_kaimal), low, {.tile = true, .tower_count = 1}),
               InputError);
}

double deviation_of(int steps, const std::function<double(int step)>& value) {
  double sum = 0, squares = 0;
  for (int step = 0; step < steps; ++step) {
    sum += value(step) / steps;
    squares += value(step) * value(step) / steps;
  }
  return std::sqrt(squares - sum * sum);
}

TEST(SynthesiseWind, MatchedAtTheHubOrAtThePointsHasTheDeviationThereInEverySample) {
  WindGrid grid = small;
  grid.bottom = 24;  // the reference height, 30 m, is that of row 4
  const auto deviation_at = [](const WindField& field, std::size_t c, int row, int column) {
    return deviation_of(field.grid.step_count,
                        [&](int step) { return value_at(field, c, step, row, column); });
  };
  for (const int steps : {60, 61}) {
    grid.step_count = steps;
    const TurbulentWind wind = wind_of(SpectrumKind::iec_kaimal, 3);
    SynthesisReport report;
    const WindField plain = synthesise_wind(wind, grid),
                    hub = synthesise_wind(wind, grid, {.match = Match::hub}, &report),
                    points = synthesise_wind(wind, grid, {.match = Match::points, .tower_count = 2});
    EXPECT_EQ(hub_point(hub.grid), (std::array{4, 4}));
    for (std::size_t c = 0; c < 3; ++c) {
      const double wanted = std::sqrt(spectrum_variance(wind.spectrum)[static_cast<int>(c)]);
      EXPECT_NEAR(deviation_at(hub, c, 4, 4) / wanted, 1, 1e-5);
      EXPECT_GT(std::abs(deviation_at(plain, c, 4, 4) / wanted - 1), 0.01) << "then the test does not tell";
      // One number for all of a component: the field is otherwise the one that was not matched.
      const double factor = report.match_factor[c][0];
      EXPECT_EQ(report.match_factor[c][1], factor);
      EXPECT_NEAR(deviation_at(hub, c, 0, 1) / deviation_at(plain, c, 0, 1), factor, 1e-4);
      for (int row = 0; row < grid.z_count; ++row) {
        for (int column = 0; column < grid.y_count; ++column)
          EXPECT_NEAR(deviation_at(points, c, row, column) / wanted, 1, 1e-5);
      }
      const double at_tower = deviation_of(steps, [&](int step) { return tower_at(points, c, step, 1); });
      EXPECT_NEAR(at_tower / wanted, 1, 1e-5);
    }
  }
  grid.bottom = 1;
  EXPECT_THROW(synthesise_wind(wind_of(SpectrumKind::iec_kaimal), grid, {.match = Match::hub}), InputError);
  for (const Match match : {Match::spectrum, Match::variance, Match::hub, Match::points}) {
    const char* const names[] = {"spectrum", "variance", "hub", "points"};
    EXPECT_EQ(match_named(names[static_cast<int>(match)]), match);
  }
  EXPECT_THROW(match_named("all"), InputError);
}

// Mean over seeds, and its standard error from their scatter.
struct Mean {
  double sum = 0, squares = 0, count = 0;
  void add(double value) {
    sum += value;
    squares += value * value;
    ++count;
  }
  double value() const { return sum / count; }
  double error() const { return std::sqrt((squares / count - value() * value()) / count); }
};

TEST(SynthesiseWind, HasTheCovarianceOfUAndWThatWasAskedForAtEveryHeightAndTheSpectraAsBefore) {
  const WindGrid grid{.y_count = 10,
                      .z_count = 3,
                      .step_count = 256,
                      .y_spacing = 40,
                      .z_spacing = 20,
                      .bottom = 5,
                      .step = 0.5};
  const TimeAxis axis{grid.period(), grid.step_count};
  for (const SpectrumKind kind : {SpectrumKind::simiu_scanlan, SpectrumKind::iec_kaimal}) {
    std::array<Mean, 3> covariance, power_u, power_w;  // by row
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
      TurbulentWind wind = wind_of(kind, seed);
      wind.covariance_uw = -0.6 * largest_covariance_uw(wind.spectrum, 30, 10);
      const WindField field = synthesise_wind(wind, grid);
      Eigen::MatrixXcd u = coefficients(field, 0), w = coefficients(field, 2);
      for (Eigen::MatrixXcd* series : {&u, &w}) {
        series->row(0).setZero();
        series->row(series->rows() - 1) *= std::sqrt(0.5);  // half a bin
      }
      for (Eigen::Index row = 0; row < 3; ++row) {
        const auto of_row_u = u.middleCols(10 * row, 10), of_row_w = w.middleCols(10 * row, 10);
        const auto at = static_cast<std::size_t>(row);
        covariance[at].add(of_row_u.conjugate().cwiseProduct(of_row_w).sum().real() / 5);
        power_u[at].add(of_row_u.squaredNorm() / 5);
        power_w[at].add(of_row_w.squaredNorm() / 5);
      }
    }
    for (int row = 0; row < 3; ++row) {
      double wanted = 0;
      Vec3 power = Vec3::Zero();  // in the bins that the loop has
      for (int bin = 1; bin < axis.bin_count(); ++bin) {
        const double width = (2 * bin == axis.sample_count ? 0.5 : 1) / axis.period;
        const Vec3 s = spectrum_at(wind_of(kind), grid.z(row), axis.frequency(bin));
        wanted += width * -0.6 * std::sqrt(s[0] * s[2]);
        power += width * s;
      }
      const auto at = static_cast<std::size_t>(row);
      EXPECT_LT(covariance[at].error(), -0.08 * wanted) << "then the test does not tell";
      EXPECT_NEAR(covariance[at].value(), wanted, 4 * covariance[at].error()) << name_of(kind) << ", " << row;
      EXPECT_NEAR(power_u[at].value(), power[0], 4 * power_u[at].error());
      EXPECT_NEAR(power_w[at].value(), power[2], 4 * power_w[at].error());
    }
  }
}

TEST(SynthesiseWind, ThatVeersIsTheWindThatDoesNotTurnedAtEveryHeight) {
  TurbulentWind straight = wind_of(SpectrumKind::simiu_scanlan);
  straight.mean = {.speed = 10,
                   .reference_height = 6,
                   .profile = ProfileKind::table,
                   .table = {{1, 5, 0}, {6, 10, 0}, {11, 12, 0}}};
  TurbulentWind veering = straight;
  veering.mean.table[0].turn = 80;
  veering.mean.table[1].turn = 60;
  veering.mean.table[2].turn = 30;
  const WindField plain = synthesise_wind(straight, small, {.tower_count = 1}),
                  turned = synthesise_wind(veering, small, {.tower_count = 1});
  const auto expect_turned = [](double degrees, const auto& from, const auto& to) {
    const double angle = degrees * std::numbers::pi / 180;
    EXPECT_NEAR(to(0), std::cos(angle) * from(0) - std::sin(angle) * from(1), 1e-5);
    EXPECT_NEAR(to(1), std::sin(angle) * from(0) + std::cos(angle) * from(1), 1e-5);
    EXPECT_EQ(to(2), from(2));
  };
  for (int step = 0; step < small.step_count; ++step) {
    for (int row = 0; row < small.z_count; ++row) {
      const double z = small.z(row), degrees = z < 6 ? 4 * (6 - z) : -6 * (z - 6);
      for (int column = 0; column < small.y_count; ++column) {
        expect_turned(
            degrees, [&](std::size_t c) { return value_at(plain, c, step, row, column); },
            [&](std::size_t c) { return value_at(turned, c, step, row, column); });
      }
    }
    expect_turned(
        20, [&](std::size_t c) { return tower_at(plain, c, step, 0); },
        [&](std::size_t c) { return tower_at(turned, c, step, 0); });
  }
}

TEST(SynthesiseWind, OfOneSeedHasTheSameGustsAtAnotherSpeed) {
  const WindGrid grid{
      .y_count = 3, .z_count = 3, .step_count = 1024, .y_spacing = 20, .z_spacing = 20, .bottom = 70};
  const auto gusts = [&](double speed, std::uint64_t seed) {
    TurbulentWind wind =
        turbulent_wind({.speed = speed, .reference_height = 90}, 0.16, SpectrumKind::iec_kaimal);
    wind.seed = seed;
    Eigen::MatrixXcd series = coefficients(synthesise_wind(wind, grid), 0);
    series.row(0).setZero();
    return series;
  };
  const auto correlation = [](const Eigen::MatrixXcd& a, const Eigen::MatrixXcd& b) {
    return a.conjugate().cwiseProduct(b).sum().real() / (a.norm() * b.norm());
  };
  EXPECT_GT(correlation(gusts(12, 1), gusts(15, 1)), 0.95);
  EXPECT_LT(std::abs(correlation(gusts(12, 1), gusts(15, 2))), 0.5);
}

}  // namespace
}  // namespace tremula
