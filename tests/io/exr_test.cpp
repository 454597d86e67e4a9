#include "tremula/io/exr.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tremula/base/error.hpp"

#ifdef TREMULA_HAVE_OPENEXR
#include <cstring>
#include <vector>

#include <ImfChannelList.h>
#include <ImfChromaticities.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfStandardAttributes.h>
#endif

namespace tremula {
namespace {

LinearImage gradient(int width, int height) {
  LinearImage image{width, height, {}};
  for (int i = 0; i < 3 * width * height; ++i)
    image.rgb.push_back(1e-3F * static_cast<float>(i) * static_cast<float>(i % 7));
  return image;
}

TEST(EncodeExr, RejectsAnImageWithoutAllItsPixels) {
  EXPECT_THROW(encode_exr(LinearImage{2, 2, {}}), InputError);
  EXPECT_THROW(encode_exr(LinearImage{}), InputError);
}

#ifndef TREMULA_HAVE_OPENEXR

TEST(EncodeExr, SaysWhatItNeedsWhereItIsNotThere) {
  EXPECT_FALSE(has_exr());
  EXPECT_THROW(encode_exr(gradient(2, 2)), Error);
}

#else

class Bytes : public Imf::IStream {
 public:
  explicit Bytes(const std::string& bytes) : Imf::IStream("test"), bytes_(bytes) {}
  bool read(char data[], int count) override {
    std::memcpy(data, bytes_.data() + place_, static_cast<std::size_t>(count));
    place_ += static_cast<std::size_t>(count);
    return place_ < bytes_.size();
  }
  std::uint64_t tellg() override { return place_; }
  void seekg(std::uint64_t place) override { place_ = place; }

 private:
  const std::string& bytes_;
  std::uint64_t place_ = 0;
};

// Channels as floats, interleaved.
LinearImage decoded(const std::string& bytes, const std::vector<const char*>& channels) {
  Bytes stream(bytes);
  Imf::InputFile file(stream);
  const auto size = file.header().dataWindow();
  LinearImage image{size.max.x + 1, size.max.y + 1, {}};
  image.rgb.resize(static_cast<std::size_t>(3 * image.width * image.height));
  Imf::FrameBuffer frame;
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_NE(file.header().channels().findChannel(channels[c]), nullptr) << channels[c];
    frame.insert(channels[c], Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(image.rgb.data() + c), 12,
                                         12 * static_cast<std::size_t>(image.width)));
  }
  file.setFrameBuffer(frame);
  file.readPixels(0, image.height - 1);
  return image;
}

TEST(EncodeExr, ReadsBackToThePrecisionOfHalfFloats) {
  for (const auto& [width, height] : {std::pair{1, 1}, {5, 3}, {131, 70}}) {
    const LinearImage image = gradient(width, height);
    const LinearImage found = decoded(encode_exr(image), {"R", "G", "B"});
    EXPECT_EQ(found.width, width);
    EXPECT_EQ(found.height, height);
    for (std::size_t i = 0; i < image.rgb.size(); ++i)
      EXPECT_NEAR(found.rgb[i], image.rgb[i], image.rgb[i] * 0x1p-11F + 1e-7F);
  }
}

TEST(EncodeExr, WritesWhatHalfFloatsDoNotHoldAsTheNearestTheyDo) {
  constexpr float infinite = std::numeric_limits<float>::infinity();
  const LinearImage image{
      2, 1, {1e9F, infinite, -infinite, std::numeric_limits<float>::quiet_NaN(), 1e-20F, -0.5F}};
  const LinearImage found = decoded(encode_exr(image), {"R", "G", "B"});
  EXPECT_EQ(found.rgb, (std::vector<float>{65504, 65504, -65504, 0, 0, -0.5F}));
}

TEST(EncodeExr, HasGuidesAsLayersAndTheSameBytesEveryTime) {
  TracedImage traced{gradient(9, 4), gradient(9, 4), gradient(9, 4)};
  traced.albedo.rgb[4] = 0.25F;
  traced.normal.rgb[5] = -1;
  const std::string bytes = encode_exr(traced);
  EXPECT_EQ(bytes, encode_exr(traced));
  EXPECT_EQ(decoded(bytes, {"albedo.R", "albedo.G", "albedo.B"}).rgb[4], 0.25F);
  EXPECT_EQ(decoded(bytes, {"normal.X", "normal.Y", "normal.Z"}).rgb[5], -1);
  traced.albedo = gradient(8, 4);
  EXPECT_THROW(encode_exr(traced), InputError);
}

TEST(EncodeExr, SaysThatItsPrimariesAreThoseOfRec709) {
  const std::string bytes = encode_exr(gradient(2, 2));
  Bytes stream(bytes);
  const Imf::InputFile file(stream);
  ASSERT_TRUE(Imf::hasChromaticities(file.header()));
  EXPECT_NEAR(Imf::chromaticities(file.header()).red.x, 0.64, 1e-6);
  EXPECT_NEAR(Imf::chromaticities(file.header()).white.y, 0.329, 1e-6);
}

#endif

}  // namespace
}  // namespace tremula
