// Where the frames of a film go: one picture, a file for each, or a film.
#pragma once

#include "tremula/io/film.hpp"
#include "tremula/render/denoise.hpp"
#include "tremula/render/tone_map.hpp"

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "outputs.hpp"

namespace tremula::cli {

enum class FrameForm { still, sequence, film };

struct FrameFiles {
  std::string path;  // of a sequence with one %d or %04d, where the number of the frame goes
  FrameForm form = FrameForm::still;
  std::string extension;  // ".png", ".exr", ".vdb", ".mp4", ".webm", ".gif"

  std::string path_of(int frame) const;
};

// Throws InputError for a path that has another extension, or other % than one of %d, %4d, %04d.
FrameFiles frame_files(const std::string& path);
// The same of a name whose extension is known to be that of a picture or a volume.
FrameFiles numbered_files(const std::string& path);

// "17", "10-20", "0-470:10" as frames up to `most`; "" takes the `count` of a film. Throws InputError.
std::vector<int> frames_of(const std::string& text, int count, int most);

// A folder for frames is made where it is not there. Throws Error.
void make_folders(const std::vector<FrameFiles>& files);

// What would be written; in folders that are not there yet nothing can be overwritten.
std::vector<Place> output_places(const std::vector<FrameFiles>& files, const std::vector<int>& frames,
                                 const std::string& report);

struct FilmFormat {
  int width = 0, height = 0;  // [pixels]
  int frames = 0;
  double frames_per_second = 0;
};

// The light of every frame, made into what its files hold.
class FrameWriter {
 public:
  // `stills`: where pictures that are one file go. No denoiser: noise stays. Throws as Film does.
  FrameWriter(std::vector<FrameFiles> files, const FilmFormat& format, std::optional<Denoiser> denoiser,
              const ToneMapping& tones, Outputs& stills);

  bool has(int frame) const;  // whether all files of this frame are there
  Image shown(const TracedImage& traced) const;
  // A frame that has a file of its own is written at once: what is finished stays when the work is stopped.
  void write(int frame, const TracedImage& traced);
  void finish();

 private:
  LinearImage light_of(const TracedImage& traced) const;

  std::vector<FrameFiles> files_;
  std::optional<Denoiser> denoiser_;
  ToneMapping tones_;
  Outputs& stills_;
  std::vector<std::unique_ptr<Film>> films_;
};

}  // namespace tremula::cli
