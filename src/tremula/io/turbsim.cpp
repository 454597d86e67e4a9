#include "tremula/io/turbsim.hpp"

#include "tremula/base/error.hpp"
#include "tremula/io/atomic_file.hpp"
#include "tremula/io/finite.hpp"
#include "tremula/wind/check_field.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <span>

namespace tremula {
namespace {

static_assert(std::endian::native == std::endian::little, "the files are little endian");

constexpr std::int16_t id_of_one_run = 7, id_of_a_loop = 8;
constexpr std::size_t header_size = 70;
constexpr std::int32_t longest_text = 10'000;  // TurbSim itself writes at most 200
constexpr double absurd = 1e9;                 // metres, seconds or metres a second
constexpr double lowest_integer = std::numeric_limits<std::int16_t>::min(),
                 highest_integer = std::numeric_limits<std::int16_t>::max();

std::string text_of(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", value);
  return text;
}

// ---- Reading

struct Header {
  std::string_view bytes;
  const std::string& name;
  std::size_t at = 0;

  template <typename T>
  T next() {
    T value;
    std::memcpy(&value, bytes.data() + at, sizeof value);
    at += sizeof value;
    return value;
  }

  // What was just read is wrong.
  [[noreturn]] void refuse(const char* what, std::size_t size, const std::string& found,
                           const std::string& wanted) const {
    throw InputError(name + ": " + what + " (byte " + std::to_string(at - size) + ")", found, wanted);
  }

  std::int32_t count(const char* what, std::int32_t least) {
    const auto value = next<std::int32_t>();
    if (value < least) refuse(what, 4, std::to_string(value), std::to_string(least) + " or more");
    return value;
  }

  float number(const char* what, bool must_be_positive = false) {
    const auto value = next<float>();
    if (!std::isfinite(value)) refuse(what, 4, text_of(value), "a finite number");
    if (std::abs(value) > absurd) refuse(what, 4, text_of(value), "at most " + text_of(absurd));
    if (must_be_positive && value <= 0) refuse(what, 4, text_of(value), "a number above 0");
    return value;
  }

  float scale(const char* what, bool may_be_zero) {
    const auto value = next<float>();
    if (!std::isfinite(value)) refuse(what, 4, text_of(value), "a finite number");
    if (value == 0 && !may_be_zero) refuse(what, 4, text_of(value), "a number other than 0");
    return value;
  }
};

void check_range(const Header& header, const TurbSimFile& file, std::size_t c) {
  const double largest = std::max(std::abs(file.velocity(std::numeric_limits<std::int16_t>::min(), c)),
                                  std::abs(file.velocity(std::numeric_limits<std::int16_t>::max(), c)));
  if (largest <= absurd) return;
  throw InputError(
      header.name + ": slope and offset of " + "uvw"[c] + " (byte " + std::to_string(42 + 8 * c) + ")",
      "speeds up to " + text_of(largest) + " m/s", "at most " + text_of(absurd));
}

// ---- Writing

template <typename T>
void append(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

std::string header_bytes(const TurbSimFile& file) {
  const std::array<float, 6> numbers{file.z_spacing, file.y_spacing,  file.step,
                                     file.hub_speed, file.hub_height, file.bottom};
  for (const std::span<const float> each :
       {std::span<const float>(numbers), std::span<const float>(file.slope),
        std::span<const float>(file.offset)})
    check_finite("TurbSim file: header", each);
  std::string bytes;
  append(bytes, file.periodic ? id_of_a_loop : id_of_one_run);
  for (const std::int32_t count : {file.z_count, file.y_count, file.tower_count, file.step_count})
    append(bytes, count);
  for (const float number : numbers) append(bytes, number);
  for (std::size_t c = 0; c < 3; ++c) {
    append(bytes, file.slope[c]);
    append(bytes, file.offset[c]);
  }
  append(bytes, static_cast<std::int32_t>(file.text.size()));
  return bytes + file.text;
}

std::string_view bytes_of(const std::int16_t* values, std::size_t count) {
  return {reinterpret_cast<const char*>(values), 2 * count};
}

struct Range {
  float low, high;
};

// Floats in the order of their values are these integers in order: integers have a minimum and a maximum that
// vectorise, and NaN lies beyond infinity instead of comparing false with everything.
std::int32_t ordered(float value) {
  const auto bits = std::bit_cast<std::int32_t>(value);
  return bits ^ ((bits >> 31) & 0x7FFFFFFF);
}

float from_ordered(std::int32_t order) { return std::bit_cast<float>(order ^ ((order >> 31) & 0x7FFFFFFF)); }

Range range_of(const std::vector<float>& grid, const std::vector<float>& tower, char component) {
  std::int32_t low = std::numeric_limits<std::int32_t>::max(),
               high = std::numeric_limits<std::int32_t>::min();
  for (const std::vector<float>* values : {&grid, &tower}) {
    for (const float value : *values) {
      const std::int32_t order = ordered(value);
      low = std::min(low, order);
      high = std::max(high, order);
    }
  }
  const Range range{from_ordered(low), from_ordered(high)};
  for (const float end : {range.low, range.high}) {
    if (!(std::abs(end) <= absurd)) {
      throw InputError(std::string("wind field: ") + component, text_of(end),
                       "finite values of at most " + text_of(absurd) + " m/s");
    }
  }
  return range;
}

struct Scale {
  float slope, offset;
};

Scale scale_for(Range range) {
  const double width = static_cast<double>(range.high) - static_cast<double>(range.low);
  // Where all values are the same, integer 0 stands for it. TurbSim puts it at the lowest integer, where the
  // offset in single precision leaves an error of 2 mm/s.
  if (width == 0) return {1, -range.low};
  // Beyond this slope single precision could not tell the integers of a wind of 1 m/s apart anyway.
  constexpr double steepest = 1e12;
  const auto slope = static_cast<float>(std::min((highest_integer - lowest_integer) / width, steepest));
  return {slope,
          static_cast<float>(lowest_integer - static_cast<double>(slope) * static_cast<double>(range.low))};
}

// Rounded to the nearest integer, ties to even, and kept within 16 bits: adding 1.5 * 2^23 leaves the integer
// in the low bits of the sum, which any vector unit can do.
void to_integers(const float* values, std::size_t count, Scale scale, std::int16_t* integers) {
  constexpr float shift = 12582912, low = lowest_integer, high = highest_integer;
  for (std::size_t i = 0; i < count; ++i) {
    float scaled = values[i] * scale.slope + scale.offset;
    scaled = scaled < low ? low : scaled;
    scaled = scaled > high ? high : scaled;
    integers[i] = static_cast<std::int16_t>(std::bit_cast<std::int32_t>(scaled + shift));
  }
}

}  // namespace

std::size_t TurbSimFile::values_per_step() const {
  return 3 * (static_cast<std::size_t>(z_count) * static_cast<std::size_t>(y_count) +
              static_cast<std::size_t>(tower_count));
}

double TurbSimFile::velocity(std::int16_t value, std::size_t component) const {
  return (value - static_cast<double>(offset[component])) / static_cast<double>(slope[component]);
}

double TurbSimFile::tower_height(int k) const {
  return static_cast<double>(bottom) - k * static_cast<double>(z_spacing);
}

TurbSimFile parse_turbsim(std::string_view bytes, const std::string& name) {
  Header header{bytes, name};
  const auto too_short = [&] {
    return InputError(name, std::to_string(bytes.size()) + " bytes",
                      "the " + std::to_string(header_size) + " with which a TurbSim file begins");
  };
  if (bytes.size() < 2) throw too_short();
  const auto id = header.next<std::int16_t>();
  if (id != id_of_one_run && id != id_of_a_loop)
    header.refuse("kind of file", 2, std::to_string(id), "7 (TurbSim, one run) or 8 (TurbSim, periodic)");
  if (bytes.size() < header_size) throw too_short();

  TurbSimFile file;
  file.periodic = id == id_of_a_loop;
  file.z_count = header.count("rows", 1);
  file.y_count = header.count("points across", 1);
  file.tower_count = header.count("points of the tower", 0);
  file.step_count = header.count("steps", 1);
  file.z_spacing = header.number("spacing of the rows", file.z_count > 1 || file.tower_count > 0);
  file.y_spacing = header.number("spacing across", file.y_count > 1);
  file.step = header.number("step", true);
  file.hub_speed = header.number("mean speed at hub height");
  if (file.hub_speed < 0) header.refuse("mean speed at hub height", 4, text_of(file.hub_speed), "0 or more");
  file.hub_height = header.number("hub height");
  file.bottom = header.number("height of the lowest row");
  constexpr const char* slopes[] = {"slope of u", "slope of v", "slope of w"};
  constexpr const char* offsets[] = {"offset of u", "offset of v", "offset of w"};
  for (std::size_t c = 0; c < 3; ++c) {
    file.slope[c] = header.scale(slopes[c], false);
    file.offset[c] = header.scale(offsets[c], true);
    check_range(header, file, c);
  }
  const std::int32_t text_size = header.count("length of the text", 0);
  if (text_size > longest_text)
    header.refuse("length of the text", 4, std::to_string(text_size),
                  "at most " + std::to_string(longest_text));

  // Counts up to 2^31 each: their products are compared without being formed where they might overflow.
  const std::size_t front = header_size + static_cast<std::size_t>(text_size);
  const std::size_t points = static_cast<std::size_t>(file.z_count) * static_cast<std::size_t>(file.y_count) +
                             static_cast<std::size_t>(file.tower_count);
  const auto steps = static_cast<std::size_t>(file.step_count);
  const bool fits = bytes.size() >= front && (bytes.size() - front) % 6 == 0 &&
                    (bytes.size() - front) / 6 % points == 0 && (bytes.size() - front) / 6 / points == steps;
  if (!fits) {
    const double wanted =
        static_cast<double>(front) + 6.0 * static_cast<double>(points) * static_cast<double>(steps);
    char size[32];
    std::snprintf(size, sizeof size, "%.0f", wanted);
    throw InputError(name, std::to_string(bytes.size()) + " bytes",
                     std::string(wanted < 1e15 ? size : text_of(wanted)) + " for " +
                         std::to_string(file.z_count) + " x " + std::to_string(file.y_count) + " grid and " +
                         std::to_string(file.tower_count) + " tower points, " +
                         std::to_string(file.step_count) + " steps and a text of " +
                         std::to_string(text_size));
  }
  file.text = bytes.substr(header_size, static_cast<std::size_t>(text_size));
  file.values.resize(3 * points * steps);
  std::memcpy(file.values.data(), bytes.data() + front, bytes.size() - front);
  return file;
}

TurbSimFile read_turbsim(const std::string& path) { return parse_turbsim(read_file(path), path); }

WindField wind_field(const TurbSimFile& file) {
  WindField field;
  field.grid = {.y_count = file.y_count,
                .z_count = file.z_count,
                .step_count = file.step_count,
                .y_spacing = file.y_spacing,
                .z_spacing = file.z_spacing,
                .bottom = file.bottom,
                .step = file.step,
                .mean_speed = file.hub_speed,
                .reference_height = file.hub_height,
                .periodic = file.periodic};
  field.tower_count = file.tower_count;
  const std::size_t points = field.grid.point_count(), towers = static_cast<std::size_t>(file.tower_count),
                    per_step = file.values_per_step();
  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<float>&grid = field.velocity[c], &tower = field.tower[c];
    grid.resize(points * static_cast<std::size_t>(file.step_count));
    tower.resize(towers * static_cast<std::size_t>(file.step_count));
    for (std::size_t t = 0; t < static_cast<std::size_t>(file.step_count); ++t) {
      const std::int16_t* values = file.values.data() + t * per_step + c;
      for (std::size_t p = 0; p < points; ++p)
        grid[t * points + p] = static_cast<float>(file.velocity(values[3 * p], c));
      for (std::size_t k = 0; k < towers; ++k)
        tower[t * towers + k] = static_cast<float>(file.velocity(values[3 * (points + k)], c));
    }
  }
  return field;
}

void write_turbsim(const std::string& path, const TurbSimFile& file) {
  AtomicFile out(path);
  out.write(header_bytes(file));
  out.write(bytes_of(file.values.data(), file.values.size()));
  out.commit();
}

void write_turbsim(AtomicFile& out, const WindField& field, std::string_view text) {
  check_wind_field(field);
  const WindGrid& grid = field.grid;
  TurbSimFile file{.periodic = grid.periodic,
                   .z_count = grid.z_count,
                   .y_count = grid.y_count,
                   .tower_count = field.tower_count,
                   .step_count = grid.step_count,
                   .z_spacing = static_cast<float>(grid.z_spacing),
                   .y_spacing = static_cast<float>(grid.y_spacing),
                   .step = static_cast<float>(grid.step),
                   .hub_speed = static_cast<float>(grid.mean_speed),
                   .hub_height = static_cast<float>(grid.reference_height),
                   .bottom = static_cast<float>(grid.bottom),
                   .text = std::string(text.substr(0, static_cast<std::size_t>(longest_text))),
                   .values = {}};
  std::array<Scale, 3> scales;
  for (std::size_t c = 0; c < 3; ++c) {
    scales[c] = scale_for(range_of(field.velocity[c], field.tower[c], "uvw"[c]));
    file.slope[c] = scales[c].slope;
    file.offset[c] = scales[c].offset;
  }
  // A few steps at a time, so that the integers of a block never leave the cache on their way to the file.
  const std::size_t points = grid.point_count(), towers = static_cast<std::size_t>(field.tower_count),
                    per_step = points + towers, steps = static_cast<std::size_t>(grid.step_count),
                    block = std::clamp<std::size_t>(16384 / per_step, 1, steps);
  std::vector<std::int16_t> together(3 * per_step * block), one(std::max(points * block, towers));
  out.write(header_bytes(file));
  for (std::size_t first = 0; first < steps; first += block) {
    const std::size_t count = std::min(block, steps - first);
    for (std::size_t c = 0; c < 3; ++c) {
      to_integers(field.velocity[c].data() + first * points, count * points, scales[c], one.data());
      for (std::size_t t = 0; t < count; ++t) {
        std::int16_t* step = together.data() + 3 * t * per_step + c;
        for (std::size_t p = 0; p < points; ++p) step[3 * p] = one[t * points + p];
      }
      if (towers == 0) continue;
      for (std::size_t t = 0; t < count; ++t) {
        std::int16_t* step = together.data() + 3 * (t * per_step + points) + c;
        to_integers(field.tower[c].data() + (first + t) * towers, towers, scales[c], one.data());
        for (std::size_t k = 0; k < towers; ++k) step[3 * k] = one[k];
      }
    }
    out.write(bytes_of(together.data(), 3 * per_step * count));
  }
}

void write_turbsim(const std::string& path, const WindField& field, std::string_view text) {
  AtomicFile out(path);
  write_turbsim(out, field, text);
  out.commit();
}

}  // namespace tremula
