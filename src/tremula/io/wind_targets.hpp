// What a field of a given wind should measure: the curves to hold against its statistics.
#pragma once

#include "tremula/io/wind_plot.hpp"
#include "tremula/wind/synthesis.hpp"
#include "tremula/wind/turbulent_wind.hpp"

namespace tremula {

// On the heights, bands and separations of the statistics of a field on that grid. Spectra are averaged over
// the same bins; the root-coherence is the ratio of the same sums over the bins of a band, with the powers of
// the middle row, along and across the wind of its own height. The deviation is that of the bins which the
// grid's steps have, of all of them together; for other Match than spectrum, that of the whole model (at the
// hub). u and v are those of the plane also where the wind veers.
WindTargets wind_targets(const TurbulentWind& wind, const WindGrid& grid, const FieldStatistics& statistics,
                         Match match = Match::spectrum);

}  // namespace tremula
