#include "tremula/dynamics/foliage.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tremula/base/error.hpp"

namespace tremula {
namespace {

const FoliageLaw law{.vogel_exponent = -0.8, .folding_speed = 4};

TEST(FoldingFactor, IsOneAtRestAndThePowerOfTheVogelExponentInAStorm) {
  EXPECT_EQ(folding_factor(law, 0), 1);
  EXPECT_NEAR(folding_factor(law, 4), std::pow(2, -0.4), 1e-15);
  EXPECT_NEAR(folding_factor(law, 8e4) / folding_factor(law, 4e4), std::pow(2, -0.8), 1e-8);
  EXPECT_EQ(folding_factor({.vogel_exponent = 0, .folding_speed = 4}, 30), 1);
}

TEST(FoldingSlope, IsTheLogarithmicDerivativeOfTheFactor) {
  for (const double speed : {0.1, 3.0, 20.0}) {
    const double h = 1e-5;
    const double difference =
        std::log(folding_factor(law, speed * (1 + h))) - std::log(folding_factor(law, speed * (1 - h)));
    EXPECT_NEAR(folding_slope(law, speed), difference / (2 * h), 1e-9);
  }
}

TEST(CheckFoliage, RefusesLeavesThatUnfoldInTheWindAndSpeedsThatAreNone) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NO_THROW(check_foliage({}));
  for (const double exponent : {0.1, -1.4, nan})
    EXPECT_THROW(check_foliage({.vogel_exponent = exponent}), InputError);
  for (const double speed : {0.0, -1.0, nan, std::numeric_limits<double>::infinity()})
    EXPECT_THROW(check_foliage({.folding_speed = speed}), InputError);
}

}  // namespace
}  // namespace tremula
