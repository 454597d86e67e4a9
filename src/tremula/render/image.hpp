// Pictures in memory, side by side on a sheet, and as PNG.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace tremula {

struct Image {
  int width = 0;                  // [pixels]
  int height = 0;                 // [pixels]
  std::vector<std::uint8_t> rgb;  // (3 * width * height) sRGB, rows from the top

  const std::uint8_t* pixel(int x, int y) const {
    return rgb.data() +
           3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
  }
  std::uint8_t* pixel(int x, int y) { return const_cast<std::uint8_t*>(std::as_const(*this).pixel(x, y)); }
};

// The images in rows of `columns`, in order, each with its label (ASCII) in the upper left corner. Throws
// InputError unless all images are of one size and there are as many labels as images, or none.
Image contact_sheet(std::span<const Image> images, int columns, std::span<const std::string> labels = {});

// The bytes of a PNG file (8 bit RGB). Throws InputError for an image without all its pixels.
std::string encode_png(const Image& image);

}  // namespace tremula
