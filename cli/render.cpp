// tremula render: a scene, or a plant alone, as pictures and films. Read RenderCommand::run, the last.

#include "tremula/base/error.hpp"
#include "tremula/base/memory.hpp"
#include "tremula/io/exr.hpp"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <unistd.h>

#include "commands.hpp"
#include "frame_files.hpp"
#include "scene_things.hpp"
#include "shot.hpp"

namespace tremula::cli {
namespace {

const std::map<std::string, Denoiser> denoisers{{"own", Denoiser::own},
                                                {"oidn", Denoiser::open_image_denoise}};

// "960x540"
Eigen::Vector2i parse_pair(const std::string& flag, const std::string& text, const std::string& wanted) {
  Eigen::Vector2i pair;
  const char *begin = text.data(), *end = begin + text.size();
  const auto first = std::from_chars(begin, end, pair.x());
  const bool parts = first.ec == std::errc{} && first.ptr != end && *first.ptr == 'x';
  const auto second = parts ? std::from_chars(first.ptr + 1, end, pair.y()) : first;
  if (!parts || second.ec != std::errc{} || second.ptr != end || pair.minCoeff() < 1)
    throw InputError(flag, "'" + text + "'", wanted);
  return pair;
}

// How far a film is, with the time that is left, where somebody watches.
class FilmProgress {
 public:
  FilmProgress(std::size_t count) : count_(count), begun_(Clock::now()) {}
  ~FilmProgress() {
    if (watched_) std::fputs("\r\033[K", stderr);
  }
  FilmProgress(const FilmProgress&) = delete;
  FilmProgress& operator=(const FilmProgress&) = delete;

  void show(std::size_t frame, double done) {
    if (!watched_ || Clock::now() - drawn_ < std::chrono::milliseconds(200)) return;
    drawn_ = Clock::now();
    const double share = (static_cast<double>(frame) + done) / static_cast<double>(count_);
    const double spent = std::chrono::duration<double>(drawn_ - begun_).count();
    const double left = share > 0 ? spent * (1 - share) / share : 0;
    std::fprintf(stderr, "\r\033[Kframe %zu of %zu, %.0f %%", frame + 1, count_, 100 * share);
    if (share > 0.01 || spent > 10) {
      if (left < 90)
        std::fprintf(stderr, ", %.0f s left", left);
      else
        std::fprintf(stderr, ", %.0f min left", left / 60);
    }
    std::fflush(stderr);
  }

 private:
  using Clock = std::chrono::steady_clock;
  std::size_t count_;
  Clock::time_point begun_, drawn_{};
  bool watched_ = isatty(STDERR_FILENO) == 1;
};

// Light, guides, noise and what the denoiser holds of them.
void check_memory(const ScenePicture& picture) {
  constexpr double bytes_a_pixel = 160, gigabyte = 1e9;
  const double wanted = bytes_a_pixel * picture.size.x() * picture.size.y();
  const auto present = static_cast<double>(available_memory());
  if (wanted > present) {
    throw Error(printed(
        "a picture of %d x %d pixels wants about %.3g GB of memory and there are %.3g GB: take a smaller "
        "--size",
        picture.size.x(), picture.size.y(), wanted / gigabyte, present / gigabyte));
  }
}

void add(TraceCounts& total, const TraceCounts& counts) {
  total.rays += counts.rays;
  total.triangles = counts.triangles;
  total.instances = counts.instances;
  total.poses = counts.poses;
  total.seconds_build += counts.seconds_build;
  total.seconds_trace += counts.seconds_trace;
}

struct RenderCommand {
  PlantInWind plant;  // its flags, for every object; its input is a scene or a plant
  std::vector<std::string> outputs;
  std::string report, size, frames, sheet;
  std::optional<int> samples, bounces;
  std::optional<double> shutter, exposure;
  bool no_denoise = false, resume = false;
  std::string denoiser = "own";
  ThreadsFlag threads;

  std::vector<FrameFiles> frame_outputs() const;
  void set_picture(ScenePicture& picture) const;
  std::vector<int> picked_frames(const std::vector<FrameFiles>& files, int count) const;
  Json report_of(const Scene& scene, const SceneCommands& commands, const MovingScene& moving,
                 const std::vector<int>& picked, const TraceCounts& counts, const WarningLog& warnings,
                 const StageLog& log) const;
  void run(const CLI::App& flags) const;
};

std::vector<FrameFiles> RenderCommand::frame_outputs() const {
  if (outputs.empty())
    throw InputError("render", "no output",
                     "-o FILE.png, frames/%04d.png, FILE.exr, FILE.mp4, .webm or .gif");
  std::vector<FrameFiles> files;
  for (const std::string& path : outputs) {
    files.push_back(frame_files(path));
    const FrameFiles& last = files.back();
    if (resume && last.form != FrameForm::sequence)
      throw InputError("--resume", "given with -o " + path,
                       "frames/%04d.png: what is one file is made whole");
    if (!sheet.empty() && (last.form != FrameForm::still || last.extension != ".png"))
      throw InputError("--sheet", "given with -o " + path, "-o FILE.png");
    if (last.extension == ".exr" && !has_exr())
      throw Error("-o " + path + ": this program was built without OpenEXR (libopenexr-dev)");
  }
  return files;
}

void RenderCommand::set_picture(ScenePicture& picture) const {
  if (!size.empty()) {
    picture.size = parse_pair("--size", size, "width x height in pixels, such as 960x540");
    if (picture.size.maxCoeff() > 16384) throw InputError("--size", "'" + size + "'", "at most 16384 pixels");
  }
  if (samples) picture.samples = *samples;
  if (bounces) picture.bounces = *bounces;
  if (shutter) picture.shutter = *shutter;
  if (exposure) picture.exposure = *exposure;
  if (no_denoise) picture.denoise = false;
}

// Of a still the first, unless somebody says which; of a sheet so many over the loop; of all else all.
std::vector<int> RenderCommand::picked_frames(const std::vector<FrameFiles>& files, int count) const {
  const bool still =
      std::ranges::any_of(files, [](const auto& each) { return each.form == FrameForm::still; });
  if (!sheet.empty()) {
    const Eigen::Vector2i cells = parse_pair("--sheet", sheet, "columns x rows, such as 4x3");
    const int wanted = cells.prod();
    if (wanted > count || cells.maxCoeff() > 64)
      throw InputError("--sheet", "'" + sheet + "'", "at most the " + std::to_string(count) + " frames");
    std::vector<int> picked;
    for (int i = 0; i < wanted; ++i) picked.push_back(static_cast<int>(std::int64_t{i} * count / wanted));
    return picked;
  }
  std::vector<int> picked = frames_of(still && frames.empty() ? "0" : frames, count, count - 1);
  if (still && picked.size() > 1)
    throw InputError("--frames", "'" + frames + "'",
                     "one frame for one picture; -o frames/%04d.png for more");
  return picked;
}

void RenderCommand::run(const CLI::App& flags) const {
  const std::vector<FrameFiles> files = frame_outputs();
  if (!sheet.empty() && !frames.empty()) throw InputError("--frames", "given with --sheet", "one of them");
  if (!report.empty()) format_of({"--report", report}, "", {{"json", "what was done"}}, 0);
  if (no_denoise && flags.count("--denoiser") > 0)
    throw InputError("--no-denoise", "given with --denoiser", "one of them");
  if (denoiser == "oidn" && !has_open_image_denoise())
    throw Error(
        "--denoiser oidn: libOpenImageDenoise.so is not installed where programs find it; --denoiser own is "
        "always there");
  if (!can_trace()) throw Error("render: this program was built without Embree (libembree-dev)");
  Scene scene = open_scene(plant.input);
  set_picture(scene.picture);
  const ScenePicture& picture = scene.picture;
  check_memory(picture);
  const SceneCommands commands = commands_of(scene, flags);
  const std::vector<int> picked = picked_frames(files, commands.loop.sample_count);
  std::vector<Place> inputs = commands.input_places();
  inputs.push_back({"SCENE", plant.input});
  Outputs stills(output_places(files, picked, report), inputs);

  StageLog log;
  WarningLog warnings;
  MovingScene moving = move_scene(scene, commands, log, warnings);
  if (!is_scene(plant.input)) stand_alone(scene, commands, *moving.loops().front()->rest);
  const FilmCamera camera = camera_of(scene, commands, moving);
  moving.things = make_things({scene, commands, camera, log, warnings});
  TraceScene traced = trace_scene(scene, commands.under_water, moving.loops());
  traced.ray_shapes = moving.shapes();
  const ToneMapping tones = tones_of(traced, picture.exposure);
  log.begin("scene");
  const Tracer tracer(traced);
  log.begin("frames");
  std::optional<Denoiser> chosen;
  if (picture.denoise) chosen = denoisers.at(denoiser);
  make_folders(files);
  FrameWriter writer(files,
                     {.width = picture.size.x(),
                      .height = picture.size.y(),
                      .frames = static_cast<int>(picked.size()),
                      .frames_per_second = commands.frames_per_second},
                     chosen, tones, stills);
  std::vector<Image> cells;
  std::vector<std::string> labels;
  TraceCounts total;
  {
    FilmProgress progress(picked.size());
    for (std::size_t i = 0; i < picked.size(); ++i) {
      if (resume && writer.has(picked[i])) continue;
      const double time = picked[i] / commands.frames_per_second;
      TraceCounts counts;
      const TracedImage frame = tracer.trace(
          camera.camera, time,
          {.width = picture.size.x(),
           .height = picture.size.y(),
           .samples = picture.samples,
           .bounces = picture.bounces,
           .shutter = picture.shutter / commands.frames_per_second,
           .lens = {camera.lens_radius, camera.focus_distance(time)},
           .seed = picture.seed + static_cast<std::uint64_t>(picked[i])},
          [&](double done) { progress.show(i, done); }, &counts);
      add(total, counts);
      if (sheet.empty()) {
        writer.write(picked[i], frame);
      } else {
        cells.push_back(writer.shown(frame));
        labels.push_back(printed("t = %.2f s", time));
      }
    }
  }
  if (!cells.empty()) {
    const int columns = parse_pair("--sheet", sheet, "").x();
    stills.add(outputs.front(), encode_png(contact_sheet(cells, columns, labels)));
  }
  writer.finish();
  log.finish();
  if (!report.empty())
    stills.add(report, text_of(report_of(scene, commands, moving, picked, total, warnings, log)));
  stills.commit();
  stills.announce();
}

Json RenderCommand::report_of(const Scene& scene, const SceneCommands& commands, const MovingScene& moving,
                              const std::vector<int>& picked, const TraceCounts& counts,
                              const WarningLog& warnings, const StageLog& log) const {
  const ScenePicture& picture = scene.picture;
  Json objects = Json::array();
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    std::size_t copies = 0;
    for (const auto& loop : moving.objects[i]) copies += loop->instances.size();
    objects.push_back({{"name", scene.objects[i].name},
                       {"source", scene.objects[i].source},
                       {"instances", copies},
                       {"motions", moving.objects[i].size()},
                       {"vertices", moving.objects[i].front()->rest->vertex_count()}});
  }
  for (const SceneThing& thing : moving.things)
    objects.push_back({{"name", thing.name}, {"kind", thing.kind}, {"count", thing.count}});
  return {{"tremula", TREMULA_VERSION},
          {"input", plant.input},
          {"wind_speed_m_s", commands.wind.speed},
          {"heading_deg", commands.wind.heading},
          {"period_s", commands.loop.period},
          {"frames_per_second", commands.frames_per_second},
          {"frames", picked},
          {"size", {picture.size.x(), picture.size.y()}},
          {"samples", picture.samples},
          {"bounces", picture.bounces},
          {"shutter", picture.shutter},
          {"denoiser", picture.denoise ? Json(denoiser_name(denoisers.at(denoiser))) : Json()},
          {"objects", objects},
          {"instances", moving.instance_count},
          {"triangles", counts.triangles},
          {"poses", counts.poses},
          {"rays", counts.rays},
          {"seconds_build", counts.seconds_build},
          {"seconds_trace", counts.seconds_trace},
          {"rays_per_second", counts.seconds_trace > 0 ? Json(counts.rays / counts.seconds_trace) : Json()},
          {"warnings", warnings.lines},
          {"outputs", outputs},
          {"stages", log.json()},
          {"peak_bytes", peak_bytes()}};
}

}  // namespace

void add_render(CLI::App& app) {
  auto command = std::make_shared<RenderCommand>();
  CLI::App& sub = *app.add_subcommand("render", "A scene, or a plant alone, as pictures and films");
  sub.add_option("SCENE|INPUT", command->plant.input,
                 "A scene (.toml, see tremula check --keys), or what tremula animate takes: a file or a "
                 "preset, which "
                 "then stands alone on grass")
      ->required();
  sub.add_option(
      "-o,--output", command->outputs,
      "What to write, by extension: .png and .exr (linear light): one picture; with a number in the name, "
      "frames/%04d.png, a file for every frame; .mp4, .webm, .gif: a film, through the program ffmpeg; may "
      "be repeated");
  sub.add_option("--report", command->report, "What was done, as JSON: copies, rays, seconds and memory");
  sub.add_option("--frames", command->frames,
                 "Which frames: 17, 10-20, or 0-90:10 for every tenth (of a picture 0, else all)");
  sub.add_flag("--resume", command->resume, "Leave frames that are there as they are");
  sub.add_option("--sheet", command->sheet,
                 "Columns and rows of a contact sheet over the loop, in one .png: 4x3");
  const char* group = "Picture";
  sub.add_option("--size", command->size, "Width and height [pixels] (960x540)")->group(group);
  sub.add_option("--samples", command->samples, "Of every pixel (64)")->group(group);
  sub.add_option("--bounces", command->bounces, "Of light (6)")->group(group);
  sub.add_option("--shutter", command->shutter,
                 "How long it is open, of the time of a frame; 0: no motion blur (0.5)")
      ->group(group);
  sub.add_option("--exposure", command->exposure,
                 "Brighter by so many stops than the light of the day asks for (0)")
      ->group(group);
  sub.add_option("--denoiser", command->denoiser,
                 "own, or oidn: Intel Open Image Denoise, where its library is installed")
      ->check(CLI::IsMember(denoisers))
      ->capture_default_str()
      ->group(group);
  sub.add_flag("--no-denoise", command->no_denoise, "Leave the noise of few samples")->group(group);
  command->plant.add_to(sub);
  command->threads.add_to(sub);
  sub.footer(
      "Examples:\n"
      "  tremula render oak -o oak.png\n"
      "  tremula render flag --wind-speed 8 --period 8 --fps 25 -o flag.mp4\n"
      "  tremula render scene.toml --size 1920x1080 --samples 256 --frames 0 -o frame.png\n"
      "  tremula render scene.toml --frames 100-199 --resume -o frames/%04d.exr\n"
      "  tremula render scene.toml --sheet 4x3 --size 320x180 --samples 16 -o sheet.png\n");
  sub.callback([command, &sub] { command->threads.run([&] { command->run(sub); }); });
}

}  // namespace tremula::cli
