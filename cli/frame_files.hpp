// Where the frames of a film go: one picture, a file for each, or a film.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace tremula::cli {

enum class FrameForm { still, sequence, film };

struct FrameFiles {
  std::string path;  // of a sequence with one %d or %04d, where the number of the frame goes
  FrameForm form = FrameForm::still;
  std::string extension;  // ".png", ".exr", ".mp4", ".webm", ".gif"

  std::string path_of(int frame) const;
};

// Throws InputError for a path that has another extension, or other % than one of %d, %4d, %04d.
FrameFiles frame_files(const std::string& path);

// "17", "10-20", "0-470:10" as frames of a film of so many; "" takes all. Throws InputError.
std::vector<int> frames_of(const std::string& text, int count);

}  // namespace tremula::cli
