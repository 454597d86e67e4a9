// What every user of a WindField may rely on.
#pragma once

#include "tremula/wind/field.hpp"

namespace tremula {

// Throws InputError unless counts are at least 1 (a tower may have none), spacings, step and speed are
// numbers that make a grid, and every component has as many values as the counts say. Does not look at the
// values.
void check_wind_field(const WindField& field);

}  // namespace tremula
