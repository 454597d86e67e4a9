#include "tremula/render/camera.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "tremula/base/error.hpp"

namespace tremula {
namespace {

constexpr double pi = std::numbers::pi;

TEST(Project, FollowsThePinhole) {
  Camera camera;
  camera.eye = Vec3(-4, 1, 2);
  camera.half_height = 0.5;
  camera.aspect = 2;
  EXPECT_EQ(*project(camera, {0, 1, 2}), Eigen::Vector2d(0.5, 0.5));
  EXPECT_EQ(*project(camera, {0, 1, 4}), Eigen::Vector2d(0.5, 0));   // 2 m up at 4 m: the upper edge
  EXPECT_EQ(*project(camera, {0, -3, 2}), Eigen::Vector2d(1, 0.5));  // 4 m to the right (-y): the right edge
  EXPECT_EQ(*project(camera, {4, -3, 2}), Eigen::Vector2d(0.75, 0.5));
  EXPECT_FALSE(project(camera, {-4.1, 1, 2}));
  EXPECT_FALSE(project(camera, camera.eye));
}

TEST(FrameExtent, HoldsTheBoxWithAMarginThatIsReached) {
  const Vec3 low(-1, -2, 0), high(3, 1, 7);
  for (const double aspect : {0.5, 1.0, 1.78}) {
    for (double azimuth = -3; azimuth < 3.2; azimuth += 0.7) {
      for (const double elevation : {-0.3, 0.0, 0.2, 1.3}) {
        const Camera camera = frame_extent(low, high, azimuth, elevation, aspect);
        double left = 1, right = 0, top = 1, bottom = 0;
        for (int corner = 0; corner < 8; ++corner) {
          const Vec3 point(corner & 1 ? high.x() : low.x(), corner & 2 ? high.y() : low.y(),
                           corner & 4 ? high.z() : low.z());
          const auto seen = project(camera, point);
          ASSERT_TRUE(seen);
          left = std::min(left, seen->x());
          right = std::max(right, seen->x());
          top = std::min(top, seen->y());
          bottom = std::max(bottom, seen->y());
        }
        // Tight in one direction, within the margin in the other.
        EXPECT_NEAR(std::min({left, 1 - right, top, 1 - bottom}), 0.06, 1e-9);
        EXPECT_TRUE(std::abs(right - left - 0.88) < 1e-9 || std::abs(bottom - top - 0.88) < 1e-9);
      }
    }
  }
}

TEST(FrameExtent, TakesTheMarginAndTheFieldOfViewThatItIsGiven) {
  const Vec3 low(-1, -2, 0), high(3, 1, 7);
  const Camera camera = frame_extent(low, high, 0.4, 0.1, 1.5, {.half_height = 0.6, .margin = 0.2});
  EXPECT_EQ(camera.half_height, 0.6);
  double top = 1, bottom = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const auto seen = project(camera, {corner & 1 ? high.x() : low.x(), corner & 2 ? high.y() : low.y(),
                                       corner & 4 ? high.z() : low.z()});
    ASSERT_TRUE(seen);
    top = std::min(top, seen->y());
    bottom = std::max(bottom, seen->y());
  }
  EXPECT_NEAR(bottom - top, 0.6, 1e-9);
  EXPECT_THROW(frame_extent(low, high, 0, 0, 1, {.half_height = 0}), InputError);
  EXPECT_THROW(frame_extent(low, high, 0, 0, 1, {.margin = 0.5}), InputError);
}

TEST(LookAt, HasThePointInTheMiddleAndTheHorizonLevel) {
  const Camera camera = look_at({5, -3, 2}, {-1, 4, 7}, 1.6, 0.3);
  EXPECT_LT((*project(camera, {-1, 4, 7}) - Eigen::Vector2d(0.5, 0.5)).norm(), 1e-12);
  EXPECT_NEAR(camera.right.z(), 0, 1e-15);
  EXPECT_GT(camera.up.z(), 0);
  EXPECT_NEAR(camera.right.cross(camera.up).dot(camera.forward), -1, 1e-12) << "as right, up and forward are";
  EXPECT_EQ(camera.half_height, 0.3);
  EXPECT_EQ(camera.aspect, 1.6);
  EXPECT_THROW(look_at({1, 2, 3}, {1, 2, 3}, 1), InputError);
  EXPECT_THROW(look_at({1, 2, 3}, {1, 2, std::numeric_limits<double>::infinity()}, 1), InputError);
}

TEST(FrameExtent, LooksFromTheGivenSideAndHeight) {
  const Camera from_x = frame_extent({-1, -1, -1}, {1, 1, 1}, 0, 0, 1);
  EXPECT_GT(from_x.eye.x(), 2);
  EXPECT_NEAR(from_x.eye.y(), 0, 1e-12);
  EXPECT_GT(project(from_x, {0, 1, 0})->x(), 0.5);  // y is to the right of who looks along -x
  EXPECT_LT(project(from_x, {0, 0, 1})->y(), 0.5);  // z is up
  const Camera from_y = frame_extent({-1, -1, -1}, {1, 1, 1}, pi / 2, 0.5, 1);
  EXPECT_GT(from_y.eye.y(), 2);
  EXPECT_NEAR(from_y.forward.z(), -std::sin(0.5), 1e-12);
  EXPECT_NEAR(from_y.right.dot(from_y.forward), 0, 1e-12);
  EXPECT_NEAR(from_y.up.dot(from_y.forward), 0, 1e-12);
}

TEST(FrameExtent, ABoxWithoutSizeIsStillSeen) {
  const Camera camera = frame_extent({1, 2, 3}, {1, 2, 3}, 0.3, 0.1, 1);
  const auto seen = project(camera, {1, 2, 3});
  ASSERT_TRUE(seen);
  EXPECT_NEAR(seen->x(), 0.5, 1e-9);
  EXPECT_NEAR(seen->y(), 0.5, 0.01);
}

TEST(FramePoints, IsAsCloseAsThePointsAllow) {
  const std::vector<Eigen::Vector3f> points = {{0, 0, 0}, {0, 0, 5}, {1, 0.5F, 3}, {-2, 1, 4}, {0.3F, -1, 2}};
  for (double azimuth = -3; azimuth < 3.2; azimuth += 0.7) {
    const Camera camera = frame_points(points, azimuth, 0.2, 1.3);
    Eigen::Vector2d low(1, 1), high(0, 0);
    for (const Eigen::Vector3f& point : points) {
      const auto seen = project(camera, point.cast<double>());
      ASSERT_TRUE(seen);
      low = low.cwiseMin(*seen);
      high = high.cwiseMax(*seen);
    }
    EXPECT_GT(low.minCoeff(), 0.06 - 1e-6);
    EXPECT_LT(high.maxCoeff(), 0.94 + 1e-6);
    EXPECT_NEAR((high - low).maxCoeff(), 0.88, 1e-6);
  }
}

TEST(FrameExtent, RejectsWhatCannotBeFramed) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(frame_extent({0, 0, nan}, {1, 1, 1}, 0, 0, 1), InputError);
  EXPECT_THROW(frame_extent({0, 0, 2}, {1, 1, 1}, 0, 0, 1), InputError);
  EXPECT_THROW(frame_extent({0, 0, 0}, {1, 1, 1}, nan, 0, 1), InputError);
  EXPECT_THROW(frame_extent({0, 0, 0}, {1, 1, 1}, 0, pi / 2, 1), InputError);
  EXPECT_THROW(frame_extent({0, 0, 0}, {1, 1, 1}, 0, 0, 0), InputError);
  EXPECT_THROW(frame_points({}, 0, 0, 1), InputError);
  const std::vector<Eigen::Vector3f> bad = {{0, 0, static_cast<float>(nan)}};
  EXPECT_THROW(frame_points(bad, 0, 0, 1), InputError);
}

TEST(AzimuthAcross, LooksAcrossTheWindButNotAtTheEdgeOfASheet) {
  using Pose = std::vector<Eigen::Vector3f>;
  const double heading = 0.4, degree = std::numbers::pi / 180;
  const auto along = [&](double angle) {
    return Eigen::Vector3f(static_cast<float>(std::cos(heading + angle)),
                           static_cast<float>(std::sin(heading + angle)), 0);
  };
  const std::vector<Pose> flag{{along(std::numbers::pi / 2)}}, curtain{{along(0)}},
      round{{along(0), along(1), along(2), along(3), along(4), along(5)}};
  EXPECT_NEAR(azimuth_across(flag, heading), heading - 105 * degree, 1e-12);
  EXPECT_NEAR(azimuth_across(round, heading), heading - 105 * degree, 1e-12);
  EXPECT_NEAR(azimuth_across(curtain, heading), heading - 145 * degree, 1e-12);
}

}  // namespace
}  // namespace tremula
