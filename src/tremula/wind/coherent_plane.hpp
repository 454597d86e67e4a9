// A homogeneous random field of unit variance on a periodic plane, with a given root-coherence: the part of
// the synthesis that works in space, one frequency bin at a time (F section 3.4, errata F4).
//
// The coherence R at minimum-image separations has the eigenvalues lambda(k) = sum over r of R(r) exp(-i k
// r). With complex Gaussian w(k), E|w|^2 = 1,
//
//   x(r) = sum over k of sqrt(lambda(k) / sum of lambda) w(k) exp(+i k r)
//
// has E x(r) conj(x(r')) = R(r - r'). A coherence that was cut off at half a period may have negative
// eigenvalues: they count as 0, and the rest is scaled so that the variance is 1.
#pragma once

#include "tremula/numerics/fft.hpp"
#include "tremula/numerics/random.hpp"
#include "tremula/wind/coherence.hpp"
#include "tremula/wind/turbulent_wind.hpp"

#include <array>
#include <complex>
#include <cstdint>

namespace tremula {

// The cells of one axis of the periodic plane: enough for a window of `points` points whose wrapped-around
// neighbours are too far to matter (root-coherence below `tolerance`), or twice the window where gusts reach
// further. 1 for one point.
int periodic_length(int points, double spacing, double decay, double tolerance);

// The next whole number from x >= 0 on, but for rounding: the last bit of a logarithm or of a distance, which
// another machine may round otherwise, must not make another plane and with it another wind.
int whole_number_from(double x);

// Complex noise of unit power by its address. Of its parts, `shared` is another stream's noise of the same
// bin and places: the two are then correlated by that much (of Gaussian amplitudes only).
struct Noise {
  Amplitudes amplitudes = Amplitudes::gaussian;
  std::uint64_t seed = 1;
  RandomStream stream = RandomStream::wind_u;
  std::uint32_t bin = 0;
  double shared = 0;
  RandomStream other = RandomStream::wind_u;
};

// What one thread needs, for the bins of one plane after the other.
struct CoherentPlaneWork {
  FftArray<std::complex<float>> plane;                 // (rows x pitch): coefficients, then the field
  FftArray<std::complex<float>> noise;                 // (rows x columns)
  std::array<FftArray<float>, 2> amplitude;            // (rows x pitch) sqrt(lambda)
  std::array<float, 2> scale = {};                     // 1 / sqrt(sum of lambda)
  std::array<double, 2> clipped_share = {};            // of sum |lambda|
  std::array<FftArray<float>, 4> squared_separations;  // across and up, in decay lengths, for both coherences
};

class CoherentPlane {
 public:
  // rows up, columns across; the field is wanted in the first kept_rows rows.
  CoherentPlane(int rows, int columns, int kept_rows) : series_(rows, columns, kept_rows) {}

  int rows() const { return series_.rows(); }
  int columns() const { return series_.columns(); }
  int pitch() const { return series_.pitch(); }

  // Two coherences at the price of one: they are real and even, and so are their transforms, which come out
  // as real and imaginary part. Spacings [m].
  void set_coherences(const std::array<CoherenceDecay, 2>& decays, double row_spacing, double column_spacing,
                      CoherentPlaneWork& work) const;

  // The field of coherence `which` times `work.scale[which]` still to be applied, into work.plane.
  void draw(const Noise& noise, int which, CoherentPlaneWork& work) const;

  // The correlation, at a place, of two fields drawn from the same noise with these two coherences: 1 where
  // they are the same.
  double likeness(const CoherentPlaneWork& work) const;

  // How far the coherences as they are (clipped, wrapped around) lie from those wanted, at separations of up
  // to window_rows and window_columns points: the largest difference. Destroys work.plane.
  std::array<double, 2> coherence_error(const std::array<CoherenceDecay, 2>& decays, double row_spacing,
                                        double column_spacing, int window_rows, int window_columns,
                                        CoherentPlaneWork& work) const;

 private:
  PlaneSeries series_;
};

// Places 0 … count - 1.
void draw_noise(const Noise& noise, std::size_t count, std::complex<float>* values);

}  // namespace tremula
