#include "tremula/io/html.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "support.hpp"
#include "tremula/base/error.hpp"

namespace tremula {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

struct Triangle {
  Surface surface;
  MorphTargets morphs;

  Triangle() {
    surface.position = {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}};
    surface.normal.assign(3, {0, -1, 0});
    surface.texture = {{0, 0}, {1, 0}, {0, 1}};
    surface.branch = {0, 0, 0};
    surface.along = {0, 0, 1};
    surface.parts.resize(1);
    surface.parts[0].material.name = "bark";
    surface.parts[0].triangles = {0, 1, 2};
    morphs.period = 1;
    morphs.frequencies = {2};
    morphs.shapes = {{{{0, 0, 0}, {0, 0, 0}, {0.1F, 0, 0}}, std::vector<Eigen::Vector3f>(3, {0, 0, 0})}};
    morphs.targets = {{"mode 01 2.000 Hz", ShapeKind::mode, 0, 0, 1}};
    morphs.times = {0, 0.5F, 1};
    morphs.weights = {-1, 1, -1};
  }
};

std::string between(const std::string& text, const std::string& begin, const std::string& end) {
  const std::size_t from = text.find(begin);
  if (from == std::string::npos) return "";
  return text.substr(from + begin.size(), text.find(end, from) - from - begin.size());
}

std::string decode_base64(const std::string& text) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned bits = 0;
  int count = 0;
  for (const char c : text) {
    if (c == '=') break;
    bits = bits << 6 | static_cast<unsigned>(digits.find(c));
    count += 6;
    if (count >= 8) {
      count -= 8;
      bytes += static_cast<char>(bits >> count & 255);
    }
  }
  return bytes;
}

std::string unpack_gzip(const std::string& packed) {
  z_stream stream{};
  EXPECT_EQ(inflateInit2(&stream, 15 + 16), Z_OK);
  std::string bytes(1 << 20, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
  stream.avail_in = static_cast<uInt>(packed.size());
  stream.next_out = reinterpret_cast<Bytef*>(bytes.data());
  stream.avail_out = static_cast<uInt>(bytes.size());
  EXPECT_EQ(inflate(&stream, Z_FINISH), Z_STREAM_END);
  bytes.resize(stream.total_out);
  inflateEnd(&stream);
  return bytes;
}

#define NEED_VIEWER() \
  if (!can_write_html()) GTEST_SKIP() << "built without node and npm"

TEST(EncodeHtml, ThePageHoldsTheLoop) {
  NEED_VIEWER();
  const Triangle t;
  // Names of different lengths, so that the data ends at every place of a group of three bytes.
  for (const char* name : {"a", "birch", "birch in the wind", "oak 17"}) {
    const LoopFacts facts{.name = name};
    const std::string data = between(encode_html(t.surface, t.morphs, facts),
                                     R"(<script id="loop" type="text/plain">)", "</script>");
    EXPECT_EQ(data.size() % 4, 0U);
    EXPECT_EQ(unpack_gzip(decode_base64(data)),
              encode_glb(t.surface, t.morphs, facts, {.compression = MeshCompression::meshopt}));
  }
}

TEST(EncodeHtml, TheNameCannotBreakThePage) {
  NEED_VIEWER();
  const Triangle t;
  const std::string html = encode_html(t.surface, t.morphs, {.name = "</title><script>alert(1)</script>&"});
  EXPECT_EQ(between(html, "<title>", "</title>"), "&lt;/title>&lt;script>alert(1)&lt;/script>&amp;");
  EXPECT_THAT(html, Not(HasSubstr("<script>alert")));
}

TEST(EncodeHtml, ThePageMayNotAskTheNetwork) {
  NEED_VIEWER();
  const Triangle t;
  EXPECT_THAT(encode_html(t.surface, t.morphs, {}), HasSubstr("default-src 'none'"));
}

TEST(EncodeHtml, GivesTheSameBytesEveryTime) {
  NEED_VIEWER();
  const Triangle t;
  EXPECT_EQ(encode_html(t.surface, t.morphs, {}), encode_html(t.surface, t.morphs, {}));
}

TEST(EncodeHtml, SaysWhatIsMissingWithoutTheViewer) {
  if (can_write_html()) GTEST_SKIP() << "built with the viewer";
  const Triangle t;
  try {
    encode_html(t.surface, t.morphs, {});
    FAIL() << "wrote a page";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("built without the viewer"));
  }
}

TEST(WriteHtml, WritesThePageOrNothing) {
  NEED_VIEWER();
  const test::TemporaryFolder folder;
  const Triangle t;
  write_html(folder / "tree.html", t.surface, t.morphs, {});
  std::ifstream file(folder / "tree.html", std::ios::binary);
  std::stringstream bytes;
  bytes << file.rdbuf();
  EXPECT_EQ(bytes.str(), encode_html(t.surface, t.morphs, {}));

  EXPECT_THROW(write_html(folder / "bad.html", Surface{}, t.morphs, {}), Error);
  EXPECT_FALSE(std::filesystem::exists(folder / "bad.html"));
}

}  // namespace
}  // namespace tremula
