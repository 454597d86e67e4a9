// Random numbers without a state: every number has an address (seed, stream, bin, place) and is always the
// same, in whatever order and on however many threads it is drawn. Philox 4x32-10 (Salmon et al. 2011,
// Random123).
#pragma once

#include <array>
#include <complex>
#include <cstddef>
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
  modal_loads = 7,
  waves = 8,
  placing = 9,
  grass = 10,
  impressions = 13,
  strands = 14,
  drift = 15,
  lattice_u = 20,
  lattice_v = 21,
  lattice_w = 22,
  test = 1000,
};

struct RandomAddress {
  std::uint64_t seed = 0;
  RandomStream stream = RandomStream::test;
  std::uint32_t bin = 0;    // a frequency bin, a derivation step, …
  std::uint64_t place = 0;  // a point, a branch, a letter, … below 2^32 * 2^32
};

// The bin of another realisation of what happens in a bin. bin below 2^24, draw 0 … 127.
constexpr std::uint32_t bin_of_draw(int bin, int draw) {
  return static_cast<std::uint32_t>(bin) + (static_cast<std::uint32_t>(draw) << 24U);
}

// Uniform in [0, 1), 53 bits.
double uniform(const RandomAddress& address);

// Two of one address, for the time of one; the first is uniform(address).
std::array<double, 2> two_uniforms(const RandomAddress& address);

// Complex Gaussian with E|w|^2 = 1: independent real and imaginary parts of variance 1/2 each.
std::complex<double> complex_gaussian(const RandomAddress& address);

// Many at a time, in float and from 32 bits for the magnitude and 32 for the phase: places 0 … count - 1 of
// one bin. Not the numbers complex_gaussian gives for these addresses. |w| ends at 4.8, where one in 10^10
// lies beyond.
void complex_gaussians(std::uint64_t seed, RandomStream stream, std::uint32_t bin, std::size_t count,
                       std::complex<float>* values);

// Those of one block alone: places 128 block … 128 block + 127. block below 2^58.
inline constexpr std::size_t gaussian_block = 128;
void complex_gaussian_block(std::uint64_t seed, RandomStream stream, std::uint32_t bin, std::uint64_t block,
                            std::complex<float>* values);

// The phases of those numbers without their magnitudes: |w| = 1, to a few roundings.
void unit_phases(std::uint64_t seed, RandomStream stream, std::uint32_t bin, std::size_t count,
                 std::complex<float>* values);

}  // namespace tremula
