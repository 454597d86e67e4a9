// The line of names above a table, whichever program wrote it: what its columns are called and what stands
// between them.
#pragma once

#include "tremula/io/text_table.hpp"

#include <cstddef>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tremula {

// A line that names columns: its first field that holds anything is no number.
bool is_table_header(std::string_view line);

struct TableHeader {
  char delimiter = ' ';            // ',', ';', tab, or ' ' for runs of blanks
  std::vector<std::string> shown;  // the names as they stand, without quotes, fit for messages
  std::vector<std::string> plain;  // small letters and digits of them: start.x, startX and start_x are one

  // The first column that has one of these plain names.
  std::optional<std::size_t> find(std::initializer_list<std::string_view> names) const;
};

TableHeader parse_table_header(std::string_view line);

// The fields of a line below the header; quotes around a field are cut off.
Fields split_row(std::string_view line, char delimiter);

}  // namespace tremula
