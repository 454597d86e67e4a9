// A font of 5 x 8 pixels for labels on pictures: printable ASCII, one byte a column, lowest bit on top.
#pragma once

#include <array>
#include <cstdint>

namespace tremula {

inline constexpr int glyph_width = 5;
inline constexpr int glyph_height = 8;
using Glyph = std::array<std::uint8_t, glyph_width>;

// The glyph of a character; a box for anything that is not printable ASCII.
const Glyph& glyph(char character);

}  // namespace tremula
