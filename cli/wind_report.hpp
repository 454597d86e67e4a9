// Wind fields and what was measured of them as JSON.
#pragma once

#include "tremula/io/wind_plot.hpp"
#include "tremula/io/wind_verdict.hpp"
#include "tremula/wind/synthesis.hpp"

#include "common.hpp"

namespace tremula::cli {

Json describe(const WindGrid& grid);

// {"rows", "bands", "spectra", "coherence"}: measured, and beside it the target where there is one.
Json describe(const FieldStatistics& statistics, const WindTargets& targets);

Json describe(const WindVerdict& verdict);

// Resolved shares are those of a row.
Json describe(const SynthesisReport& report, std::size_t row);

}  // namespace tremula::cli
