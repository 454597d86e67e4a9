#include "frame_files.hpp"

#include "tremula/base/error.hpp"
#include "tremula/io/exr.hpp"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <regex>
#include <utility>

namespace tremula::cli {
namespace {

const std::regex number_in_name("%(0?)([1-9]?)d");

std::string folder_of(const std::string& path) { return std::filesystem::path(path).parent_path().string(); }

bool has_folder(const FrameFiles& files) {
  const std::string folder = folder_of(files.path);
  return folder.empty() || std::filesystem::exists(folder);
}

// As bright as what is shown, and linear.
LinearImage exposed(LinearImage light, double exposure) {
  for (float& value : light.rgb) value *= static_cast<float>(exposure);
  return light;
}

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
  const std::string extension = lower_extension(path);
  if (!is_film(path)) {
    if (extension != ".png" && extension != ".exr")
      throw InputError("-o " + path, "cannot be rendered into", ".png, .exr, .mp4, .webm or .gif");
    return numbered_files(path);
  }
  if (numbered_files(path).form == FrameForm::sequence)
    throw InputError("-o " + path, "a film with a number of the frame", "frames/%04d.png or film.mp4");
  return {path, FrameForm::film, extension};
}

FrameFiles numbered_files(const std::string& path) {
  FrameFiles files{path, FrameForm::still, lower_extension(path)};
  const std::ptrdiff_t percents = std::ranges::count(path, '%');
  if (percents == 0) return files;
  if (percents > 1 || !std::regex_search(path, number_in_name)) {
    throw InputError("-o " + path, "%", "one number of the frame in it, as in frames/%04d" + files.extension);
  }
  files.form = FrameForm::sequence;
  return files;
}

std::vector<int> frames_of(const std::string& text, int count, int most) {
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
    if (!good || at != end || first < 0 || first > last || last > most || step < 1) {
      throw InputError(
          "--frames", "'" + text + "'",
          "a frame, a range such as 10-20, or every tenth of one, 0-90:10, within 0-" + std::to_string(most));
    }
  }
  std::vector<int> frames;
  for (int frame = first; frame <= last; frame += step) frames.push_back(frame);
  return frames;
}

void make_folders(const std::vector<FrameFiles>& files) {
  for (const FrameFiles& each : files) {
    if (each.form != FrameForm::sequence || has_folder(each)) continue;
    std::error_code error;
    std::filesystem::create_directories(folder_of(each.path), error);
    if (error) throw Error(folder_of(each.path) + ": " + error.message());
  }
}

std::vector<Place> output_places(const std::vector<FrameFiles>& files, const std::vector<int>& frames,
                                 const std::string& report) {
  std::vector<Place> places{{"--report", report}};
  for (const FrameFiles& each : files) {
    if (each.form != FrameForm::sequence) {
      places.push_back({"-o", each.path});
    } else if (has_folder(each)) {
      for (const int frame : frames) places.push_back({"-o", each.path_of(frame)});
    }
  }
  return places;
}

FrameWriter::FrameWriter(std::vector<FrameFiles> files, const FilmFormat& format,
                         std::optional<Denoiser> denoiser, const ToneMapping& tones, Outputs& stills)
    : files_(std::move(files)), denoiser_(denoiser), tones_(tones), stills_(stills) {
  for (const FrameFiles& each : files_) {
    if (each.form != FrameForm::film) continue;
    films_.push_back(std::make_unique<Film>(each.path, FilmSettings{.width = format.width,
                                                                    .height = format.height,
                                                                    .frames = format.frames,
                                                                    .frame_rate = format.frames_per_second,
                                                                    .crf = {}}));
  }
}

bool FrameWriter::has(int frame) const {
  return std::ranges::all_of(files_, [&](const FrameFiles& each) {
    return each.form == FrameForm::sequence && std::filesystem::exists(each.path_of(frame));
  });
}

LinearImage FrameWriter::light_of(const TracedImage& traced) const {
  return denoiser_ ? denoise(traced, *denoiser_) : traced.light;
}

Image FrameWriter::shown(const TracedImage& traced) const { return tone_map(light_of(traced), tones_); }

void FrameWriter::write(int frame, const TracedImage& traced) {
  const LinearImage light = light_of(traced);
  const Image image = tone_map(light, tones_);
  for (const std::unique_ptr<Film>& film : films_) film->add(image);
  for (const FrameFiles& each : files_) {
    if (each.form == FrameForm::film) continue;
    const std::string bytes =
        each.extension == ".exr" ? encode_exr(exposed(light, tones_.exposure)) : encode_png(image);
    if (each.form == FrameForm::still)
      stills_.add(each.path, bytes);
    else
      write_file_atomically(each.path_of(frame), bytes);
  }
}

void FrameWriter::finish() {
  for (const std::unique_ptr<Film>& film : films_) film->finish();
}

}  // namespace tremula::cli
