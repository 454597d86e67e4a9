// The wind field on a plane, by FFT in space and time (F section 3.4; design in the theory chapter). Per
// frequency bin a coherent field of unit spectrum, its rows scaled by sqrt(S(z, f)/(2T)), then one real
// series in time per point: exact spectra at every height, O(log) work per sample, and a loop that closes.
#pragma once

#include "tremula/wind/field.hpp"
#include "tremula/wind/turbulent_wind.hpp"

#include <array>
#include <functional>
#include <vector>

namespace tremula {

struct SynthesisOptions {
  // The plane repeats itself in y and z too, row z_count being row 0: for covering a landscape with one
  // field. The coherence then counts separations around the plane.
  bool tile = false;
  // Each row is scaled so that its variance, which bins from 1/T to half the sampling rate resolve in part
  // only, is the whole of the model's. Otherwise the spectrum is the model's.
  bool match_variance = false;
  // Root-coherence that may be lost to, or gained from, the far side of the periodic domain.
  double padding_tolerance = 0.005;
  std::function<void(double done)> progress = {};  // 0 … 1, from any thread; throw to cancel
};

// What came out, per component.
struct SynthesisReport {
  // Of the model's variance, the share in bins 1 … M/2 with the spectrum of that row (z_count).
  std::array<std::vector<double>, 3> resolved_share = {};
  std::array<double, 3> clipped_share = {};       // negative eigenvalues, in the bin where they are most
  std::array<double, 3> mean_clipped_share = {};  // over the bins, by their power in the middle row
  // The largest difference of the root-coherence from the model's within the plane, in the bins looked at:
  // the first of every domain size. 0 in tile mode, which has a coherence of its own.
  std::array<double, 3> coherence_error = {};
  int largest_rows = 0, largest_columns = 0;  // of the periodic domains
};

// The grid says where and when; its mean_speed and reference_height are taken from the wind. The mean is in
// u. Rows below lowest_spectrum_height take the spectrum there. Memory: the field and half of one component
// more. Throws InputError for a wind or a grid that cannot be.
WindField synthesise_wind(const TurbulentWind& wind, const WindGrid& grid,
                          const SynthesisOptions& options = {}, SynthesisReport* report = nullptr);

// Throws InputError for counts below 1, spacings that are not above 0, more than 2^31 points times steps, …
void check_wind_grid(const WindGrid& grid);

}  // namespace tremula
