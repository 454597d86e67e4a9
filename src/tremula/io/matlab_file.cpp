#include "tremula/io/matlab_file.hpp"

#include "tremula/base/error.hpp"
#include "tremula/io/text_table.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

#include <zlib.h>

namespace tremula {
namespace {

// What one file may unpack to: a thousand bytes for each of half a million cylinders. Numbers that were
// measured pack to a half or a tenth; what unpacks to a hundred times its size is no model of a tree.
constexpr std::size_t most_inflated = std::size_t{1} << 29;
constexpr std::size_t always_inflated = std::size_t{1} << 26;
constexpr std::size_t most_times_packed = 100;
constexpr std::size_t most_elements = std::size_t{1} << 40;

enum ElementType : std::uint32_t {
  mi_int8 = 1,
  mi_uint8 = 2,
  mi_int16 = 3,
  mi_uint16 = 4,
  mi_int32 = 5,
  mi_uint32 = 6,
  mi_single = 7,
  mi_double = 9,
  mi_int64 = 12,
  mi_uint64 = 13,
  mi_matrix = 14,
  mi_compressed = 15,
};

template <typename T>
T load(const char* bytes, bool big_endian) {
  char raw[sizeof(T)];
  std::memcpy(raw, bytes, sizeof(T));
  if (big_endian != (std::endian::native == std::endian::big)) std::reverse(raw, raw + sizeof(T));
  T value;
  std::memcpy(&value, raw, sizeof(T));
  return value;
}

struct Element {
  std::uint32_t type = 0;
  std::string_view data;
};

// Takes one element from the front of `rest`.
Element take_element(std::string_view& rest, bool big_endian, const std::string& where) {
  if (rest.size() < 8) {
    throw InputError(where, "ends where the next of its elements should begin", "a whole file");
  }
  const auto first = load<std::uint32_t>(rest.data(), big_endian);
  if (first >> 16 != 0) {  // small: type, size and up to four bytes in one word of eight
    const std::uint32_t size = first >> 16;
    if (size > 4)
      throw InputError(where, "a small element of " + std::to_string(size) + " bytes", "at most 4");
    const Element element{first & 0xFFFF, rest.substr(4, size)};
    rest.remove_prefix(8);
    return element;
  }
  const auto size = load<std::uint32_t>(rest.data() + 4, big_endian);
  rest.remove_prefix(8);
  if (size > rest.size()) {
    throw InputError(
        where,
        "an element of " + std::to_string(size) + " bytes where " + std::to_string(rest.size()) + " are left",
        "a whole file");
  }
  const Element element{first, rest.substr(0, size)};
  const std::size_t padded = first == mi_compressed ? size : (std::size_t{size} + 7) / 8 * 8;
  rest.remove_prefix(std::min(padded, rest.size()));
  return element;
}

void want_type(const Element& element, std::uint32_t type, const char* what, const std::string& where) {
  if (element.type == type) return;
  throw InputError(where, std::string(what) + " of element type " + std::to_string(element.type),
                   "type " + std::to_string(type));
}

// Unpacks one element. It begins with its own size, so that no more memory is taken than it needs.
std::string inflate_element(std::string_view packed, bool big_endian, std::size_t budget,
                            const std::string& where) {
  z_stream stream{};
  if (inflateInit(&stream) != Z_OK) throw Error(where + ": zlib cannot start");
  struct End {
    z_stream* stream;
    ~End() { inflateEnd(stream); }
  } const end{&stream};
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
  stream.avail_in = static_cast<uInt>(packed.size());

  constexpr std::size_t tag = 8;
  std::string out(tag, '\0');
  std::size_t filled = 0;
  // False at the end of the data.
  const auto inflate_to = [&](char* to, std::size_t room) {
    stream.next_out = reinterpret_cast<Bytef*>(to);
    stream.avail_out = static_cast<uInt>(room);
    const int result = inflate(&stream, Z_NO_FLUSH);
    if (result == Z_OK || result == Z_STREAM_END) return result == Z_OK;
    throw InputError(
        where, result == Z_BUF_ERROR ? "compressed data that break off" : "compressed data that are damaged",
        "a whole file");
  };
  const auto fill = [&] {
    bool more = true;
    while (filled < out.size() && more) {
      more = inflate_to(out.data() + filled, out.size() - filled);
      filled = out.size() - stream.avail_out;
    }
    out.resize(filled);
  };
  fill();
  if (out.size() < tag) return out;
  if (load<std::uint32_t>(out.data(), big_endian) >> 16 != 0) return out;  // a small element is whole
  const std::size_t size = load<std::uint32_t>(out.data() + 4, big_endian);
  if (tag + size > budget || tag + size > std::max(always_inflated, most_times_packed * packed.size())) {
    throw InputError(where, std::to_string(packed.size()) + " bytes that unpack to " + std::to_string(size),
                     "at most " + std::to_string(std::min(
                                      budget, std::max(always_inflated, most_times_packed * packed.size()))));
  }
  out.resize(tag + size);
  fill();
  char padding[16];
  inflate_to(padding, sizeof padding);  // up to the check sum, which is compared there
  return out;
}

MatlabArray parse_array(std::string_view data, bool big_endian, const std::string& where) {
  MatlabArray array;
  array.big_endian = big_endian;
  if (data.empty()) {  // how an empty field is written
    array.array_class = 6;
    array.dimensions = {0, 0};
    return array;
  }
  const Element flags = take_element(data, big_endian, where);
  want_type(flags, mi_uint32, "array flags", where);
  if (flags.data.size() != 8) {
    throw InputError(where, std::to_string(flags.data.size()) + " bytes of array flags", "8");
  }
  const auto bits = load<std::uint32_t>(flags.data.data(), big_endian);
  array.array_class = bits & 0xFF;
  array.is_complex = (bits & 0x0800) != 0;
  if (array.array_class > 16) return array;  // objects of newer MATLAB, laid out otherwise; never asked for

  const Element dimensions = take_element(data, big_endian, where);
  want_type(dimensions, mi_int32, "dimensions", where);
  std::size_t product = 1;
  for (std::size_t i = 0; i + 4 <= dimensions.data.size(); i += 4) {
    const auto n = load<std::int32_t>(dimensions.data.data() + i, big_endian);
    if (n < 0) throw InputError(where, "dimension " + std::to_string(n), "0 or more");
    array.dimensions.push_back(static_cast<std::size_t>(n));
    if (n > 0 && product > most_elements / static_cast<std::size_t>(n)) {
      throw InputError(where, "dimensions with a product above 2^40", "what fits into the file");
    }
    product *= static_cast<std::size_t>(n);
  }
  const Element name = take_element(data, big_endian, where);
  want_type(name, mi_int8, "name", where);
  array.name = name.data;
  array.body = data;
  return array;
}

template <typename T>
std::vector<double> convert(std::string_view data, bool big_endian) {
  std::vector<double> values(data.size() / sizeof(T));
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = static_cast<double>(load<T>(data.data() + i * sizeof(T), big_endian));
  }
  return values;
}

std::size_t bytes_of(std::uint32_t type) {
  switch (type) {
    case mi_int8:
    case mi_uint8:
      return 1;
    case mi_int16:
    case mi_uint16:
      return 2;
    case mi_int32:
    case mi_uint32:
    case mi_single:
      return 4;
    case mi_double:
    case mi_int64:
    case mi_uint64:
      return 8;
    default:
      return 0;
  }
}

}  // namespace

std::size_t MatlabArray::size() const {
  std::size_t product = 1;
  for (const std::size_t n : dimensions) product *= n;
  return product;
}

const MatlabArray* MatlabFile::find(std::string_view name) const {
  const auto found =
      std::find_if(variables.begin(), variables.end(), [&](const MatlabArray& a) { return a.name == name; });
  return found == variables.end() ? nullptr : &*found;
}

bool is_matlab_file(std::string_view bytes) {
  if (bytes.starts_with("MATLAB ") || bytes.starts_with("\x89HDF")) return true;
  if (bytes.size() < 128) return false;
  const std::string_view end = bytes.substr(126, 2);
  return end == "IM" || end == "MI";
}

MatlabFile read_matlab_file(std::string_view bytes, const std::string& path) {
  const auto reject_hdf5 = [&] {
    throw InputError(path, "a MATLAB 7.3 (HDF5) file", "one saved with save(..., '-v7')");
  };
  if (bytes.starts_with("\x89HDF")) reject_hdf5();
  if (bytes.size() < 128) {
    throw InputError(path, counted(bytes.size(), "byte"), "the 128 with which a MATLAB file begins");
  }
  const bool big_endian = bytes.substr(126, 2) == "MI";
  if (!big_endian && bytes.substr(126, 2) != "IM") {
    throw InputError(path, "a MATLAB header without its mark of byte order", "IM or MI at byte 126");
  }
  const auto version = load<std::uint16_t>(bytes.data() + 124, big_endian);
  if (version == 0x0200) reject_hdf5();
  if (version != 0x0100)
    throw InputError(path, "MATLAB file version " + std::to_string(version), "256 (level 5)");

  MatlabFile file{path, {}, {}};
  std::size_t inflated = 0;
  std::string_view rest = bytes.substr(128);
  while (!rest.empty()) {
    const std::string where = path + ": variable " + std::to_string(file.variables.size() + 1);
    Element element = take_element(rest, big_endian, where);
    if (element.type == mi_compressed) {
      file.inflated.push_back(inflate_element(element.data, big_endian, most_inflated - inflated, where));
      inflated += file.inflated.back().size();
      std::string_view unpacked = file.inflated.back();
      element = take_element(unpacked, big_endian, where);
    }
    want_type(element, mi_matrix, "an array", where);
    file.variables.push_back(parse_array(element.data, big_endian, where));
  }
  return file;
}

std::optional<MatlabArray> find_field(const MatlabArray& array, std::string_view name,
                                      const std::string& where) {
  if (!array.is_struct()) {
    throw InputError(where, "an array of class " + std::to_string(array.array_class), "a struct (class 2)");
  }
  std::string_view rest = array.body;
  const Element width = take_element(rest, array.big_endian, where);
  want_type(width, mi_int32, "length of field names", where);
  const Element names = take_element(rest, array.big_endian, where);
  want_type(names, mi_int8, "field names", where);
  const auto n = width.data.size() == 4 ? load<std::int32_t>(width.data.data(), array.big_endian) : 0;
  if (n <= 0) throw InputError(where, "field names of length " + std::to_string(n), "at least 1");
  if (array.size() == 0) return {};
  for (std::size_t at = 0; at + static_cast<std::size_t>(n) <= names.data.size();
       at += static_cast<std::size_t>(n)) {
    const Element value = take_element(rest, array.big_endian, where);
    const std::string_view padded = names.data.substr(at, static_cast<std::size_t>(n));
    if (padded.substr(0, padded.find('\0')) != name) continue;
    want_type(value, mi_matrix, "a field", where);
    return parse_array(value.data, array.big_endian, where + "." + std::string(name));
  }
  return {};
}

std::optional<MatlabArray> first_cell(const MatlabArray& array, const std::string& where) {
  if (array.size() == 0) return {};
  std::string_view rest = array.body;
  const Element element = take_element(rest, array.big_endian, where);
  want_type(element, mi_matrix, "a cell", where);
  return parse_array(element.data, array.big_endian, where);
}

const char* kind_of(const MatlabArray& array) {
  switch (array.array_class) {
    case 1:
      return "a cell array";
    case 2:
      return "a struct";
    case 4:
      return "text";
    default:
      return array.array_class >= 6 && array.array_class <= 15 ? "numbers" : "an object or table";
  }
}

std::vector<double> numbers(const MatlabArray& array, const std::string& where) {
  if (array.array_class < 6 || array.array_class > 15 || array.is_complex) {
    throw InputError(
        where,
        array.is_complex ? "complex numbers" : "an array of class " + std::to_string(array.array_class),
        "real numbers (class 6 to 15)");
  }
  if (array.size() == 0) return {};
  std::string_view rest = array.body;
  const Element element = take_element(rest, array.big_endian, where);
  const std::size_t width = bytes_of(element.type);
  if (width == 0)
    throw InputError(where, "numbers of element type " + std::to_string(element.type), "a type of number");
  if (element.data.size() != width * array.size()) {
    throw InputError(where, std::to_string(element.data.size()) + " bytes of numbers",
                     std::to_string(width * array.size()) + " by its dimensions");
  }
  switch (element.type) {
    case mi_int8:
      return convert<std::int8_t>(element.data, array.big_endian);
    case mi_uint8:
      return convert<std::uint8_t>(element.data, array.big_endian);
    case mi_int16:
      return convert<std::int16_t>(element.data, array.big_endian);
    case mi_uint16:
      return convert<std::uint16_t>(element.data, array.big_endian);
    case mi_int32:
      return convert<std::int32_t>(element.data, array.big_endian);
    case mi_uint32:
      return convert<std::uint32_t>(element.data, array.big_endian);
    case mi_single:
      return convert<float>(element.data, array.big_endian);
    case mi_int64:
      return convert<std::int64_t>(element.data, array.big_endian);
    case mi_uint64:
      return convert<std::uint64_t>(element.data, array.big_endian);
    default:
      return convert<double>(element.data, array.big_endian);
  }
}

}  // namespace tremula
