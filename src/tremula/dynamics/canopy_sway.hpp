// How far the wind moves the tops of plants that stand close: rice, fur, moss. No plant is known for itself.
// All are one oscillator, the first mode of one of them (F section 4.1), that answers what is linear in the
// gusts of a push which goes with the square of the wind, and that draws its neighbours along (F eq. 5). So a
// field of them is a response field (response_field.hpp).
#pragma once

#include "tremula/dynamics/response_field.hpp"
#include "tremula/wind/travelling_field.hpp"

#include <Eigen/Core>

namespace tremula {

struct CanopyResponse {
  double frequency = 1;  // [Hz]
  double damping_ratio = 0.1;
  double give = 1e-3;       // d: a steady wind U moves the tops by d U^2 [m/(m/s)^2]
  double neighbours = 0.1;  // s of exp(-|dx|^2/s^2), over which tops move together [m]
};

struct CanopySway {
  TravellingField field;  // of 2 d U times the wind, through the oscillator [m]
  double height = 0;      // above the ground, of the gusts that count [m]
  double most = 0;        // no top is displaced further [m]

  // Of the top of what stands there [m], at a time [s]: d U^2 and what the gusts add.
  Eigen::Vector2d operator()(const Eigen::Vector2d& place, double time) const;
};

// `gusts`: at one height or more, of which the first counts. Throws InputError as respond and
// oscillator_impedance do.
CanopySway canopy_sway(const TravellingField& gusts, const CanopyResponse& response);

}  // namespace tremula
