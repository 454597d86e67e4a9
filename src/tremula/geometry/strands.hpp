// Plants of many thin parts, and fur, as strands: lines with a width, on a patch that repeats. A shape model
// for 3-D textures (texels.hpp; F section 5.4).
#pragma once

#include "tremula/base/types.hpp"

#include <cstdint>
#include <string_view>
#include <vector>

namespace tremula {

struct Strand {
  std::vector<Eigen::Vector3f> points;  // two or more, from where it begins to its tip [m]
  std::vector<float> widths;            // (points) as seen across it, the mean from all around [m]: the
                                        // diameter of what is round, 2/pi of the breadth of what is flat
  Eigen::Vector3f first_color{0.5F, 0.5F, 0.5F}, last_color{0.5F, 0.5F, 0.5F};  // linear albedo, 0–1
  std::uint32_t plant = 0;
  float held = -1;  // at which height the stem of its plant holds it, rigidly [m]; below 0: it is the stem
};

// Of length times width: the area of the strand, seen across it [m^2].
double area_of(const Strand& strand);

struct StrandPatch {
  Eigen::Vector2f size{1, 1};         // repeats by so much along x and y [m]; strands may reach beyond it
  float height = 0;                   // of the highest point above the ground, z = 0 [m]
  std::vector<Eigen::Vector2f> feet;  // (plants) where a plant stands [m]
  std::vector<Strand> strands;
};

enum class VolumePlant { rice, moss, fur };

// Throws InputError that lists the names where there is none of this name.
VolumePlant volume_plant_of(std::string_view name);

struct StrandOptions {
  double scale = 1;  // of everything, the patch too
  std::uint64_t seed = 1;
  int variant = 0;  // 0 … 65535. What stands near the border of the patch is the same in all of them, so that
                    // any may stand beside any
};

// Rice near harvest: hills 15 cm apart in rows 30 cm apart, of about a dozen culms, with long leaves and
// panicles that nod; about 0.9 m. Moss: cushions of shoots with leaves, some with a seta and its capsule; 3
// cm. Fur: guard hairs of all lengths in tufts and locks over shorter ones, combed towards +x; 4 cm. Throws
// InputError for a scale that is not above 0, and for a variant that is none.
StrandPatch grow_strands(VolumePlant plant, const StrandOptions& options = {});

}  // namespace tremula
