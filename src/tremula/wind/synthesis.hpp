// The wind field on a plane, by FFT in space and time (F section 3.4; design in the theory chapter). Per
// frequency bin a coherent field of unit spectrum, its rows scaled by sqrt(S(z, f)/(2T)), then one real
// series in time per point: exact spectra at every height, O(log) work per sample, and a loop that closes.
#pragma once

#include "tremula/wind/field.hpp"
#include "tremula/wind/turbulent_wind.hpp"

#include <array>
#include <functional>
#include <string>
#include <vector>

namespace tremula {

// What the deviations of a loop are to be. The spectrum of the model over the bins that a loop has, from 1/T
// to half the sampling rate, holds a part of its variance only.
enum class Match {
  spectrum,  // that part: every bin has the power of the model
  variance,  // the whole, in the mean over seeds: each row and component times one number
  hub,  // the whole, in this sample at the grid point nearest the reference height and y = 0: each component
        // times one number, everywhere
  points,  // the whole, in this sample at every point: each times a number of its own
};

// "spectrum", "variance", "hub", "points". Throws InputError for other names.
Match match_named(const std::string& name);

struct SynthesisOptions {
  // The plane repeats itself in y and z too, row z_count being row 0: for covering a landscape with one
  // field. The coherence then counts separations around the plane.
  bool tile = false;
  Match match = Match::spectrum;
  // Points of a tower (WindField::tower): the first at the lowest row, y = 0, the others below it. Not for
  // tiles.
  int tower_count = 0;
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
  // By what Match multiplied the fluctuation, the least and the most of all points.
  std::array<std::array<double, 2>, 3> match_factor = {{{1, 1}, {1, 1}, {1, 1}}};
};

// The grid says where and when; its mean_speed and reference_height are taken from the wind. The mean is in
// u; where the wind veers, its mean and its fluctuations turn together from u towards v. Rows below
// lowest_spectrum_height take the spectrum there. Memory: the field and half of one component more. Throws
// InputError for a wind or a grid that cannot be, for a tower that reaches the ground, and for Match::hub
// where the reference height lies beyond the grid.
WindField synthesise_wind(const TurbulentWind& wind, const WindGrid& grid,
                          const SynthesisOptions& options = {}, SynthesisReport* report = nullptr);

// The point that Match::hub looks at: its row and its column.
std::array<int, 2> hub_point(const WindGrid& grid);

// How many points of a tower fit above the ground.
int tower_points_above_ground(const WindGrid& grid);

// Throws InputError for counts below 1, spacings that are not above 0, more than 2^31 points times steps, …
void check_wind_grid(const WindGrid& grid);

}  // namespace tremula
