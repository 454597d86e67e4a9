// Reads MATLAB 5 files (what MATLAB and SciPy save unless told otherwise; -v6 and -v7) with every count
// checked against the bytes that are there. libmatio does not check: on damaged files it loops for seconds,
// asks for terabytes, and in the HDF5 files of -v7.3 runs into memory that is not its own. Layout: "MAT-File
// Format", The MathWorks, chapter 1 (level 5).
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tremula {

// An array as it stands in the file; nothing is converted before it is asked for.
struct MatlabArray {
  std::string name;          // of a variable, else empty
  unsigned array_class = 0;  // mxDOUBLE_CLASS = 6 and so on
  bool is_complex = false;
  std::vector<std::size_t> dimensions;
  std::string_view body;  // what follows the name: elements of a numeric array, fields of a struct
  bool big_endian = false;

  bool is_cell() const { return array_class == 1; }
  bool is_struct() const { return array_class == 2; }
  bool is_single() const { return array_class == 7; }
  std::size_t size() const;  // product of the dimensions
};

struct MatlabFile {
  std::string path;                  // for messages
  std::deque<std::string> inflated;  // what the variables point into, beside the bytes given
  std::vector<MatlabArray> variables;

  const MatlabArray* find(std::string_view name) const;  // null where there is none
};

bool is_matlab_file(std::string_view bytes);

// The variables of a file, which point into `bytes`. Throws InputError for MATLAB 7.3 and for damage of any
// kind.
MatlabFile read_matlab_file(std::string_view bytes, const std::string& path);

// A field of the first element of a struct array; `where` is for messages ("tree.mat: QSM").
std::optional<MatlabArray> find_field(const MatlabArray& array, std::string_view name,
                                      const std::string& where);

// The first element of a cell array, where it has one.
std::optional<MatlabArray> first_cell(const MatlabArray& array, const std::string& where);

// What an array is, in words: "struct", "cell array", "text", "numbers".
const char* kind_of(const MatlabArray& array);

// The elements, column by column. Throws InputError unless the array is real, numeric or logical, and whole.
std::vector<double> numbers(const MatlabArray& array, const std::string& where);

}  // namespace tremula
