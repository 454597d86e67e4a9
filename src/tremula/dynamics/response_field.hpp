// What answers a gust in the same way wherever it stands, as a field of its own (F section 4.2): no structure
// is known, only how much follows a gust of one frequency (an impedance) and how far along neighbours are
// drawn with it.
//
//   d = h_t(f) h_x(k; f) v       over frequencies and wave numbers (F eq. 5)
//
// The gusts travel, loop and are known on a plane, and so does the answer.
#pragma once

#include "tremula/dynamics/transfer.hpp"
#include "tremula/numerics/time_axis.hpp"
#include "tremula/wind/travelling_field.hpp"

#include <complex>
#include <concepts>
#include <functional>
#include <type_traits>
#include <utility>
#include <vector>

namespace tremula {

// h_t: what a gust of 1 m/s gives, e.g. [m s/m] or [rad s/m], of a real signal at a frequency [Hz] >= 0. Any
// function of the frequency is one.
struct Impedance {
  std::function<std::complex<double>(double frequency)> at = {};
  // The mean of |h_t|^2 between two frequencies, for resonances that are narrower than a bin (errata S11);
  // empty: h_t at the frequency of a bin stands for all of it.
  std::function<double(double low, double high)> mean_power = {};

  Impedance() = default;
  template <std::invocable<double> Function>
  requires(!std::same_as<std::remove_cvref_t<Function>, Impedance>) Impedance(Function function)
      : at(std::move(function)) {}

  explicit operator bool() const { return static_cast<bool>(at); }
  std::complex<double> operator()(double frequency) const { return at(frequency); }
};

// static_response / (1 - (f/f_0)^2 + 2 i zeta f/f_0): an oscillator (F section 4.1). A bin takes the root
// mean square of it over its width with the phase of its middle, as BinTransfer does for one coordinate; so
// variances do not depend on the period. `sampled`: what the oscillator in time does with the very loop.
// Throws InputError unless frequency and damping are above 0 and all is finite.
Impedance oscillator_impedance(double natural_frequency, double damping_ratio, double static_response,
                               Transfer kind = Transfer::bin_averaged);

struct ImpedanceRow {
  double frequency = 0;  // [Hz], rising
  std::complex<double> response = 0;
};
// Linear between rows; the first and the last beyond them. Throws InputError for a table of no rows, or of
// rows that do not rise or are not finite.
Impedance impedance_from_table(std::vector<ImpedanceRow> rows);

// What a bin of a loop is multiplied by. Bin 0 does not move in the loop: a real number. Throws InputError
// where the impedance is not finite.
std::complex<double> bin_response(const Impedance& impedance, const TimeAxis& loop, int bin);

// h_x, how a push at one place moves others: of unit integral over the ground, so that wind that is the same
// everywhere gives h_t alone.
struct SpatialResponse {
  enum class Kind {
    none,             // everything for itself
    gaussian,         // exp(-|dx|^2/s^2)
    exponential,      // exp(-|dx|/s)
    shinya_fournier,  // exp(-f |dx|^2/sigma) (F eq. 5): s^2 = sigma/f
  };
  Kind kind = Kind::none;
  double length = 1;  // s [m], or the root of F's sigma [m Hz^1/2]
};

// What is left of a gust of one frequency [Hz] whose front is straight and that travels at a speed [m/s]: h_x
// over the wave number 2 pi f/U, 0 to 1.
double spatial_gain(const SpatialResponse& spatial, double frequency, double speed);

struct FieldResponse {
  Impedance along = {}, across = {}, up = {};  // empty: does not move so
  SpatialResponse spatial = {};
};

// On the plane and over the loop of the gusts, about h_t(0) of their mean. Across the wind the gusts are
// straight between columns, and beyond the last of them as there. The same bits on any number of threads.
// Throws InputError for a field that is none or not finite, impedances that are not finite, and a length that
// is not above 0.
TravellingField respond(const TravellingField& gusts, const FieldResponse& response);

}  // namespace tremula
