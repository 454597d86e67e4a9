#include "tremula/numerics/random.hpp"

#include "tremula/numerics/vector_math.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Random123/philox.h>

#if defined(__x86_64__) && defined(__GNUC__)
#include <immintrin.h>
#define TREMULA_PHILOX_AVX2 __attribute__((target("avx2")))
#endif

namespace tremula {
namespace {

struct Words {
  std::uint64_t first, second;
};

Words words_at(const RandomAddress& a) {
  const r123::Philox4x32::ctr_type counter = {{static_cast<std::uint32_t>(a.place),
                                               static_cast<std::uint32_t>(a.place >> 32), a.bin,
                                               static_cast<std::uint32_t>(a.stream)}};
  const r123::Philox4x32::key_type key = {
      {static_cast<std::uint32_t>(a.seed), static_cast<std::uint32_t>(a.seed >> 32)}};
  const auto block = r123::Philox4x32{}(counter, key);
  return {(std::uint64_t{block[1]} << 32) | block[0], (std::uint64_t{block[3]} << 32) | block[2]};
}

// Philox of a run of counters (first + i, 0, bin, stream), i = 0 … run - 1, words apart.
constexpr std::size_t run = 64;
struct alignas(64) Run {
  std::uint32_t words[4][run];
};

void philox(std::uint64_t seed, std::uint32_t stream, std::uint32_t bin, std::uint64_t first, Run& out) {
  const r123::Philox4x32::key_type key = {
      {static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)}};
  for (std::size_t i = 0; i < run; ++i) {
    const std::uint64_t place = first + i;
    const auto block = r123::Philox4x32{}(
        {{static_cast<std::uint32_t>(place), static_cast<std::uint32_t>(place >> 32), bin, stream}}, key);
    for (std::size_t w = 0; w < 4; ++w) out.words[w][i] = block[w];
  }
}

#ifdef TREMULA_PHILOX_AVX2
// The same numbers. A 32 x 32 bit product fills a 64 bit lane with just what a round wants, and the next
// product ignores the upper half of its factors: one lane a counter, nothing to shuffle.
TREMULA_PHILOX_AVX2 void philox_avx2(std::uint64_t seed, std::uint32_t stream, std::uint32_t bin,
                                     std::uint64_t first, Run& out) {
  constexpr int groups = 4;  // of four counters: even and odd ones of two runs of eight
  const __m256i low = _mm256_set1_epi64x(0xFFFFFFFF);
  for (std::size_t start = 0; start < run; start += 16) {
    __m256i w0[groups], w1[groups], w2[groups], w3[groups];
    for (int g = 0; g < groups; ++g) {
      const __m256i place = _mm256_add_epi64(
          _mm256_set1_epi64x(static_cast<long long>(first + start)),
          _mm256_add_epi64(_mm256_set_epi64x(6, 4, 2, 0), _mm256_set1_epi64x(8 * (g / 2) + g % 2)));
      w0[g] = _mm256_and_si256(place, low);
      w1[g] = _mm256_srli_epi64(place, 32);
      w2[g] = _mm256_set1_epi64x(bin);
      w3[g] = _mm256_set1_epi64x(stream);
    }
    auto key0 = static_cast<std::uint32_t>(seed), key1 = static_cast<std::uint32_t>(seed >> 32);
    for (int round = 0; round < 10; ++round) {
      const __m256i k0 = _mm256_set1_epi64x(key0), k1 = _mm256_set1_epi64x(key1);
      for (int g = 0; g < groups; ++g) {
        const __m256i p0 = _mm256_mul_epu32(w0[g], _mm256_set1_epi64x(PHILOX_M4x32_0));
        const __m256i p1 = _mm256_mul_epu32(w2[g], _mm256_set1_epi64x(PHILOX_M4x32_1));
        w0[g] = _mm256_xor_si256(_mm256_xor_si256(_mm256_srli_epi64(p1, 32), w1[g]), k0);
        w2[g] = _mm256_xor_si256(_mm256_xor_si256(_mm256_srli_epi64(p0, 32), w3[g]), k1);
        w1[g] = p1;
        w3[g] = p0;
      }
      key0 += PHILOX_W32_0;
      key1 += PHILOX_W32_1;
    }
    for (int g = 0; g < groups; g += 2) {
      const __m256i* words[4] = {w0, w1, w2, w3};
      for (int w = 0; w < 4; ++w) {
        const __m256i even_and_odd =
            _mm256_blend_epi32(words[w][g], _mm256_slli_epi64(words[w][g + 1], 32), 0xAA);
        _mm256_store_si256(reinterpret_cast<__m256i*>(&out.words[w][start + 4 * static_cast<std::size_t>(g)]),
                           even_and_odd);
      }
    }
  }
}
#endif

// Words 0 and 2 give magnitudes, 1 and 3 phases: first all numbers of the first pair, then of the second.
TREMULA_CLONES void gaussians_of_run(const Run& random, float* values) {
  for (std::size_t half = 0; half < 2; ++half) {
    for (std::size_t i = 0; i < run; ++i) {
      // Half a step off the ends: the logarithm is finite.
      const float magnitude = std::sqrt(
          minus_log((static_cast<float>(static_cast<std::int32_t>(random.words[2 * half][i] >> 1)) + 0.25F) *
                    0x1p-31F));
      const SinCos angle = sincos_of_turns(static_cast<std::int32_t>(random.words[2 * half + 1][i]));
      values[2 * (half * run + i)] = magnitude * angle.cosine;
      values[2 * (half * run + i) + 1] = magnitude * angle.sine;
    }
  }
}

TREMULA_CLONES void phases_of_run(const Run& random, float* values) {
  for (std::size_t half = 0; half < 2; ++half) {
    for (std::size_t i = 0; i < run; ++i) {
      const SinCos angle = sincos_of_turns(static_cast<std::int32_t>(random.words[2 * half + 1][i]));
      values[2 * (half * run + i)] = angle.cosine;
      values[2 * (half * run + i) + 1] = angle.sine;
    }
  }
}

auto* best_philox() {
  auto* generate = &philox;
#ifdef TREMULA_PHILOX_AVX2
  if (__builtin_cpu_supports("avx2")) generate = &philox_avx2;
#endif
  return generate;
}

template <typename OfRun>
void fill(std::uint64_t seed, RandomStream stream, std::uint32_t bin, std::size_t count,
          std::complex<float>* values, OfRun of_run) {
  auto* generate = best_philox();
  Run random;
  for (std::size_t done = 0; done < count; done += 2 * run) {
    generate(seed, static_cast<std::uint32_t>(stream), bin, done / 2, random);
    if (count - done >= 2 * run) {
      of_run(random, reinterpret_cast<float*>(values + done));
    } else {
      std::complex<float> rest[2 * run];
      of_run(random, reinterpret_cast<float*>(rest));
      std::copy_n(rest, count - done, values + done);
    }
  }
}

double to_unit_interval(std::uint64_t word) { return static_cast<double>(word >> 11) * 0x1p-53; }

}  // namespace

double uniform(const RandomAddress& address) { return to_unit_interval(words_at(address).first); }

std::array<double, 2> two_uniforms(const RandomAddress& address) {
  const Words words = words_at(address);
  return {to_unit_interval(words.first), to_unit_interval(words.second)};
}

std::complex<double> complex_gaussian(const RandomAddress& address) {
  const Words words = words_at(address);
  // 1 - u is in (0, 1]: the logarithm is finite. |w|^2 is exponential with mean 1.
  const double magnitude = std::sqrt(-std::log(1.0 - to_unit_interval(words.first)));
  return std::polar(magnitude, 2 * std::numbers::pi * to_unit_interval(words.second));
}

void complex_gaussians(std::uint64_t seed, RandomStream stream, std::uint32_t bin, std::size_t count,
                       std::complex<float>* values) {
  fill(seed, stream, bin, count, values, gaussians_of_run);
}

void complex_gaussian_block(std::uint64_t seed, RandomStream stream, std::uint32_t bin, std::uint64_t block,
                            std::complex<float>* values) {
  static_assert(gaussian_block == 2 * run);
  Run random;
  best_philox()(seed, static_cast<std::uint32_t>(stream), bin, block * run, random);
  gaussians_of_run(random, reinterpret_cast<float*>(values));
}

void unit_phases(std::uint64_t seed, RandomStream stream, std::uint32_t bin, std::size_t count,
                 std::complex<float>* values) {
  fill(seed, stream, bin, count, values, phases_of_run);
}

}  // namespace tremula
