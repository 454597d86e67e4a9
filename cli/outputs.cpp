#include "outputs.hpp"

#include "tremula/base/error.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <iostream>

#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

namespace tremula::cli {
namespace {

constexpr const char* standard_output = "-";

// The same for two names of one file. Empty where two may write what they like: /dev/null.
std::string identity(const std::string& path) {
  struct stat status;
  const bool exists =
      path == standard_output ? ::fstat(STDOUT_FILENO, &status) == 0 : ::stat(path.c_str(), &status) == 0;
  if (!exists) {
    if (path == standard_output) return "";
    const std::filesystem::path target = std::filesystem::absolute(file_behind(path));
    return (std::filesystem::canonical(target.parent_path()) / target.filename()).string();
  }
  if (S_ISCHR(status.st_mode) && status.st_rdev == makedev(1, 3))
    return path == standard_output ? "stdout" : "";
  return std::to_string(status.st_dev) + ":" + std::to_string(status.st_ino);
}

std::string shown(const Place& place) {
  return place.flag.starts_with('-') ? place.flag + " " + place.path : place.path;
}

std::unique_ptr<AtomicFile> open_output(const std::string& path) {
  if (path == standard_output) return std::make_unique<AtomicFile>(STDOUT_FILENO, "standard output");
  return std::make_unique<AtomicFile>(path);
}

// "/motion/largest_rms_m" of the first number that is not finite.
const Json* find_not_finite(const Json& json, std::string& where) {
  if (json.is_number_float()) return std::isfinite(json.get<double>()) ? nullptr : &json;
  if (!json.is_structured()) return nullptr;
  for (const auto& [key, value] : json.items()) {
    const std::size_t before = where.size();
    where += "/" + key;
    if (const Json* found = find_not_finite(value, where)) return found;
    where.resize(before);
  }
  return nullptr;
}

}  // namespace

Outputs::Outputs(const std::vector<Place>& outputs, const std::vector<Place>& inputs) {
  std::vector<std::pair<std::string, Place>> taken;
  for (const Place& input : inputs) {
    std::error_code ignored;
    if (!std::filesystem::exists(input.path, ignored)) continue;  // a preset, the name of a model
    taken.emplace_back(identity(input.path), input);
  }
  const std::size_t input_count = taken.size();
  for (const Place& output : outputs) {
    if (output.path.empty()) continue;
    if (output.path == standard_output) {
      AtomicFile(STDOUT_FILENO, "standard output");
    } else {
      file_behind(output.path);
    }
    const std::string id = identity(output.path);
    for (std::size_t i = 0; i < taken.size() && !id.empty(); ++i) {
      if (taken[i].first != id) continue;
      throw InputError(shown(output),
                       i < input_count ? "would replace the input " + shown(taken[i].second)
                                       : "goes where " + shown(taken[i].second) + " goes",
                       i < input_count ? "another file" : "a place of its own");
    }
    taken.emplace_back(id, output);
  }
}

AtomicFile& Outputs::begin(const std::string& path, const std::string& told) {
  files_.push_back(open_output(path));
  if (path != standard_output) written_.push_back(told.empty() ? path : path + ": " + told);
  return *files_.back();
}

void Outputs::add(const std::string& path, std::string_view bytes, const std::string& told) {
  begin(path, told).write(bytes);
}

void Outputs::commit() {
  std::vector<AtomicFile*> files;
  for (const auto& file : files_) files.push_back(file.get());
  commit_together(files);
  files_.clear();
}

void Outputs::announce() const {
  for (const std::string& what : written_) std::cerr << "tremula: wrote " << what << '\n';
}

void print(std::string_view text) {
  AtomicFile out(STDOUT_FILENO, "standard output");
  out.write(text);
  out.commit();
}

std::string text_of(const Json& json) {
  std::string where;
  if (const Json* found = find_not_finite(json, where)) {
    throw Error("JSON: " + where + " is " + std::to_string(found->get<double>()) +
                ", and nothing is written that is not finite");
  }
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + '\n';
}

std::string lower_extension(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

std::size_t format_of(const Place& place, const std::string& named, const std::vector<Format>& formats,
                      int by_default) {
  const auto index_of = [&](std::string_view name) {
    return static_cast<std::size_t>(std::find_if(formats.begin(), formats.end(),
                                                 [&](const Format& format) { return format.name == name; }) -
                                    formats.begin());
  };
  std::string extensions;
  for (const Format& format : formats) {
    extensions.append(extensions.empty() ? "." : ", .").append(format.name);
    extensions.append(" (").append(format.what).append(")");
  }
  const std::string extension = lower_extension(place.path);
  if (!extension.empty()) {
    const std::size_t format = index_of(std::string_view(extension).substr(1));
    if (format == formats.size()) throw InputError(shown(place), "'" + extension + "'", extensions);
    if (!named.empty() && named != formats[format].name) {
      throw InputError("--format " + named, "given with " + shown(place),
                       "--format " + std::string(formats[format].name) + ", or none: the extension decides");
    }
    return format;
  }
  if (!named.empty()) return index_of(named);
  if (by_default >= 0) return static_cast<std::size_t>(by_default);
  throw InputError(shown(place), "has no extension that says what to write", extensions);
}

}  // namespace tremula::cli
