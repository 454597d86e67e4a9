// Wind fields as TurbSim writes them (.bts, full-field TurbSim binary, little endian), which OpenFAST,
// HAWC2's tools and PyConTurb read as well. Layout: TurbSim User's Guide 2.00, appendix D.
//
// 70 bytes of header and a text, then 16-bit integers: for every step the grid (rows from the bottom, within
// a row from -y to +y, u v w innermost), then the tower from the top (u v w). velocity = (integer -
// offset)/slope.
#pragma once

#include "tremula/wind/field.hpp"

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace tremula {

class AtomicFile;

// A file as it stands: written again, it has the same bytes.
struct TurbSimFile {
  bool periodic = true;  // id 8, else 7
  std::int32_t z_count = 0, y_count = 0, tower_count = 0, step_count = 0;
  float z_spacing = 0, y_spacing = 0, step = 0;     // [m], [m], [s]
  float hub_speed = 0, hub_height = 0, bottom = 0;  // [m/s], [m], [m]
  std::array<float, 3> slope = {}, offset = {};     // of u, v, w
  std::string text;                                 // any bytes
  std::vector<std::int16_t> values;                 // ((grid + tower points) * 3 * steps), as in the file

  std::size_t values_per_step() const;
  double velocity(std::int16_t value, std::size_t component) const;  // [m/s]
  double tower_height(int k) const;  // [m]: the k-th point, from 0, is k spacings below the lowest row
};

// Throws InputError, naming the file, the field of the header and its byte, for what is no such file:
// truncated, longer than its counts say, counts below 1, spacings that make no grid, numbers that are not
// finite, slope 0.
TurbSimFile read_turbsim(const std::string& path);
TurbSimFile parse_turbsim(std::string_view bytes, const std::string& name);

// Velocities by the formula above in double precision, rounded once to float. The tower's points are at
// TurbSimFile::tower_height.
WindField wind_field(const TurbSimFile& file);

// The file as it was read.
void write_turbsim(const std::string& path, const TurbSimFile& file);

// Scales each component so that its range over grid and tower fills 16 bits, as TurbSim does: the error is at
// most half of range/65535, and single precision. Needs a few hundred kB beside the field. The text may say
// what made the field. Throws InputError for values that are not finite or above 1e9 m/s, Error where the
// file cannot be written.
void write_turbsim(const std::string& path, const WindField& field,
                   std::string_view text = "Wind field written by tremula.");
// Into a file that the caller commits.
void write_turbsim(AtomicFile& out, const WindField& field, std::string_view text);

}  // namespace tremula
