#include "tremula/numerics/fft.hpp"

#include "tremula/numerics/random.hpp"

#include <complex>
#include <numbers>

#include <gtest/gtest.h>

namespace tremula {
namespace {

Eigen::MatrixXcd random_half_spectra(int sample_count, int columns) {
  Eigen::MatrixXcd spectra(sample_count / 2 + 1, columns);
  for (Eigen::Index i = 0; i < spectra.size(); ++i) {
    spectra.data()[i] = complex_gaussian({3, RandomStream::test, 0, static_cast<std::uint64_t>(i)});
  }
  spectra.row(0).imag().setZero();
  if (sample_count % 2 == 0) spectra.row(sample_count / 2).imag().setZero();
  return spectra;
}

TEST(Fft, EqualsTheFourierSeriesSummedTermByTermForEvenAndOddLengths) {
  for (const int count : {1, 2, 3, 8, 15, 30}) {
    const Eigen::MatrixXcd spectra = random_half_spectra(count, 3);
    const Eigen::MatrixXd samples = samples_from_half_spectra(spectra, count);
    ASSERT_EQ(samples.rows(), count);
    for (int p = 0; p < count; ++p) {
      for (int column = 0; column < 3; ++column) {
        double sum = spectra(0, column).real();
        for (int k = 1; k <= count / 2; ++k) {
          const double both = 2 * k == count ? 1 : 2;
          sum += both * (spectra(k, column) * std::polar(1.0, 2 * std::numbers::pi * k * p / count)).real();
        }
        EXPECT_NEAR(samples(p, column), sum, 1e-12) << "M = " << count << ", p = " << p;
      }
    }
  }
}

TEST(Fft, ForwardUndoesInverse) {
  for (const int count : {1, 2, 7, 64, 600}) {
    const Eigen::MatrixXcd spectra = random_half_spectra(count, 2);
    const Eigen::MatrixXcd back = half_spectra_from_samples(samples_from_half_spectra(spectra, count));
    EXPECT_LT((back - spectra).cwiseAbs().maxCoeff(), 1e-13 * count + 1e-14) << "M = " << count;
  }
}

TEST(Fft, IgnoresWhatCannotBelongToARealSignal) {
  Eigen::MatrixXcd spectra = random_half_spectra(16, 1);
  const Eigen::MatrixXd samples = samples_from_half_spectra(spectra, 16);
  spectra(0, 0) += std::complex<double>(0, 5);
  spectra(8, 0) += std::complex<double>(0, -3);
  EXPECT_EQ(samples, samples_from_half_spectra(spectra, 16));
}

}  // namespace
}  // namespace tremula
