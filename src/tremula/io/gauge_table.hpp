// What gauges on a plant read, as text: one row per frame and gauge.
#pragma once

#include "tremula/dynamics/gauge.hpp"

#include <span>
#include <string>

namespace tremula {

// Columns frame,time_s,gauge,bending_moment_n_m,along_n_m,across_n_m,shear_n,axial_n,torsion_n_m,strain
// (GaugeSeries). Frames are samples of the loop, 0 … M-1 (M is frame 0 again). Numbers are written so that
// reading gives back the same double. Throws InputError for a frame below 0 or above M, for series of
// different lengths or periods, and for names that a table cannot hold.
std::string encode_gauge_table(std::span<const GaugeSeries> gauges, std::span<const int> frames);

}  // namespace tremula
