// Pictures read back, and how far apart two are.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <stb_image.h>

namespace tremula::test {

struct Picture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;

  // Of a rectangle, by channel.
  std::array<double, 3> mean(int left, int top, int columns, int rows) const {
    std::array<double, 3> sum{};
    for (int y = top; y < top + rows; ++y) {
      for (int x = left; x < left + columns; ++x) {
        for (std::size_t c = 0; c < 3; ++c) sum[c] += rgb[3 * static_cast<std::size_t>(y * width + x) + c];
      }
    }
    for (double& value : sum) value /= columns * rows;
    return sum;
  }
};

// Of no size where there is no picture.
inline Picture read_picture(const std::string& path) {
  Picture picture;
  int channels = 0;
  std::uint8_t* bytes = stbi_load(path.c_str(), &picture.width, &picture.height, &channels, 3);
  if (bytes == nullptr) return {};
  picture.rgb.assign(bytes, bytes + 3 * static_cast<std::size_t>(picture.width * picture.height));
  stbi_image_free(bytes);
  return picture;
}

struct Difference {
  double mean = 255, largest = 255;
};

inline Difference difference_in_blocks(const Picture& a, const Picture& b, int block) {
  if (a.width != b.width || a.height != b.height || a.width < block || a.height < block) return {};
  Difference difference{0, 0};
  int count = 0;
  for (int y = 0; y + block <= a.height; y += block) {
    for (int x = 0; x + block <= a.width; x += block) {
      const auto in_a = a.mean(x, y, block, block), in_b = b.mean(x, y, block, block);
      for (std::size_t c = 0; c < 3; ++c) {
        const double off = std::abs(in_a[c] - in_b[c]);
        difference.mean += off;
        difference.largest = std::max(difference.largest, off);
        ++count;
      }
    }
  }
  difference.mean /= count;
  return difference;
}

}  // namespace tremula::test
