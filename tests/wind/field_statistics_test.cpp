#include "tremula/wind/field_statistics.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "tremula/base/error.hpp"
#include "tremula/numerics/random.hpp"

namespace tremula {
namespace {

constexpr double pi = std::numbers::pi;

// velocity(component, row, column, step)
using Velocity = std::function<double(std::size_t, int, int, int)>;

WindField make_field(const WindGrid& grid, const Velocity& velocity) {
  WindField field;
  field.grid = grid;
  for (std::size_t c = 0; c < 3; ++c) {
    for (int t = 0; t < grid.step_count; ++t) {
      for (int i = 0; i < grid.z_count; ++i) {
        for (int j = 0; j < grid.y_count; ++j)
          field.velocity[c].push_back(static_cast<float>(velocity(c, i, j, t)));
      }
    }
  }
  return field;
}

double gaussian(std::uint32_t what, std::uint64_t place) {
  return std::numbers::sqrt2 * complex_gaussian({11, RandomStream::test, what, place}).real();
}

// One bin a band.
const FieldStatisticsOptions every_bin{.bands_per_decade = 1000};

TEST(LogarithmicBands, TakeEveryBinOnceAndNeverGrowFasterThanAsked) {
  for (const int last : {0, 1, 2, 7, 500, 2047}) {
    for (const double per_decade : {1.0, 5.0, 10.0, 1000.0}) {
      const auto bands = logarithmic_bands(last, 0.25, per_decade);
      int next = 1;
      for (const FrequencyBand& band : bands) {
        ASSERT_EQ(band.first_bin, next);
        ASSERT_GE(band.last_bin, band.first_bin);
        EXPECT_DOUBLE_EQ(band.frequency, 0.125 * (band.first_bin + band.last_bin));
        if (band.bin_count() > 1) {
          EXPECT_LE((band.last_bin + 0.5) / (band.first_bin - 0.5), std::pow(10, 2 / per_decade));
        }
        next = band.last_bin + 1;
      }
      EXPECT_EQ(next, last + 1);
    }
  }
  EXPECT_LT(logarithmic_bands(100'000, 1, 10).size(), 50U);
}

TEST(FieldStatistics, OfASumOfCosinesAreItsMeansAndAmplitudes) {
  const WindGrid grid{.y_count = 3, .z_count = 2, .step_count = 64, .bottom = 2, .step = 0.25};
  const auto amplitude = [](std::size_t c, int row) { return (1 + static_cast<double>(c)) * (row + 0.5); };
  const WindField field = make_field(grid, [&](std::size_t c, int i, int j, int t) {
    const double slow = std::cos(2 * pi * 3 * t / 64 + j), fast = std::cos(2 * pi * 20 * t / 64 - i);
    return (c == 0 ? 5.0 + i + 0.1 * j : 0.0) + amplitude(c, i) * (slow + 0.5 * fast);
  });
  const FieldStatistics statistics = field_statistics(field, every_bin);
  ASSERT_EQ(statistics.bands.size(), 31U);
  EXPECT_DOUBLE_EQ(statistics.resolution, 1 / 16.0);
  for (int i = 0; i < 2; ++i) {
    const auto r = static_cast<std::size_t>(i);
    const RowStatistics& row = statistics.rows[r];
    EXPECT_EQ(row.height, 2 + i);
    EXPECT_NEAR(row.mean[0], 5.1 + i, 1e-6);
    EXPECT_NEAR(row.turbulence_intensity, row.deviation[0] / (5.1 + i), 1e-6);
    for (std::size_t c = 0; c < 3; ++c) {
      const double a = amplitude(c, i);
      EXPECT_NEAR(row.deviation[c], a * std::sqrt(1.25 / 2), 1e-6);
      for (std::size_t j = 0; j < 3; ++j) {
        EXPECT_NEAR(statistics.point_mean[c][3 * r + j], c == 0 ? 5.0 + i + 0.1 * static_cast<double>(j) : 0,
                    1e-6);
        EXPECT_NEAR(statistics.point_deviation[c][3 * r + j], row.deviation[c], 1e-6);
      }
      for (std::size_t b = 0; b < statistics.bands.size(); ++b) {
        const int bin = statistics.bands[b].first_bin;
        ASSERT_EQ(statistics.bands[b].bin_count(), 1);
        // A cosine has the variance amplitude^2/2, all of it in a band of 1/T.
        const double wanted = bin == 3 ? 16 * a * a / 2 : bin == 20 ? 16 * a * a / 8 : 0;
        EXPECT_NEAR(statistics.spectra[r][c].value[b], wanted, 1e-5 * (1 + wanted)) << "bin " << bin;
      }
    }
    EXPECT_NEAR(row.covariance_uw, row.deviation[0] * row.deviation[2], 1e-5);  // w is three times u
  }
}

TEST(FieldStatistics, SpreadTheWholeVarianceOverTheBands) {
  const WindGrid grid{.y_count = 2, .z_count = 2, .step_count = 255};
  const WindField field = make_field(grid, [](std::size_t c, int i, int j, int t) {
    return 3 + gaussian(static_cast<std::uint32_t>(c), static_cast<std::uint64_t>((t * 2 + i) * 2 + j));
  });
  for (const double per_decade : {3.0, 10.0}) {
    const FieldStatistics statistics = field_statistics(field, {.bands_per_decade = per_decade});
    for (std::size_t r = 0; r < 2; ++r) {
      for (std::size_t c = 0; c < 3; ++c) {
        double integral = 0;
        for (std::size_t b = 0; b < statistics.bands.size(); ++b) {
          integral +=
              statistics.spectra[r][c].value[b] * statistics.bands[b].bin_count() * statistics.resolution;
        }
        EXPECT_NEAR(integral, std::pow(statistics.rows[r].deviation[c], 2), 1e-9);
      }
    }
  }
}

TEST(FieldMoments, AreThoseOfTheFullStatistics) {
  const WindGrid grid{.y_count = 3, .z_count = 2, .step_count = 50, .periodic = false};
  const WindField field = make_field(grid, [](std::size_t c, int i, int j, int t) {
    return 3 * i +
           gaussian(60 + static_cast<std::uint32_t>(c), static_cast<std::uint64_t>((t * 2 + i) * 3 + j));
  });
  const FieldStatistics moments = field_moments(field), all = field_statistics(field);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(moments.rows[i].height, all.rows[i].height);
    EXPECT_EQ(moments.rows[i].mean, all.rows[i].mean);
    EXPECT_EQ(moments.rows[i].deviation, all.rows[i].deviation);
    EXPECT_EQ(moments.rows[i].covariance_uw, all.rows[i].covariance_uw);
  }
  EXPECT_EQ(moments.point_mean, all.point_mean);
  EXPECT_EQ(moments.point_deviation, all.point_deviation);
  EXPECT_TRUE(moments.spectra.empty());
}

// The spectrum of white noise is 2 sigma^2 dt at every frequency. In units of the standard error that is
// given the measured bands scatter by 1: their mean is 0 within 5/sqrt(n), their mean square (of n numbers
// near Gaussian) 1 within 5 sqrt(2/n) and what the error itself is uncertain by.
TEST(FieldStatistics, OfWhiteNoiseAreFlatWithinTheErrorsTheyClaim) {
  for (const bool periodic : {true, false}) {
    const WindGrid grid{.y_count = 1, .z_count = 40, .step_count = 4096, .step = 0.5, .periodic = periodic};
    const WindField field = make_field(grid, [](std::size_t c, int i, int, int t) {
      return 4 + 0.7 * gaussian(10 + static_cast<std::uint32_t>(c), static_cast<std::uint64_t>(t * 40 + i));
    });
    const FieldStatistics statistics = field_statistics(field);
    EXPECT_EQ(statistics.segment_count, periodic ? 1 : 7);
    const double wanted = 2 * 0.49 * 0.5;
    double sum = 0, squares = 0;
    int count = 0;
    for (const auto& row : statistics.spectra) {
      for (const RowSpectrum& spectrum : row) {
        for (std::size_t b = 0; b < statistics.bands.size(); ++b) {
          if (statistics.bands[b].bin_count() < 20) continue;
          const double score = (spectrum.value[b] - wanted) / spectrum.standard_error[b];
          sum += score;
          squares += score * score;
          ++count;
        }
      }
    }
    ASSERT_GT(count, 500);
    EXPECT_NEAR(sum / count, 0, 0.3) << (periodic ? "periodic" : "not periodic");
    EXPECT_NEAR(squares / count, 1, 0.3) << (periodic ? "periodic" : "not periodic");
  }
}

// A cosine that does not fit into the segments, far from the ends of the band, keeps its variance under the
// window.
TEST(FieldStatistics, OfAFieldThatIsNotPeriodicKeepTheVarianceOfACosine) {
  const WindGrid grid{.y_count = 2, .z_count = 1, .step_count = 1000, .step = 0.1, .periodic = false};
  const WindField field = make_field(
      grid, [](std::size_t, int, int j, int t) { return 2 * std::cos(2 * pi * 1.2345 * 0.1 * t + j); });
  const FieldStatistics statistics =
      field_statistics(field, {.bands_per_decade = 1000, .segment_length = 200});
  EXPECT_EQ(statistics.segment_length, 200);
  EXPECT_EQ(statistics.segment_count, 9);
  double integral = 0;
  for (std::size_t b = 0; b < statistics.bands.size(); ++b) {
    const double value = statistics.spectra[0][0].value[b];
    integral += value * statistics.resolution;
    if (std::abs(statistics.bands[b].frequency - 1.2345) > 4 * statistics.resolution) {
      EXPECT_LT(value, 2e-3 * 2 / statistics.resolution) << statistics.bands[b].frequency << " Hz";
    }
  }
  EXPECT_NEAR(integral, 2, 0.01);
}

// Every point has sqrt(rho) of a noise that all share and sqrt(1 - rho) of its own: the coherence is rho.
// Means of n samples know it to (1 - rho^2)/sqrt(2 n); the pairs share points, so n counts bins only.
TEST(FieldStatistics, FindTheCoherenceThatWasPutIn) {
  for (const bool periodic : {true, false}) {
    const double rho[] = {0.2, 0.5, 0.9};
    const WindGrid grid{
        .y_count = 4, .z_count = 5, .step_count = 4096, .y_spacing = 3, .z_spacing = 2, .periodic = periodic};
    const WindField field = make_field(grid, [&](std::size_t c, int i, int j, int t) {
      const auto step = static_cast<std::uint64_t>(t), point = static_cast<std::uint64_t>(i * 4 + j);
      const auto stream = static_cast<std::uint32_t>(20 + 2 * c);
      return (i + 1) * (std::sqrt(rho[c]) * gaussian(stream, step) +
                        std::sqrt(1 - rho[c]) * gaussian(stream + 1, step * 20 + point));
    });
    const FieldStatistics statistics =
        field_statistics(field, {.y_separations = {3, 1, 4}, .z_separations = {2, 9}});
    ASSERT_EQ(statistics.coherence.size(), 9U);  // 1 and 3 across, 2 upward; three components
    for (const FieldCoherence& coherence : statistics.coherence) {
      EXPECT_EQ(coherence.distance, coherence.cells * (coherence.vertical ? 2 : 3));
      EXPECT_EQ(coherence.pair_count,
                coherence.vertical ? 12U : 5U * static_cast<std::size_t>(4 - coherence.cells));
      const double wanted = rho[coherence.component];
      for (std::size_t b = 0; b < statistics.bands.size(); ++b) {
        const int bins = statistics.bands[b].bin_count();
        if (bins < 30) continue;
        const double error = (1 - wanted * wanted) / std::sqrt(2.0 * bins);
        EXPECT_NEAR(coherence.root[b], wanted, 5 * error) << coherence.component << " band " << b;
        EXPECT_NEAR(coherence.real[b], wanted, 5 * error) << coherence.component << " band " << b;
      }
    }
  }
}

// The same wind two steps later one row up: fully coherent, with the phase of the delay.
TEST(FieldStatistics, TellADelayFromALossOfCoherence) {
  const WindGrid grid{.y_count = 2, .z_count = 3, .step_count = 256, .step = 0.2};
  const WindField field = make_field(grid, [](std::size_t, int i, int j, int t) {
    return gaussian(40 + static_cast<std::uint32_t>(j), static_cast<std::uint64_t>((t - 2 * i + 256) % 256));
  });
  const FieldStatistics statistics =
      field_statistics(field, {.bands_per_decade = 1000, .y_separations = {}, .z_separations = {1, 2}});
  ASSERT_EQ(statistics.coherence.size(), 6U);
  for (const FieldCoherence& coherence : statistics.coherence) {
    for (std::size_t b = 0; b < statistics.bands.size(); ++b) {
      const double delay = 2 * coherence.cells * grid.step;
      EXPECT_NEAR(coherence.root[b], 1, 1e-5);
      EXPECT_NEAR(coherence.real[b], std::cos(2 * pi * statistics.bands[b].frequency * delay), 1e-5);
    }
  }
}

TEST(FieldStatistics, OfCalmAirOfOneStepAndOfOnePointAreNumbers) {
  for (const int steps : {1, 2, 3, 4, 50}) {
    for (const bool periodic : {true, false}) {
      const WindGrid grid{.y_count = 2, .z_count = 2, .step_count = steps, .periodic = periodic};
      const FieldStatistics statistics =
          field_statistics(make_field(grid, [](std::size_t, int, int, int) { return 0.0; }));
      EXPECT_EQ(statistics.rows[1].turbulence_intensity, 0);
      EXPECT_EQ(statistics.rows[1].deviation[2], 0);
      for (const FieldCoherence& coherence : statistics.coherence) {
        for (const double value : coherence.root) EXPECT_EQ(value, 0);
      }
      for (const double value : statistics.spectra[0][0].value) EXPECT_EQ(value, 0);
      for (const double error : statistics.spectra[0][0].standard_error) EXPECT_EQ(error, 0);
    }
  }
}

TEST(FieldStatistics, RefuseSettingsThatMakeNoSense) {
  const WindGrid grid{.y_count = 2, .z_count = 2, .step_count = 8};
  const WindField field = make_field(grid, [](std::size_t, int, int, int) { return 1.0; });
  EXPECT_THROW(field_statistics(field, {.bands_per_decade = 0}), InputError);
  EXPECT_THROW(field_statistics(field, {.bands_per_decade = std::nan("")}), InputError);
  EXPECT_THROW(field_statistics(field, {.y_separations = {0}}), InputError);
  EXPECT_THROW(field_statistics(field, {.z_separations = {-1}}), InputError);
  EXPECT_THROW(field_statistics(field, {.segment_length = -1}), InputError);
  WindField cut = field;
  cut.velocity[1].pop_back();
  EXPECT_THROW(field_statistics(cut), InputError);
}

}  // namespace
}  // namespace tremula
