// A picture as light adds: linear, without bounds, before it is shown.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace tremula {

struct LinearImage {
  int width = 0;           // [pixels]
  int height = 0;          // [pixels]
  std::vector<float> rgb;  // (3 * width * height) linear sRGB primaries (Rec. 709), rows from the top

  const float* pixel(int x, int y) const {
    return rgb.data() +
           3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
  }
  float* pixel(int x, int y) { return const_cast<float*>(std::as_const(*this).pixel(x, y)); }
};

// Throws InputError for an image without all its pixels, or without any.
void check_all_pixels(const LinearImage& image);

// What a path tracer knows of a picture besides its light: what guides a denoiser.
struct TracedImage {
  LinearImage light;      // radiance
  LinearImage albedo;     // 0–1, of what is seen first; the sky's is 1
  LinearImage normal;     // unit, of what is seen first; 0 for the sky
  LinearImage half = {};  // light of half of the samples alone, from which the noise is known; or empty
};

}  // namespace tremula
