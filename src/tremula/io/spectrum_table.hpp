// Measured wind spectra from a text table: a header that names the columns, then rows of numbers with commas,
// semicolons or blanks between them. Columns are found by name, others are passed over:
//   frequency  S_u S_v S_w   [Hz], [(m/s)^2/Hz]
//   k1_rad_per_m  Fu Fv Fw   [rad/m], [m^3/s^2]: by wave number (see SpectrumTable)
// One-sided. Lines that begin with # are comments.
#pragma once

#include "tremula/wind/spectrum.hpp"

#include <string>
#include <string_view>

namespace tremula {

// Throws InputError, with the line, for a header without these columns, fields that are no numbers above 0,
// frequencies that do not rise and fewer than two rows.
SpectrumTable read_spectrum_table(const std::string& path);
SpectrumTable read_spectrum_table(std::string_view text, const std::string& path);  // path is for messages

}  // namespace tremula
