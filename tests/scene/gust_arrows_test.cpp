#include "tremula/scene/gust_arrows.hpp"

#include "tremula/base/error.hpp"
#include "tremula/io/gust_plot.hpp"

#include <cmath>
#include <memory>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include "complaint.hpp"

namespace tremula {
namespace {

using Eigen::Vector3f;
using test::complaint_of;
using testing::HasSubstr;

// 4 m/s along x, and along it a sine of one loop over the columns.
std::shared_ptr<const TravellingField> wavy_field() {
  TravellingField field;
  field.loop = {8, 64};
  field.speed = 4;
  field.plane = {.columns = 5, .first_column = -4, .spacing = 2, .heights = {1.5}};
  field.mean = {{4, 0, 0}};
  for (int p = 0; p < 64; ++p) {
    for (int j = 0; j < 5; ++j) {
      const double phase = 2 * 3.14159265358979 * (p / 64.0 + j / 9.0);
      field.values.push_back(
          {static_cast<float>(std::sin(phase)), static_cast<float>(std::cos(phase)), 0.2F, 0});
    }
  }
  return std::make_shared<const TravellingField>(std::move(field));
}

const ArrowLattice lattice{.low = {-6, -4}, .high = {6, 4}, .z = 1.5, .spacing = 2, .scale = 0.3};

TEST(GustArrows, ReachFromTailToTipAlongTheWindAtTheirPlaceAndTime) {
  const auto field = wavy_field();
  const Loop loop = gust_arrows(field, lattice);
  const std::size_t count = arrow_count(lattice), of_one = loop.rest->vertex_count() / count;
  ASSERT_EQ(count, 7U * 5U);
  for (const double time : {0.0, 1.3, 7.9}) {
    const SurfaceDelta delta = loop.skin_at(time);
    for (std::size_t k = 0; k < count; ++k) {
      const Vec3 place(-6 + 2.0 * static_cast<double>(k % 7), -4 + 2.0 * static_cast<double>(k / 7), 1.5);
      const Vec3 wanted = 0.3 * value_at(*field, place, time);
      const Vector3f tail = loop.rest->position[k * of_one] + delta.position[k * of_one],
                     tip = loop.rest->position[(k + 1) * of_one - 1] + delta.position[(k + 1) * of_one - 1];
      EXPECT_LT(((tip - tail).cast<double>() - wanted).norm(), 1e-5);
      EXPECT_LT((0.5 * (tip + tail).cast<double>() - place).norm(), 1e-5);
    }
  }
}

TEST(GustArrows, CloseWithTheLoopAndHaveUnitNormals) {
  const Loop loop = gust_arrows(wavy_field(), lattice);
  EXPECT_EQ(loop.sample_count(), 64);
  const SurfaceDelta now = loop.skin_at(1.7), later = loop.skin_at(9.7);
  for (std::size_t v = 0; v < loop.rest->vertex_count(); ++v) {
    EXPECT_EQ(now.position[v], later.position[v]);
    EXPECT_NEAR((loop.rest->normal[v] + now.normal[v]).norm(), 1, 1e-5);
  }
}

TEST(GustTint, IsTheColourOfTheSpeedInsideItsFieldAndNothingOutside) {
  const auto field = wavy_field();
  const auto tint = gust_tint(field, lattice);
  EXPECT_EQ(tint({6.5F, 0}, 1).w(), 0);
  EXPECT_EQ(tint({0, -4.5F}, 1).w(), 0);
  const Eigen::Vector4f at = tint({1, 2}, 1), same = tint({5, 2}, 2);  // 4 m downwind a second later
  EXPECT_GT(at.w(), 0);
  EXPECT_LT((at - same).norm(), 1e-5F);
  const auto fast_at = [&](double time) { return value_at(*field, {1, 2, 1.5}, time).head<2>().norm(); };
  const double slower = fast_at(0.5) < fast_at(4.5) ? 0.5 : 4.5, faster = 5 - slower;
  EXPECT_GT(tint({1, 2}, slower).head<3>().sum(), tint({1, 2}, faster).head<3>().sum());
  EXPECT_LT(tint({1, 2}, slower).w(), tint({1, 2}, faster).w());
}

TEST(GustArrows, RefuseALatticeThatIsNone) {
  const auto complaint = [](const auto& change) {
    ArrowLattice wrong = lattice;
    change(wrong);
    return complaint_of([&] { gust_arrows(wavy_field(), wrong); });
  };
  EXPECT_THAT(complaint([](ArrowLattice& one) { one.spacing = 0.01; }), HasSubstr("a larger spacing"));
  EXPECT_THAT(complaint([](ArrowLattice& one) { one.scale = 0; }), HasSubstr("scale of the arrows"));
  EXPECT_THAT(complaint([](ArrowLattice& one) { one.high.x() = -7; }), HasSubstr("from low to high"));
}

}  // namespace
}  // namespace tremula
