// Texels (Kajiya and Kay 1989; F section 5.4): a 3-D texture of plants that are too fine to be drawn one by
// one. A texel says how much of them is in it, how they lie and what colour they are; never where. They are
// made by 3-D scan conversion of a shape model.
//
// What a ray in the direction w meets is by chance, with the extinction
//
//   sigma(w) = a sqrt(w^T S w),   S = q (1 - t t^T) + p t t^T,   q = 2/(2 + r), p = r q:
//
// of strands that all lie along t (r = 0) a |sin(w, t)|, the area of round ones seen from there, and of those
// that lie all ways (r = 1) a sqrt(2/3), where the mean of the sine is pi/4: within 4 %. S is the mean of
// 1 - t t^T over the area (an SGGX distribution; Heitz, Dupuy, Crassin and Dachsbacher 2015).
#pragma once

#include "tremula/geometry/strands.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace tremula {

struct Texel {
  std::uint16_t density = 0;               // times Texels::density_step
  std::array<std::uint8_t, 2> axis = {};   // t, octahedral
  std::uint8_t spread = 0;                 // r times 255
  std::array<std::uint8_t, 3> color = {};  // 255 times the square root of the linear albedo
};

struct TexelValue {
  float density = 0;                                // a: area of strands, seen across them, per volume [1/m]
  Eigen::Vector3f axis = Eigen::Vector3f::UnitZ();  // t, unit, either way
  float spread = 0;                                 // r, 0 … 1
  Eigen::Vector3f color = Eigen::Vector3f::Zero();  // linear albedo
};

// From z = 0 up; x fastest, then y, then z.
struct Texels {
  std::array<int, 3> count = {1, 1, 1};
  Eigen::Vector3f cell{1, 1, 1};  // [m]
  bool repeats = true;            // along x and y
  float density_step = 1;         // [1/m]
  std::vector<Texel> values;

  std::size_t index(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(count[1]) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(count[0]) +
           static_cast<std::size_t>(x);
  }
  Eigen::Vector3f size() const {
    return cell.cwiseProduct(Eigen::Vector3f(static_cast<float>(count[0]), static_cast<float>(count[1]),
                                             static_cast<float>(count[2])));
  }
};

TexelValue value_of(const Texel& texel, float density_step);
inline TexelValue value_of(const Texels& texels, int x, int y, int z) {
  return value_of(texels.values[texels.index(x, y, z)], texels.density_step);
}
// `density_step`: what one step of the density stands for [1/m].
Texel texel_of(const TexelValue& value, float density_step);

// sigma / a for a unit direction.
float seen_share(const TexelValue& value, const Eigen::Vector3f& direction);

inline constexpr double most_texels = 2.5e8;  // of a texture: 2 GB

// The texture of a patch: strands that leave it come in again on the other side. `resolution`: a texel's
// edge, rounded so that a whole number fits the patch [m]. All area is kept: each piece of a strand is cut at
// the walls of the texels; what is wider than a texel is spread over several lines; what is above `height` or
// below the ground counts in the layer next to it. `height` [m]: 0 for that of the patch.
// Throws InputError for a resolution that is not above 0, for more than most_texels, and for a patch without
// an area or with numbers that are not finite.
Texels scan_convert(const StrandPatch& patch, double resolution, double height = 0);

// How many texels that will be, without making them.
double texel_count(const StrandPatch& patch, double resolution, double height = 0);

// The texture itself, then by half as fine again and again until a texel is `coarsest` [m] or one is left
// along every way: means over area.
std::vector<Texels> mip_levels(Texels finest, double coarsest);

// All its area [m^2].
double area_of(const Texels& texels);

}  // namespace tremula
