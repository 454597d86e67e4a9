// A loop at a glance: twelve instants side by side.
#pragma once

#include "tremula/deformation/loop.hpp"

#include <string>

namespace tremula {

// PNG of four columns and three rows, each with its time, seen across the wind so that lean and sway show, or
// more from upwind where a sheet would turn its edge.
// The same loop gives the same bytes. Throws Error for poses that are not finite.
std::string encode_contact_sheet(const Loop& loop);

}  // namespace tremula
