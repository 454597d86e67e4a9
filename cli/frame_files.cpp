#include "frame_files.hpp"

#include "tremula/base/error.hpp"
#include "tremula/io/film.hpp"

#include <algorithm>
#include <charconv>
#include <regex>

#include "outputs.hpp"

namespace tremula::cli {
namespace {

const std::regex number_in_name("%(0?)([1-9]?)d");

}  // namespace

std::string FrameFiles::path_of(int frame) const {
  std::smatch found;
  if (form != FrameForm::sequence || !std::regex_search(path, found, number_in_name)) return path;
  std::string number = std::to_string(frame);
  const std::size_t width = found[2].length() > 0 ? static_cast<std::size_t>(*found[2].first - '0') : 0;
  if (number.size() < width) number.insert(0, width - number.size(), found[1].length() > 0 ? '0' : ' ');
  return found.prefix().str() + number + found.suffix().str();
}

FrameFiles frame_files(const std::string& path) {
  FrameFiles files{path, FrameForm::still, lower_extension(path)};
  const bool of_film = is_film(path);
  if (!of_film && files.extension != ".png" && files.extension != ".exr")
    throw InputError("-o " + path, "cannot be rendered into", ".png, .exr, .mp4, .webm or .gif");
  const std::ptrdiff_t percents = std::ranges::count(path, '%');
  if (percents == 0) {
    files.form = of_film ? FrameForm::film : FrameForm::still;
    return files;
  }
  if (percents > 1 || !std::regex_search(path, number_in_name))
    throw InputError("-o " + path, "%", "one number of the frame in it, as in frames/%04d.png");
  if (of_film)
    throw InputError("-o " + path, "a film with a number of the frame", "frames/%04d.png or film.mp4");
  files.form = FrameForm::sequence;
  return files;
}

std::vector<int> frames_of(const std::string& text, int count) {
  int first = 0, last = count - 1, step = 1;
  if (!text.empty()) {
    const char *at = text.data(), *end = at + text.size();
    const auto take = [&](int& value) {
      const auto read = std::from_chars(at, end, value);
      at = read.ptr;
      return read.ec == std::errc{};
    };
    bool good = take(first);
    last = first;
    if (good && at != end && *at == '-') good = ++at != end && take(last);
    if (good && at != end && *at == ':') good = ++at != end && take(step);
    if (!good || at != end || first < 0 || first > last || last >= count || step < 1) {
      throw InputError("--frames", "'" + text + "'",
                       "a frame, a range such as 10-20, or every tenth of one, 0-90:10, within 0-" +
                           std::to_string(count - 1));
    }
  }
  std::vector<int> frames;
  for (int frame = first; frame <= last; frame += step) frames.push_back(frame);
  return frames;
}

}  // namespace tremula::cli
