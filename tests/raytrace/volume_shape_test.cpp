#include "tremula/raytrace/volume_shape.hpp"

#include "raytrace/simple_scenes.hpp"

#include "tremula/base/error.hpp"
#include "tremula/base/noise.hpp"
#include "tremula/raytrace/scattering.hpp"

#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <tbb/global_control.h>

namespace tremula {
namespace {

using namespace simple;
using Eigen::Vector2d;
using Eigen::Vector2f;
using Eigen::Vector3f;

// The same everywhere: so much area [1/m] along an axis, to a height [m].
std::shared_ptr<VolumeField> slab(float density, const Vector3f& axis, float albedo, double height = 0.5,
                                  float spread = 0) {
  TexelValue value{.density = density, .axis = axis, .spread = spread, .color = Vector3f::Constant(albedo)};
  Texels texels{.count = {4, 4, 10},
                .cell = Vector3f::Constant(static_cast<float>(height) / 10),
                .repeats = true,
                .density_step = density / 60000,
                .values = {}};
  texels.values.assign(160, texel_of(value, texels.density_step));
  auto field = std::make_shared<VolumeField>();
  field->patches = {{texels}};
  field->height = height;
  return field;
}

// The share of rays that pass, and of how many.
double passed(const RayShape& shape, const Vector3f& origin, const Vector3f& direction, int rays) {
  const std::vector<PosedRayShape> posed = shape.pose(0, 0);
  int through = 0;
  for (int i = 0; i < rays; ++i) {
    RayShapeHit hit;
    const auto random = hash(static_cast<std::uint32_t>(i) + 77U);
    if (!posed.at(0).hit(origin, direction, 0.5F, 1e9F, random, hit)) ++through;
  }
  return static_cast<double>(through) / rays;
}

TEST(VolumeShape, OfAUniformSlabPassesTheExponentialOfItsDepth) {
  const Vector3f axis = Vector3f(0.2F, 0.5F, 1).normalized();
  const std::shared_ptr<VolumeField> field = slab(3, axis, 0.5F);
  const RayShape shape = volume_shape(field, {}, "slab");
  const TexelValue value = value_of(field->patches[0][0], 0, 0, 0);
  constexpr int rays = 40000;
  for (const Vector3f& way :
       {Vector3f(0, 0, -1), Vector3f(0.7F, 0.1F, -0.5F), Vector3f(-0.2F, 0.9F, -0.3F)}) {
    const Vector3f direction = way.normalized();
    const double depth = 3.0 * static_cast<double>(value.axis.cross(direction).norm()) * 0.5 /
                         static_cast<double>(-direction.z());
    const double wanted = std::exp(-depth);
    const double error = std::sqrt(wanted * (1 - wanted) / rays);
    EXPECT_NEAR(passed(shape, Vector3f(0.1F, 0.2F, 3), direction, rays), wanted, 3 * error + 1e-4);
  }
}

TEST(VolumeShape, BentPassesWhatTheBentSlabDoes) {
  // Upright strands that all bend alike: straight down a ray meets a' |sin theta| = a tan theta at each
  // height, and the heights are shorter by the cosine: the depth is a h times the integral of sin theta over
  // s, the way of the top.
  std::shared_ptr<VolumeField> field = slab(6, Vector3f::UnitZ(), 0.5F);
  field->sway = [](const Vector2d&, double) { return Vector2d(0.15, 0.1); };
  field->most_sway = 1;
  const RayShape shape = volume_shape(field, {}, "slab");
  const double tip = tip_angle(std::hypot(0.15, 0.1) / 0.5), depth = 6 * 0.5 * station_at(tip, 1).along;
  constexpr int rays = 40000;
  const double wanted = std::exp(-depth), error = std::sqrt(wanted * (1 - wanted) / rays);
  EXPECT_NEAR(passed(shape, Vector3f(0, 0, 2), -Vector3f::UnitZ(), rays), wanted, 3 * error + 0.01 * wanted);
}

TEST(VisibleNormal, OfParallelStrandsIsDrawnAboutTheirAxisByItsCosine) {
  TexelValue value{
      .density = 1, .axis = Vector3f(1, 2, -1).normalized(), .spread = 0, .color = Vector3f::Zero()};
  const Vector3f direction = Vector3f(0.3F, -0.4F, -0.9F).normalized();
  const Vector3f facing = (value.axis * value.axis.dot(direction) - direction).normalized();
  double sum = 0, squares = 0;
  constexpr int side = 100;
  for (int i = 0; i < side * side; ++i) {
    const Vector2f random((static_cast<float>(i % side) + 0.5F) / side,
                          (static_cast<float>(i / side) + 0.5F) / side);
    const Vector3f normal = visible_normal(value, direction, random);
    EXPECT_NEAR(normal.norm(), 1, 1e-4F);
    EXPECT_NEAR(normal.dot(value.axis), 0, 2e-3F);
    EXPECT_LT(normal.dot(direction), 1e-4F);
    const auto cosine = static_cast<double>(normal.dot(facing));
    sum += cosine;
    squares += cosine * cosine;
  }
  // With the density cos/2: the mean of the cosine is pi/4 and that of its square 2/3.
  EXPECT_NEAR(sum / (side * side), std::numbers::pi / 4, 2e-3);
  EXPECT_NEAR(squares / (side * side), 2.0 / 3, 2e-3);
}

// Kajiya and Kay: light from l leaves a strand along t for the eye by (t.l t.e + sin(t, l) sin(t, e))^p,
// which is 1 where both make the same angle with t.
TEST(VisibleNormal, OfParallelStrandsMirrorsLightOntoTheConeOfKajiyaAndKay) {
  const Vector3f axis = Vector3f(1, 2, -1).normalized();
  const TexelValue value{.density = 1, .axis = axis, .spread = 0, .color = Vector3f::Zero()};
  const Vector3f direction = Vector3f(0.3F, -0.4F, -0.9F).normalized(), to_eye = -direction;
  const auto across = [&](const Vector3f& way) { return Vector3f(way - axis * axis.dot(way)).normalized(); };
  double around = 0;
  constexpr int side = 100;
  for (int i = 0; i < side * side; ++i) {
    const Vector2f random((static_cast<float>(i % side) + 0.5F) / side,
                          (static_cast<float>(i / side) + 0.5F) / side);
    const Vector3f normal = visible_normal(value, direction, random);
    const Vector3f to_light = 2 * to_eye.dot(normal) * normal - to_eye;
    const float sines = axis.cross(to_light).norm() * axis.cross(to_eye).norm();
    EXPECT_NEAR(axis.dot(to_light) * axis.dot(direction) + sines, 1, 2e-3F);
    around += static_cast<double>(across(to_light).dot(across(to_eye)));
  }
  // About the strand by cos(phi/2)/4, whose mean cosine is 1/3.
  EXPECT_NEAR(around / (side * side), 1.0 / 3, 2e-3);
}

TEST(VolumeShape, WithACoatGivesBackSchlicksShareOfItOverARoundStrand) {
  const std::shared_ptr<VolumeField> field = slab(6, Vector3f::UnitX(), 0);
  const RayShape shape = volume_shape(field, {.translucent = 0, .roughness = 0.1F}, "slab");
  const std::vector<PosedRayShape> posed = shape.pose(0, 0);
  const Vector3f down = -Vector3f::UnitZ();
  double sum = 0, wanted = 0;
  int hits = 0;
  for (std::uint32_t i = 0; i < 40000; ++i) {
    RayShapeHit hit;
    if (!posed[0].hit(Vector3f(0.1F, 0.2F, 3), down, 0.5F, 1e9F, hash(i + 5U), hit)) continue;
    ASSERT_NE(hit.gloss, nullptr);
    sum += static_cast<double>(hit.gloss->share(-hit.normal.dot(down)));
    ++hits;
  }
  // A smooth coat of the refractive index 1.5 at normals that are seen by their cosine.
  constexpr int steps = 2000;
  for (int i = 0; i < steps; ++i) {
    const double cosine = std::cos(std::numbers::pi * ((i + 0.5) / steps - 0.5));
    wanted += (0.04 + 0.96 * std::pow(1 - cosine, 5)) * cosine / 2 * std::numbers::pi / steps;
  }
  EXPECT_NEAR(sum / hits, wanted, 0.03 * wanted);
}

TEST(VolumeShape, RefusesARoughnessThatIsNone) {
  EXPECT_THROW(volume_shape(slab(1, Vector3f::UnitZ(), 0), {.roughness = 1.5F}, "slab"), InputError);
}

TraceScene in_white_sky(std::shared_ptr<VolumeField> field, const VolumeLook& look = {}) {
  TraceScene scene = in_uniform_sky({});
  scene.ray_shapes.push_back(std::make_shared<const RayShape>(volume_shape(std::move(field), look, "slab")));
  return scene;
}

TEST(VolumeShape, ThatSwallowsNothingIsInvisibleInAUniformSky) {
  for (const auto& [spread, roughness] :
       {std::pair<float, std::optional<float>>{0.0F, {}}, {0.6F, {}}, {0.0F, 0.3F}, {0.6F, 0.5F}}) {
    std::shared_ptr<VolumeField> field = slab(4, Vector3f(0.3F, 0.1F, 1).normalized(), 1, 0.5, spread);
    field->low = {-1, -1};
    field->high = {1, 1};
    field->sway = [](const Vector2d& place, double) { return Vector2d(0.1 * std::sin(5 * place.x()), 0.1); };
    field->most_sway = 0.3;
    const TraceScene scene = in_white_sky(field, {.translucent = 0, .roughness = roughness});
    const LinearImage light = picture(scene, look({0, -4, 1}, {0, 0, 0.2}),
                                      {.width = 24, .height = 24, .samples = 64, .bounces = 64})
                                  .light;
    EXPECT_NEAR(mean_of(light).y(), 1, 0.02);
  }
}

// Black strands along x with a coat, seen straight down: Kajiya and Kay's highlight is where the light makes
// the same angle with them, a right one.
TEST(VolumeShape, WithACoatIsBrightWhereTheSunMakesTheAngleWithItsStrandsThatTheEyeMakes) {
  const std::shared_ptr<VolumeField> field = slab(8, Vector3f::UnitX(), 0);
  TraceScene scene = in_white_sky(field, {.translucent = 0, .roughness = 0.4F});
  scene.uniform_sky.reset();
  scene.daylight.sun_elevation = std::numbers::pi / 4;
  const auto seen_in_sun_from = [&](double azimuth) {
    scene.daylight.sun_azimuth = azimuth;
    return mean_of(
               picture(scene, look({0, 0, 3}, {0, 0.001, 0}, 0.1), {.width = 8, .height = 8, .samples = 256})
                   .light)
        .y();
  };
  const double across = seen_in_sun_from(std::numbers::pi / 2), along = seen_in_sun_from(0);
  EXPECT_GT(across, 3 * along);
}

TEST(VolumeShape, ShadesTheGroundBelowItByTheMeanOfWhatItPasses) {
  // Black upright strands over all the sky: of what comes from the cosine mu exp(-a h sqrt(1 - mu^2)/mu) is
  // left.
  std::shared_ptr<VolumeField> field = slab(3, Vector3f::UnitZ(), 0);
  field->low = {-40, -40};
  field->high = {40, 40};
  field->ground = 1;
  TraceScene scene = in_white_sky(field);
  scene.ground.kind = GroundKind::plain;
  scene.ground.color = Vector3f::Constant(0.5F);
  const LinearImage light =
      picture(scene, look({0, 0, 0.5}, {0, 0.01, 0}), {.width = 16, .height = 16, .samples = 256}).light;
  double left = 0;
  constexpr int steps = 4000;
  for (int i = 0; i < steps; ++i) {
    const double mu = (i + 0.5) / steps;
    left += 2 * mu * std::exp(-3 * 0.5 * std::sqrt(1 - mu * mu) / mu) / steps;
  }
  EXPECT_NEAR(mean_of(light).y(), 0.5 * left, 0.02 * left);
}

TEST(VolumeShape, IsTheSameOnAnyNumberOfThreadsAndWhateverIsFarther) {
  std::shared_ptr<VolumeField> field = slab(4, Vector3f(0.3F, 0.1F, 1).normalized(), 0.5F);
  field->sway = [](const Vector2d& place, double time) {
    return Vector2d(0.1 * std::sin(place.x() + time), 0.05);
  };
  field->most_sway = 0.2;
  const TraceScene scene = in_white_sky(field);
  const TraceOptions options{.width = 16, .height = 12, .samples = 4, .shutter = 0.1};
  const LinearImage many = picture(scene, look({0, -4, 1}, {0, 0, 0.2}), options, 1.5).light;
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(many.rgb, picture(scene, look({0, -4, 1}, {0, 0, 0.2}), options, 1.5).light.rgb);
  const std::vector<PosedRayShape> posed = scene.ray_shapes.front()->pose(0, 0);
  const Vector3f origin(0, -3, 0.4F), direction = Vector3f(0, 1, -0.02F);
  for (std::uint32_t random = 0; random < 50; ++random) {
    RayShapeHit far, near;
    if (!posed[0].hit(origin, direction, 0, 1e9F, random, far)) continue;
    EXPECT_TRUE(posed[0].hit(origin, direction, 0, far.distance * 1.001F, random, near));
    EXPECT_EQ(near.distance, far.distance);
    EXPECT_FALSE(posed[0].hit(origin, direction, 0, far.distance * 0.999F, random, near));
  }
}

}  // namespace
}  // namespace tremula
