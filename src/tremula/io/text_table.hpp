// Rows of numbers in text files from strangers: lines, fields, and the error that says where and what.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>

namespace tremula {

// The largest number a reader takes for a coordinate or a size [m]: well past the size of the Earth, and
// small enough for every product of lengths that follows to stay finite.
inline constexpr double largest_size = 1e9;
// The smallest it takes for a radius [m]: a hundredth of an atom, and large enough for 1/r^4 to stay finite.
inline constexpr double smallest_size = 1e-12;

// The branches a reader takes from one file: six unknowns each stay far below the range of int.
inline constexpr std::size_t most_branches = 50'000'000;

// Walks over the lines of a text, whatever ends them: \n, \r\n or \r. Blanks around a line are cut off.
struct TextLines {
  std::string_view rest;
  std::size_t number = 0;  // of the line given last, from 1

  bool next(std::string_view& line);
};

// The fields of one line. More than `at` holds are counted but not kept.
struct Fields {
  std::array<std::string_view, 64> at;
  std::size_t count = 0;
};
Fields split_at_blanks(std::string_view line);           // at runs of blanks, commas and semicolons
Fields split_at(std::string_view line, char delimiter);  // blanks and quotes around a field are cut off

// True where the field is a number and nothing else; "nan" and what overflows count as numbers that are not
// finite.
bool parse_number(std::string_view field, double& value);

// True up to 2^53: beyond, a double no longer tells whole numbers apart.
bool is_whole_number(double value);

// What stood in a file, fit for a one-line message: no control characters, at most 40 characters.
std::string shown(std::string_view field);
std::string printable(std::string text);  // the whole of it: ? for what is no printable ASCII
std::string shown(double value);          // as many digits as it takes to tell it from its neighbours
std::string rounded(double value);        // six digits, for what was computed
std::string counted(std::size_t count, const std::string& what);  // "1 column", "2 columns"

// One line of a table, and the errors about it: "tree.swc:12: radius is -0.01, wanted a number above 0".
struct TableRow {
  const std::string& path;
  std::size_t line;
  const Fields& fields;

  std::string place() const;
  double number(std::size_t column, const char* name) const;  // any number, NaN too
  double finite(std::size_t column, const char* name) const;
  double coordinate(std::size_t column, const char* name) const;  // within largest_size of 0
  double positive(std::size_t column, const char* name) const;    // from smallest_size to largest_size
  long long integer(std::size_t column, const char* name) const;  // also as 12.0 or 1.2e1
  [[noreturn]] void reject(std::size_t column, const char* name, const std::string& wanted) const;
};

}  // namespace tremula
