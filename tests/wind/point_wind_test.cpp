#include "tremula/wind/point_wind.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "tremula/base/error.hpp"
#include "tremula/wind/field_statistics.hpp"
#include "tremula/wind/synthesis.hpp"

namespace tremula {
namespace {

TEST(ReferenceWind, OfAModelIsWhatItWasMadeFrom) {
  const MeanWind mean{.speed = 9, .reference_height = 15, .heading = 70};
  for (const Wind& wind :
       {Wind(turbulent_wind(mean, 0.17)), Wind(turbulent_wind(mean, 0.17, SpectrumKind::iec_kaimal)),
        Wind(StamWind{.mean = mean, .turbulence_intensity = 0.17})}) {
    const ReferenceWind found = at_reference_height(wind);
    EXPECT_EQ(found.speed, 9);
    EXPECT_EQ(found.height, 15);
    EXPECT_EQ(found.heading, 70);
    EXPECT_NEAR(found.intensity.value(), 0.17, 1e-12);
  }
  EXPECT_FALSE(at_reference_height(StamWind{.rows = StamRows::as_printed}).intensity);
  EXPECT_FALSE(at_reference_height(turbulent_wind({.speed = 0}, 0.2)).intensity);
}

TEST(ReferenceWind, OfAFieldIsItsOwnWithTheDeviationOfItsRow) {
  const MeanWind mean{.speed = 12, .reference_height = 8};
  const WindGrid grid{.y_count = 4,
                      .z_count = 5,
                      .step_count = 500,
                      .y_spacing = 2,
                      .z_spacing = 2,
                      .bottom = 2,
                      .step = 0.1};
  auto field = std::make_shared<WindField>(synthesise_wind(turbulent_wind(mean, 0.2), grid));
  const ReferenceWind found = at_reference_height(GivenWind{field, 45});
  EXPECT_EQ(found.speed, 12);
  EXPECT_EQ(found.height, 8);
  EXPECT_EQ(found.heading, 45);
  // Row 3 lies at 8 m.
  EXPECT_NEAR(found.intensity.value(), field_statistics(*field).rows[3].deviation[0] / 12, 1e-12);
  EXPECT_THROW(at_reference_height(GivenWind{}), InputError);
}

}  // namespace
}  // namespace tremula
