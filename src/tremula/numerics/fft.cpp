#include "tremula/numerics/fft.hpp"

#include "tremula/base/check.hpp"

#include <algorithm>
#include <complex>
#include <mutex>
#include <utility>
#include <vector>

#ifdef TREMULA_FFT_kissfft
#include <cmath>
#include <numbers>

#include <kissfft.hh>
#else
#include <fftw3.h>
#endif

namespace tremula {

#ifdef TREMULA_FFT_kissfft

Eigen::MatrixXd samples_from_half_spectra(const Eigen::MatrixXcd& half_spectra, int sample_count) {
  check_at_least("samples of a series", sample_count, 1);
  check_equal("bins of the half spectra", half_spectra.rows(), sample_count / 2 + 1);
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
  check_at_least("samples of a series", samples.rows(), 1);
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

namespace {

// One complex series. KissFFT has no butterfly for the factor 7 and takes a general loop, ten times slower;
// here seven interleaved series of a seventh of the length are joined instead. Fields are made on planes
// whose sides may have that factor (fast_length), whichever library is used.
class Line {
 public:
  explicit Line(int length)
      : sevenths_(length % 7 == 0 ? length / 7 : 0),
        part_(static_cast<std::size_t>(sevenths_ > 0 ? sevenths_ : length), true),
        parts_(static_cast<std::size_t>(7 * sevenths_)) {
    for (int q = 0; q < 7; ++q) {
      for (int k = 0; k < sevenths_; ++k)
        turns_.push_back(std::complex<float>(std::polar(1.0, 2 * std::numbers::pi * q * k / length)));
      cosines_[q] = static_cast<float>(std::cos(2 * std::numbers::pi * q / 7));
      sines_[q] = static_cast<float>(std::sin(2 * std::numbers::pi * q / 7));
    }
  }

  // Not const: this and KissFFT where a factor is 7 or more write to buffers of their own; threads need
  // copies.
  void sum(const std::complex<float>* in, std::complex<float>* out) {
    if (sevenths_ == 0) return part_.transform(in, out);
    const auto n = static_cast<std::size_t>(sevenths_);
    for (std::size_t q = 0; q < 7; ++q) part_.transform(in + q, parts_.data() + q * n, 0, 1, 7);
    for (std::size_t k = 0; k < n; ++k) {
      std::complex<float> turned[7];
      for (std::size_t q = 0; q < 7; ++q) turned[q] = times(parts_[q * n + k], turns_[q * n + k]);
      out[k] = turned[0];
      for (int j = 1; j < 4; ++j) out[k] += turned[j] + turned[7 - j];
      for (int r = 1; r < 4; ++r) {
        std::complex<float> even = turned[0], odd = 0;
        for (int j = 1; j < 4; ++j) {
          even += cosines_[j * r % 7] * (turned[j] + turned[7 - j]);
          odd += sines_[j * r % 7] * (turned[j] - turned[7 - j]);
        }
        out[k + n * static_cast<std::size_t>(r)] = {even.real() - odd.imag(), even.imag() + odd.real()};
        out[k + n * static_cast<std::size_t>(7 - r)] = {even.real() + odd.imag(), even.imag() - odd.real()};
      }
    }
  }

 private:
  int sevenths_;  // 0: the length does not divide by 7
  kissfft<float> part_;
  std::vector<std::complex<float>> parts_, turns_ = {};
  float cosines_[7], sines_[7];

  // Without the detour of std::complex for infinities.
  static std::complex<float> times(std::complex<float> a, std::complex<float> b) {
    return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
  }
};

}  // namespace

struct RealSeries::Plan {
  Line transform;
  int batch;
};

RealSeries::RealSeries(int sample_count, int batch)
    : sample_count_(sample_count), plan_(new Plan{Line(sample_count), batch}) {}

void RealSeries::sum(std::complex<float>* half_spectra, float* samples) const {
  const int count = sample_count_;
  Line transform = plan_->transform;
  std::vector<std::complex<float>> both(static_cast<std::size_t>(count)), series(both.size());
  // Two real series at a time, as real and imaginary part of one complex series.
  for (int b = 0; b < plan_->batch; b += 2) {
    const bool alone = b + 1 == plan_->batch;
    const std::complex<float>* first = half_spectra + static_cast<std::ptrdiff_t>(b) * bin_count();
    const std::complex<float>* second = alone ? first : first + bin_count();
    const std::complex<float> i(0, 1);
    both[0] = {first[0].real(), second[0].real()};
    for (int k = 1; 2 * k <= count; ++k) {
      const auto bin = static_cast<std::size_t>(k);
      if (2 * k == count) {
        both[bin] = {first[k].real(), second[k].real()};
      } else {
        both[bin] = first[k] + i * second[k];
        both[both.size() - bin] = std::conj(first[k]) + i * std::conj(second[k]);
      }
    }
    transform.sum(both.data(), series.data());
    float* out = samples + static_cast<std::ptrdiff_t>(b) * pitch();
    for (std::size_t t = 0; t < series.size(); ++t) {
      out[t] = series[t].real();
      if (!alone) out[t + static_cast<std::size_t>(pitch())] = series[t].imag();
    }
  }
}

struct PlaneSeries::Plan {
  Line along_column, along_row;
  int kept_rows;

  void sum(std::complex<float>* plane, int rows, int columns, int wanted_rows, int pitch) const {
    Line of_column = along_column, of_row = along_row;
    std::vector<std::complex<float>> in(static_cast<std::size_t>(std::max(rows, columns))), out(in.size());
    for (int c = 0; c < columns; ++c) {
      for (int r = 0; r < rows; ++r) in[static_cast<std::size_t>(r)] = plane[r * pitch + c];
      of_column.sum(in.data(), out.data());
      for (int r = 0; r < wanted_rows; ++r) plane[r * pitch + c] = out[static_cast<std::size_t>(r)];
    }
    for (int r = 0; r < wanted_rows; ++r) {
      std::copy_n(plane + r * pitch, columns, in.data());
      of_row.sum(in.data(), plane + r * pitch);
    }
  }
};

PlaneSeries::PlaneSeries(int rows, int columns, int kept_rows)
    : rows_(rows), columns_(columns), plan_(new Plan{Line(rows), Line(columns), kept_rows}) {}

void PlaneSeries::sum(std::complex<float>* plane) const {
  plan_->sum(plane, rows_, columns_, rows_, pitch());
}

void PlaneSeries::sum_kept(std::complex<float>* plane) const {
  plan_->sum(plane, rows_, columns_, plan_->kept_rows, pitch());
}

#else

namespace {
std::mutex planner;  // FFTW plans may run side by side but not be made so
}

Eigen::MatrixXd samples_from_half_spectra(const Eigen::MatrixXcd& half_spectra, int sample_count) {
  check_at_least("samples of a series", sample_count, 1);
  check_equal("bins of the half spectra", half_spectra.rows(), sample_count / 2 + 1);
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
  check_at_least("samples of a series", samples.rows(), 1);
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

namespace {

struct FloatPlan {
  fftwf_plan plan = nullptr;
  FloatPlan() = default;
  FloatPlan(const FloatPlan&) = delete;
  FloatPlan& operator=(const FloatPlan&) = delete;
  ~FloatPlan() {
    const std::lock_guard lock(planner);
    fftwf_destroy_plan(plan);
  }
};

fftwf_complex* of_fftw(std::complex<float>* values) { return reinterpret_cast<fftwf_complex*>(values); }

}  // namespace

struct RealSeries::Plan : FloatPlan {};

RealSeries::RealSeries(int sample_count, int batch) : sample_count_(sample_count) {
  auto plan = std::make_unique<Plan>();
  FftArray<std::complex<float>> in(static_cast<std::size_t>(batch) * static_cast<std::size_t>(bin_count()));
  FftArray<float> out(static_cast<std::size_t>(batch) * static_cast<std::size_t>(pitch()));
  const std::lock_guard lock(planner);
  plan->plan = fftwf_plan_many_dft_c2r(1, &sample_count, batch, of_fftw(in.data()), nullptr, 1, bin_count(),
                                       out.data(), nullptr, 1, pitch(), FFTW_ESTIMATE);
  plan_ = std::move(plan);
}

void RealSeries::sum(std::complex<float>* half_spectra, float* samples) const {
  fftwf_execute_dft_c2r(plan_->plan, of_fftw(half_spectra), samples);
}

struct PlaneSeries::Plan {
  FloatPlan along_columns, along_rows, along_kept_rows;
};

PlaneSeries::PlaneSeries(int rows, int columns, int kept_rows) : rows_(rows), columns_(columns) {
  auto plan = std::make_unique<Plan>();
  FftArray<std::complex<float>> plane(size());
  fftwf_complex* data = of_fftw(plane.data());
  const auto many = [&](int length, int count, int stride, int distance) {
    return fftwf_plan_many_dft(1, &length, count, data, nullptr, stride, distance, data, nullptr, stride,
                               distance, FFTW_BACKWARD, FFTW_ESTIMATE);
  };
  const std::lock_guard lock(planner);
  plan->along_columns.plan = many(rows, columns, pitch(), 1);
  plan->along_rows.plan = many(columns, rows, 1, pitch());
  plan->along_kept_rows.plan = many(columns, kept_rows, 1, pitch());
  plan_ = std::move(plan);
}

void PlaneSeries::sum(std::complex<float>* plane) const {
  fftwf_execute_dft(plan_->along_columns.plan, of_fftw(plane), of_fftw(plane));
  fftwf_execute_dft(plan_->along_rows.plan, of_fftw(plane), of_fftw(plane));
}

void PlaneSeries::sum_kept(std::complex<float>* plane) const {
  fftwf_execute_dft(plan_->along_columns.plan, of_fftw(plane), of_fftw(plane));
  fftwf_execute_dft(plan_->along_kept_rows.plan, of_fftw(plane), of_fftw(plane));
}

#endif

RealSeries::~RealSeries() = default;
PlaneSeries::~PlaneSeries() = default;

int fast_length(int least) {
  for (int length = least;; ++length) {
    int rest = length, twos = 0;
    for (; rest % 2 == 0; rest /= 2) ++twos;
    // Measured: lengths like 56, 64 and 80 are two to four times faster, per point, than 54, 60, 72 or 100.
    if (rest <= 7 && (length <= 16 || twos >= 3)) return length;
  }
}

}  // namespace tremula
