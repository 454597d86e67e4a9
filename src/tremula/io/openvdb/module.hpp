// What is between the library and its module for OpenVDB, which is opened when a volume is to be written:
// with OpenVDB come threads and libraries for its log, 50 ms and tens of megabytes, of no use to anybody
// else.
#pragma once

#include "tremula/base/types.hpp"
#include "tremula/geometry/texels.hpp"

#include <array>
#include <string>

namespace tremula {

struct VdbVolume {
  std::array<int, 3> count;
  Vec3 cell, low;      // [m]
  float most_density;  // that there can be [1/m]
  TexelValue (*value_at)(const void* texels, int x, int y, int z);
  const void* texels;
};

// False with what went wrong instead of the bytes.
using EncodeVdb = bool(const VdbVolume& volume, std::string& bytes);
inline constexpr const char* encode_vdb_name = "tremula_encode_vdb";

}  // namespace tremula
