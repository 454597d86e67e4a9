// Quadrics as triangles, for what draws no quadrics.
#pragma once

#include "tremula/geometry/impression.hpp"

#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace tremula {

// Rings of level ellipses, the lowest first, closer where a quadric closes. Open at a plane that cuts it, as
// quadrics are for rays.
struct QuadricMesh {
  std::vector<Eigen::Vector3f> positions;  // (rings x sides) on the quadric [m]
  std::vector<Eigen::Vector3f> normals;    // outwards, unit
  std::vector<std::uint32_t> triangles;    // counterclockwise from outside
};

// Throws InputError as check_quadric does, and for fewer than 2 rings or 3 sides.
QuadricMesh mesh_of(const Quadric& quadric, int rings, int sides);

}  // namespace tremula
