#include "tremula/raytrace/ground_look.hpp"

#include "tremula/base/noise.hpp"

#include <algorithm>
#include <cmath>

namespace tremula {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

// Layers of noise about 0, each of so many cells a metre, that fade before they are finer than a pixel.
struct Layers {
  Vector2f place;
  float footprint;

  float operator()(float per_metre, std::uint32_t seed) const {
    const float fade = std::clamp(1.5F - per_metre * footprint, 0.0F, 1.0F);
    if (fade <= 0) return 0;
    const Vector2f at = (per_metre * place).cwiseMax(-1e9F).cwiseMin(1e9F);  // noise counts in int
    return fade * (noise(at.x(), at.y(), 0, seed) - 0.5F);
  }
};

// The normal of heights [m] that `height(place)` gives.
template <class Height>
Vector3f tilted(const Vector2f& place, float footprint, const Height& height) {
  const float step = std::max(0.003F, 0.5F * footprint);
  const float here = height(place);
  const float east = height(place + Vector2f(step, 0)), north = height(place + Vector2f(0, step));
  return Vector3f(here - east, here - north, step).normalized();
}

// Short grass: meadow with drier patches, tufts, blades.
PatternSpot grass(const Rgb& mean, const Vector2f& place, float footprint) {
  const Layers layer{place, footprint};
  const float dry = 0.7F * layer(0.05F, 11) + 0.6F * layer(0.29F, 12) + 0.5F * layer(1.7F, 13);
  const float tufts = 0.5F * layer(0.9F, 14) + 0.8F * layer(6, 15) + 0.9F * layer(17, 16);
  const float blades = layer(70, 17) + 0.9F * layer(210, 18);
  const Rgb albedo = mean.cwiseProduct(Rgb(1 + 0.6F * dry, 1 + 0.2F * dry, 1 + 0.35F * dry)) *
                     std::max(0.15F, 1 + 0.45F * tufts + 0.6F * blades);
  constexpr float flat = 0.3F;
  if (footprint > flat) return {albedo, Vector3f::UnitZ()};
  const auto height = [&](const Vector2f& at) {
    const Layers rise{at, footprint};
    return 0.035F * rise(6, 15) + 0.018F * rise(17, 16);
  };
  return {albedo, tilted(place, footprint, height)};
}

PatternSpot soil(const Rgb& mean, const Vector2f& place, float footprint) {
  const Layers layer{place, footprint};
  const float patches = 0.9F * layer(0.2F, 21) + 0.7F * layer(1.1F, 22);
  const float crumbs = 0.6F * layer(9, 23) + 0.7F * layer(37, 24) + 0.6F * layer(120, 25);
  const auto height = [&](const Vector2f& at) {
    const Layers rise{at, footprint};
    return 0.05F * rise(1.1F, 22) + 0.03F * rise(9, 23) + 0.014F * rise(37, 24) + 0.004F * rise(120, 25);
  };
  return {mean * std::max(0.2F, 1 + 0.4F * patches + 0.5F * crumbs), tilted(place, footprint, height)};
}

// Ripples that run across x and wander.
PatternSpot sand(const Rgb& mean, const Vector2f& place, float footprint) {
  const Layers layer{place, footprint};
  const float patches = 0.5F * layer(0.15F, 31) + 0.4F * layer(0.8F, 32);
  const float grains = 0.35F * layer(60, 33) + 0.5F * layer(300, 34);
  const auto height = [&](const Vector2f& at) {
    constexpr float per_metre = 7;  // [1/m]
    const float fade = std::clamp(1.5F - 2 * per_metre * footprint, 0.0F, 1.0F);
    const Layers rise{at, footprint};
    const float wander = 2.2F * rise(0.7F, 35) + 0.5F * rise(2.3F, 36);
    const float phase = 6.2831853F * (per_metre * at.x() + wander);
    return fade * 0.010F * std::sin(phase) + 0.05F * rise(0.5F, 37) + 0.0007F * rise(300, 34);
  };
  return {mean * std::max(0.2F, 1 + 0.3F * patches + 0.3F * grains), tilted(place, footprint, height)};
}

PatternSpot snow(const Rgb& mean, const Vector2f& place, float footprint) {
  const Layers layer{place, footprint};
  const auto height = [&](const Vector2f& at) {
    const Layers rise{at, footprint};
    return 0.25F * rise(0.35F, 41) + 0.05F * rise(1.5F, 42) + 0.006F * rise(11, 43) + 0.0008F * rise(140, 44);
  };
  return {mean * (1 + 0.04F * layer(3, 45) + 0.05F * layer(140, 44)), tilted(place, footprint, height)};
}

}  // namespace

Rgb ground_color_of(const GroundLook& ground) {
  switch (ground.kind) {
    case GroundKind::grass:
      return {0.090F, 0.122F, 0.038F};
    case GroundKind::soil:
      return {0.15F, 0.105F, 0.07F};
    case GroundKind::sand:
      return {0.40F, 0.34F, 0.22F};
    case GroundKind::snow:
      return {0.80F, 0.82F, 0.85F};
    case GroundKind::plain:
      return ground.color;
    case GroundKind::none:
      break;
  }
  return Rgb::Zero();
}

namespace {

PatternSpot untinted(const GroundLook& ground, const Vector2f& place, float footprint) {
  const Rgb mean = ground_color_of(ground);
  constexpr float plain = 100;
  if (footprint > plain) return {mean, Vector3f::UnitZ()};
  switch (ground.kind) {
    case GroundKind::grass:
      return grass(mean, place, footprint);
    case GroundKind::soil:
      return soil(mean, place, footprint);
    case GroundKind::sand:
      return sand(mean, place, footprint);
    case GroundKind::snow:
      return snow(mean, place, footprint);
    case GroundKind::plain:
    case GroundKind::none:
      break;
  }
  return {mean, Vector3f::UnitZ()};
}

}  // namespace

PatternSpot ground_pattern(const GroundLook& ground, const Vector2f& place, float footprint) {
  PatternSpot spot = untinted(ground, place, footprint);
  if (!ground.tint) return spot;
  const Eigen::Vector4f tint = ground.tint(place, ground.time);
  spot.albedo += tint.w() * (tint.head<3>() - spot.albedo);
  return spot;
}

}  // namespace tremula
