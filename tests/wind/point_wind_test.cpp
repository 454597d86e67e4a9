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
    const ReferenceWind& found = wind.reference;
    EXPECT_EQ(found.speed, 9);
    EXPECT_EQ(found.height, 15);
    EXPECT_EQ(found.heading, 70);
    EXPECT_NEAR(found.intensity.value(), 0.17, 1e-12);
  }
  EXPECT_FALSE(Wind(StamWind{.rows = StamRows::as_printed}).reference.intensity);
  EXPECT_FALSE(Wind(turbulent_wind({.speed = 0}, 0.2)).reference.intensity);
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
  const ReferenceWind found = Wind(GivenWind{field, 45}).reference;
  EXPECT_EQ(found.speed, 12);
  EXPECT_EQ(found.height, 8);
  EXPECT_EQ(found.heading, 45);
  // Row 3 lies at 8 m.
  EXPECT_NEAR(found.intensity.value(), field_statistics(*field).rows[3].deviation[0] / 12, 1e-12);
  EXPECT_THROW(Wind(GivenWind{}), InputError);
}

TEST(Wind, KnowsItsSpectrumWhereItsKindHasOne) {
  const TurbulentWind turbulent = turbulent_wind({.speed = 9}, 0.17);
  EXPECT_EQ(Wind(turbulent).spectrum(5, 0.3), spectrum_at(turbulent, 5, 0.3)[0]);
  EXPECT_GT(Wind(StamWind{}).spectrum(5, 0.3), 0);
  EXPECT_FALSE(Wind(StamWind{.rows = StamRows::as_printed}).spectrum);
  EXPECT_FALSE(Wind(turbulent_wind({.speed = 9}, 0)).spectrum);
}

// What two plants ask of one wind: the first alone, and both.
TEST(Wind, InADomainIsTheSameGustsForWhoeverAsks) {
  Eigen::Matrix3Xd both = Eigen::Matrix3Xd::Random(3, 40);
  both.row(2) = 8 + 5 * both.row(2).array();
  both.topRows(2) *= 10;
  const Eigen::Matrix3Xd one = both.leftCols(15);
  const TurbulentWind turbulent = turbulent_wind({.speed = 6, .heading = 25}, 0.2);
  const TimeAxis loop{20, 200};
  const WindDomain domain{Vec3(-12, -12, 0), Vec3(12, 12, 15)};
  const Wind shared(turbulent, domain), alone(turbulent);
  const PointWind near = wind_at_points(shared, loop, one), all = wind_at_points(shared, loop, both);
  for (const int bin : {1, 7, 60}) {
    EXPECT_EQ(near.velocity(bin, 0), all.velocity(bin, 0).leftCols(15)) << bin;
    EXPECT_GT((wind_at_points(alone, loop, one).velocity(bin, 0) -
               wind_at_points(alone, loop, both).velocity(bin, 0).leftCols(15))
                  .norm(),
              0.1 * near.velocity(bin, 0).norm())
        << bin;
  }
}

TEST(Wind, InADomainOfManyPointsIsThatOfFewToTheErrorOfItsLevels) {
  // Many points share levels of height; few have their own.
  Eigen::Matrix3Xd many = Eigen::Matrix3Xd::Random(3, 900);
  many.row(2) = 8 + 5 * many.row(2).array();
  const Wind wind(turbulent_wind({.speed = 6}, 0.2), WindDomain{Vec3(-1, -1, 1), Vec3(1, 1, 15)});
  const TimeAxis loop{20, 200};
  const Eigen::Matrix3Xcd all = wind_at_points(wind, loop, many).velocity(9, 0),
                          few = wind_at_points(wind, loop, many.leftCols(30)).velocity(9, 0);
  EXPECT_LT((all.leftCols(30) - few).norm(), 1e-3 * few.norm());
}

TEST(Wind, RefusesPointsOutsideItsDomainAndDomainsThatAreNone) {
  const TurbulentWind turbulent = turbulent_wind({}, 0.2);
  const auto ask = [&](const WindDomain& domain, const Vec3& point) {
    return wind_at_points(Wind(turbulent, domain), {20, 200}, point);
  };
  EXPECT_NO_THROW(ask({Vec3(0, 0, 0), Vec3(4, 4, 4)}, Vec3(4, 0, 1)));
  EXPECT_THROW(ask({Vec3(0, 0, 0), Vec3(4, 4, 4)}, Vec3(4.01, 0, 1)), InputError);
  EXPECT_THROW(ask({Vec3(0, 0, 5), Vec3(4, 4, 4)}, Vec3(1, 1, 4)), InputError);
  EXPECT_THROW(ask({Vec3(0, NAN, 0), Vec3(4, 4, 4)}, Vec3(1, 1, 1)), InputError);
}

}  // namespace
}  // namespace tremula
