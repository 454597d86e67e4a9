#include "tremula/io/html.hpp"

#include "tremula/base/error.hpp"
#include "tremula/io/atomic_file.hpp"
#include "tremula/io/base64.hpp"

#include <algorithm>
#include <cstdint>
#include <string_view>

#include <zlib.h>

namespace tremula {

// The page as the viewer's build made it, empty without Node.js. Written by viewer/scripts/embed.mjs.
std::string_view viewer_page();

namespace {

// The page holds each of these once.
constexpr std::string_view title_mark = "@TREMULA_TITLE@", loop_mark = "@TREMULA_LOOP@";

// Chromium's strings end at 512 MiB, and the page reads the loop as one.
constexpr std::size_t max_encoded_size = 500'000'000;

// What browsers unpack themselves (DecompressionStream).
std::string gzip(std::string& bytes) {
  z_stream stream{};
  constexpr int gzip_window = 15 + 16;  // 2^15 bytes; 16 asks for the header of gzip
  if (deflateInit2(&stream, Z_BEST_COMPRESSION, Z_DEFLATED, gzip_window, 9, Z_DEFAULT_STRATEGY) != Z_OK)
    throw Error(".html: zlib cannot start");
  std::string packed(deflateBound(&stream, bytes.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(bytes.data());
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  const int result = deflate(&stream, Z_FINISH);
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  if (result != Z_STREAM_END) throw Error(".html: zlib cannot pack the loop");
  return packed;
}

std::string escape(std::string_view text) {
  std::string result;
  for (const char c : text) {
    if (c == '<')
      result += "&lt;";
    else if (c == '&')
      result += "&amp;";
    else
      result += c;
  }
  return result;
}

void check_can_write() {
  if (!can_write_html()) {
    throw Error(
        ".html: this program was built without the viewer; build it where node and npm are installed");
  }
}

}  // namespace

bool can_write_html() { return !viewer_page().empty(); }

std::string encode_page(std::string data, const std::string& name) {
  check_can_write();
  const std::string_view page = viewer_page();
  const std::size_t title = page.find(title_mark), loop = page.find(loop_mark);
  const std::string packed = gzip(data);
  const std::size_t encoded_size = base64_size(packed.size());
  if (encoded_size > max_encoded_size) {
    throw Error(".html: the loop would take " + std::to_string(encoded_size) +
                " bytes and browsers open at most " + std::to_string(max_encoded_size) +
                ": ask for fewer modes or a coarser surface");
  }
  std::string html;
  html.reserve(page.size() + encoded_size + name.size() + 64);
  html += page.substr(0, title);
  html += escape(name);
  html += page.substr(title + title_mark.size(), loop - title - title_mark.size());
  append_base64(html, packed);
  html += page.substr(loop + loop_mark.size());
  return html;
}

std::string encode_html(const Surface& surface, const MorphTargets& morphs, const LoopFacts& facts) {
  check_can_write();
  return encode_page(encode_glb(surface, morphs, facts, {.compression = MeshCompression::meshopt}),
                     facts.name);
}

std::string encode_html(const Loop& loop, const Rig& rig) {
  check_can_write();
  return encode_page(encode_glb(loop, rig, {.compression = MeshCompression::meshopt, .shapes = true}),
                     loop.facts.name);
}

void write_html(const std::string& path, const Surface& surface, const MorphTargets& morphs,
                const LoopFacts& facts) {
  write_file_atomically(path, encode_html(surface, morphs, facts));
}

}  // namespace tremula
