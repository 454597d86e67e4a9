// What a program may hand over by mistake: an error that says what is wrong, and no crash.
#include <gtest/gtest.h>

#include <cmath>

#include "tremula/base/error.hpp"
#include "tremula/numerics/fft.hpp"
#include "tremula/numerics/pairwise_filter.hpp"
#include "tremula/numerics/quadrature.hpp"

namespace tremula {
namespace {

TEST(Numerics, RefusesLengthsThatAreNone) {
  EXPECT_THROW(samples_from_half_spectra(Eigen::MatrixXcd::Zero(1, 2), 0), InputError);
  EXPECT_THROW(samples_from_half_spectra(Eigen::MatrixXcd::Zero(1, 2), -4), InputError);
  EXPECT_THROW(samples_from_half_spectra(Eigen::MatrixXcd::Zero(4, 2), 8), InputError);
  EXPECT_THROW(half_spectra_from_samples(Eigen::MatrixXd::Zero(0, 2)), InputError);
  EXPECT_EQ(samples_from_half_spectra(Eigen::MatrixXcd::Zero(5, 0), 8).cols(), 0);
  for (const int count : {0, -1}) {
    EXPECT_THROW(gauss_legendre(count), InputError);
  }
}

TEST(Numerics, RefusesNoiseAndDecaysThatAPairwiseFilterCannotTake) {
  const PairwiseFilter filter(Eigen::Matrix3Xd::Random(3, 10));
  const PairwiseFilter::Channels noise = PairwiseFilter::Channels::Zero(10, PairwiseFilter::channels);
  EXPECT_EQ(filter.apply(1, 0, noise).filtered.rows(), 10);
  EXPECT_THROW(filter.apply(1, 0, noise.topRows(9)), InputError);
  for (const double decay : {-1.0, HUGE_VAL, static_cast<double>(NAN)})
    EXPECT_THROW(filter.apply(decay, 0, noise), InputError);
}

}  // namespace
}  // namespace tremula
