// What a page reads that is no glTF (grass_page.hpp, drift_page.hpp), all of it little endian: four letters
// that say what it is, the length of the JSON as 32 bits, the JSON (padded with blanks to whole words), then
// the numbers that it refers to by their first byte ("first_byte").
#pragma once

#include "tremula/deformation/loop.hpp"
#include "tremula/wind/travelling_field.hpp"

#include <bit>
#include <cstring>
#include <string>
#include <string_view>
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

// Of a loop of that period [s].
nlohmann::ordered_json facts_json(const LoopFacts& facts, double period);

// Of a field of one layer: how the page looks it up (viewer/src/block.ts: Travelling).
nlohmann::ordered_json axes_json(const TravellingField& field);
// Its values, the first `kept` of the four numbers of each, 16 bits signed; the document says under `name`
// where they are and their step. Throws Error for a number that is not finite.
void append_field(const TravellingField& field, std::size_t kept, const char* name,
                  nlohmann::ordered_json& document, std::string& bytes);

std::string page_block(std::string_view letters, const nlohmann::ordered_json& document,
                       const std::string& numbers);

}  // namespace tremula
