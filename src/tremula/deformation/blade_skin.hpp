// The skin of a blade of grass, a stem or an ear.
#pragma once

#include "tremula/geometry/meadow.hpp"

#include <cstdint>
#include <vector>

namespace tremula {

// By where its vertices are about the joints of its pieces.
struct BladeVertex {
  int joint;
  float across, out;                // along the flat side and out of it, in widths
  float normal_across, normal_out;  // unit
  float u;                          // of the texture
};
struct BladeSkin {
  std::vector<BladeVertex> vertices;
  std::vector<std::uint32_t> triangles;
  bool two_sided = false;
};
BladeSkin skin_of(const BladeKind& kind);

}  // namespace tremula
