// The mean wind: how it grows with height and where it blows to.
#pragma once

#include "tremula/base/types.hpp"

#include <vector>

namespace tremula {

enum class ProfileKind {
  constant,
  logarithmic,  // U(z) = U_ref ln((z-d)/z0) / ln((z_ref-d)/z0), 0 below d + z0
  power,        // U(z) = U_ref (z/z_ref)^exponent
  table,        // as measured, linear between its rows, its first and last row beyond them
};

struct ProfileRow {
  double height = 0;  // [m]
  double speed = 0;   // [m/s]
  double turn = 0;    // counter-clockwise seen from above, against any one direction [degrees]
};

struct MeanWind {
  double speed = 6;              // U_ref at the reference height [m/s]
  double reference_height = 10;  // [m]
  double heading = 0;            // where it blows to, counter-clockwise from +x seen from above [degrees]
  ProfileKind profile = ProfileKind::logarithmic;
  double roughness_length = 0.03;  // z0, short grass [m]
  double power_exponent = 0.2;
  double displacement = 0;  // d, of the log law: the height its ground seems to have over a canopy [m]
  // Below the top h of a canopy that the plants of interest stand in: U(z) = U(h) exp(-a (1 - z/h)), whatever
  // the profile above. 0: no canopy.
  double canopy_height = 0;  // h [m]
  double canopy_decay = 2;   // a
  // Of ProfileKind::table, from the lowest row up. Its speeds are scaled to U_ref at z_ref, and its turns
  // count from there: at z_ref the wind blows to the heading. It knows its own canopy.
  std::vector<ProfileRow> table = {};
};

// Throws InputError for numbers that make no wind (negative speed, z0 <= 0 or above the reference height, …).
void check_mean_wind(const MeanWind& wind);

// [m/s], 0 at and below the ground. The reference height may lie within the canopy.
double mean_speed(const MeanWind& wind, double height);

// Speed [m/s] of a table that is not scaled.
double table_speed(const std::vector<ProfileRow>& table, double height);

// Where the wind of that height blows to against that of the reference height [degrees]: 0 but in tables.
double veer(const MeanWind& wind, double height);

// The friction velocity u* [m/s] that goes with the logarithmic profile: U_ref kappa / ln((z_ref-d)/z0), von
// Karman's kappa = 0.4. For other profiles and within the canopy: of the log law through the speed at the
// canopy's top or the reference height, whichever is higher.
double log_law_friction_velocity(const MeanWind& wind);

Vec3 heading_direction(double heading);                       // [degrees]; unit vector, horizontal
Vec3 heading_direction(const MeanWind& wind);                 // that of its reference
Vec3 heading_direction(const MeanWind& wind, double height);  // with the veer
Vec3 mean_velocity(const MeanWind& wind, double height);      // [m/s], world axes

}  // namespace tremula
