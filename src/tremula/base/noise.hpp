// Patterns without a picture: a hash, and noise that looks the same from every side and on every machine.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace tremula {

inline std::uint32_t hash(std::uint32_t x) {
  x = (x ^ (x >> 16)) * 0x7feb352dU;
  x = (x ^ (x >> 15)) * 0x846ca68bU;
  return x ^ (x >> 16);
}

inline float hash_to_unit(std::uint32_t x) { return static_cast<float>(hash(x) >> 8) * 0x1p-24F; }

inline float smooth_step(float low, float high, float x) {
  const float t = std::clamp((x - low) / (high - low), 0.0F, 1.0F);
  return t * t * (3 - 2 * t);
}

// Smooth noise in [0, 1] with one value per unit; `period` in x (0: none) so that it closes around a stem.
inline float noise(float x, float y, int period, std::uint32_t seed) {
  const float fx = std::floor(x), fy = std::floor(y);
  const float tx = smooth_step(0, 1, x - fx), ty = smooth_step(0, 1, y - fy);
  const auto value = [&](int dx, int dy) {
    int ix = static_cast<int>(fx) + dx;
    if (period > 0) ix = (ix % period + period) % period;
    const int iy = static_cast<int>(fy) + dy;
    return hash_to_unit(static_cast<std::uint32_t>(ix) * 0x9e3779b9U +
                        hash(static_cast<std::uint32_t>(iy) + seed));
  };
  return (1 - ty) * ((1 - tx) * value(0, 0) + tx * value(1, 0)) +
         ty * ((1 - tx) * value(0, 1) + tx * value(1, 1));
}

}  // namespace tremula
