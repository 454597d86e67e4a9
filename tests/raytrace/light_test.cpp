// Light against what is known of it in closed form.
#include "raytrace/simple_scenes.hpp"

#include <gtest/gtest.h>

namespace tremula {
namespace {

using namespace simple;
using Eigen::Vector3f;

constexpr double pi = std::numbers::pi;

TEST(WhiteFurnace, HidesAClosedThingThatSwallowsNothing) {
  for (const char* name : {"timber", "panel"}) {  // dull; with gloss
    const TraceScene scene = in_uniform_sky({loop_of(sphere(name, 1, 1))});
    const TracedImage seen = picture(scene, look({4, 0, 1}, Vec3::Zero(), 0.3),
                                     {.width = 24, .height = 24, .samples = 64, .bounces = 64});
    EXPECT_LT((mean_of(seen.light) - Eigen::Vector3d::Ones()).norm(), 0.01) << name;
    for (const float light : seen.light.rgb) EXPECT_NEAR(light, 1, 0.03) << name;
  }
}

TEST(WhiteFurnace, HidesACloudOfLeavesThatReflectOrTransmitAllLight) {
  const TraceScene scene = in_uniform_sky({loop_of(cloud("cloth", 1, 400))});
  const TracedImage seen = picture(scene, look({4, 0, 1}, Vec3::Zero(), 0.3),
                                   {.width = 24, .height = 24, .samples = 64, .bounces = 64});
  EXPECT_LT((mean_of(seen.light) - Eigen::Vector3d::Ones()).cwiseAbs().maxCoeff(), 0.01);
  const TracedImage grey =
      picture(in_uniform_sky({loop_of(cloud("cloth", 0.5F, 400))}), look({4, 0, 1}, Vec3::Zero(), 0.3),
              {.width = 24, .height = 24, .samples = 16});
  EXPECT_LT(mean_of(grey.light)[0], 0.95) << "the cloud was not there at all";
}

TEST(Ground, UnderAUniformSkySendsUpAlbedoTimesItsRadiance) {
  TraceScene scene = in_uniform_sky({}, 3);
  scene.ground = {.kind = GroundKind::plain, .color = {0.8F, 0.4F, 0.1F}};
  const TracedImage seen =
      picture(scene, look({0, 0, 2}, {0, 0, 0}), {.width = 8, .height = 8, .samples = 16});
  EXPECT_LT((mean_of(seen.light) - Eigen::Vector3d(2.4, 1.2, 0.3)).norm(), 1e-4);
}

TEST(Ground, UnderSunAndSkySendsUpAlbedoTimesIrradianceOverPi) {
  TraceScene scene;
  scene.ground = {.kind = GroundKind::plain, .color = {0.5F, 0.5F, 0.5F}};
  scene.daylight.sun_elevation = 0.6;
  const Daylight light(scene.daylight);
  const TracedImage seen =
      picture(scene, look({0, 0, 2}, {0, 0, 0}), {.width = 16, .height = 16, .samples = 256});
  const Eigen::Vector3d wanted = (0.5 / pi * light.level_irradiance().cast<double>());
  EXPECT_LT((mean_of(seen.light) - wanted).norm(), 0.01 * wanted.norm());
}

TEST(Ground, BelowADarkDiscLosesTheDiscsFormFactor) {
  const double radius = 0.5, height = 1;
  Surface disc = surface_of("timber", 0, false);
  constexpr int sides = 96;
  const std::uint32_t middle = add_vertex(disc, {0, 0, static_cast<float>(height)}, -Vector3f::UnitZ());
  for (int i = 0; i < sides; ++i) {
    const double angle = 2 * pi * i / sides;
    add_vertex(disc, Vec3(radius * std::cos(angle), radius * std::sin(angle), height).cast<float>(),
               -Vector3f::UnitZ());
  }
  for (std::uint32_t i = 0; i < sides; ++i) add_triangle(disc, middle, 1 + (i + 1) % sides, 1 + i);
  TraceScene scene = in_uniform_sky({loop_of(disc)});
  scene.ground = {.kind = GroundKind::plain, .color = {1, 1, 1}};
  const TracedImage seen =
      picture(scene, look({3, 0, 0.5}, Vec3::Zero(), 0.003), {.width = 8, .height = 8, .samples = 1024});
  const double hidden = radius * radius / (radius * radius + height * height);
  EXPECT_NEAR(mean_of(seen.light)[1], 1 - hidden, 0.004);
}

// A wall's shadow, of which the edge is a strip as wide as the sun is from there.
TEST(Sun, CastsShadowsWithHalfOfItsLightOnTheirEdge) {
  TraceScene scene;
  scene.ground = {.kind = GroundKind::plain, .color = {0.5F, 0.5F, 0.5F}};
  scene.daylight.sun_elevation = pi / 4;
  scene.daylight.sun_azimuth = 0;
  Surface wall = surface_of("timber", 0, false);
  const float height = 2;
  add_quad(wall, {0, -50, 0}, {0, 100, 0}, {0, 0, height});
  scene.loops = {loop_of(wall)};
  const auto light_at = [&](double x) {
    const TracedImage seen = picture(scene, look({x - 0.5, 0, 3}, {x, 0, 0}, 1e-4),
                                     {.width = 8, .height = 8, .samples = 512, .bounces = 1});
    return mean_of(seen.light)[1];
  };
  const double sun = std::acos(static_cast<double>(Daylight(scene.daylight).sun_cosine()));
  const double half_width = height * std::numbers::sqrt2 * std::tan(sun) * std::numbers::sqrt2;
  const double umbra = light_at(-height + 1.5 * half_width), edge = light_at(-height),
               lit = light_at(-height - 1.5 * half_width);
  EXPECT_GT(lit, 3 * umbra);
  EXPECT_NEAR(edge, (lit + umbra) / 2, 0.02 * lit);
  EXPECT_NEAR(light_at(-height - 0.5 * half_width), umbra + (lit - umbra) * 0.804, 0.02 * lit)
      << "of a disc cut at half its radius, 1/2 + (asin 1/2 + 1/2 cos(asin 1/2)) / pi is seen";
}

TEST(Haze, HidesADarkThingAsFarAwayAsTheExtinctionSays) {
  Surface wall = surface_of("timber", 0, false);
  add_quad(wall, {100, -200, -200}, {0, 400, 0}, {0, 0, 400});
  TraceScene scene = in_uniform_sky({loop_of(wall)});
  scene.haze.extinction = {0.001F, 0.01F, 0.1F};
  const TracedImage seen =
      picture(scene, look(Vec3::Zero(), {1, 0, 0}, 0.01), {.width = 4, .height = 4, .samples = 4});
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(mean_of(seen.light)[i], 1 - std::exp(-100 * static_cast<double>(scene.haze.extinction[i])),
                1e-3);
  }
}

TEST(Water, TakesRedFirst) {
  Surface wall = surface_of("timber", 0.7F, false);
  add_quad(wall, {4, -20, -20}, {0, 40, 0}, {0, 0, 40});
  TraceScene scene;
  scene.loops = {loop_of(wall)};
  scene.under_water = true;
  scene.ground.kind = GroundKind::none;
  const auto seen_from = [&](double x) {
    return mean_of(
        picture(scene, look({x, 0, 0}, {4, 0, 0}), {.width = 8, .height = 8, .samples = 16}).light);
  };
  const Eigen::Vector3d near = seen_from(3), far = seen_from(-6);
  EXPECT_GT(near.minCoeff(), 0);
  EXPECT_LT(far[0] / far[2], 0.95 * near[0] / near[2]);
}

}  // namespace
}  // namespace tremula
