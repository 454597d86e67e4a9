// tremula animate of a volume of a scene: OpenVDB, a file for every frame; or a page of its shape model.
#include "tremula/base/error.hpp"
#include "tremula/base/memory.hpp"
#include "tremula/base/number_text.hpp"
#include "tremula/base/suggestion.hpp"
#include "tremula/io/vdb.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <string>
#include <utility>
#include <vector>

#include "animate.hpp"
#include "frame_files.hpp"
#include "scene_things.hpp"

namespace tremula::cli {
namespace {

constexpr double usual_texels = 2e7;  // at most, unless somebody asks for more

bool is_vdb(const std::string& path) { return lower_extension(path) == ".vdb"; }
bool is_html(const std::string& path) { return lower_extension(path) == ".html"; }

const SceneVolume* find_volume(const Scene& scene, const std::string& name) {
  const auto found = std::ranges::find(scene.volumes, name, &SceneVolume::name);
  return found != scene.volumes.end() ? &*found : nullptr;
}

[[noreturn]] void refuse_what_is_no_volume(const Scene& scene, const std::string& name) {
  std::vector<std::string> names;
  std::string list;
  for (const SceneVolume& volume : scene.volumes) {
    names.push_back(volume.name);
    list += (list.empty() ? "" : ", ") + volume.name;
  }
  throw InputError("--object", name.empty() ? "not given" : "'" + name + "'",
                   names.empty()
                       ? "a volume, for .vdb, and the scene has no [[volumes]]"
                       : "one of the volumes of the scene, for .vdb: " + list + suggestion(name, names));
}

std::vector<FrameFiles> files_of(const std::vector<std::string>& outputs, const std::string& name) {
  const std::string wanted = name + "/%04d.vdb (OpenVDB), " + name + ".html, or a picture by tremula render";
  if (outputs.empty()) throw InputError("animate", "no output", "-o " + wanted);
  std::vector<FrameFiles> files;
  for (const std::string& path : outputs) {
    if (is_html(path))
      throw InputError("-o " + path, "given beside other files of '" + name + "'", "a page by itself");
    if (!is_vdb(path))
      throw InputError("-o " + path, "given with '" + name + "', a volume, which has no mesh",
                       "-o " + wanted);
    if (!has_vdb())
      throw Error(
          "-o " + path +
          ": this program was built without OpenVDB (libopenvdb-dev), or has lost its tremula/openvdb.so");
    files.push_back(numbered_files(path));
  }
  return files;
}

// Of one file the first frame, unless somebody says which.
std::vector<int> frames_of_files(const std::vector<FrameFiles>& files, const std::string& frames, int count) {
  const bool still =
      std::ranges::any_of(files, [](const FrameFiles& each) { return each.form == FrameForm::still; });
  std::vector<int> picked = frames_of(still && frames.empty() ? "0" : frames, count, count);
  if (still && picked.size() > 1)
    throw InputError("--frames", "'" + frames + "'", "one frame for one file; -o NAME/%04d.vdb for more");
  return picked;
}

// Cubes that hold all of a field at any time.
struct TexelBox {
  Eigen::Vector3d low{0, 0, 0};  // [m]
  std::array<int, 3> count{1, 1, 1};
  double cell = 1;  // [m]

  double texels() const { return static_cast<double>(count[0]) * count[1] * count[2]; }
};

TexelBox box_around(const PosedVolume& posed, double cell) {
  TexelBox box{.low = posed.bounds.min().cast<double>(), .cell = cell};
  const Eigen::Vector3d size = posed.bounds.sizes().cast<double>();
  for (int i = 0; i < 3; ++i) {
    // A texture whose cells are the box's ends with one, whatever single precision says of it.
    const double cells = std::ceil(size[i] / cell - 1e-3);
    box.count[static_cast<std::size_t>(i)] = static_cast<int>(std::clamp(cells, 1.0, 2e9));
  }
  return box;
}

TexelBox usual_box(const PosedVolume& posed) {
  TexelBox box = box_around(posed, static_cast<double>(posed.field->patches[0][0].cell.x()));
  while (box.texels() > usual_texels)
    box = box_around(posed, box.cell * std::max(1.001, std::cbrt(box.texels() / usual_texels)));
  return box;
}

// The box, its grids where every texel is full, and what is written.
void check_room(const TexelBox& box) {
  constexpr double bytes_a_texel = sizeof(Texel) + 28 + 28, gigabyte = 1e9;
  const double wanted = bytes_a_texel * box.texels();
  const auto present = static_cast<double>(available_memory());
  if (box.texels() <= most_texels && wanted <= present) return;
  throw InputError("--texel-size",
                   number_text(box.cell) + " m, which makes a box of " + printed("%.3g", box.texels()) +
                       " texels and up to " + printed("%.3g", wanted / gigabyte) + " GB",
                   "a larger one: at most " + number_text(most_texels) + " texels, and there are " +
                       printed("%.3g", present / gigabyte) + " GB");
}

std::string text_of(const std::array<int, 3>& count) {
  return std::to_string(count[0]) + " x " + std::to_string(count[1]) + " x " + std::to_string(count[2]);
}

struct WrittenFrames {
  std::size_t frames = 0;
  double bytes = 0;

  double bytes_a_frame() const { return frames > 0 ? bytes / static_cast<double>(frames) : 0; }
};

// Every frame that is to be a file of its own is written at once: it stays when the work is stopped.
template <class Encode>
WrittenFrames write_frames(const std::vector<FrameFiles>& files, const std::vector<int>& frames, bool resume,
                           const Encode& encode, StageLog& log, Outputs& stills) {
  WrittenFrames written;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    log.progress("frames", static_cast<double>(i) / static_cast<double>(frames.size()));
    const auto is_there = [&](const FrameFiles& each) {
      return std::filesystem::exists(each.path_of(frames[i]));
    };
    if (resume && std::ranges::all_of(files, is_there)) continue;
    const std::string bytes = encode(frames[i]);
    ++written.frames;
    written.bytes += static_cast<double>(bytes.size());
    for (const FrameFiles& each : files) {
      if (each.form == FrameForm::still)
        stills.add(each.path, bytes);
      else
        write_file_atomically(each.path_of(frames[i]), bytes);
    }
  }
  return written;
}

// What there is of one output, in a line.
std::string told(const FrameFiles& files, const std::vector<int>& frames, const TexelBox& box,
                 const WrittenFrames& written) {
  std::string text = files.path_of(frames.front());
  if (frames.size() > 1)
    text += " to " + files.path_of(frames.back()) + ": " + std::to_string(frames.size()) + " files";
  text += ": " + text_of(box.count) + " texels of " + printed("%.3g", box.cell) + " m";
  if (written.frames > 0) text += ", " + printed("%.3g", written.bytes_a_frame() / 1e6) + " MB a frame";
  return text;
}

}  // namespace

bool AnimateCommand::animate_volume(const CLI::App& flags) const {
  const auto vdb = std::ranges::find_if(outputs, is_vdb);
  if (is_scene(plant.input)) {
    const Scene scene = open_scene(plant.input);
    if (const SceneVolume* volume = find_volume(scene, name_or_only(scene, object))) {
      const auto is_page = [&](const std::string& path) {
        return is_html(path) || (lower_extension(path).empty() && format == "html");
      };
      if (!outputs.empty() && std::ranges::all_of(outputs, is_page))
        write_strands(scene, *volume, flags);
      else
        write_volume(scene, *volume, flags);
      return true;
    }
    if (vdb != outputs.end()) refuse_what_is_no_volume(scene, object);
  }
  if (vdb == outputs.end()) return false;
  throw InputError("-o " + *vdb, "given with " + plant.input + ", which has a mesh",
                   ".glb, .html, .csv or .png; .vdb for an object of the [[volumes]] of a scene");
}

void AnimateCommand::write_strands(const Scene& scene, const SceneVolume& volume,
                                   const CLI::App& flags) const {
  const auto make = [&](const ThingSite& site) {
    const StrandField field = grow_strand_field(volume, site);
    const double share = share_of_page(field);
    std::string html = encode_volume_page(field, site.facts(volume.name, volume.seed));
    const std::size_t strands = shown_strands(field, share);
    std::string shown = std::to_string(strands) + " strands";
    if (share < 1) {
      shown += printed(", %.3g %% of all", 100 * share);
      site.warnings.add({volume.name + ": the page shows" + printed(" %.3g %%", 100 * share) +
                         " of the strands, each with the same chance, and as much wider"});
    }
    return ThingPage{std::move(html),
                     shown,
                     {{"object", volume.name},
                      {"species", volume.species},
                      {"page", {{"strands", strands}, {"share", share}}}}};
  };
  write_page(scene, volume.name, volume.place, "a volume", flags, output_writers(), make);
}

void AnimateCommand::write_volume(const Scene& scene, const SceneVolume& volume,
                                  const CLI::App& flags) const {
  constexpr std::array<std::string_view, 9> known{"--object", "--output",     "--report",
                                                  "--frames", "--texel-size", "--resume",
                                                  "--period", "--threads",    "--fps"};
  refuse_flags_of_plants(flags, volume.name, known);
  const std::vector<FrameFiles> files = files_of(outputs, volume.name);
  if (!report.empty()) format_of({"--report", report}, "", {{"json", "what was done"}}, 0);
  if (resume && std::ranges::any_of(files, [](const auto& each) { return each.form == FrameForm::still; }))
    throw InputError("--resume", "given with one file", "-o " + volume.name + "/%04d.vdb");
  const SceneCommands commands = commands_of(scene, flags);
  if (commands.is_clip) throw InputError("the motion of the scene", "a clip", "a loop, which volumes need");
  const std::vector<int> picked = frames_of_files(files, frames, commands.loop.sample_count);
  std::vector<Place> inputs = commands.input_places();
  inputs.push_back({"SCENE", plant.input});
  Outputs stills(tremula::cli::output_places(files, picked, report), inputs);

  StageLog log;
  WarningLog warnings;
  const FilmCamera nobody;
  const ThingSite site{scene, commands, nobody, log, warnings};
  log.begin(volume.name);
  const VolumeGround ground =
      made_at(volume.place, [&] { return prepare_volume(grow_volume(volume, site).field); });
  const PosedVolume first = pose_volume(ground, 0);
  const TexelBox box = texel_size ? box_around(first, *texel_size) : usual_box(first);
  check_room(box);
  make_folders(files);
  const WrittenFrames written = write_frames(
      files, picked, resume,
      [&](int frame) {
        const PosedVolume posed = pose_volume(ground, frame / commands.frames_per_second);
        return encode_vdb(resample(posed, box.low, box.count, box.cell), box.low);
      },
      log, stills);
  add_report({{"object", volume.name},
              {"species", volume.species},
              {"texel_size_m", box.cell},
              {"texels", box.count},
              {"low_m", {box.low.x(), box.low.y(), box.low.z()}},
              {"frames", picked},
              {"frames_written", written.frames},
              {"bytes_a_frame", written.bytes_a_frame()}},
             commands, warnings, log, stills);
  stills.commit();
  for (const FrameFiles& each : files)
    std::cerr << "tremula: wrote " << told(each, picked, box, written) << '\n';
}

}  // namespace tremula::cli
