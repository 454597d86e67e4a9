#include "tremula/scene/film_camera.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "complaint.hpp"

namespace tremula {
namespace {

using testing::HasSubstr;

constexpr double degree = std::numbers::pi / 180;

CameraKey key(double time, const Vec3& eye, const Vec3& look_at = {0, 0, 2}) {
  return {.time = time, .eye = eye, .look_at = look_at, .place = {"scene.toml", 7, 1}};
}

SceneCamera around(double period) {
  SceneCamera camera;
  for (int i = 0; i < 5; ++i) {
    const double angle = 2 * std::numbers::pi * (i + 0.1 * i * i) / 7.5;  // not evenly
    camera.path.push_back(key(0.5 + period * (i + 0.05 * i * i) / 7,
                              Vec3(10 * std::cos(angle), 10 * std::sin(angle), 2 + (i % 2)),
                              {0.1 * i, 0, 2}));
  }
  camera.path[2].field_of_view = 15 * degree;
  return camera;
}

const CameraView loop_of_ten{.period = 10};

TEST(FilmCamera, WithAnEyeLooksFromThereAtThePoint) {
  SceneCamera camera;
  camera.eye = Vec3(-30, 4, 1.7);
  camera.look_at = Vec3(2, 1, 6);
  camera.field_of_view = 40 * degree;
  const Camera still = film_camera(camera, {}, {.aspect = 2}).camera(3);
  EXPECT_EQ(still.eye, *camera.eye);
  const auto middle = project(still, *camera.look_at);
  ASSERT_TRUE(middle);
  EXPECT_LT((*middle - Eigen::Vector2d(0.5, 0.5)).norm(), 1e-12);
  EXPECT_NEAR(still.half_height, std::tan(20 * degree), 1e-12);
  EXPECT_NEAR(still.right.z(), 0, 1e-15) << "level";
  EXPECT_GT(still.up.z(), 0);
}

TEST(FilmCamera, LooksStraightDownWithYAbove) {
  SceneCamera camera;
  camera.eye = Vec3(0, 0, 50);
  camera.look_at = Vec3(0, 0, 0);
  const Camera still = film_camera(camera, {}, {.aspect = 1}).camera(0);
  const auto above = project(still, {0, 5, 0}), right = project(still, {5, 0, 0});
  ASSERT_TRUE(above && right);
  EXPECT_LT(above->y(), 0.5);
  EXPECT_GT(right->x(), 0.5);
}

TEST(FilmCamera, WithoutAnEyeHasEverythingInTheFrameWithItsMargin) {
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 200; ++i)
    points.emplace_back(5 * std::sin(1.0F * i), 4 * std::cos(2.3F * i), 4 + 4 * std::sin(0.7F * i));
  SceneCamera camera;
  camera.azimuth = 1.1;
  camera.elevation = 12 * degree;
  camera.margin = 0.15;
  camera.field_of_view = 50 * degree;
  const Camera still = film_camera(camera, {}, {.points = points, .aspect = 1.5}).camera(0);
  double least = 1, most = 0, lowest = 1, highest = 0;
  for (const Eigen::Vector3f& point : points) {
    const auto at = project(still, point.cast<double>());
    ASSERT_TRUE(at);
    least = std::min(least, at->x());
    most = std::max(most, at->x());
    lowest = std::min(lowest, at->y());
    highest = std::max(highest, at->y());
  }
  EXPECT_GE(std::min(least, lowest), 0.15 - 1e-6);
  EXPECT_LE(std::max(most, highest), 0.85 + 1e-6);
  EXPECT_NEAR(std::max(most - least, highest - lowest), 0.7, 1e-6) << "as near as that allows";
  EXPECT_NEAR(still.half_height, std::tan(25 * degree), 1e-12);
}

TEST(FilmCamera, OnAPathIsAtItsKeysAtTheirTimes) {
  const SceneCamera camera = around(10);
  const FilmCamera film = film_camera(camera, {}, loop_of_ten);
  for (const CameraKey& at : camera.path) {
    const Camera there = film.camera(at.time);
    EXPECT_LT((there.eye - at.eye).norm(), 1e-9);
    EXPECT_LT((there.forward - (at.look_at - at.eye).normalized()).norm(), 1e-9);
    EXPECT_NEAR(there.half_height, std::tan(0.5 * at.field_of_view.value_or(28 * degree)), 1e-9);
  }
}

TEST(FilmCamera, OnAPathThatRepeatsClosesInPlaceAndSpeed) {
  const FilmCamera film = film_camera(around(10), {}, loop_of_ten);
  const auto eye = [&](double time) { return film.camera(time).eye; };
  for (const double time : {0.0, 0.5, 3.21, 9.9}) {
    EXPECT_LT((eye(time) - eye(time + 10)).norm(), 1e-12);
    EXPECT_LT((eye(time) - eye(time - 30)).norm(), 1e-11);
  }
  // The slopes on both sides of every key, the first and the last of the loop among them, are the same.
  const double h = 1e-5;
  for (const CameraKey& at : around(10).path) {
    const Vec3 before = (eye(at.time) - eye(at.time - h)) / h, after = (eye(at.time + h) - eye(at.time)) / h;
    EXPECT_LT((before - after).norm(), 1e-3) << at.time;
    EXPECT_GT(before.head<2>().norm(), 1) << "and it does move";
  }
}

TEST(FilmCamera, BetweenInnerKeysFollowsAnyParabolaExactly) {
  SceneCamera camera;
  camera.path_repeats = false;
  const auto parabola = [](double t) { return Vec3(3 + 2 * t - 0.3 * t * t, -9 + t * t, 5); };
  for (const double time : {0.0, 1.0, 2.5, 3.0, 5.0, 6.0})
    camera.path.push_back(key(time, parabola(time), {40, 50, 0}));
  const FilmCamera film = film_camera(camera, {}, {});
  for (double time = 1; time <= 5; time += 0.13)
    EXPECT_LT((film.camera(time).eye - parabola(time)).norm(), 1e-12) << time;
}

TEST(FilmCamera, NeverGoesBelowTheLowerOfTwoKeys) {
  SceneCamera camera;
  const std::vector<double> heights{0.1, 9, 0.1, 0.1, 6, 0.2};
  for (std::size_t i = 0; i < heights.size(); ++i)
    camera.path.push_back(key(static_cast<double>(i), {10.0 - static_cast<double>(i), 5, heights[i]}));
  const FilmCamera film = film_camera(camera, {}, {.period = 6});
  for (double time = 0; time < 6; time += 0.01) {
    const auto i = static_cast<std::size_t>(time);
    EXPECT_GE(film.camera(time).eye.z(), std::min(heights[i], heights[(i + 1) % 6]) - 1e-12) << time;
  }
}

TEST(FilmCamera, OnAPathThatEndsRestsBeforeAndAfterIt) {
  SceneCamera camera;
  camera.path_repeats = false;
  camera.path = {key(1, {5, 0, 2}), key(3, {0, 5, 2})};
  const FilmCamera film = film_camera(camera, {}, {});
  EXPECT_EQ(film.camera(-4).eye, Vec3(5, 0, 2));
  EXPECT_EQ(film.camera(30).eye, Vec3(0, 5, 2));
  EXPECT_LT((film.camera(2).eye - Vec3(2.5, 2.5, 2)).norm(), 1e-12);
}

TEST(FilmCamera, FocusesOnWhatItLooksAtUnlessItIsTold) {
  SceneCamera camera;
  camera.eye = Vec3(-10, 0, 2);
  camera.look_at = Vec3(0, 0, 2);
  camera.aperture = 0.05;
  EXPECT_EQ(film_camera(camera, {}, {}).lens_radius, 0.025);
  EXPECT_NEAR(film_camera(camera, {}, {}).focus_distance(0), 10, 1e-12);
  camera.focus_at = Vec3(-4, 3, 2);
  EXPECT_NEAR(film_camera(camera, {}, {}).focus_distance(0), 6, 1e-12) << "its plane, not its distance";
  camera.focus_distance = 3;
  EXPECT_EQ(film_camera(camera, {}, {}).focus_distance(0), 3);
  camera = around(10);
  camera.aperture = 0.05;
  const CameraKey at = camera.path[1];
  EXPECT_NEAR(film_camera(camera, {}, loop_of_ten).focus_distance(at.time), (at.look_at - at.eye).norm(),
              1e-9);
}

TEST(FilmCamera, RefusesWhatCannotBeFilmed) {
  const auto complaint = [](const SceneCamera& camera, const CameraView& view,
                            const SceneGround& ground = {}) {
    return test::complaint_of([&] { film_camera(camera, ground, view); });
  };
  EXPECT_THAT(complaint(around(10), {.period = 4}), HasSubstr("scene.toml:7:1: camera.path.time"));
  EXPECT_THAT(complaint(around(10), {.period = 4}), HasSubstr("less than the loop of 4 s"));

  SceneCamera below;
  below.elevation = -30 * degree;
  below.place = {"scene.toml", 3, 1};
  const std::vector<Eigen::Vector3f> points{{0, 0, 0}, {1, 0, 2}};
  EXPECT_THAT(complaint(below, {.points = points}),
              HasSubstr("scene.toml:3:1: camera: its eye would be at a height of -"));
  EXPECT_EQ(complaint(below, {.points = points}, {.kind = "none"}), "");

  SceneCamera through;
  through.path = {key(0, {-2, 0, 2}), key(1, {2, 0, 2})};
  EXPECT_THAT(complaint(through, loop_of_ten), HasSubstr("the eye is at what it looks at"));
  EXPECT_NE(complaint({}, {.points = {}}), "");
}

}  // namespace
}  // namespace tremula
