#include "tremula/scene/haze.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tremula/base/error.hpp"

namespace tremula {
namespace {

TEST(Haze, LeavesTwoPerCentOfTheContrastAtTheVisibility) {
  for (const double visibility : {100.0, 2000.0, 20e3, 100e3})
    EXPECT_NEAR(std::exp(-static_cast<double>(air_extinction(visibility)[1]) * visibility), 0.02, 1e-5);
  for (const double visibility : {1.0, 12.0, 40.0})
    EXPECT_NEAR(std::exp(-static_cast<double>(water_extinction(visibility)[1]) * visibility), 0.02, 1e-5);
}

TEST(Haze, OfAirTakesBlueFirstAndOfFogAllAlike) {
  const Eigen::Vector3f clear = air_extinction(100e3), fog = air_extinction(1);
  EXPECT_GT(clear[2], clear[1]);
  EXPECT_GT(clear[1], clear[0]);
  // Kruse: wavelength^-1.6 beyond 50 km.
  EXPECT_NEAR(static_cast<double>(clear[2] / clear[0]), std::pow(610.0 / 465, 1.6), 1e-5);
  EXPECT_NEAR(static_cast<double>(fog[2] / fog[0]), 1, 0.02);
}

TEST(Haze, OfWaterTakesRedFirstAndOfTheClearestIsThatOfWaterItself) {
  const Eigen::Vector3f sea = water_extinction(12), pure = water_extinction(1e5);
  EXPECT_GT(sea[0], sea[1]);
  EXPECT_GT(sea[1], sea[2]);
  EXPECT_NEAR(static_cast<double>(pure[1]), 0.0565, 1e-6);
  EXPECT_NEAR(static_cast<double>(sea[0] - sea[1]), static_cast<double>(pure[0] - pure[1]), 1e-6)
      << "what floats is grey";
}

TEST(Haze, OfAMediumIsThatOfItsVisibilityOrOfWhatIsUsual) {
  EXPECT_EQ(extinction_of({}, false), air_extinction(20e3));
  EXPECT_EQ(extinction_of({}, true), water_extinction(12));
  EXPECT_EQ(extinction_of({.visibility = 3000}, false), air_extinction(3000));
  EXPECT_THROW(air_extinction(0), InputError);
  EXPECT_THROW(water_extinction(std::nan("")), InputError);
}

}  // namespace
}  // namespace tremula
