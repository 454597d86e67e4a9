// Random numbers without a state: every number has an address (seed, stream, bin, place) and is always the
// same, in whatever order and on however many threads it is drawn. Philox 4x32-10 (Salmon et al. 2011,
// Random123).
#pragma once

#include <complex>
#include <cstdint>

namespace tremula {

// What a number is for. Two uses never share a stream, so adding one does not change the other.
enum class RandomStream : std::uint32_t {
  wind_u = 1,
  wind_v = 2,
  wind_w = 3,
  growth = 4,
  leaves = 5,
  lanczos_start = 6,
  test = 1000,
};

struct RandomAddress {
  std::uint64_t seed = 0;
  RandomStream stream = RandomStream::test;
  std::uint32_t bin = 0;    // a frequency bin, a derivation step, …
  std::uint64_t place = 0;  // a point, a branch, a letter, … below 2^32 * 2^32
};

// Uniform in [0, 1), 53 bits.
double uniform(const RandomAddress& address);

// Complex Gaussian with E|w|^2 = 1: independent real and imaginary parts of variance 1/2 each.
std::complex<double> complex_gaussian(const RandomAddress& address);

}  // namespace tremula
