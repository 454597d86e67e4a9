#include "tremula/wind/spectrum.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "support.hpp"
#include "tremula/base/error.hpp"

namespace tremula {
namespace {

// The integral over f > 0, by the trapezoidal rule in log f: the integrand f S falls off on both sides.
Vec3 integral(const SpectrumModel& model, double height, double speed, double step = 0.01) {
  Vec3 sum = Vec3::Zero();
  for (double log_f = -40; log_f < 40; log_f += step) {
    sum += step * std::exp(log_f) * spectrum(model, std::exp(log_f), height, speed);
  }
  return sum;
}

Vec3 variance(double height, double speed, double friction_velocity) {
  return integral({.friction_velocity = friction_velocity}, height, speed);
}

const MeanWind breeze{.speed = 8, .reference_height = 20};

TEST(SimiuScanlanSpectrum, IntegratesToTheVarianceAtEveryHeightAndSpeed) {
  TREMULA_NEED_DATA("validation.json");
  const auto json = nlohmann::json::parse(std::ifstream(test::data_folder() / "validation.json"));
  nlohmann::json wanted;
  for (const auto& item : json["items"]) {
    if (item["id"] == "wind.spectrum.simiu_scanlan") wanted = item["variance_over_ustar2"];
  }
  for (const double height : {1.0, 10.0, 80.0}) {
    const Vec3 found = variance(height, 7, 0.4) / 0.16;
    EXPECT_NEAR(found[0] / wanted["u"].get<double>(), 1, 1e-6);
    EXPECT_NEAR(found[1] / wanted["v"].get<double>(), 1, 1e-6);
    EXPECT_NEAR(found[2] / wanted["w"].get<double>(), 1, 1e-6);
  }
}

TEST(SimiuScanlanSpectrum, FallsWithTheMinusFiveThirdsPowerAtHighFrequency) {
  const Vec3 ratio =
      simiu_scanlan_spectrum(2e4, 10, 6, 0.3).cwiseQuotient(simiu_scanlan_spectrum(1e4, 10, 6, 0.3));
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(ratio[c], std::pow(2.0, -5.0 / 3), 1e-4);
}

TEST(FrictionVelocity, GivesTheIntensityItIsMadeFrom) {
  const double friction_velocity = friction_velocity_from_intensity(0.2, 6);
  EXPECT_NEAR(std::sqrt(variance(10, 6, friction_velocity)[0]), 1.2, 1e-6);
}

TEST(Spectrum, OfEveryModelIntegratesToItsVarianceInClosedForm) {
  for (const SpectrumKind kind :
       {SpectrumKind::simiu_scanlan, SpectrumKind::iec_kaimal, SpectrumKind::von_karman}) {
    const SpectrumModel model = spectrum_model(kind, breeze, 0.2);
    const Vec3 wanted = spectrum_variance(model);
    for (const double height : {2.0, 40.0}) {
      const Vec3 found = integral(model, height, 6);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c] / wanted[c], 1, 1e-6) << name_of(kind) << ", " << c;
    }
    EXPECT_NEAR(wanted[0], 1.6 * 1.6, 1e-12) << "intensity times speed, squared";
  }
}

TEST(Spectrum, OfTheStandardHasItsRatiosOfDeviations) {
  const Vec3 kaimal = spectrum_variance(spectrum_model(SpectrumKind::iec_kaimal, breeze, 0.1)).cwiseSqrt();
  EXPECT_NEAR(kaimal[1] / kaimal[0], 0.8, 1e-12);
  EXPECT_NEAR(kaimal[2] / kaimal[0], 0.5, 1e-12);
  const Vec3 karman = spectrum_variance(spectrum_model(SpectrumKind::von_karman, breeze, 0.1));
  EXPECT_NEAR((karman - karman[0] * Vec3::Ones()).norm(), 0, 1e-12);
}

TEST(Spectrum, OfTheStandardIsTheFormOfItsTextAtOnePointOfEachFormula) {
  // Written out for a hub at 100 m (Lambda = 42 m), 10 m/s, sigma_1 = 1.5 m/s, f = 0.1 Hz: f S / sigma^2.
  const MeanWind hub{.speed = 10, .reference_height = 100};
  const double n = 0.1 * 8.1 * 42 / 10;
  const SpectrumModel kaimal = spectrum_model(SpectrumKind::iec_kaimal, hub, 0.15);
  EXPECT_NEAR(0.1 * spectrum(kaimal, 0.1, 50, 9)[0] / 2.25, 4 * n / std::pow(1 + 6 * n, 5.0 / 3), 1e-12);
  const double m = 0.1 * 3.5 * 42 / 10;
  const Vec3 karman = 0.1 / 2.25 * spectrum(spectrum_model(SpectrumKind::von_karman, hub, 0.15), 0.1, 50, 9);
  // The standard rounds 70.8 to 71 and 188.8 to 189.
  EXPECT_NEAR(karman[0] * std::pow(1 + 71 * m * m, 5.0 / 6) / (4 * m), 1, 5e-3);
  EXPECT_NEAR(karman[1] * std::pow(1 + 71 * m * m, 11.0 / 6) / (2 * m * (1 + 189 * m * m)), 1, 5e-3);
  EXPECT_EQ(karman[1], karman[2]);
}

TEST(Spectrum, OfIsotropicTurbulenceObeysTheRelationOfVonKarman) {
  // S_v = (S_u - f dS_u/df) / 2 in any isotropic incompressible turbulence.
  const SpectrumModel model = spectrum_model(SpectrumKind::von_karman, breeze, 0.2);
  for (const double f : {0.003, 0.05, 1.0}) {
    const double slope =
        (spectrum(model, f * (1 + 1e-5), 5, 5)[0] - spectrum(model, f * (1 - 1e-5), 5, 5)[0]) / 2e-5;
    const Vec3 s = spectrum(model, f, 5, 5);
    EXPECT_NEAR(s[1] / (0.5 * (s[0] - slope)), 1, 1e-8);
  }
}

SpectrumTable some_table(bool by_wave_number) {
  return {.by_wave_number = by_wave_number,
          .at = {0.01, 0.04, 0.3, 1.0},
          .values = {{3, 2, 1}, {3, 4, 1.5}, {0.2, 0.3, 0.1}, {0.02, 0.04, 0.03}}};
}

TEST(SpectrumTable, GoesThroughItsRowsAndIsStraightBetweenThemInLogarithms) {
  const SpectrumModel model = table_spectrum(some_table(false));
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_LT((spectrum(model, model.table.at[i], 5, 5) - model.table.values[i]).norm(), 1e-14);
  }
  const Vec3 middle = spectrum(model, std::sqrt(0.04 * 0.3), 5, 5);
  EXPECT_NEAR(middle[1], std::sqrt(4 * 0.3), 1e-12);
  EXPECT_EQ(spectrum(model, 0.002, 5, 5), model.table.values[0]);
  EXPECT_NEAR(spectrum(model, 8, 5, 5)[2], 0.03 / 32, 1e-12);
}

TEST(SpectrumTable, IntegratesToItsVarianceByFrequencyAndByWaveNumber) {
  for (const bool by_wave_number : {false, true}) {
    const SpectrumModel model = table_spectrum(some_table(by_wave_number));
    const Vec3 wanted = spectrum_variance(model);
    for (const double speed : {3.0, 12.0}) {
      EXPECT_LT((integral(model, 5, speed, 0.001) - wanted).norm() / wanted.norm(), 1e-5);
    }
  }
}

TEST(SpectrumTable, RefusesWhatIsNoSpectrum) {
  const auto with = [](auto change) {
    SpectrumTable table = some_table(false);
    change(table);
    return table;
  };
  EXPECT_THROW(table_spectrum({}), InputError);
  EXPECT_THROW(table_spectrum(with([](auto& t) { t.at.pop_back(); })), InputError);
  EXPECT_THROW(table_spectrum(with([](auto& t) { t.at[0] = 0; })), InputError);
  EXPECT_THROW(table_spectrum(with([](auto& t) { t.at[2] = t.at[1]; })), InputError);
  EXPECT_THROW(table_spectrum(with([](auto& t) { t.values[1][2] = 0; })), InputError);
  EXPECT_THROW(table_spectrum(with([](auto& t) { t.values[1][0] = std::nan(""); })), InputError);
  EXPECT_THROW(table_spectrum(with([](auto& t) { t.at[3] = std::numeric_limits<double>::infinity(); })),
               InputError);
}

TEST(SpectrumNamed, KnowsTheNamesItGivesAndNoOthers) {
  for (const SpectrumKind kind : {SpectrumKind::simiu_scanlan, SpectrumKind::iec_kaimal,
                                  SpectrumKind::von_karman, SpectrumKind::table}) {
    EXPECT_EQ(spectrum_named(name_of(kind)), kind);
  }
  EXPECT_THROW(spectrum_named("kaimal"), InputError);
}

TEST(Spectrum, IsZeroWhereThereIsNoMeanWind) {
  EXPECT_EQ(spectrum(spectrum_model(SpectrumKind::simiu_scanlan, breeze, 0.2), 0.1, 5, 0), Vec3::Zero());
}

TEST(WithDeviations, ChangesTheVariancesAndNotTheShapes) {
  const Vec3 wanted(1.2, 1.1, 0.4);
  for (const SpectrumKind kind :
       {SpectrumKind::simiu_scanlan, SpectrumKind::iec_kaimal, SpectrumKind::von_karman}) {
    const SpectrumModel own = spectrum_model(kind, breeze, 0.2), changed = with_deviations(own, wanted);
    EXPECT_LT((spectrum_variance(changed) - wanted.cwiseAbs2()).norm(), 1e-14) << name_of(kind);
    const Vec3 factor = spectrum(changed, 0.1, 12, 5).cwiseQuotient(spectrum(own, 0.1, 12, 5));
    for (const double frequency : {0.001, 1.0, 30.0}) {
      const Vec3 there = spectrum(changed, frequency, 12, 5).cwiseQuotient(spectrum(own, frequency, 12, 5));
      EXPECT_LT((there - factor).norm(), 1e-12) << name_of(kind) << ", " << frequency;
    }
  }
  EXPECT_THROW(
      with_deviations(spectrum_model(SpectrumKind::simiu_scanlan, breeze, 0.2), Vec3::Constant(std::nan(""))),
      InputError);
}

TEST(LargestCovariance, IsTheProductOfDeviationsWhereSpectraHaveOneShapeAndLessElsewhere) {
  SpectrumTable table;
  for (const double f : {0.001, 0.01, 0.1, 1.0, 10.0}) {
    table.at.push_back(f);
    table.values.emplace_back(3 / (1 + f), 1, 0.75 / (1 + f));
  }
  const SpectrumModel alike = table_spectrum(table);
  EXPECT_NEAR(largest_covariance_uw(alike, 10, 6) / (0.5 * spectrum_variance(alike)[0]), 1, 1e-4);
  for (const SpectrumKind kind :
       {SpectrumKind::simiu_scanlan, SpectrumKind::iec_kaimal, SpectrumKind::von_karman}) {
    const SpectrumModel model = spectrum_model(kind, breeze, 0.2);
    const Vec3 variance = spectrum_variance(model);
    const double most = largest_covariance_uw(model, 10, 6);
    EXPECT_LT(most, std::sqrt(variance[0] * variance[2]));
    EXPECT_GT(most, 0.5 * std::sqrt(variance[0] * variance[2]));
    EXPECT_NEAR(largest_covariance_uw(model, 40, 9), most, 1e-6 * most) << "the same at all heights";
  }
}

}  // namespace
}  // namespace tremula
