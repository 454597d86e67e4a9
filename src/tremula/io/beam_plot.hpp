// The shapes in which a uniform beam vibrates as one picture (F figure 4).
#pragma once

#include <string>

namespace tremula {

// SVG text: the first shapes of the clamped-free beam, scaled to 1 at their tips as F draws them, and dashed
// the polynomial that F offers for the first. Throws InputError unless 1 to 12 shapes are wanted.
std::string plot_beam_shapes(int count = 3);

}  // namespace tremula
