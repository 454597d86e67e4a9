// Fourier series of real periodic signals, over FFTW or KissFFT (TREMULA_FFT).
//
//   x_p = sum over k = -M/2 … M/2 of X_k exp(+2 pi i k p / M),   X_{-k} = conj(X_k)
//
// so X_0 is the mean and the variance is 2 sum_{0<k<M/2} |X_k|^2 (+ |X_{M/2}|^2 where M is even).
#pragma once

#include <Eigen/Core>

namespace tremula {

// Column by column: half spectra (M/2+1 x m), bins 0 … M/2, to samples (M x m). The imaginary parts of bin 0
// and, for even M, of bin M/2 cannot belong to a real signal and are ignored. sample_count M >= 1.
Eigen::MatrixXd samples_from_half_spectra(const Eigen::MatrixXcd& half_spectra, int sample_count);

// The inverse: samples (M x m) to half spectra (M/2+1 x m).
Eigen::MatrixXcd half_spectra_from_samples(const Eigen::MatrixXd& samples);

}  // namespace tremula
