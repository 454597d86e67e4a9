// Trees as an impressionist paints them: a trunk, and a crown of a few quadrics, whose colour and holes are a
// texture (Gardner, Simulation of natural scenes using textured quadric surfaces, SIGGRAPH 1984, and Visual
// simulation of clouds, SIGGRAPH 1985; F section 5.3). Nothing is known of their branches. For far forests.
#pragma once

#include "tremula/base/types.hpp"
#include "tremula/geometry/skeleton.hpp"

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

namespace tremula {

// ---- Quadrics

// All x with (x - centre)^T form (x - centre) <= level, between two heights: Gardner's quadrics bounded by
// planes.
struct Quadric {
  Vec3 centre = Vec3::Zero();               // [m]; of a cone its apex
  Mat3 form = Mat3::Identity();             // symmetric [1/m^2]
  double level = 1;                         // 0 of a cone
  double low = -infinite, high = infinite;  // heights [m]

  static constexpr double infinite = std::numeric_limits<double>::infinity();
};

Quadric ellipsoid(const Vec3& centre, const Vec3& semi_axes);  // along x, y and z [m]
// Upright, from its apex down to where it has that radius; up, where the height is below 0.
Quadric upright_cone(const Vec3& apex, double height, double radius);  // [m]
// Of a trunk that gets thinner upwards: from z = 0, on the axis.
Quadric tapered_column(double height, double base_radius, double top_radius);

// The level section at a height: an ellipse.
struct QuadricSection {
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();  // [m]
  Eigen::Vector2d half = Eigen::Vector2d::Zero();    // half of what it measures along x and y [m]
  double area = 0;                                   // [m^2]
};
std::optional<QuadricSection> section_at(const Quadric& quadric, double height);  // none: nothing there

bool is_inside(const Quadric& quadric, const Vec3& point);
Eigen::AlignedBox3d bounds_of(const Quadric& quadric);
double volume_of(const Quadric& quadric);  // [m^3]

// Throws InputError (place: `name`) for a quadric without volume: one that is flat or empty; for one that is
// not bounded; and for numbers that are not finite.
void check_quadric(const Quadric& quadric, const std::string& name);

// ---- The texture

// A product of two sums of sines that shift each other's phase (Gardner 1984):
//
//   T = k sum_i (C_i sin(X_i x + P_i) + T_0) sum_i (C_i sin(Y_i y + Q_i) + T_0)
//   P_i = pi/2 sin(Y_{i-1} y) + pi sin(X_i z/2),   Q_i = pi/2 sin(X_{i-1} x) + pi sin(Y_i z/2)
//   X_{i+1} = 2 X_i,  C_{i+1} = 0.707 C_i
//
// z shifts phases as well, so that it is a texture of space (Gardner 1985). T_0 is the mean of C_i, the least
// with which no factor is below 0, and k such that T is from 0 to 1.
struct GardnerTexture {
  int octaves = 6;
  double wavelength = 2;   // of the first sine along x [m]
  double stretch = 1.17;   // wavelength along x over that along y; 1 shows a grid
  double falloff = 0.707;  // C_{i+1}/C_i
};

// Throws InputError for octaves beyond 1 … 16, and lengths and falloffs that are not above 0.
void check_texture(const GardnerTexture& texture);

float value_at(const GardnerTexture& texture, const Eigen::Vector3f& place);

// How T is distributed over space.
struct TextureLevels {
  std::array<float, 257> quantile{};  // T that k/256 of space is below
};
TextureLevels levels_of(const GardnerTexture& texture);
// The threshold above which T is on so much of space, 0 … 1.
float threshold_for(const TextureLevels& levels, float cover);

// How opaque a crown is where the texture is T. `middle` is how far within the outline that the eye sees the
// place lies: 1 where it sees the middle of the quadric, 0 at its silhouette. The threshold grows towards
// the silhouette, which gets ragged so (Gardner 1985, eq. for translucence).
struct CrownCover {
  float middle = 0.9F, edge = 0.03F;  // share of the crown that is covered there
  float softness = 0.04F;             // range of T over which leaves fade out
};
float opacity_at(const TextureLevels& levels, const CrownCover& cover, float value, float middle);

// ---- Trees

struct ImpressionistTree {
  std::string name;
  double height = 10, width = 8;                // [m]
  double trunk_height = 9;                      // of the trunk, which goes on into the crown [m]
  double base_radius = 0.2, top_radius = 0.02;  // [m]
  std::string material = "green-wood";          // of the trunk
  Eigen::Vector3f bark_color{0.33F, 0.27F, 0.21F}, leaf_color{0.25F, 0.36F, 0.13F};  // sRGB
  std::vector<Quadric> crown;
  GardnerTexture texture;
  CrownCover cover;
  double leaf_size = 0.1;       // [m] of a leaf, or of a handful of small ones
  double crown_density = 1.38;  // branches and leaves over the volume of the crown [kg/m^3]
  std::uint64_t seed = 1;
};

struct ImpressionistShape {
  std::string name, description;
  double height = 10;          // that it has by itself [m]
  double width_by_height = 1;  // [-]
};
const std::vector<ImpressionistShape>& impressionist_shapes();

// A tree of that shape. Width, where not given, is that of the shape at this height. Throws InputError that
// lists the shapes for another, and for sizes that are not above 0.
ImpressionistTree impressionist_tree(std::string_view shape, double height, std::optional<double> width = {},
                                     std::uint64_t seed = 1);

// Throws InputError as check_quadric and check_texture do, and for a tree without trunk or crown.
void check_tree(const ImpressionistTree& tree);

// The trunk, then the crown.
std::vector<Quadric> quadrics_of(const ImpressionistTree& tree);

// How a quadric of a tree is painted. Where x is a place from its centre, the texture there is that at
// turn x + offset: never the same piece of it, and its grid never the same way.
struct QuadricPaint {
  Eigen::Matrix3f turn = Eigen::Matrix3f::Identity();
  Eigen::Vector3f offset = Eigen::Vector3f::Zero();  // [m]
  // form = root^T diag(sign) root: root x makes a sphere of an ellipsoid.
  Eigen::Matrix3f root = Eigen::Matrix3f::Identity();
  Eigen::Vector3f sign = Eigen::Vector3f::Ones();
};
// `number`: among quadrics_of(tree).
QuadricPaint paint_of(const Quadric& quadric, std::size_t number, std::uint64_t seed);
// How far along x, y and z the texture of a copy is shifted, so that no two have the same leaves [m].
float texture_shift(std::size_t copy);

// What the wind takes hold of and the trunk carries, by height.
struct CrownLayer {
  double low = 0, high = 0;  // [m]
  double volume = 0;         // of all quadrics together [m^3]
  double frontal_area = 0;   // as it is seen along y [m^2]
};
std::vector<CrownLayer> crown_layers(const ImpressionistTree& tree, int count);

// The tree for the cascade: its trunk as a beam of a few branches, with the crown's mass and drag lumped on
// it (F: "all branches are horizontal and the trunk is vertical"). Leaves are lumps of a layer each, of
// `leaf_area` [m^2] per m^2 of frontal area.
//
// 4.8 with the drag coefficient 0.25 of foliage: at 20 m/s, folded, 0.18 of the frontal area in still air,
// where crowns of three broadleaves had 0.15 to 0.22 (Vollsinger et al. 2005).
Skeleton trunk_skeleton(const ImpressionistTree& tree, double leaf_area = 4.8);

}  // namespace tremula
