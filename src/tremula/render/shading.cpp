#include "tremula/render/shading.hpp"

#include "tremula/base/noise.hpp"
#include "tremula/render/patterns.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include <Eigen/Geometry>

namespace tremula {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

constexpr float pi = std::numbers::pi_v<float>;

// Straight in the shadows, a soft shoulder in the lights; 1 is reached at `white`.
Rgb tone(const Rgb& light) {
  constexpr float white = 4;
  return light.unaryExpr([](float c) { return c * (1 + c / (white * white)) / (1 + 0.55F * c) * 1.15F; });
}

// The sky behind the plant, pale at the horizon; below, what the disc of ground fades into.
Rgb backdrop(const Vector3f& direction) {
  const float height = direction.z();
  const Rgb horizon(0.86F, 0.91F, 0.92F);
  const Rgb high(0.24F, 0.46F, 0.78F);
  const Rgb low(0.72F, 0.80F, 0.72F);
  if (height >= 0) return horizon + (high - horizon) * (1 - std::exp(-3.5F * height));
  return horizon + (low - horizon) * (1 - std::exp(8.0F * height));
}

// A spot of a triangle as a ray meets it.
struct Spot {
  std::size_t part;
  const std::uint32_t* corners;  // (3)
  Vector3f ab, ac;               // edges [m]
  Vector3f point, normal, direction;
  Vector2f uv;
  float distance;
  bool seen_from_behind;
  float sun;  // share of its disc that the spot sees
};

// Where the ray meets the plane, kept inside: the spot is the middle of several samples.
Spot find_spot(const PictureScene& scene, std::uint32_t triangle, const Vector3f& direction, float turn) {
  const Drawn& drawn = scene.drawn;
  Spot spot;
  spot.part = drawn.part_of(triangle);
  spot.direction = direction;
  const std::uint32_t* corner = spot.corners = &drawn.triangles[3 * std::size_t{triangle}];
  const Vector3f& a = drawn.positions[corner[0]];
  spot.ab = drawn.positions[corner[1]] - a;
  spot.ac = drawn.positions[corner[2]] - a;
  const Vector3f plane = spot.ab.cross(spot.ac);

  const Vector3f p = direction.cross(spot.ac);
  const float determinant = spot.ab.dot(p);
  float s = 1.0F / 3, t = 1.0F / 3;
  if (std::abs(determinant) > 1e-20F) {
    const Vector3f from = scene.eye.position - a;
    s = std::clamp(from.dot(p) / determinant, 0.0F, 1.0F);
    t = std::clamp(direction.dot(from.cross(spot.ab)) / determinant, 0.0F, 1.0F);
    if (s + t > 1) {
      const float sum = s + t;
      s /= sum;
      t /= sum;
    }
  }
  spot.point = a + s * spot.ab + t * spot.ac;
  const auto blend = [&](const auto& values) {
    return ((1 - s - t) * values[corner[0]] + s * values[corner[1]] + t * values[corner[2]]).eval();
  };
  spot.normal = blend(drawn.normals);
  const float length = spot.normal.norm();
  spot.normal = length > 1e-6F ? Vector3f(spot.normal / length) : Vector3f(plane.normalized());
  spot.uv = blend(drawn.surface.texture).cwiseMax(-1e6F).cwiseMin(1e6F);  // noise counts in int
  spot.distance = (spot.point - scene.eye.position).norm();
  spot.seen_from_behind = plane.dot(direction) > 0;
  if (spot.seen_from_behind && drawn.surface.parts[spot.part].material.two_sided) spot.normal = -spot.normal;
  const Vector3f sunny = spot.normal.dot(scene.light.to_sun) >= 0 ? spot.normal : Vector3f(-spot.normal);
  spot.sun = scene.light.sun.visible_share(spot.point, sunny, turn);
  return spot;
}

// What a dull surface of this colour sends to the eye.
Rgb shade_dull(const PictureScene& scene, const Spot& spot, const Vector3f& normal, const Rgb& albedo) {
  const Rgb sky = scene.light.ambient.irradiance(spot.point, normal);
  return tone(
      albedo.cwiseProduct(std::max(normal.dot(scene.light.to_sun), 0.0F) * spot.sun * sun_light + sky) / pi *
      scene.light.exposure);
}

Rgb shade_bark(const PictureScene& scene, const Spot& spot) {
  const Surface& surface = scene.drawn.surface;
  const Vector2f uv_ab = surface.texture[spot.corners[1]] - surface.texture[spot.corners[0]];
  const Vector2f uv_ac = surface.texture[spot.corners[2]] - surface.texture[spot.corners[0]];
  const TextureFrame frame = texture_frame(spot.ab, spot.ac, uv_ab, uv_ac);
  const float footprint = spot.distance * scene.eye.pixel * frame.per_metre;
  const PatternSpot bark =
      bark_pattern(scene.drawn.colors[spot.part], spot.uv, spot.normal, frame, footprint);
  return shade_dull(scene, spot, bark.normal, bark.albedo);
}

Rgb shade_leaf(const PictureScene& scene, const Spot& spot) {
  const Pieces& leaves = scene.drawn.surface.parts[spot.part].pieces;
  const std::uint32_t leaf = leaves.size > 0 ? (spot.corners[0] - leaves.first_vertex) / leaves.size : 0;
  const Rgb albedo = leaf_pattern(scene.drawn.colors[spot.part], spot.uv, leaf, spot.seen_from_behind);
  const Rgb through = light_through_leaf(albedo);

  const Vector3f& normal = spot.normal;
  const AmbientLight& ambient = scene.light.ambient;
  const float towards_sun = normal.dot(scene.light.to_sun);
  const Rgb lit = albedo * std::max(towards_sun, 0.0F) + through * std::max(-towards_sun, 0.0F);
  const Rgb sky = albedo.cwiseProduct(ambient.irradiance(spot.point, normal)) +
                  0.5F * through.cwiseProduct(ambient.irradiance(spot.point, -normal));
  const Vector3f half_way = (scene.light.to_sun - spot.direction).normalized();
  const float gloss = towards_sun > 0 ? 0.055F * std::pow(std::max(normal.dot(half_way), 0.0F), 18.0F) : 0;
  return tone(((lit.cwiseProduct(spot.sun * sun_light) + sky) / pi + gloss * spot.sun * sun_light) *
              scene.light.exposure);
}

}  // namespace

std::size_t Drawn::part_of(std::uint32_t triangle) const {
  return static_cast<std::size_t>(std::upper_bound(part_ends.begin(), part_ends.end(), triangle) -
                                  part_ends.begin());
}

Rgb shade_ground(const PictureScene& scene, const Vector3f& direction, float turn) {
  const Rgb behind = scene.under_water ? water_behind(direction) : backdrop(direction);
  const Vector3f& eye = scene.eye.position;
  if (!scene.ground.drawn || direction.z() > -1e-4F || eye.z() <= scene.ground.height) return behind;
  const float distance = (scene.ground.height - eye.z()) / direction.z();
  const Vector3f point = eye + distance * direction;
  const float from_centre = (point.head<2>() - scene.ground.centre).norm() / scene.ground.radius;
  const float presence = 1 / (1 + from_centre * from_centre * from_centre);
  if (presence <= 0.004F) return behind;

  // Short grass: patches and a grain at several scales, each faded out before it is finer than a pixel.
  const Vector2f place = point.head<2>() / scene.ground.radius;
  const float footprint = distance * scene.eye.pixel / scene.ground.radius / std::max(-direction.z(), 0.02F);
  const auto layer = [&](float frequency, std::uint32_t seed) {
    const float fade = std::clamp(1.5F - frequency * footprint, 0.0F, 1.0F);
    return fade * (noise(place.x() * frequency, place.y() * frequency, 0, seed) - 0.5F);
  };
  const float patches = layer(13, 11) + 0.6F * layer(41, 12);
  const float grain = layer(160, 13) + layer(460, 14) + 0.8F * layer(1300, 15);
  const Rgb albedo = (scene.under_water ? sand_color : ground_color)
                         .cwiseProduct(Rgb(1 + 0.3F * patches, 1 + 0.1F * patches, 1)) *
                     (1 + 0.2F * patches + 0.22F * grain);

  const float sun = scene.light.sun.visible_share(point, Vector3f::UnitZ(), turn) * scene.light.to_sun.z();
  float open = scene.light.on_ground.sky_share(point.x(), point.y());
  // The fog is too coarse for the foot of a stem. A tall cylinder hides this share of the sky in all
  // directions.
  for (const Stem& stem : scene.ground.stems) {
    const float away = std::max((point.head<2>() - stem.centre).norm(), stem.radius);
    open *= 1 - std::asin(stem.radius / std::max(away, 1e-6F)) / pi;
  }
  const Rgb sky = (0.4F * sky_zenith + 0.6F * sky_horizon) * pi * open;
  const Rgb light = albedo.cwiseProduct(sun * sun_light + sky) / pi * (0.75F * scene.light.exposure);
  return behind + presence * (tone(light) - behind);
}

Rgb through_water(const Rgb& color, const Vector3f& direction, float distance, float scale) {
  const float way = distance / scale;
  const Rgb dyed =
      color.cwiseProduct(Rgb(std::exp(-0.55F * way), std::exp(-0.10F * way), std::exp(-0.06F * way)));
  return water_behind(direction) + std::exp(-0.35F * way) * (dyed - water_behind(direction));
}

Rgb shade_triangle(const PictureScene& scene, std::uint32_t triangle, const Vector3f& direction, float turn) {
  const Spot spot = find_spot(scene, triangle, direction, turn);
  const std::string& name = scene.drawn.surface.parts[spot.part].material.name;
  if (name == "bark") return shade_bark(scene, spot);
  if (name == "leaf" || name == "ribbon") return shade_leaf(scene, spot);
  return shade_dull(scene, spot, spot.normal, scene.drawn.colors[spot.part]);
}

}  // namespace tremula
