// Films, by the program ffmpeg, which is looked for in PATH: .mp4 (H.264), .webm (VP9) and .gif. Frame k is
// shown from k / frames per second on for as long as any other, so that a loop whose period is frames /
// frames per second follows itself without a seam. Nothing in the file tells when or by which version it was
// made.
#pragma once

#include "tremula/render/image.hpp"

#include <cstddef>
#include <memory>
#include <optional>
#include <string>

namespace tremula {

// Whether a path is that of a film, by its extension.
bool is_film(const std::string& path);

struct FilmSettings {
  int width = 0, height = 0;  // of the frames [pixels], 16 … 8192
  int frames = 0;             // that will be added
  double frame_rate = 25;     // [1/s], above 0 … 240; of .gif up to 50
  std::optional<int>
      crf;  // quality of .mp4 (0 … 51, as it is 20) and .webm (0 … 63, as it is 32): less is better
};

// Where a film of odd width or height is one pixel wider or higher, as its colours are kept for two by two
// pixels: its last column or row is there twice. Not so .gif.
//
// The file gets its name when it is whole (see atomic_file.hpp). A .gif of up to most_for_palette bytes of
// pixels has one palette; larger ones have a palette for each frame.
inline constexpr std::size_t most_for_palette = std::size_t{1} << 30;

class Film {
 public:
  // Throws InputError for another extension and for numbers out of range, Error (naming the path) where
  // nothing can be written there or ffmpeg is not there: at once, not after the frames are made.
  Film(const std::string& path, const FilmSettings& settings);
  ~Film();  // without finish() nothing is left behind
  Film(const Film&) = delete;
  Film& operator=(const Film&) = delete;

  void add(
      const Image& frame);  // the next one; throws InputError for another size, Error with what ffmpeg says
  void finish();            // after the last one; throws InputError unless all are there, Error as above

 private:
  struct Process;
  std::unique_ptr<Process> process_;
};

}  // namespace tremula
