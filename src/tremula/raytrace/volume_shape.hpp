// Fields of texels for the ray tracer (Kajiya and Kay 1989): what a ray meets in them is by chance, a strand
// that has the frame and the colour of its texel.
#pragma once

#include "tremula/deformation/volume.hpp"
#include "tremula/raytrace/ray_shape.hpp"

#include <memory>
#include <optional>
#include <string>

namespace tremula {

struct VolumeLook {
  float translucent = 0.3F;  // what a strand lets through, of what it reflects, 0 … 1
  // Of the clear coat of strands, 0 … 1, wax or keratin, whose sheen lies where eye and light make equal
  // angles with them; none: dull.
  std::optional<float> roughness = {};
  float patches = 0;      // how far the hue of a place is off the mean, 0 … 1: fields have paler spots
  float patch_size = 1;   // [m]
  float pixel = 0.0006F;  // size of a pixel at distance 1: what is finer is taken from coarser textures
};

// Throws InputError as check_volume does, and for a roughness beyond 0 to 1.
RayShape volume_shape(std::shared_ptr<const VolumeField> field, const VolumeLook& look, std::string name);

// A direction that a strand's side looks in, of those that the ray in `direction` sees: the normals of an
// SGGX distribution (Heitz et al. 2015, its visible ones). Unit, towards where the ray comes from. Of
// parallel round strands: about their axis, by the cosine.
Eigen::Vector3f visible_normal(const TexelValue& value, const Eigen::Vector3f& direction,
                               const Eigen::Vector2f& random);

}  // namespace tremula
