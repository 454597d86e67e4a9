// Elementary functions in float that compilers turn into vector code: plain arithmetic, no branches, no
// tables. Loops that call them are compiled for wider instruction sets too (TREMULA_CLONES).
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

#include "tremula/base/simd.hpp"

namespace tremula {

// exp(-x) for x >= 0, good to 2e-7: 2^n times a polynomial for 2^f, f in [-1/2, 1/2].
inline float exp_minus(float x) {
  const float t = std::max(-126.0F, -1.44269504F * x);
  const float n = (t + 12582912.0F) - 12582912.0F;  // to the nearest integer
  const float f = (t - n) * 0.693147181F;
  const float series =
      1 + f * (1 + f * (0.5F + f * (0.166666667F +
                                    f * (0.0416666667F + f * (0.00833333333F + f * 0.00138888889F)))));
  return series * std::bit_cast<float>((static_cast<std::int32_t>(n) + 127) << 23);
}

// -ln(x) for normal x in (0, 1], good to 2e-7 of the result and never below 0: polynomial of Cephes' logf for
// mantissas from sqrt(1/2) to sqrt(2).
inline float minus_log(float x) {
  const auto bits = std::bit_cast<std::int32_t>(x);
  const std::int32_t exponent = (bits - 0x3f3504f3) >> 23;
  const float m = std::bit_cast<float>(bits - exponent * (1 << 23)) - 1;
  float series = 7.0376836292e-2F;
  series = series * m - 1.1514610310e-1F;
  series = series * m + 1.1676998740e-1F;
  series = series * m - 1.2420140846e-1F;
  series = series * m + 1.4249322787e-1F;
  series = series * m - 1.6668057665e-1F;
  series = series * m + 2.0000714765e-1F;
  series = series * m - 2.4999993993e-1F;
  series = series * m + 3.3333331174e-1F;
  const float square = m * m;
  const float log = m + (series * m * square - 0.5F * square);
  return std::max(0.0F, -(static_cast<float>(exponent) * 0.693147181F + log));
}

struct SinCos {
  float sine, cosine;
};

// Sine and cosine of 2 pi turns / 2^32, good to 1e-7: the quadrant, and polynomials (Cephes) for the rest.
inline SinCos sincos_of_turns(std::int32_t turns) {
  const auto unsigned_turns = static_cast<std::uint32_t>(turns);
  const std::uint32_t quadrant = (unsigned_turns + 0x20000000U) >> 30;
  const auto rest = static_cast<std::int32_t>(unsigned_turns - (quadrant << 30));
  const float x = static_cast<float>(rest) * (6.283185307F * 0x1p-32F), square = x * x;
  const float s =
      x + x * square * (-1.6666654611e-1F + square * (8.3321608736e-3F + square * -1.9515295891e-4F));
  const float c =
      1 - 0.5F * square +
      square * square *
          (4.166664568298827e-2F + square * (-1.388731625493765e-3F + square * 2.443315711809948e-5F));
  const bool swapped = (quadrant & 1) != 0;
  const std::uint32_t sine_sign = (quadrant & 2) << 30, cosine_sign = ((quadrant + 1) & 2) << 30;
  return {std::bit_cast<float>(std::bit_cast<std::uint32_t>(swapped ? c : s) ^ sine_sign),
          std::bit_cast<float>(std::bit_cast<std::uint32_t>(swapped ? s : c) ^ cosine_sign)};
}

}  // namespace tremula
