// The check of a wind field as one picture: profiles, spectra and coherence, measured and wanted.
#pragma once

#include "tremula/wind/field_statistics.hpp"

#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace tremula {

struct Curve {
  std::vector<double> x, y;  // of one length
};

// What the field should be like, as plain curves; whatever is empty is not drawn.
struct WindTargets {
  struct Spectrum {
    std::size_t row = 0, component = 0;
    Curve curve;  // frequency [Hz], one-sided density [(m/s)^2/Hz]
  };
  struct Coherence {
    bool vertical = false;
    int cells = 1;
    std::size_t component = 0;
    Curve curve;  // frequency [Hz], root-coherence
  };
  Curve mean;                             // height [m], along-wind mean [m/s]
  Curve mean_across = {};                 // the same of v: of a wind that veers
  Curve covariance = {};                  // height [m], of u and w [m^2/s^2]
  std::array<Curve, 3> deviation = {};    // height [m], standard deviation [m/s]
  std::vector<Spectrum> spectra = {};     // drawn where the row is one of the three that are shown
  std::vector<Coherence> coherence = {};  // drawn where the separation is one of those shown
  // Of the model's variances of u, v, w the part in the bins that a loop of the field's length has, at the
  // hub; 0: not known.
  std::array<double, 3> resolved_share = {};
};

struct WindReport {
  std::string title;
  FieldStatistics statistics;
  WindTargets targets = {};
};

// SVG text: mean, deviation and covariance with height; f S(f) of u, v, w in the lowest, the middle and the
// top row; root-coherence of u, v, w across and upward. Measured full, target dashed. The same report gives
// the same bytes.
std::string plot_wind(const WindReport& report);

// SVG text: S(f) of u, v and w in one row (F figure 2), measured full and target dashed. Throws InputError
// for a row that is not there.
std::string plot_spectra(const WindReport& report, std::size_t row);

void write_wind_plot(const std::string& path, const WindReport& report);  // throws Error

}  // namespace tremula
