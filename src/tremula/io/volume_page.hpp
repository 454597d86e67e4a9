// The page (.html) of a volume: not its texels but the shape model that they are made of (strands.hpp), drawn
// as ribbons as often as the patch is laid side by side, and bent by the graphics card as bend_strands bends
// it (F section 5.4), by the response of the tops as a texture. Of more strands than cards draw some are
// left out, each with the same chance, and the others are as much wider.
//
// What the page reads (page_block.hpp), with the letters "TRMV":
// - squares: (squares x 4) floats: x and y of the corner of a patch, its variant, 0.
// - points: (points of all patches x 4) floats: x y z and width.
// - strands: (strands of all patches x 8) floats: first point, points, x and y of the foot, height at which
//   the stem holds it or below 0, its first and its last colour (linear, 8 bits a channel, red the
//   highest), 0.
// - tallness: (rows x columns) of 8 bits, in 255 parts, padded to whole words.
// - sway: (samples x columns x 2) of 16 bits signed, in steps: CanopySway about the mean, along and across.
#pragma once

#include "tremula/deformation/loop.hpp"
#include "tremula/dynamics/canopy_sway.hpp"
#include "tremula/geometry/strands.hpp"

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace tremula {

// More make a page that plays as a row of stills. Of ribbons, two a piece of a strand.
inline constexpr double most_triangles_of_volume = 1.5e6;

// A volume as a page holds it; fields as in VolumeField (deformation/volume.hpp).
struct StrandField {
  std::vector<StrandPatch> patches;  // (variants) of one size, and of one height that bends
  double height = 1;                 // of what bends [m]
  Eigen::Vector2d low{-1, -1}, high{1, 1};
  std::function<double(const Eigen::Vector2d& place)> tallness;  // 0 … 1; empty: 1
  CanopySway sway;
  float translucent = 0;  // share of light that leaves let through
  std::uint32_t seed = 1;
};

// The squares that a field is laid out of, row after row.
struct PatchSquare {
  Eigen::Vector2f corner{0, 0};  // [m]
  std::size_t variant = 0;
};
std::vector<PatchSquare> squares_of(const StrandField& field);

// The share of the strands that a page holds, 0 to 1, by the area of the field.
double share_of_page(const StrandField& field);

// The strands of a variant that are left where such a share of all is, and that stand in the field anywhere.
std::vector<std::size_t> strands_left(const StrandField& field, std::size_t variant, double share);

// How many of these stand in the field, in all squares.
std::size_t shown_strands(const StrandField& field, double share);

// The same field gives the same bytes. Throws InputError for a field without patches or an area, with patches
// that differ in size, of which less than a fiftieth can be shown, and for numbers that are not finite.
std::string encode_volume(const StrandField& field, const LoopFacts& facts);

// Throws Error as encode_html() does, and as encode_volume().
std::string encode_volume_page(const StrandField& field, const LoopFacts& facts);

}  // namespace tremula
