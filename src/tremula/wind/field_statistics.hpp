// What a wind field is like, to be held against what it should be like: profile, spectra, coherence. A field
// from a file, of whatever make, is measured in the same way as our own.
//
// A periodic field is a Fourier series and is measured bin by bin, without window and without leakage. A
// field that is not is cut into segments under a Hann window that overlap by half (Welch).
#pragma once

#include "tremula/wind/field.hpp"

#include <array>
#include <vector>

namespace tremula {

struct FieldStatisticsOptions {
  double bands_per_decade = 10;  // of the frequency; a band holds at least one bin
  // Which points are compared, in cells of the grid. Those that the grid does not have are left out.
  std::vector<int> y_separations = {1, 2, 4, 8, 16}, z_separations = {1, 2, 4, 8, 16};
  int segment_length = 0;  // of a field that is not periodic [steps]; 0: a quarter of it
};

struct RowStatistics {
  double height = 0;                     // [m]
  std::array<double, 3> mean = {};       // over points and time [m/s]
  std::array<double, 3> deviation = {};  // of the fluctuation about each point's own mean [m/s]
  double turbulence_intensity = 0;       // sigma_u / U; 0 where there is no mean wind
  double covariance_uw = 0;              // [m^2/s^2]
};

// Bins first_bin … last_bin of the series, or of the segments. Bin p is the frequency p * resolution.
struct FrequencyBand {
  int first_bin = 1, last_bin = 1;
  double frequency = 0;  // mean of its bins [Hz]
  int bin_count() const { return last_bin - first_bin + 1; }
};

struct RowSpectrum {
  std::vector<double> value;           // one-sided, mean over the points and the bins of a band [(m/s)^2/Hz]
  std::vector<double> standard_error;  // of the value; with fewer than four bins: as if all points were one
};

// Of one component at points that many cells apart: sum of v_a conj(v_b) over the bins of a band and the
// points of two rows (or of one), over the root of both sums of |v|^2; then the mean over the rows.
struct FieldCoherence {
  bool vertical = false;  // else across
  int cells = 1;
  double distance = 0;        // [m]
  std::size_t component = 0;  // 0 u, 1 v, 2 w
  std::size_t pair_count = 0;
  std::vector<double> root;  // modulus, by band: the root-coherence
  std::vector<double> real;  // real part, by band: below the modulus where one of the two lags
};

struct FieldStatistics {
  std::vector<RowStatistics> rows;
  std::array<std::vector<double>, 3> point_mean, point_deviation;  // [m/s] at row * y_count + column
  double resolution = 0;                                           // [Hz] between bins
  int segment_length = 0, segment_count = 1;                       // steps; one segment: the periodic field
  std::vector<FrequencyBand> bands;                                // empty below 4 steps
  std::vector<std::array<RowSpectrum, 3>> spectra;                 // by row, then component
  std::vector<FieldCoherence> coherence;
};

// Row by row: needs memory for the spectra of as many rows of one component as the largest vertical
// separation spans. Throws InputError for a field that is none (check_wind_field) and for options out of
// range.
FieldStatistics field_statistics(const WindField& field, const FieldStatisticsOptions& options = {});

// Only rows, point_mean and point_deviation: no spectra, which are most of the work.
FieldStatistics field_moments(const WindField& field);

// Bins 1 … last_bin in bands of equal width on a log axis, as far as bins allow.
std::vector<FrequencyBand> logarithmic_bands(int last_bin, double resolution, double bands_per_decade);

}  // namespace tremula
