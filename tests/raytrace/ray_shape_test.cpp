#include "tremula/raytrace/ray_shape.hpp"

#include "raytrace/simple_scenes.hpp"

#include "tremula/base/error.hpp"
#include "tremula/base/noise.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include <tbb/global_control.h>

namespace tremula {
namespace {

using namespace simple;
using Eigen::Vector3f;

// Where a ray meets a sphere first, before `farthest`.
bool meets_sphere(const Vector3f& centre, float radius, const Vector3f& origin, const Vector3f& direction,
                  float farthest, RayShapeHit& hit) {
  const Vector3f from = origin - centre;
  const float half = from.dot(direction), rest = half * half - from.squaredNorm() + radius * radius;
  if (rest < 0) return false;
  for (const float at : {-half - std::sqrt(rest), -half + std::sqrt(rest)}) {
    if (!(at > 0 && at < farthest)) continue;
    hit.distance = at;
    hit.normal = (from + at * direction) / radius;
    return true;
  }
  return false;
}

std::shared_ptr<RayShape> ball(float albedo, std::function<Vector3f(double)> centre = nullptr) {
  auto shape = std::make_shared<RayShape>();
  shape->name = "ball";
  shape->pose = [=](double time, double shutter) {
    const auto at = [=](double t) { return centre ? centre(t) : Vector3f(0, 0, 0); };
    const Vector3f first = at(time - shutter / 2), last = at(time + shutter / 2);
    PosedRayShape posed;
    for (const Vector3f& end : {first, last}) {
      posed.bounds.extend(end - Vector3f::Ones());
      posed.bounds.extend(end + Vector3f::Ones());
    }
    posed.hit = [=](const Vector3f& origin, const Vector3f& direction, float open, float farthest,
                    std::uint32_t, RayShapeHit& hit) {
      hit.reflected = Vector3f::Constant(albedo);
      return meets_sphere(first + open * (last - first), 1, origin, direction, farthest, hit);
    };
    return std::vector<PosedRayShape>{posed};
  };
  return shape;
}

// A level board at z = 0 of 2 m x 2 m, of which a ray meets a share alone, by chance.
std::shared_ptr<RayShape> veil(float share, int layers = 1) {
  auto shape = std::make_shared<RayShape>();
  shape->name = "veil";
  shape->pose = [=](double, double) {
    std::vector<PosedRayShape> all;
    for (int i = 0; i < layers; ++i) {
      PosedRayShape posed;
      const float height = 0.1F * static_cast<float>(i);
      posed.bounds.extend(Vector3f(-1, -1, height - 1e-3F));
      posed.bounds.extend(Vector3f(1, 1, height + 1e-3F));
      posed.hit = [=](const Vector3f& origin, const Vector3f& direction, float, float farthest,
                      std::uint32_t random, RayShapeHit& hit) {
        hit.distance = (height - origin.z()) / direction.z();
        const Vector3f at = origin + hit.distance * direction;
        return hit.distance > 0 && hit.distance < farthest && at.head<2>().cwiseAbs().maxCoeff() <= 1 &&
               hash_to_unit(random) < share;
      };
      all.push_back(posed);
    }
    return all;
  };
  return shape;
}

TraceScene scene_of(std::vector<std::shared_ptr<const RayShape>> shapes) {
  TraceScene scene = in_uniform_sky({});
  scene.ray_shapes = std::move(shapes);
  return scene;
}

TEST(RayShape, ASphereLooksAsItsFineMeshDoesInSunAndSky) {
  TraceScene scene;
  scene.ground.grass_height = 0;
  const auto lift = [](double) { return Vector3f(0, 0, 1.5F); };
  TraceScene meshed = scene;
  meshed.loops = {loop_of(sphere("timber", 0.5F, 1, 200), lift)};
  scene.ray_shapes = {ball(0.5F, lift)};
  const Camera camera = look({-6, 3, 2}, {0, 0, 1}, 0.4);
  const TraceOptions options{.width = 48, .height = 48, .samples = 64};
  const TracedImage shape = picture(scene, camera, options), mesh = picture(meshed, camera, options);
  EXPECT_LT(difference(shape.albedo, mesh.albedo), 1e-3);
  EXPECT_LT(difference(shape.normal, mesh.normal), 4e-3);
  EXPECT_LT((mean_of(shape.light) - mean_of(mesh.light)).norm(), 0.005 * mean_of(mesh.light).norm());
  EXPECT_LT(difference(shape.light, mesh.light), 0.02 * mean_of(mesh.light).mean());
}

TEST(RayShape, OfAlbedoOneIsInvisibleInAUniformSky) {
  const TracedImage seen = picture(scene_of({ball(1)}), look({-5, 0, 0}, Vec3::Zero(), 0.4),
                                   {.width = 16, .height = 16, .samples = 64, .bounces = 64});
  EXPECT_NEAR(mean_of(seen.light).mean(), 1, 0.01);
}

TEST(RayShape, ThatMovesIsBlurredAsItsMeshIs) {
  const auto across = [](double t) { return Vector3f(0, static_cast<float>(t), 0); };
  TraceScene meshed = in_uniform_sky({loop_of(sphere("timber", 0, 1, 100), across)});
  const Camera camera = look({-5, 0, 0}, Vec3::Zero(), 0.4);
  const TraceOptions options{.width = 24, .height = 24, .samples = 256, .shutter = 0.5};
  const TracedImage shape = picture(scene_of({ball(0, across)}), camera, options),
                    mesh = picture(meshed, camera, options);
  EXPECT_LT(difference(shape.light, mesh.light), 0.003);
  const TracedImage still = picture(scene_of({ball(0)}), camera, options);
  EXPECT_GT(difference(shape.light, still.light), 0.02) << "nothing was blurred";
}

TEST(RayShape, HidesWhatIsBehindItAndIsHiddenByWhatIsBefore) {
  Surface board = surface_of("timber", 0.9F, true);
  add_quad(board, {0, -3, -3}, {0, 6, 0}, {0, 0, 6});
  for (const float at : {-2.0F, 2.0F}) {
    TraceScene scene = in_uniform_sky({loop_of(board)});
    scene.ray_shapes = {ball(0, [at](double) { return Vector3f(at, 0, 0); })};
    const TracedImage seen = picture(scene, look({-8, 0, 0}, Vec3::Zero(), 0.2),
                                     {.width = 9, .height = 9, .samples = 4, .bounces = 1});
    EXPECT_NEAR(seen.albedo.pixel(4, 4)[0], at < 0 ? 0 : 0.9, 1e-3);
  }
}

TEST(RayShape, HalfTransparentLetsHalfOfTheLightThroughToTheEye) {
  const TracedImage seen = picture(scene_of({veil(0.5F)}), look({0, 0, 5}, Vec3::Zero(), 0.15),
                                   {.width = 32, .height = 32, .samples = 64});
  const double standard_error = 0.5 / std::sqrt(32 * 32 * 64.0);
  EXPECT_NEAR(mean_of(seen.light).mean(), 0.5, 3 * standard_error);
}

TEST(RayShape, TwoHalfTransparentOnesOnOneRayLetAQuarterThrough) {
  const TracedImage seen = picture(scene_of({veil(0.5F, 2)}), look({0, 0, 5}, Vec3::Zero(), 0.15),
                                   {.width = 32, .height = 32, .samples = 64});
  const double standard_error = std::sqrt(0.25 * 0.75 / (32 * 32 * 64.0));
  EXPECT_NEAR(mean_of(seen.light).mean(), 0.25, 3 * standard_error);
}

// Straight below the sun, a veil that is black leaves a ground in its shadow half of what the sun gives.
TEST(RayShape, HalfTransparentLetsHalfOfTheSunThroughToTheGround) {
  TraceScene scene;
  scene.daylight.sun_elevation = 1.4;
  scene.ground = {.kind = GroundKind::plain};
  const auto lit = [&](std::vector<std::shared_ptr<const RayShape>> shapes) {
    scene.ray_shapes = std::move(shapes);
    const double height = 0.3;
    scene.ground.height = -height;
    const Vec3 below(-height / std::tan(1.4), 0, -height);
    return mean_of(picture(scene, look(below + Vec3(0, -0.2, 0.15), below, 0.05),
                           {.width = 24, .height = 24, .samples = 256, .bounces = 1})
                       .light);
  };
  const Eigen::Vector3d open = lit({}), half = lit({veil(0.5F)}), closed = lit({veil(1)});
  EXPECT_LT(closed[0], 0.35 * open[0]) << "not in the shadow";
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(half[i], 0.5 * (open[i] + closed[i]), 0.01 * open[i]);
}

TEST(RayShape, GivesTheSameBytesOnAnyNumberOfThreads) {
  std::vector<LinearImage> seen;
  for (const std::size_t threads : {1U, 2U, 5U}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    seen.push_back(picture(scene_of({veil(0.5F, 3)}), look({0, -3, 5}, Vec3::Zero(), 0.25),
                           {.width = 40, .height = 40, .samples = 4})
                       .light);
  }
  EXPECT_EQ(seen[0].rgb, seen[1].rgb);
  EXPECT_EQ(seen[0].rgb, seen[2].rgb);
}

TEST(RayShape, ThatIsNoneIsRefused) {
  EXPECT_THROW(Tracer(scene_of({nullptr})), InputError);
  EXPECT_THROW(Tracer(scene_of({std::make_shared<RayShape>()})), InputError);
  const auto picture_of = [](const PosedRayShape& posed) {
    auto shape = std::make_shared<RayShape>();
    shape->pose = [posed](double, double) { return std::vector{posed}; };
    return picture(scene_of({shape}), look({-5, 0, 0}, Vec3::Zero()),
                   {.width = 4, .height = 4, .samples = 1});
  };
  PosedRayShape posed = ball(1)->pose(0, 0)[0];
  EXPECT_NO_THROW(picture_of(posed));
  posed.bounds.max().x() = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(picture_of(posed), Error);
  EXPECT_THROW(picture_of({}), InputError);
}

}  // namespace
}  // namespace tremula
