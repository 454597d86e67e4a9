// The mean wind: how it grows with height and where it blows to.
#pragma once

#include "tremula/base/types.hpp"

namespace tremula {

enum class ProfileKind {
  constant,
  logarithmic,  // U(z) = U_ref ln(z/z0) / ln(z_ref/z0), 0 below z0
  power,        // U(z) = U_ref (z/z_ref)^exponent
};

struct MeanWind {
  double speed = 6;              // U_ref at the reference height [m/s]
  double reference_height = 10;  // [m]
  double heading = 0;            // where it blows to, counter-clockwise from +x seen from above [degrees]
  ProfileKind profile = ProfileKind::logarithmic;
  double roughness_length = 0.03;  // z0, short grass [m]
  double power_exponent = 0.2;
};

// Throws InputError for numbers that make no wind (negative speed, z0 <= 0 or above the reference height, …).
void check_mean_wind(const MeanWind& wind);

double mean_speed(const MeanWind& wind, double height);  // [m/s], 0 at and below the ground
Vec3 heading_direction(const MeanWind& wind);            // unit vector, horizontal

}  // namespace tremula
