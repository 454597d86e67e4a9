#include "tremula/dynamics/loads.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "tremula/numerics/rotation.hpp"

namespace tremula {
namespace {

const Site plate{.point = 0, .kind = SiteKind::plate, .axis = Vec3(0.6, 0, 0.8), .area = 0.3};

SiteLoad in_wind(const Site& site, const Vec3& wind) {
  return load_on(site, {wind, Mat3::Zero()}, 1, load_law({.model = LoadModel::linearised}));
}

TEST(LoadsOnAPlate, AreTheSpeedThroughItTimesAllOfIt) {
  const Vec3 wind(5, 2, -1);
  const SiteLoad load = in_wind(plate, wind);
  const double half = 0.5 * 1.2 * LoadOptions{}.plate_normal_coefficient * plate.area;
  EXPECT_LT((load.mean - half * wind.norm() * wind.dot(plate.axis) * plate.axis).norm(), 1e-12);
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3 step = 1e-5 * Vec3::Unit(axis);
    const Vec3 slope = (in_wind(plate, wind + step).mean - in_wind(plate, wind - step).mean) / 2e-5;
    EXPECT_LT((load.per_velocity.col(axis) - slope).norm(), 1e-7);
  }
}

TEST(LoadsOnAPlate, OfAWindAlongItAreNoneButForItsGusts) {
  const SiteLoad load = in_wind(plate, 7 * Vec3::UnitY());
  EXPECT_LT(load.mean.norm(), 1e-12);
  EXPECT_GT(plate.axis.dot(load.per_velocity * plate.axis), 1);
}

TEST(LoadsOnAPlate, TurnWithIt) {
  const Vec3 wind(5, 2, -1);
  const SiteLoad load = in_wind(plate, wind);
  for (int axis = 0; axis < 3; ++axis) {
    Site after = plate, before = plate;
    after.axis = rotation_matrix(1e-5 * Vec3::Unit(axis)) * plate.axis;
    before.axis = rotation_matrix(-1e-5 * Vec3::Unit(axis)) * plate.axis;
    const Vec3 slope = (in_wind(after, wind).mean - in_wind(before, wind).mean) / 2e-5;
    EXPECT_LT((load.turning.col(axis) - slope).norm(), 1e-7);
  }
}

TEST(DragAlong, CountsThePartOfTheWindInTheSheet) {
  Sheet sheet;  // in x and z
  EXPECT_LT((drag_along(sheet, {3, 5, 4}, 1.2) - 0.06 * 5 * Vec3(3, 0, 4)).norm(), 1e-14);
  EXPECT_EQ(drag_along(sheet, {0, 5, 0}, 1.2).norm(), 0);
}

}  // namespace
}  // namespace tremula
