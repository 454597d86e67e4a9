// What light comes from where in a picture: from the ground, from a point of the surface, from the sky.
#pragma once

#include "tremula/geometry/surface.hpp"
#include "tremula/render/sky.hpp"
#include "tremula/render/sun_view.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace tremula {

struct Stem {
  Eigen::Vector2f centre = Eigen::Vector2f::Zero();
  float radius = 0;
};

// Where the picture is taken from.
struct Eye {
  Eigen::Vector3f position, right, up, forward;
  float half_height, half_width;  // of the picture at distance 1
  float pixel;                    // its size at distance 1

  Eigen::Vector3f ray(float x, float y) const {  // x, y in the picture, 0 to 1
    return (forward + (2 * x - 1) * half_width * right + (1 - 2 * y) * half_height * up).normalized();
  }
};

// The disc that the plant stands on.
struct Ground {
  float height;  // [m]
  Eigen::Vector2f centre;
  float radius;  // [m]
  std::vector<Stem> stems;
  bool drawn;
};

struct Light {
  Eigen::Vector3f to_sun;
  float exposure;
  SunView sun;
  AmbientLight ambient;
  GroundLight on_ground;
};

// What is drawn: the parts of a surface, and their triangles one part after the other.
struct Drawn {
  const Surface& surface;
  std::span<const Eigen::Vector3f> positions, normals;
  std::vector<std::uint32_t> triangles;  // (3 per triangle)
  std::vector<std::size_t> part_ends;    // triangles up to the end of each part
  std::vector<Rgb> colors;               // of the parts, linear

  std::size_t part_of(std::uint32_t triangle) const;
};

struct PictureScene {
  Drawn drawn;
  Eye eye;
  Ground ground;
  Light light;
  bool under_water = false;
};

// Light and colours of a bright day with a little haze; radiances.
inline const Rgb sun_light = Rgb(1.0F, 0.90F, 0.74F) * 3.3F;
inline const Rgb sky_zenith = Rgb(0.40F, 0.52F, 0.74F) * 0.95F;
inline const Rgb sky_horizon = Rgb(0.86F, 0.90F, 0.94F) * 0.85F;
inline const Rgb ground_color(0.135F, 0.205F, 0.055F);
inline const Rgb sand_color(0.40F, 0.34F, 0.22F);

// What is seen in `direction` (unit) where no triangle is, and on a triangle that is; as the screen shows it,
// linear, 0 to 1 or a little above. `turn` in [0, 1) turns the pattern of the shadow's samples.
Rgb shade_ground(const PictureScene& scene, const Eigen::Vector3f& direction, float turn);
Rgb shade_triangle(const PictureScene& scene, std::uint32_t triangle, const Eigen::Vector3f& direction,
                   float turn);

// What is left of a colour seen in that direction through so much water; `scale`: as much as the picture is
// made for [m].
Rgb through_water(const Rgb& color, const Eigen::Vector3f& direction, float distance, float scale);

}  // namespace tremula
