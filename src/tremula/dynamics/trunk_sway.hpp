// How a trunk follows the gusts wherever it stands: its fundamental mode, along and across the wind, as an
// oscillator that a response field takes (response_field.hpp), so that thousands of trees sway in one wind
// for the price of one field. F section 6.1 takes the fundamental mode alone as well: "the power of the
// second mode is small (1 % for the trunk)".
#pragma once

#include "tremula/dynamics/damping.hpp"
#include "tremula/dynamics/loads.hpp"
#include "tremula/dynamics/response_field.hpp"
#include "tremula/structure/structure.hpp"
#include "tremula/wind/point_wind.hpp"

#include <array>
#include <vector>

#include <Eigen/Core>

namespace tremula {

struct SwayOptions {
  LoadOptions loads = {};
  Damping damping = {};
  double crown_radius = 0;  // gusts are averaged over a disc of that [m]
};

struct TrunkSway {
  double gust_height = 0;  // above the foot, whose gusts count: the mean by what they move [m]
  // Along and across the wind: of the mode, the air's damping in it, and where the top goes in a gust of 1
  // m/s that does not end [m s/m].
  std::array<double, 2> frequency{}, damping_ratio{}, static_response{};
  // Of the trunk by height: where it stands in the mean wind [m], and how far it moves where the top moves 1;
  // along and across.
  std::vector<double> heights;  // rising from the foot, 0 [m]
  std::vector<Eigen::Vector2d> lean, share;

  FieldResponse response = {};  // of gusts: the displacement of the top [m]
};

// Of a structure that stands on one foot, at the origin, and whose last node is its top; lumped, so without
// shelter. Throws InputError for one that does not, and as find_lean and solve_modes do.
TrunkSway trunk_sway(const Structure& structure, const Wind& wind, const TimeAxis& loop,
                     const SwayOptions& options = {});

// The skeleton of a material so stiff that its first mode is at that frequency [Hz] in still air. Throws
// InputError where the weight lets none be: what stands has to bear it.
Structure tuned_structure(const Skeleton& skeleton, StructureOptions options, double frequency);

}  // namespace tremula
