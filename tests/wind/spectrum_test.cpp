#include "tremula/wind/spectrum.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "support.hpp"

namespace tremula {
namespace {

// The integral over f > 0, by the trapezoidal rule in log f: the integrand f S falls off on both sides.
Vec3 variance(double height, double speed, double friction_velocity) {
  Vec3 sum = Vec3::Zero();
  const double step = 0.01;
  for (double log_f = -40; log_f < 40; log_f += step) {
    const double f = std::exp(log_f);
    sum += step * f * simiu_scanlan_spectrum(f, height, speed, friction_velocity);
  }
  return sum;
}

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

}  // namespace
}  // namespace tremula
