// What is drawn into a surface beside its colour: the furrows of bark, the ribs of leaves; and the colour of
// water. Each scale of a pattern is faded out before it is finer than a pixel.
#pragma once

#include "tremula/render/sky.hpp"

#include <cstdint>

#include <Eigen/Core>

namespace tremula {

// How texture coordinates lie on a triangle with the edges `ab` and `ac`.
struct TextureFrame {
  float per_metre = 0;                                // how fast they grow, about
  Eigen::Vector3f along_u = Eigen::Vector3f::Zero();  // unit, where u and v grow; 0 where they do not
  Eigen::Vector3f along_v = Eigen::Vector3f::Zero();
};
TextureFrame texture_frame(const Eigen::Vector3f& ab, const Eigen::Vector3f& ac, const Eigen::Vector2f& uv_ab,
                           const Eigen::Vector2f& uv_ac);

struct PatternSpot {
  Rgb albedo;
  Eigen::Vector3f normal;  // unit, tilted by the relief
};

// Dark bark has furrows along the stem, pale bark short marks across it and brown twigs. `footprint`: the
// size of a pixel there [m] times per_metre.
PatternSpot bark_pattern(const Rgb& color, const Eigen::Vector2f& uv, const Eigen::Vector3f& normal,
                         const TextureFrame& frame, float footprint);

// Leaves: no two alike, with a pale rib, and paler below.
Rgb leaf_pattern(const Rgb& color, const Eigen::Vector2f& uv, std::uint32_t leaf, bool from_behind);

// What a leaf of this albedo lets through: light turns yellower.
Rgb light_through_leaf(const Rgb& albedo);

// Water lit from above, seen in `direction` (unit): bright towards the surface, dim below. 0 to 1.
Rgb water_behind(const Eigen::Vector3f& direction);

}  // namespace tremula
