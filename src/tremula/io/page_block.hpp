// What a page reads that is no glTF (grass_page.hpp, drift_page.hpp), all of it little endian: four letters
// that say what it is, the length of the JSON as 32 bits, the JSON (padded with blanks to whole words), then
// the numbers that it refers to by their first byte ("first_byte").
#pragma once

#include "tremula/deformation/loop.hpp"
#include "tremula/io/finite.hpp"
#include "tremula/wind/travelling_field.hpp"

#include <bit>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include <nlohmann/json.hpp>

namespace tremula {

static_assert(std::endian::native == std::endian::little);

template <class T>
void append_numbers(std::string& bytes, const std::vector<T>& values) {
  const std::size_t before = bytes.size();
  bytes.resize(before + values.size() * sizeof(T));
  if (!values.empty()) std::memcpy(bytes.data() + before, values.data(), values.size() * sizeof(T));
}

// The same, with where they are said in the document under `name`: the count of groups of `width`, and the
// first byte. Throws Error for a float that is not finite.
template <class T>
void append_part(const std::vector<T>& values, std::size_t width, const char* name,
                 nlohmann::ordered_json& document, std::string& bytes) {
  if constexpr (std::is_same_v<T, float>)
    check_finite("page: " + std::string(name), std::span<const float>(values));
  document[name] = {{"count", values.size() / width}, {"first_byte", bytes.size()}};
  append_numbers(bytes, values);
}

// Of a loop of that period [s].
nlohmann::ordered_json facts_json(const LoopFacts& facts, double period);

// How the page looks up a field that travels to that heading [degrees, from x towards y] with that speed
// [m/s] (viewer/src/block.ts: Travelling). Throws Error for a number that is not finite.
nlohmann::ordered_json axes_json(const TimeAxis& loop, const FieldPlane& plane, double heading, double speed);
// Its values, the first `kept` of the four numbers of each, 16 bits signed; the document says under `name`
// where they are and their step. Throws Error for a number that is not finite.
void append_field(const TravellingField& field, std::size_t kept, const char* name,
                  nlohmann::ordered_json& document, std::string& bytes);

std::string page_block(std::string_view letters, const nlohmann::ordered_json& document,
                       const std::string& numbers);

}  // namespace tremula
