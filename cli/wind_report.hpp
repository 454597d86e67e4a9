// Wind fields and what was measured of them as JSON.
#pragma once

#include "tremula/wind/field_statistics.hpp"

#include "common.hpp"

namespace tremula::cli {

Json describe(const WindGrid& grid);
Json describe(const FieldStatistics& statistics);  // {"rows", "bands", "spectra", "coherence"}

}  // namespace tremula::cli
