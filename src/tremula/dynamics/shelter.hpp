// What stands in the wake of something else meets less wind: the leaves and branches of a crown.
#pragma once

#include "tremula/base/types.hpp"

#include <Eigen/Core>

namespace tremula {

struct ShelterOptions {
  bool on = true;
  // Width of the columns along the wind [m]: that of a twig with its leaves, a twentieth to a fifth of the
  // width of a crown.
  double cell = 0.5;
  bool induction = true;  // some of the wind goes round the crown instead of through it
};

// (S) The share of the speed of the free wind that is left at each site, 0 … 1, where it meets the site: its
// own drag, and that of what stands beside it, does not count, as their coefficients belong to the wind
// before them. places (3 x S) [m]; drag_area (S), C a with a seen along the wind [m^2]; direction of the
// mean wind, a unit vector.
//
// Momentum along columns in the wind: du/dx = -1/2 (C a of the sites per volume) u, as the drag of canopies
// has it; what enters a column is 1 - i, with 4 i (1 - i) the thrust coefficient of what stands in it (an
// actuator disc, Glauert 1935). Continuous in the places: a site takes its share of four columns (bilinear)
// and along the wind over an eighth of a cell. The columns hang on the mean of the places. Throws InputError
// for sizes that do not agree, places or areas that are not finite, areas below 0, a direction that is no
// unit vector, and a cell that is not above 0 or so small that a billion of them do not span the places.
Eigen::VectorXd find_shelter(const Eigen::Matrix3Xd& places, const Eigen::VectorXd& drag_area,
                             const Vec3& direction, const ShelterOptions& options = {});

}  // namespace tremula
