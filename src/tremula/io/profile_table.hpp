// A measured profile of the mean wind from a text table: a header that names the columns with their units,
// then rows from the lowest height up, with commas, semicolons, tabs or blanks between the numbers. Columns
// are found by name, others are passed over:
//   height (or z) [m]    from 0 up
//   speed (or U) [m/s]
//   direction [deg]      compass, clockwise; or heading [deg], counter-clockwise; or neither
// A unit stands behind the name: height_m, "height [m]", speed_m_s, speed (m/s). Lines that begin with # are
// comments.
#pragma once

#include "tremula/wind/profile.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace tremula {

// For MeanWind::table; turns change from row to row by the shorter way round. Throws InputError, with the
// line, for a header without these columns, without a unit or in others, fields that are no such numbers,
// heights that do not rise and fewer than two rows.
std::vector<ProfileRow> read_profile_table(const std::string& path);
std::vector<ProfileRow> read_profile_table(std::string_view text, const std::string& path);

}  // namespace tremula
