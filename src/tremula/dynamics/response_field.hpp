// What answers a gust in the same way wherever it stands, as a field of its own (F section 4.2): no structure
// is known, only how much follows a gust of one frequency (an impedance) and how far along neighbours are
// drawn with it.
//
//   d = h_t(f) h_x(k; f) v       over frequencies and wave numbers (F eq. 5)
//
// The gusts travel, loop and are known on a plane, and so does the answer.
#pragma once

#include "tremula/wind/travelling_field.hpp"

#include <complex>
#include <functional>
#include <vector>

namespace tremula {

// h_t: what a gust of 1 m/s gives, e.g. [m s/m] or [rad s/m], of a real signal at a frequency [Hz] >= 0.
using Impedance = std::function<std::complex<double>(double frequency)>;

// static_response / (1 - (f/f_0)^2 + 2 i zeta f/f_0): an oscillator (F section 4.1).
Impedance oscillator_impedance(double natural_frequency, double damping_ratio, double static_response);

struct ImpedanceRow {
  double frequency = 0;  // [Hz], rising
  std::complex<double> response = 0;
};
// Linear between rows; the first and the last beyond them.
Impedance impedance_from_table(std::vector<ImpedanceRow> rows);

// h_x, how a push at one place moves others: of unit integral, so that wind that is the same everywhere gives
// h_t alone.
struct SpatialResponse {
  enum class Kind {
    none,             // everything for itself
    gaussian,         // exp(-|dx|^2/s^2)
    exponential,      // exp(-|dx|/s)
    shinya_fournier,  // exp(-f |dx|^2/sigma) (F eq. 5): s^2 = sigma/f
  };
  Kind kind = Kind::none;
  double length = 1;  // s [m], or sqrt of F's sigma [m Hz^1/2]
};

struct FieldResponse {
  Impedance along, across, up;  // empty: does not move so
  SpatialResponse spatial = {};
};

// Throws InputError for impedances or lengths that are not finite, or not above 0.
TravellingField respond(const TravellingField& gusts, const FieldResponse& response);

}  // namespace tremula
