// How a blade of grass follows the wind, as F section 5.2 has it: two angles of the particle's direction at
// its foot, each driven by an oscillator,
//
//   theta'' + gamma theta' + omega^2 theta = f_theta / m,   f_theta = -f_x sin theta + f_y cos theta,
//   phi''   + gamma phi'   + omega^2 phi   = f_phi / m,     f_phi   =  f_x cos theta + f_y sin theta.
//
// Constants come from a heavy rod with the blade's frequency and the drag of the wind over the canopy. An
// angle is what the tip of an upright blade would turn by if all were linear (structure/heavy_rod.hpp); how
// far a blade then bends is the rod's affair (deformation/grass_pose.hpp). Both oscillators are alike, so
// they turn into two along and across the wind, which are the same for all blades of a make: a response field
// (response_field.hpp), of which a blade looks up its part.
#pragma once

#include "tremula/dynamics/response_field.hpp"
#include "tremula/geometry/meadow.hpp"
#include "tremula/structure/heavy_rod.hpp"
#include "tremula/wind/gust_statistics.hpp"

#include <Eigen/Core>

namespace tremula {

struct BladeResponse {
  HeavyRod rod;                                  // stiff enough for its frequency
  RodDrag load;                                  // under which the tip of the upright rod would turn by 1 rad
  double frequency = 0;                          // [Hz]
  double damping_along = 0, damping_across = 0;  // ratios, with that of the air
  double lean = 0;                               // along the wind, under the mean drag [rad]
  double along = 0, across = 0;                  // of 1 m/s of gust at the tips that stays [rad s/m]
};

// Of the blades of a kind and frequency class, in a meadow of so many m of height (of its average plant), in
// the wind at that height: axes along the wind, across and up. Drag is averaged over the gusts as
// gust_average.hpp does, below the tips it fades with the canopy. Longer blades of a make are slower, as
// 1/length. Throws InputError for kinds and classes that there are not, for a kind without a frequency, and
// for a wind or a density that is not finite.
BladeResponse blade_response(const GrassSpecies& species, int kind, int frequency_class, double height,
                             const GustStatistics& wind, double air_density = 1.2);

// Mean and covariance of the gusts at a height above the ground, over the loop and all columns; along,
// across, up.
GustStatistics statistics_at(const TravellingField& gusts, double height);

// [rad] of gusts [m/s].
FieldResponse field_response(const BladeResponse& blade);

// The same in time, for one blade, without an error of the step: what is about the lean, along and across (2
// x samples) [rad]. place: z the height at which the wind is asked [m].
Eigen::Matrix2Xd sway_in_time(const BladeResponse& blade, const TravellingField& gusts, const Vec3& place);

// phi and theta (times the sine of the lean: an angle across) from angles along axes x and y.
inline Eigen::Vector2d in_axes_of_blade(double azimuth, const Eigen::Vector2d& along_axes) {
  const double c = std::cos(azimuth), s = std::sin(azimuth);
  return {c * along_axes.x() + s * along_axes.y(), -s * along_axes.x() + c * along_axes.y()};
}

}  // namespace tremula
