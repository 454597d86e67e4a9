#include "tremula/wind/synthesis.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <iterator>
#include <limits>
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
      const WindField field = synthesise_wind(wind, grid, {.match_variance = match}, &report);
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

}  // namespace
}  // namespace tremula
