#include "tremula/render/patterns.hpp"

#include "tremula/base/noise.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tremula {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

constexpr float pi = std::numbers::pi_v<float>;

// Bark, by how high it stands out and how bright it is there, both around 0.
struct Bark {
  float height;
  float shade;
};

constexpr float bark_is_plain = 1.5F / 18;  // from this footprint on; lichen from three times as much

Bark bark_at(const Vector2f& uv, float footprint, float paleness) {
  if (footprint >= bark_is_plain) return {0, 0};
  const auto fade = [&](float frequency) { return std::clamp(1.5F - 2 * frequency * footprint, 0.0F, 1.0F); };
  const float warp = noise(uv.x() * 6, uv.y() * 4, 6, 1) - 0.5F;
  const auto furrows = [&](float around, float along, std::uint32_t seed) {
    const float n = noise(uv.x() * around + 1.5F * warp, uv.y() * along, static_cast<int>(around), seed);
    return smooth_step(0, 0.55F, std::abs(2 * n - 1)) - 0.6F;
  };
  const float rough = fade(12) * furrows(12, 3.2F, 2) + 0.45F * fade(26) * furrows(26, 9, 3);
  const float grain = fade(60) * (noise(uv.x() * 60, uv.y() * 30, 60, 4) - 0.5F);
  const float marks = fade(26) * smooth_step(0.66F, 0.8F, noise(uv.x() * 5, uv.y() * 26, 5, 5)) +
                      fade(9) * smooth_step(0.74F, 0.8F, noise(uv.x() * 3, uv.y() * 9, 3, 6));
  const float rugged = 1 - paleness;
  return {rugged * rough + 0.3F * grain, rugged * (0.42F * rough + 0.3F * grain) - 0.7F * paleness * marks};
}

// `twig`: 1 for the twigs of trees with pale bark, which are brown.
Rgb bark_albedo(const Rgb& bark, const Vector2f& uv, float footprint, float shade, float twig) {
  const float fade = std::clamp(1.5F - 6 * footprint, 0.0F, 1.0F);
  const float lichen = fade <= 0 ? 0 : fade * smooth_step(0.5F, 0.9F, noise(uv.x() * 3, uv.y() * 1.1F, 3, 7));
  const Rgb color = bark + 0.3F * lichen * (Rgb(0.20F, 0.22F, 0.15F) - bark);
  const Rgb brown = color.cwiseMin(Rgb(0.15F, 0.10F, 0.075F));
  return (color + twig * (brown - color)) * std::max(1 + shade, 0.2F);
}

}  // namespace

TextureFrame texture_frame(const Vector3f& ab, const Vector3f& ac, const Vector2f& uv_ab,
                           const Vector2f& uv_ac) {
  TextureFrame frame;
  frame.per_metre = (uv_ab.norm() + uv_ac.norm()) / std::max(ab.norm() + ac.norm(), 1e-9F);
  const float turn_uv = uv_ab.x() * uv_ac.y() - uv_ab.y() * uv_ac.x();
  if (std::abs(turn_uv) > 1e-12F) {
    frame.along_u = ((uv_ac.y() * ab - uv_ab.y() * ac) / turn_uv).normalized();
    frame.along_v = ((uv_ab.x() * ac - uv_ac.x() * ab) / turn_uv).normalized();
  }
  return frame;
}

PatternSpot bark_pattern(const Rgb& color, const Vector2f& uv, const Vector3f& normal,
                         const TextureFrame& frame, float footprint) {
  footprint = std::min(footprint, 100.0F);
  const float radius = 1 / (2 * pi * std::max(frame.per_metre, 1e-6F));
  const float stem = smooth_step(0.005F, 0.02F, radius);
  const float white = smooth_step(0.25F, 0.5F, color.mean()) *
                      smooth_step(0.5F, 0.7F, color.minCoeff() / std::max(color.maxCoeff(), 1e-6F));
  const float paleness = white * stem;
  const Bark bark = bark_at(uv, footprint, paleness);
  PatternSpot spot{bark_albedo(color, uv, footprint, bark.shade, white * (1 - stem)), normal};
  // The relief tilts the normal, by heights a step farther.
  if (footprint < bark_is_plain && frame.along_u.squaredNorm() > 0 && frame.along_v.squaredNorm() > 0) {
    constexpr float relief = 0.012F;  // [circumferences]
    const float step = std::max(0.004F, 0.5F * footprint);
    const float rise_u = bark_at(uv + Vector2f(step, 0), footprint, paleness).height - bark.height;
    const float rise_v = bark_at(uv + Vector2f(0, step), footprint, paleness).height - bark.height;
    const Vector3f tilted = normal - relief / step * (rise_u * frame.along_u + rise_v * frame.along_v);
    if (tilted.norm() > 1e-3F) spot.normal = tilted.normalized();
  }
  return spot;
}

Rgb leaf_pattern(const Rgb& color, const Vector2f& uv, std::uint32_t leaf, bool from_behind) {
  const float bright = 0.78F + 0.44F * hash_to_unit(2 * leaf);
  const float yellow = hash_to_unit(2 * leaf + 1) - 0.5F;
  Rgb albedo = color.cwiseProduct(Rgb(1 + 0.55F * yellow, 1 + 0.1F * yellow, 1 - 0.5F * yellow)) * bright;
  const float rib = std::max(0.0F, 1 - std::abs(uv.x() - 0.5F) * 14);
  albedo *= 1 + 0.35F * rib;
  if (from_behind) albedo = 0.8F * albedo + Rgb::Constant(0.25F * albedo.mean());
  return albedo;
}

Rgb light_through_leaf(const Rgb& albedo) { return albedo.cwiseProduct(Rgb(1.25F, 1.2F, 0.35F)) * 0.75F; }

// Water lit from above: bright towards the surface, dim below.
Rgb water_behind(const Vector3f& direction) {
  const float height = direction.z();
  const Rgb middle(0.10F, 0.33F, 0.42F), surface(0.50F, 0.78F, 0.82F), deep(0.04F, 0.15F, 0.21F);
  if (height >= 0) return middle + (surface - middle) * (1 - std::exp(-2.2F * height));
  return middle + (deep - middle) * (1 - std::exp(3.0F * height));
}

}  // namespace tremula
