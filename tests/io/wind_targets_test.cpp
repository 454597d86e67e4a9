#include "tremula/io/wind_targets.hpp"

#include "tremula/wind/synthesis.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace tremula {
namespace {

const WindGrid grid{
    .y_count = 4, .z_count = 5, .step_count = 256, .y_spacing = 2, .z_spacing = 3, .bottom = 1, .step = 0.25};

// Of every wave the power is what the model says, and points know nothing of each other: nothing is left to
// chance but the covariances.
TurbulentWind wind_without_chance(SpectrumKind kind) {
  TurbulentWind wind =
      turbulent_wind({.speed = 8, .displacement = 0.5, .canopy_height = 4}, 0.2, kind, CoherenceKind::none);
  wind.amplitudes = Amplitudes::phases_only;
  return wind;
}

TEST(WindTargets, AreWhatAFieldOfThatWindMeasures) {
  for (const SpectrumKind kind : {SpectrumKind::simiu_scanlan, SpectrumKind::von_karman}) {
    for (const Match match : {Match::spectrum, Match::variance}) {
      const TurbulentWind wind = wind_without_chance(kind);
      const WindField field = synthesise_wind(wind, grid, {.match = match});
      const FieldStatistics measured = field_statistics(field, {.bands_per_decade = 4});
      const WindTargets targets = wind_targets(wind, grid, measured, match);
      ASSERT_EQ(targets.mean.y.size(), 5U);
      ASSERT_EQ(targets.spectra.size(), 15U);
      for (std::size_t i = 0; i < 5; ++i) {
        EXPECT_EQ(targets.mean.x[i], measured.rows[i].height);
        EXPECT_NEAR(targets.mean.y[i], measured.rows[i].mean[0], 1e-5);
        for (std::size_t c = 0; c < 3; ++c) {
          const double deviation = measured.rows[i].deviation[c];
          EXPECT_EQ(targets.deviation[c].x[i], measured.rows[i].height);
          // The coefficient at half the sampling rate is real: its power is the model's in the mean only.
          EXPECT_NEAR(targets.deviation[c].y[i], deviation, 0.003 * deviation) << i << " " << c;
          const WindTargets::Spectrum& spectrum = targets.spectra[3 * i + c];
          EXPECT_EQ(spectrum.row, i);
          EXPECT_EQ(spectrum.component, c);
          for (std::size_t b = 0; b < measured.bands.size(); ++b) {
            const double value = measured.spectra[i][c].value[b];
            EXPECT_NEAR(spectrum.curve.y[b], value, 1e-4 * value) << i << " " << c << " " << b;
          }
        }
      }
    }
  }
}

TEST(WindTargets, MatchedInVarianceHaveTheDeviationOfTheModel) {
  const TurbulentWind wind = wind_without_chance(SpectrumKind::iec_kaimal);
  const FieldStatistics measured = field_statistics(synthesise_wind(wind, grid));
  const WindTargets matched = wind_targets(wind, grid, measured, Match::variance);
  const WindTargets resolved = wind_targets(wind, grid, measured);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_NEAR(matched.deviation[0].y[i], 0.2 * 8, 1e-9);
    EXPECT_LT(resolved.deviation[0].y[i], 0.2 * 8);
  }
}

TEST(WindTargets, HaveTheRootCoherenceOfTheModelInBandsOfOneBinAndItsMeanByPowerInOthers) {
  TurbulentWind wind = turbulent_wind({.speed = 8}, 0.2);
  const FieldStatistics measured =
      field_statistics(synthesise_wind(wind, grid), {.bands_per_decade = 3, .y_separations = {1, 3}});
  const WindTargets targets = wind_targets(wind, grid, measured);
  ASSERT_EQ(targets.coherence.size(), measured.coherence.size());
  int of_one_bin = 0, of_more = 0;
  for (std::size_t k = 0; k < targets.coherence.size(); ++k) {
    const WindTargets::Coherence& pair = targets.coherence[k];
    EXPECT_EQ(pair.cells, measured.coherence[k].cells);
    EXPECT_EQ(pair.vertical, measured.coherence[k].vertical);
    const int c = static_cast<int>(pair.component);
    const auto model = [&](int bin) {
      return root_coherence(wind.coherence, c, bin * measured.resolution, pair.vertical ? 0 : 2 * pair.cells,
                            pair.vertical ? 3 * pair.cells : 0);
    };
    for (std::size_t b = 0; b < measured.bands.size(); ++b) {
      const FrequencyBand& band = measured.bands[b];
      if (band.bin_count() == 1) {
        EXPECT_NEAR(pair.curve.y[b], model(band.first_bin), 1e-12);
        ++of_one_bin;
      } else {
        EXPECT_LT(pair.curve.y[b], model(band.first_bin));
        EXPECT_GT(pair.curve.y[b], model(band.last_bin));
        ++of_more;
      }
    }
  }
  EXPECT_GT(of_one_bin, 0);
  EXPECT_GT(of_more, 0);
}

TEST(WindTargets, OfAWindThatVeersTurnWithItAndHaveItsCovariance) {
  TurbulentWind straight = turbulent_wind(
      {.speed = 8, .profile = ProfileKind::table, .table = {{0, 4, 0}, {10, 8, 0}, {20, 10, 0}}}, 0.2,
      SpectrumKind::iec_kaimal);
  const double most = largest_covariance_uw(straight.spectrum, 10, 8);
  straight.covariance_uw = -0.4 * most;
  TurbulentWind veering = straight;
  veering.mean.table[0].turn = 30;
  const FieldStatistics measured = field_statistics(synthesise_wind(veering, grid));
  const WindTargets plain = wind_targets(straight, grid, measured),
                    turned = wind_targets(veering, grid, measured);
  for (std::size_t i = 0; i < 5; ++i) {
    const double angle = std::max(0.0, 3 * (10 - plain.mean.x[i])) * std::numbers::pi / 180,
                 c = std::cos(angle), s = std::sin(angle), u = plain.deviation[0].y[i],
                 v = plain.deviation[1].y[i];
    EXPECT_NEAR(turned.mean.y[i], measured.rows[i].mean[0], 1e-5);
    EXPECT_NEAR(turned.mean_across.y[i], measured.rows[i].mean[1], 1e-5);
    EXPECT_NEAR(turned.deviation[0].y[i], std::hypot(c * u, s * v), 1e-12);
    EXPECT_NEAR(turned.deviation[1].y[i], std::hypot(s * u, c * v), 1e-12);
    EXPECT_NEAR(turned.covariance.y[i], c * plain.covariance.y[i], 1e-12);
    // The loop holds less of it than all.
    EXPECT_LT(plain.covariance.y[i], 0);
    EXPECT_GT(plain.covariance.y[i], -0.4 * most);
  }
  const WindTargets hub = wind_targets(straight, grid, measured, Match::hub);
  EXPECT_NEAR(hub.deviation[0].y[3], 0.2 * 8, 1e-12) << "at 10 m";
  for (const double share : plain.resolved_share) EXPECT_NEAR(share, 0.7, 0.3);
}

}  // namespace
}  // namespace tremula
