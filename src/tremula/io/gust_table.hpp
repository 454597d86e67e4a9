// A wind that changes, from a text table: rows in the order of their times, with commas, semicolons, tabs or
// blanks between the numbers, and a header that names the columns; others than these are passed over:
//   time (or t, time_s) [s]
//   speed (or U, speed_m_s) [m/s]   at the reference height
//   heading (or heading_deg)        where it blows to, from x towards y [degrees]; need not be there
// Without a header they are the first two or three columns in this order. Lines that begin with # are
// comments.
#pragma once

#include "tremula/wind/gust_script.hpp"

#include <string>
#include <string_view>

namespace tremula {

// heading [degrees]: of all rows, where the table has none. Throws InputError, with the line, for a header
// without these columns, fields that are no such numbers, times that do not ascend, speeds outside 0 to
// 100 m/s, and a table without rows or without wind.
GustScript read_gust_table(const std::string& path, double heading = 0);
GustScript read_gust_table(std::string_view text, const std::string& path, double heading = 0);

}  // namespace tremula
