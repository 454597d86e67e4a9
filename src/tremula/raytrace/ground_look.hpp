// What the ground looks like at a place.
#pragma once

#include "tremula/raytrace/raytrace.hpp"
#include "tremula/render/patterns.hpp"

namespace tremula {

// `footprint`: the size of a pixel on the ground [m]; what is finer is faded out, so that the mean stays.
PatternSpot ground_pattern(const GroundLook& ground, const Eigen::Vector2f& place, float footprint);

Rgb ground_color_of(const GroundLook& ground);  // linear albedo, the mean

}  // namespace tremula
