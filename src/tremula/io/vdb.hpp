// 3-D textures as OpenVDB files (.vdb), for renderers that show volumes.
#pragma once

#include "tremula/base/types.hpp"
#include "tremula/geometry/texels.hpp"

#include <string>

namespace tremula {

// Whether this was built with OpenVDB and finds its module for it: tremula/openvdb.so beside the libraries,
// where it is built and installed.
bool has_vdb();

// The bytes of a file with three sparse grids of one transform, a value in the middle of a texel: "density"
// (fog volume; a of texels.hpp [1/m]), "tangent" (unit, along the strands, z >= 0) and "color" (linear
// albedo), as half floats (densities beyond those as floats); where the density is 0 there is no value.
// `low`: where the texture begins [m]. One texture has the same bytes whenever it is written. Throws
// InputError for texels that are not as many as they should be, Error without has_vdb().
std::string encode_vdb(const Texels& texels, const Vec3& low = Vec3::Zero());

}  // namespace tremula
