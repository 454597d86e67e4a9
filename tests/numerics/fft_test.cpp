#include "tremula/numerics/fft.hpp"

#include "tremula/numerics/random.hpp"

#include <array>
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

TEST(RealSeries, IsTheSeriesInDoubleToTheRoundingOfFloat) {
  for (const int count : {1, 2, 3, 30, 64, 600}) {
    for (const int batch : {1, 5}) {
      const RealSeries series(count, batch);
      const Eigen::MatrixXcd spectra = random_half_spectra(count, batch);
      const Eigen::MatrixXd wanted = samples_from_half_spectra(spectra, count);
      FftArray<std::complex<float>> in(static_cast<std::size_t>(batch * series.bin_count()));
      for (Eigen::Index i = 0; i < spectra.size(); ++i) {
        in[static_cast<std::size_t>(i)] = std::complex<float>(spectra.data()[i]);
      }
      FftArray<float> out(static_cast<std::size_t>(batch * series.pitch()));
      series.sum(in.data(), out.data());
      for (int b = 0; b < batch; ++b) {
        for (int t = 0; t < count; ++t) {
          EXPECT_NEAR(static_cast<double>(out[static_cast<std::size_t>(b * series.pitch() + t)]),
                      wanted(t, b), 1e-6 * count + 1e-6)
              << "M = " << count;
        }
      }
    }
  }
}

TEST(PlaneSeries, EqualsTheDoubleSumTermByTermInTheRowsThatAreKept) {
  for (const auto& [rows, columns, kept] :
       {std::array{1, 1, 1}, {1, 6, 1}, {5, 1, 3}, {6, 10, 4}, {7, 56, 5}, {21, 14, 21}}) {
    const PlaneSeries series(rows, columns, kept);
    FftArray<std::complex<float>> all(series.size());
    for (std::size_t i = 0; i < all.size(); ++i) {
      all[i] = std::complex<float>(complex_gaussian({3, RandomStream::test, 1, i}));
    }
    const FftArray<std::complex<float>> coefficients = all;
    FftArray<std::complex<float>> some = all;
    series.sum(all.data());
    series.sum_kept(some.data());
    const auto at = [&](int r, int c) { return static_cast<std::size_t>(r * series.pitch() + c); };
    for (int r = 0; r < rows; ++r) {
      for (int c = 0; c < columns; ++c) {
        std::complex<double> sum = 0;
        for (int k = 0; k < rows; ++k) {
          for (int l = 0; l < columns; ++l) {
            const double turns = static_cast<double>(k * r) / rows + static_cast<double>(l * c) / columns;
            sum +=
                std::complex<double>(coefficients[at(k, l)]) * std::polar(1.0, 2 * std::numbers::pi * turns);
          }
        }
        EXPECT_LT(std::abs(std::complex<double>(all[at(r, c)]) - sum), 3e-5);
        if (r < kept) {
          EXPECT_LT(std::abs(std::complex<double>(some[at(r, c)]) - sum), 3e-5);
        }
      }
    }
  }
}

TEST(FastLength, IsEnoughAndLessThanTwiceAsMuch) {
  for (int least = 1; least < 3000; ++least) {
    EXPECT_GE(fast_length(least), least);
    EXPECT_LT(fast_length(least), 2 * least);
  }
}

}  // namespace
}  // namespace tremula
