// The skin of a skeleton: tubes along its axes and a card for every leaf, as one indexed triangle mesh. Each
// vertex knows the branch that carries it and where along the branch, so that any deformation of the branches
// moves it.
#pragma once

#include "tremula/base/types.hpp"
#include "tremula/geometry/skeleton.hpp"

#include <cstdint>
#include <vector>

namespace tremula {

// Vertices and triangles of one leaf: midrib (base, middle, tip) and two points of the edge on either side.
inline constexpr std::uint32_t leaf_vertices = 7;
inline constexpr std::uint32_t leaf_triangle_count = 6;

// Structure of arrays; all vertex arrays have one length V. Float: this is for pictures and files.
struct Surface {
  std::vector<Eigen::Vector3f> position;  // (V) [m] at rest, z up
  std::vector<Eigen::Vector3f> normal;    // (V) unit
  std::vector<Eigen::Vector2f> texture;  // (V) bark: u around (0–1), v along in circumferences; leaf: 0–1
  std::vector<std::int32_t> branch;      // (V) the branch that carries the vertex
  std::vector<float> along;              // (V) position along that branch, 0 start to 1 end
  std::vector<std::uint32_t> bark_triangles;  // (3 per triangle) counter-clockwise seen from outside
  std::vector<std::uint32_t> leaf_triangles;  // (3 per triangle) counter-clockwise from above; two-sided
  std::uint32_t first_leaf_vertex = 0;  // leaf l owns leaf_vertices vertices from here + l * leaf_vertices on
  Eigen::Vector3f bark_color{0.36F, 0.29F, 0.22F};  // sRGB, 0–1
  Eigen::Vector3f leaf_color{0.29F, 0.44F, 0.16F};  // sRGB, 0–1

  std::size_t vertex_count() const { return position.size(); }
};

struct SurfaceOptions {
  int max_sides = 10;         // of the thickest tube; thin twigs get fewer, never below min_sides; <= 256
  int min_sides = 3;          // >= 3
  int bend_subdivisions = 1;  // rings a branch gets besides those at its ends, for its cubic curve; one that
                              // is no longer than thick gets none; 0 … 64
  bool leaves = true;
};

// The skeleton's axes: each branch belongs to one axis; a branch is continued by the child that goes on best
// (thickest and straightest), the others start axes of their own. Branch indices from base to tip.
std::vector<std::vector<int>> split_into_axes(const Skeleton& skeleton);

// Tubes follow the axes with smooth radii and mitred joints; a side axis starts in a collar on the skin of
// the one it springs from. Every tube is closed: at its base by a disc, at its tip by one vertex that lies
// exactly on the end node of its last branch. A ring at a node that two branches of an axis share belongs to
// the lower one, at along = 1. An axis that starts clear of all wood at its node shows the rigid arm that
// holds it, as a spike from the node. Bark comes first, then leaves. Takes what check_skeleton accepts, and
// branches of no length and leaves of any shape besides. Throws InputError for other skeletons and options
// out of range.
Surface mesh_surface(const Skeleton& skeleton, const SurfaceOptions& options = {});

}  // namespace tremula
