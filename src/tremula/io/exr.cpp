#include "tremula/io/exr.hpp"

#include "tremula/base/check.hpp"
#include "tremula/base/error.hpp"

#ifdef TREMULA_HAVE_OPENEXR

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <exception>
#include <vector>

#include <ImathBox.h>
#include <ImfChannelList.h>
#include <ImfChromaticities.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfOutputFile.h>
#include <ImfStandardAttributes.h>
#include <half.h>

namespace tremula {
namespace {

// A file in memory: its index of lines is filled in when they are all there.
class StringStream : public Imf::OStream {
 public:
  explicit StringStream(std::string& bytes) : Imf::OStream("memory"), bytes_(bytes) {}
  void write(const char data[], int count) override {
    const std::size_t size = static_cast<std::size_t>(count);
    if (place_ + size > bytes_.size()) bytes_.resize(place_ + size);
    std::memcpy(bytes_.data() + place_, data, size);
    place_ += size;
  }
  std::uint64_t tellp() override { return place_; }
  void seekp(std::uint64_t place) override { place_ = static_cast<std::size_t>(place); }

 private:
  std::string& bytes_;
  std::size_t place_ = 0;
};

half nearest_half(float value) {
  if (std::isnan(value)) return half(0.0F);
  constexpr auto most = static_cast<float>(HALF_MAX);
  return half(std::clamp(value, -most, most));
}

struct Layer {
  const LinearImage* image;
  const char* channels[3];
};

std::string encode(const std::vector<Layer>& layers) {
  const LinearImage& first = *layers.front().image;
  for (const Layer& layer : layers) {
    check_all_pixels(*layer.image);
    check_equal("width of a layer", layer.image->width, first.width);
    check_equal("height of a layer", layer.image->height, first.height);
  }
  try {
    Imf::Header header(first.width, first.height);
    header.compression() = Imf::ZIP_COMPRESSION;
    Imf::addChromaticities(header, Imf::Chromaticities());  // Rec. 709 unless told otherwise
    Imf::FrameBuffer frame;
    std::vector<std::vector<half>> halves;
    for (const Layer& layer : layers) {
      const std::vector<float>& values = layer.image->rgb;
      halves.emplace_back(values.size());
      std::transform(values.begin(), values.end(), halves.back().begin(), nearest_half);
      for (std::size_t c = 0; c < 3; ++c) {
        header.channels().insert(layer.channels[c], Imf::Channel(Imf::HALF));
        frame.insert(layer.channels[c],
                     Imf::Slice(Imf::HALF, reinterpret_cast<char*>(halves.back().data() + c),
                                3 * sizeof(half), 3 * sizeof(half) * static_cast<std::size_t>(first.width)));
      }
    }
    std::string bytes;
    StringStream stream(bytes);
    {
      Imf::OutputFile file(stream, header, 0);
      file.setFrameBuffer(frame);
      file.writePixels(first.height);
    }
    return bytes;
  } catch (const std::exception& error) {
    throw Error(std::string("cannot encode a picture as OpenEXR: ") + error.what());
  }
}

}  // namespace

bool has_exr() { return true; }

std::string encode_exr(const LinearImage& image) { return encode({{&image, {"R", "G", "B"}}}); }

std::string encode_exr(const TracedImage& traced) {
  return encode({{&traced.light, {"R", "G", "B"}},
                 {&traced.albedo, {"albedo.R", "albedo.G", "albedo.B"}},
                 {&traced.normal, {"normal.X", "normal.Y", "normal.Z"}}});
}

}  // namespace tremula

#else

namespace tremula {
namespace {

[[noreturn]] void is_missing() {
  throw Error(
      ".exr needs OpenEXR, and this was built without it: install libopenexr-dev and build again, or write "
      ".png");
}

}  // namespace

bool has_exr() { return false; }

std::string encode_exr(const LinearImage& image) {
  check_all_pixels(image);
  is_missing();
}

std::string encode_exr(const TracedImage& traced) { return encode_exr(traced.light); }

}  // namespace tremula

#endif
