// Which triangle is seen at every sample of a grid: a z-buffer that keeps triangle numbers, for the camera's
// view and the sun's alike.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace tremula {

inline constexpr std::uint32_t no_triangle = std::numeric_limits<std::uint32_t>::max();

// A vertex before the division: it lies at ((x/w + 1)/2 * width, (1 - y/w)/2 * height), y up. `depth` is the
// distance along the view; for a perspective view w = depth, for a parallel one w = 1.
struct RasterVertex {
  float x, y, w, depth;
};

struct VisibilityBuffer {
  int width = 0;
  int height = 0;
  bool perspective = true;
  std::vector<float> nearness;  // (width * height) 1/depth in perspective, else -depth; -infinity: nothing
  std::vector<std::uint32_t> triangle;  // (width * height) index of the triangle, or no_triangle
};

// Draws triangles (3 indices each, both faces) in order; what is as near as what is there does not replace
// it. A sample on an edge that two triangles share belongs to one of them. The result is the same on any
// number of threads. Triangles are cut at w = near_w.
VisibilityBuffer rasterise(std::span<const RasterVertex> vertices, std::span<const std::uint32_t> indices,
                           int width, int height, bool perspective, float near_w);

}  // namespace tremula
