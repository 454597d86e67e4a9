#include "tremula/numerics/fft.hpp"

#include <complex>
#include <mutex>
#include <vector>

#ifdef TREMULA_FFT_kissfft
#include <kissfft.hh>
#else
#include <fftw3.h>
#endif

namespace tremula {

#ifdef TREMULA_FFT_kissfft

Eigen::MatrixXd samples_from_half_spectra(const Eigen::MatrixXcd& half_spectra, int sample_count) {
  const auto count = static_cast<std::size_t>(sample_count);
  kissfft<double> transform(count, true);
  std::vector<std::complex<double>> spectrum(count), series(count);
  Eigen::MatrixXd samples(sample_count, half_spectra.cols());
  for (Eigen::Index column = 0; column < half_spectra.cols(); ++column) {
    spectrum[0] = half_spectra(0, column).real();
    for (std::size_t k = 1; 2 * k <= count; ++k) {
      const std::complex<double> value = half_spectra(static_cast<Eigen::Index>(k), column);
      spectrum[k] = 2 * k == count ? value.real() : value;
      if (2 * k != count) spectrum[count - k] = std::conj(value);
    }
    transform.transform(spectrum.data(), series.data());
    for (std::size_t p = 0; p < count; ++p) samples(static_cast<Eigen::Index>(p), column) = series[p].real();
  }
  return samples;
}

Eigen::MatrixXcd half_spectra_from_samples(const Eigen::MatrixXd& samples) {
  const auto count = static_cast<std::size_t>(samples.rows());
  kissfft<double> transform(count, false);
  std::vector<std::complex<double>> series(count), spectrum(count);
  Eigen::MatrixXcd half_spectra(samples.rows() / 2 + 1, samples.cols());
  for (Eigen::Index column = 0; column < samples.cols(); ++column) {
    for (std::size_t p = 0; p < count; ++p) series[p] = samples(static_cast<Eigen::Index>(p), column);
    transform.transform(series.data(), spectrum.data());
    for (Eigen::Index k = 0; k < half_spectra.rows(); ++k) {
      half_spectra(k, column) = spectrum[static_cast<std::size_t>(k)] / static_cast<double>(count);
    }
  }
  return half_spectra;
}

#else

namespace {
std::mutex planner;  // FFTW plans may run side by side but not be made so
}

Eigen::MatrixXd samples_from_half_spectra(const Eigen::MatrixXcd& half_spectra, int sample_count) {
  Eigen::MatrixXcd spectra = half_spectra;  // FFTW overwrites its input
  Eigen::MatrixXd samples(sample_count, spectra.cols());
  auto* in = reinterpret_cast<fftw_complex*>(spectra.data());
  const int columns = static_cast<int>(spectra.cols()), bins = sample_count / 2 + 1;
  planner.lock();
  // Estimated, not measured: a measured plan may differ from run to run, and with it the last bits.
  fftw_plan plan = fftw_plan_many_dft_c2r(1, &sample_count, columns, in, nullptr, 1, bins, samples.data(),
                                          nullptr, 1, sample_count, FFTW_ESTIMATE);
  planner.unlock();
  fftw_execute(plan);
  const std::lock_guard lock(planner);
  fftw_destroy_plan(plan);
  return samples;
}

Eigen::MatrixXcd half_spectra_from_samples(const Eigen::MatrixXd& samples) {
  Eigen::MatrixXd series = samples;
  const int count = static_cast<int>(series.rows()), columns = static_cast<int>(series.cols());
  Eigen::MatrixXcd spectra(count / 2 + 1, columns);
  planner.lock();
  fftw_plan plan = fftw_plan_many_dft_r2c(1, &count, columns, series.data(), nullptr, 1, count,
                                          reinterpret_cast<fftw_complex*>(spectra.data()), nullptr, 1,
                                          count / 2 + 1, FFTW_ESTIMATE);
  planner.unlock();
  fftw_execute(plan);
  const std::lock_guard lock(planner);
  fftw_destroy_plan(plan);
  return spectra / count;
}

#endif

}  // namespace tremula
