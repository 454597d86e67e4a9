// The skin of what moves, as indexed triangles in parts, each of one material. Each vertex knows the branch
// (or other member) that carries it and where along it, so that any deformation of the members moves it. A
// skeleton's skin: tubes along its axes and a card for every leaf.
#pragma once

#include "tremula/base/types.hpp"
#include "tremula/geometry/skeleton.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace tremula {

// Vertices and triangles of one leaf: midrib (base, middle, tip) and two points of the edge on either side.
inline constexpr std::uint32_t leaf_vertices = 7;
inline constexpr std::uint32_t leaf_triangle_count = 6;

// How a part looks. The name goes into files and says what is drawn into the part beside its colour: the
// furrows of "bark", the ribs and the shine of a "leaf" or a "ribbon"; nothing into parts of other names.
struct SurfaceMaterial {
  std::string name;
  Eigen::Vector3f color{0.5F, 0.5F, 0.5F};  // sRGB, 0–1
  float roughness = 0.9F;                   // 0 a mirror, 1 dull
  bool two_sided = false;                   // thin, seen from both sides; else the skin of something closed
};

// Of a part that is made of many alike, as leaves: piece p owns `size` vertices from first_vertex + p * size
// on.
struct Pieces {
  std::uint32_t first_vertex = 0, size = 0, count = 0;

  bool owns(std::uint32_t vertex) const {
    return vertex >= first_vertex && vertex - first_vertex < size * count;
  }
};

struct SurfacePart {
  SurfaceMaterial material;
  std::vector<std::uint32_t>
      triangles;  // (3 per triangle) counter-clockwise seen from outside, or from above
  Pieces pieces = {};
};

// Structure of arrays; all vertex arrays have one length V. Float: this is for pictures and files.
struct Surface {
  std::vector<Eigen::Vector3f> position;  // (V) [m] at rest, z up
  std::vector<Eigen::Vector3f> normal;    // (V) unit
  std::vector<Eigen::Vector2f> texture;  // (V) tube: u around (0–1), v along in circumferences; leaf: 0–1
  std::vector<std::int32_t> branch;      // (V) the branch or member that carries the vertex
  std::vector<float> along;              // (V) position along it, 0 start to 1 end
  std::vector<SurfacePart> parts;

  std::size_t vertex_count() const { return position.size(); }
};

struct SurfaceOptions {
  int max_sides = 10;         // of the thickest tube; thin twigs get fewer, never below min_sides; <= 256
  int min_sides = 3;          // >= 3
  int bend_subdivisions = 1;  // rings a branch gets besides those at its ends, for its cubic curve; one that
                              // is no longer than thick gets none; 0 … 64
  bool leaves = true;
  SurfaceMaterial tube{.name = "bark", .color = {0.36F, 0.29F, 0.22F}};
  SurfaceMaterial leaf{.name = "leaf", .color = {0.29F, 0.44F, 0.16F}, .roughness = 0.6F, .two_sided = true};
};

// The skeleton's axes: each branch belongs to one axis; a branch is continued by the child that goes on best
// (thickest and straightest), the others start axes of their own. Branch indices from base to tip.
std::vector<std::vector<int>> split_into_axes(const Skeleton& skeleton);

// Tubes follow the axes with smooth radii and mitred joints; a side axis starts in a collar on the skin of
// the one it springs from. Every tube is closed: at its base by a disc, at its tip by one vertex that lies
// exactly on the end node of its last branch. A ring at a node that two branches of an axis share belongs to
// the lower one, at along = 1. An axis that starts clear of all wood at its node shows the rigid arm that
// holds it, as a spike from the node. One part for the tubes and, where there are leaves, one for those; and
// one for ribbons, strips that bend with their branches as tubes do.
// Takes what check_skeleton accepts, and branches of no length and leaves of any shape besides. Throws
// InputError for other skeletons and options out of range.
Surface mesh_surface(const Skeleton& skeleton, const SurfaceOptions& options = {});

}  // namespace tremula
