// The page (.html) of impressionist trees: the quadrics of one tree as triangles, drawn as often as it stands
// there, and how the top and the texture answer the wind as textures. The graphics card does with them what
// impression_rays.hpp does for pictures: it shifts every level as the trunk is shifted there, and asks
// Gardner's texture of every leaf whether it is there and how bright it is. So the page closes with the loop.
//
// What the page reads (page_block.hpp), with the letters "TRMI":
// - copies: (copies x 8) floats: x y z, scale, cosine and sine of the turn, time shift, shift of the texture.
// - positions, normals: (vertices x 3) floats of the resting tree; quadrics: (vertices) of 32 bits, of which
//   each is; triangles: (triangles x 3) of 32 bits.
// - sway: (samples x columns x 2) of 16 bits signed, in steps, of the top along and across; tremble: the same
//   x 4, along, across, up and 0.
// The JSON has what LoopFacts says, the steps and axes of the field, the curve of the trunk, the colours, the
// texture, and of every quadric how it is painted (QuadricPaint, matrices row after row).
#pragma once

#include "tremula/deformation/impression_motion.hpp"
#include "tremula/deformation/loop.hpp"
#include "tremula/geometry/impression.hpp"

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace tremula {

// More are a film of stills in most browsers.
inline constexpr std::size_t most_triangles_of_impressions = 6'000'000;

// All quadrics of one tree, the finer the fewer copies there are.
struct ImpressionMesh {
  std::vector<Eigen::Vector3f> positions, normals;  // of the resting tree [m]
  std::vector<std::uint32_t> quadric;               // (vertices) of quadrics_of(tree)
  std::vector<std::uint32_t> triangles;
};

// Throws InputError for no copies, and where they have more than most_triangles_of_impressions even so.
ImpressionMesh mesh_for_page(const ImpressionistTree& tree, std::size_t copies);

// The same trees give the same bytes. Throws InputError as impression_shape and mesh_for_page do, for fields
// that do not belong together or have more than one layer, and for numbers that are not finite.
std::string encode_impressions(const ImpressionistTree& tree, const std::vector<Instance>& instances,
                               const ImpressionMotion& motion, const LoopFacts& facts);

// Throws Error as encode_html() does, and as encode_impressions().
std::string encode_impressions_page(const ImpressionistTree& tree, const std::vector<Instance>& instances,
                                    const ImpressionMotion& motion, const LoopFacts& facts);

}  // namespace tremula
