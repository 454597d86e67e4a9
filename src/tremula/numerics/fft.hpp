// Fourier series of real periodic signals, over FFTW or KissFFT (TREMULA_FFT).
//
//   x_p = sum over k = -M/2 … M/2 of X_k exp(+2 pi i k p / M),   X_{-k} = conj(X_k)
//
// so X_0 is the mean and the variance is 2 sum_{0<k<M/2} |X_k|^2 (+ |X_{M/2}|^2 where M is even).
#pragma once

#include <complex>
#include <memory>
#include <vector>

#include <Eigen/Core>

namespace tremula {

// Column by column: half spectra (M/2+1 x m), bins 0 … M/2, to samples (M x m). The imaginary parts of bin 0
// and, for even M, of bin M/2 cannot belong to a real signal and are ignored. sample_count M >= 1. Throws
// InputError for other lengths; the classes below, summed for every bin, check nothing.
Eigen::MatrixXd samples_from_half_spectra(const Eigen::MatrixXcd& half_spectra, int sample_count);

// The inverse: samples (M x m) to half spectra (M/2+1 x m).
Eigen::MatrixXcd half_spectra_from_samples(const Eigen::MatrixXd& samples);

// Below: in float, planned once and summed many times, also from several threads at once. The arrays must
// come from this allocator, because plans take alignment for granted.
template <typename Number>
using FftArray = std::vector<Number, Eigen::aligned_allocator<Number>>;

// `batch` real series of one length at a time, one after the other in memory.
class RealSeries {
 public:
  RealSeries(int sample_count, int batch);
  ~RealSeries();

  int bin_count() const { return sample_count_ / 2 + 1; }
  int pitch() const { return sample_count_ + 16; }  // from series to series in `samples`

  // half_spectra (batch x bin_count, destroyed) to samples (batch x pitch).
  void sum(std::complex<float>* half_spectra, float* samples) const;

 private:
  struct Plan;
  int sample_count_;
  std::unique_ptr<const Plan> plan_;
};

// A complex series on a periodic plane:
//   x(r, c) = sum over k, l of X(k, l) exp(+2 pi i (k r / rows + l c / columns))
class PlaneSeries {
 public:
  // kept_rows of the result are asked for by sum_kept.
  PlaneSeries(int rows, int columns, int kept_rows);
  ~PlaneSeries();

  int rows() const { return rows_; }
  int columns() const { return columns_; }
  int pitch() const { return columns_ + 8; }  // from row to row: powers of two fall on the same cache lines
  std::size_t size() const { return static_cast<std::size_t>(rows_) * static_cast<std::size_t>(pitch()); }

  // In place. plane (rows x pitch). sum_kept leaves rubbish in the rows from kept_rows on, and saves their
  // work.
  void sum(std::complex<float>* plane) const;
  void sum_kept(std::complex<float>* plane) const;

 private:
  struct Plan;
  int rows_, columns_;
  std::unique_ptr<const Plan> plan_;
};

// The length from `least` on, up to twice that, whose transform is fast: a power of two times 1, 3, 5 or 7,
// and long ones of whole vectors. The same whichever library does the transforms, for the realisation of a
// wind depends on it.
int fast_length(int least);

}  // namespace tremula
