// How the variance of turbulence spreads over frequency. One-sided, per Hz: the integral over f > 0 is the
// variance.
#pragma once

#include "tremula/base/types.hpp"

namespace tremula {

// S_u, S_v, S_w [(m/s)^2/Hz] of Simiu & Scanlan as F eq. 1 has them, with C_0 = friction_velocity^2 and
// nu = f z/U: variances 6, 2.3684 and 1.6728 u*^2 (errata F2). frequency [Hz] > 0, height [m] > 0, speed
// [m/s] > 0.
Vec3 simiu_scanlan_spectrum(double frequency, double height, double speed, double friction_velocity);

// The friction velocity u* [m/s] that gives the along-wind deviation sigma_u = intensity * speed.
double friction_velocity_from_intensity(double turbulence_intensity, double speed);

}  // namespace tremula
