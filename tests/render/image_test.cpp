#include "tremula/render/image.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "tremula/base/error.hpp"
#include "tremula/render/font.hpp"

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_PNG
#include <stb_image.h>

namespace tremula {
namespace {

Image gradient(int width, int height) {
  Image image{width, height, {}};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (const int value : {x * 7 + y, y * 13, x * y})
        image.rgb.push_back(static_cast<std::uint8_t>(value));
    }
  }
  return image;
}

Image plain(int width, int height, std::uint8_t level) {
  return {width, height, std::vector<std::uint8_t>(std::size_t(3 * width * height), level)};
}

TEST(EncodePng, DecodesToTheSamePixels) {
  for (const auto& [width, height] : {std::pair{1, 1}, {3, 2}, {257, 65}}) {
    const Image image = gradient(width, height);
    const std::string png = encode_png(image);
    int x = 0, y = 0, channels = 0;
    stbi_uc* pixels = stbi_load_from_memory(reinterpret_cast<const stbi_uc*>(png.data()),
                                            static_cast<int>(png.size()), &x, &y, &channels, 0);
    ASSERT_NE(pixels, nullptr);
    EXPECT_EQ(x, width);
    EXPECT_EQ(y, height);
    EXPECT_EQ(channels, 3);
    EXPECT_TRUE(std::equal(image.rgb.begin(), image.rgb.end(), pixels));
    stbi_image_free(pixels);
  }
}

TEST(EncodePng, RejectsAnImageWithoutAllItsPixels) {
  EXPECT_THROW(encode_png({4, 4, {}}), InputError);
  EXPECT_THROW(encode_png({}), InputError);
}

TEST(ContactSheet, PutsEveryImageInItsPlaceInRows) {
  const std::vector<Image> images = {plain(20, 10, 10), plain(20, 10, 20), plain(20, 10, 30),
                                     plain(20, 10, 40), plain(20, 10, 50)};
  const Image sheet = contact_sheet(images, 2);
  EXPECT_EQ(sheet.width, 2 * 20 + 4);
  EXPECT_EQ(sheet.height, 3 * 10 + 2 * 4);
  ASSERT_EQ(sheet.rgb.size(), std::size_t(3 * sheet.width * sheet.height));
  for (int i = 0; i < 5; ++i) {
    const int left = i % 2 * 24, top = i / 2 * 14;
    for (const auto& [x, y] : {std::pair{0, 0}, {19, 0}, {0, 9}, {19, 9}}) {
      EXPECT_EQ(sheet.pixel(left + x, top + y)[1], 10 * (i + 1));
    }
  }
  EXPECT_EQ(sheet.pixel(21, 5)[0], 255);   // between columns
  EXPECT_EQ(sheet.pixel(5, 12)[0], 255);   // between rows
  EXPECT_EQ(sheet.pixel(30, 33)[0], 255);  // where there is no sixth image
}

TEST(ContactSheet, ASingleRowIsNoWiderThanItsImages) {
  const std::vector<Image> images(2, plain(8, 8, 0));
  EXPECT_EQ(contact_sheet(images, 10).width, 2 * 8 + 4);
}

TEST(ContactSheet, LabelsAreDrawnOnTheirImages) {
  const std::vector<Image> images(2, plain(100, 40, 200));
  const std::vector<std::string> labels = {"t = 2.50 s", ""};
  const Image sheet = contact_sheet(images, 2, labels);
  int marked = 0, ink = 0;
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 100; ++x) {
      if (sheet.pixel(x, y)[0] < 100) ++marked;
      EXPECT_EQ(sheet.pixel(104 + x, y)[0], 200);
    }
  }
  for (const char c : labels[0]) {
    for (const std::uint8_t column : glyph(c)) ink += __builtin_popcount(column);
  }
  EXPECT_EQ(marked, ink);
}

TEST(ContactSheet, ALabelThatIsTooLongIsCutAtTheEdgeOfTheSheet) {
  const std::vector<Image> images(1, plain(30, 20, 200));
  const std::vector<std::string> labels = {std::string(200, 'W') + "\n\xff"};
  EXPECT_EQ(contact_sheet(images, 1, labels).width, 30);
}

TEST(ContactSheet, RejectsWhatDoesNotFitTogether) {
  const std::vector<Image> images = {plain(20, 10, 10), plain(20, 11, 20)};
  EXPECT_THROW(contact_sheet(images, 2), InputError);
  EXPECT_THROW(contact_sheet({}, 2), InputError);
  EXPECT_THROW(contact_sheet(std::span(images).first(1), 0), InputError);
  const std::vector<std::string> labels = {"one", "two"};
  EXPECT_THROW(contact_sheet(std::span(images).first(1), 1, labels), InputError);
}

TEST(Glyph, EveryPrintableCharacterHasItsOwn) {
  std::set<Glyph> seen;
  for (char c = ' '; c <= '~'; ++c) seen.insert(glyph(c));
  EXPECT_EQ(seen.size(), 95U);
  EXPECT_THAT(glyph(' '), testing::Each(0));
  EXPECT_EQ(glyph('\n'), glyph('\x7f'));
  EXPECT_FALSE(seen.contains(glyph('\n')));
}

TEST(Glyph, OLooksLikeARingAndLLikeAnAngle) {
  for (int row = 0; row < 7; ++row) {
    EXPECT_EQ(glyph('L')[0] >> row & 1, 1);
    EXPECT_EQ(glyph('O')[0] >> row & 1, row > 0 && row < 6 ? 1 : 0);
    EXPECT_EQ(glyph('O')[0] >> row & 1, glyph('O')[4] >> row & 1);
  }
  for (std::size_t column = 1; column < 5; ++column) EXPECT_EQ(glyph('L')[column], 1 << 6);
}

}  // namespace
}  // namespace tremula
