// The page (.html) of a meadow: one blade of every kind, drawn as often as it stands there, and the response
// of the blades to the wind as a texture. The graphics card does with them what pose_grass does, so that the
// page holds whole fields and closes with the loop.
//
// What the page reads (page_block.hpp), with the letters "TRMG":
// - blades: (4 x blades) of 32 bits, one word of all blades after the other; from the lowest bits,
//   x 16, y 16 | z 16, length 16 | azimuth 14, facing 10, width 8 | attached 10, kind 3, trajectory 4,
//   frequency class 2, stem 13. Feet in steps from the lowest one, lengths and widths in steps, angles in
//   parts of a turn; attached: 0 on the ground, else 1 + 1022 times where on the stem; stem: how many blades
//   before.
// - responses: (makes that move x samples x columns) of the angles along the wind and across, 16 bits signed
//   in steps of the make (GrassInWind::Follows).
// - bends: (entries of all kinds) of 12 directions in 16 bits signed, in parts of 32767 (BendTable).
// The JSON has what LoopFacts says, the steps, the axes of the field, and for every kind its skin, the
// lengths of its pieces and its makes.
#pragma once

#include "tremula/deformation/grass_pose.hpp"

#include <string>

namespace tremula {

// More make a page that browsers take minutes to open.
inline constexpr std::size_t most_blades_of_page = 1'500'000;
void check_blades_of_page(std::size_t count);  // throws InputError

// The same grass gives the same bytes. Throws InputError for more blades than most_blades_of_page, for blades
// in time (GrassMotion::in_time), for more than 8 kinds, for a blade farther than 8191 behind its stem and
// for numbers that are not finite.
std::string encode_grass(const GrassInWind& grass, const LoopFacts& facts);

// Throws Error as encode_html() does, and as encode_grass().
std::string encode_grass_page(const GrassInWind& grass, const LoopFacts& facts);

}  // namespace tremula
