// How air and water dim what is far.
#pragma once

#include "tremula/base/types.hpp"
#include "tremula/scene/scene.hpp"

namespace tremula {

// Koschmieder 1924: a dark thing is seen as far as light of its contrast fades to 2 % on the way: ln 50.
inline constexpr double koschmieder = 3.912;

inline constexpr double default_visibility_in_air = 20e3, default_visibility_in_water = 12;  // [m]

// Extinction of red, green and blue [1/m] of what is seen so far away in green [m]. In air after Kruse
// (1962): that of haze falls with the wavelength, the less the thicker it is. In water what its colour is
// from, the absorption of pure water (Pope & Fry 1997), and grey what floats in it. Throws InputError for a
// visibility that is not above 0.
Eigen::Vector3f air_extinction(double visibility);
Eigen::Vector3f water_extinction(double visibility);

Eigen::Vector3f extinction_of(const SceneMedium& medium, bool under_water);

}  // namespace tremula
