// Things that are no triangles: whoever makes them says where a ray meets them. Crowns that are quadrics with
// a texture (geometry/impression.hpp) and plants that are volumes are shown so.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace tremula {

class Gloss;

// Where a ray meets a shape, and what it is made of there: dull on both sides, with a coat where there is
// one. Colours are linear, 0 to 1, and of each no more than 1 together; what is neither reflected nor
// transmitted is swallowed.
struct RayShapeHit {
  float distance = 0;                                 // along the ray's unit direction [m]
  Eigen::Vector3f normal = Eigen::Vector3f::UnitZ();  // unit, outwards
  Eigen::Vector3f reflected = Eigen::Vector3f::Zero(), transmitted = Eigen::Vector3f::Zero();
  const Gloss* gloss = nullptr;  // a clear coat over it, of the shape's own (scattering.hpp); none: dull
};

// One thing at the time of a frame.
struct PosedRayShape {
  Eigen::AlignedBox3f bounds;  // of all that is hit while the shutter is open [m]
  // The nearest hit of a ray between its origin and `farthest` [m], at `shutter`, 0 (it opens) to 1 (it
  // closes). False where there is none; `hit` is undefined then. `random` differs from ray to ray and from
  // shape to shape, and is the same whenever the same ray is asked: for what is hit by chance (transparency
  // as a probability). What is nearest must not depend on `farthest`. Called from many threads.
  std::function<bool(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction, float shutter,
                     float farthest, std::uint32_t random, RayShapeHit& hit)>
      hit;
};

// Things that are posed together, e.g. all trees of a far forest.
struct RayShape {
  std::string name;
  // At a time [s], for a shutter that is open so long about it [s].
  std::function<std::vector<PosedRayShape>(double time, double shutter)> pose;
  Eigen::AlignedBox3f reach;  // in which all stays at all times [m], for cameras that frame it
};

}  // namespace tremula
