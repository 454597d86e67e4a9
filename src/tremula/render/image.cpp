#include "tremula/render/image.hpp"

#include <algorithm>
#include <cmath>

#include "tremula/base/error.hpp"
#include "tremula/render/font.hpp"

#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#include <stb_image_write.h>

namespace tremula {
namespace {

constexpr int gutter = 4;  // [pixels] between images

void draw_label(Image& image, int left, int top, int scale, const std::string& text) {
  const auto draw = [&](int x, int y, double opacity, int color) {
    if (x < 0 || y < 0 || x >= image.width || y >= image.height) return;
    std::uint8_t* pixel = image.pixel(x, y);
    for (int c = 0; c < 3; ++c) {
      pixel[c] = static_cast<std::uint8_t>(std::lround(pixel[c] + opacity * (color - pixel[c])));
    }
  };
  const auto draw_text = [&](int x0, int y0, double opacity, int color) {
    for (std::size_t i = 0; i < text.size(); ++i) {
      const Glyph& columns = glyph(text[i]);
      for (int gx = 0; gx < glyph_width * scale; ++gx) {
        for (int gy = 0; gy < glyph_height * scale; ++gy) {
          if ((columns[static_cast<std::size_t>(gx / scale)] >> (gy / scale) & 1) == 0) continue;
          draw(x0 + static_cast<int>(i) * (glyph_width + 1) * scale + gx, y0 + gy, opacity, color);
        }
      }
    }
  };
  draw_text(left + 1, top + 1, 0.6, 255);
  draw_text(left, top, 0.85, 40);
}

void check_pixels(const Image& image) {
  const bool has_size = image.width > 0 && image.height > 0;
  const std::size_t wanted =
      has_size ? 3 * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) : 0;
  if (has_size && image.rgb.size() == wanted) return;
  throw InputError(
      "image", std::to_string(image.rgb.size()) + " bytes",
      "3 for each of " + std::to_string(image.width) + " x " + std::to_string(image.height) + " pixels");
}

}  // namespace

Image contact_sheet(std::span<const Image> images, int columns, std::span<const std::string> labels) {
  if (images.empty()) throw InputError("contact sheet", "no image", "at least one");
  if (columns < 1) throw InputError("contact sheet: columns", std::to_string(columns), "a number above 0");
  if (!labels.empty() && labels.size() != images.size()) {
    throw InputError("contact sheet: labels", std::to_string(labels.size()), std::to_string(images.size()));
  }
  const int width = images[0].width;
  const int height = images[0].height;
  for (std::size_t i = 0; i < images.size(); ++i) {
    check_pixels(images[i]);
    if (images[i].width == width && images[i].height == height) continue;
    throw InputError("contact sheet: image " + std::to_string(i),
                     std::to_string(images[i].width) + " x " + std::to_string(images[i].height),
                     std::to_string(width) + " x " + std::to_string(height));
  }
  const int count = static_cast<int>(images.size());
  columns = std::min(columns, count);
  const int rows = (count + columns - 1) / columns;
  Image sheet{columns * (width + gutter) - gutter, rows * (height + gutter) - gutter, {}};
  sheet.rgb.assign(3 * static_cast<std::size_t>(sheet.width) * static_cast<std::size_t>(sheet.height), 255);
  const int scale = std::max(1, width / 200);
  for (int i = 0; i < count; ++i) {
    const int left = i % columns * (width + gutter);
    const int top = i / columns * (height + gutter);
    const Image& image = images[static_cast<std::size_t>(i)];
    for (int y = 0; y < height; ++y) {
      std::copy_n(image.pixel(0, y), 3 * width, sheet.pixel(left, top + y));
    }
    if (!labels.empty())
      draw_label(sheet, left + 5 * scale, top + 5 * scale, scale, labels[static_cast<std::size_t>(i)]);
  }
  return sheet;
}

std::string encode_png(const Image& image) {
  check_pixels(image);
  std::string bytes;
  const auto append = [](void* context, void* data, int size) {
    static_cast<std::string*>(context)->append(static_cast<const char*>(data),
                                               static_cast<std::size_t>(size));
  };
  if (stbi_write_png_to_func(append, &bytes, image.width, image.height, 3, image.rgb.data(),
                             3 * image.width) == 0) {
    throw Error("cannot encode a PNG of " + std::to_string(image.width) + " x " +
                std::to_string(image.height));
  }
  return bytes;
}

}  // namespace tremula
