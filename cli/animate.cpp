// tremula animate: a plant in the wind, as a loop in whatever form the outputs' extensions ask for. Read
// run(), the last.

#include "tremula/base/error.hpp"
#include "tremula/base/memory.hpp"
#include "tremula/io/gauge_table.hpp"
#include "tremula/io/html.hpp"

#include <algorithm>
#include <iostream>
#include <memory>

#include "animate.hpp"
#include "frame_files.hpp"

namespace tremula::cli {
namespace {

// Where engines stop.
std::vector<std::string> warnings_of(const Rig& rig, const RigOptions& options, bool for_engines) {
  constexpr std::size_t many = 256;
  std::vector<std::string> warnings;
  const std::string count = std::to_string(rig.joints.size());
  if (for_engines && rig.joints.size() > many) {
    warnings.push_back("the .glb has " + count +
                       " joints, and Filament and Bevy take 256 a skin: fewer with --max-joints or a larger "
                       "--tolerance");
  }
  if (rig.largest_error > options.tolerance) {
    warnings.push_back("with " + count + " joints the skin is up to " + printed("%.3g", rig.largest_error) +
                       " m off the poses, and --tolerance wants " + printed("%.3g", options.tolerance) +
                       " m");
  }
  return warnings;
}

constexpr double gigabyte = 1e9;

std::string in_gigabytes(double bytes) { return printed("%.3g GB", bytes / gigabyte); }

// What would not fit is refused before it is begun; what is large is announced.
std::vector<std::string> check_size(const LoopSize& size, const LoopWriteOptions& options,
                                    const std::vector<const LoopWriter*>& writers,
                                    const std::vector<std::string>& paths) {
  std::vector<std::string> warnings;
  double largest = 0;
  for (std::size_t i = 0; i < writers.size(); ++i) {
    const double bytes = writers[i]->size(size, options);
    largest = std::max(largest, bytes);
    if (bytes < gigabyte) continue;
    warnings.push_back(
        paths[i] + " will have about " + in_gigabytes(bytes) +
        (writers[i]->extension == "csv" ? ": fewer with --frames" : ": smaller with fewer --modes"));
  }
  const double loop = motion_size(size), wanted = loop + 2 * largest;
  const auto present = static_cast<double>(available_memory());
  if (wanted > present) {
    throw Error("a loop of " + printed("%.0f", size.sample_count) + " frames and " +
                printed("%.0f", size.mode_count) + " modes wants about " + in_gigabytes(wanted) +
                " of memory and there are " + in_gigabytes(present) +
                ": take a shorter --period, a lower --fps, fewer --modes" +
                (size.frame_count > 1 ? " or --frames" : ""));
  }
  if (loop >= gigabyte) {
    warnings.push_back("a loop of " + printed("%.0f", size.sample_count) + " frames takes about " +
                       in_gigabytes(loop) + " of memory, and minutes");
  }
  return warnings;
}

LoopSize loop_size(const PreparedPlant& prepared, int sample_count, std::size_t frame_count) {
  const Plant& plant = prepared.plant;
  int nodes = plant.sheet ? plant.sheet->node_count() : plant.imported.skeleton.node_count();
  if (plant.frame) {
    for (const Panel& panel : plant.frame->panels) nodes += panel.sheet.node_count();
  }
  return {.node_count = static_cast<double>(nodes),
          .vertex_count = static_cast<double>(prepared.surface.vertex_count()),
          .mode_count = static_cast<double>(prepared.mode_count),
          .sample_count = static_cast<double>(sample_count),
          .frame_count = static_cast<double>(frame_count)};
}

WrittenModel model_of(const Loop& loop, const std::string& bytes, double error) {
  WrittenModel model{
      .form = loop.rig ? "skin" : "morph", .clips = 1, .largest_error = error, .bytes = bytes.size()};
  if (loop.rig) {
    model.joints = loop.rig->joints.size();
    model.clips = loop.rig->clips.size();
    model.keys = loop.rig->key_count();
  } else {
    model.keys = static_cast<std::size_t>(loop.sample_count() + 1);
  }
  return model;
}

std::string told(const WrittenModel& model) {
  const std::string off = printed(", %.2g m off the poses at most", model.largest_error);
  if (model.form != "skin") return "morph targets" + (model.largest_error > 0 ? off : "");
  return std::to_string(model.joints) + " joints, " + std::to_string(model.keys) + " keys" + off;
}

}  // namespace

// A loop begins again with the frame after its last.
std::vector<int> AnimateCommand::picked_frames(int sample_count) const {
  return frames_of(frames, sample_count, plant.is_clip() ? sample_count - 1 : sample_count);
}

// For every output, what is written into it.
std::vector<const LoopWriter*> AnimateCommand::output_writers() const {
  if (outputs.empty() && report.empty()) {
    throw InputError("animate", "no output", "-o FILE.glb, .html, .csv or .png, or --report FILE.json");
  }
  if (!report.empty()) format_of({"--report", report}, "", {{"json", "what was done"}}, 0);
  std::vector<Format> names;
  for (const LoopWriter& writer : loop_writers()) names.push_back({writer.extension, writer.purpose});
  const auto nameless = [](const std::string& path) { return lower_extension(path).empty(); };
  const bool format_has_use = std::any_of(outputs.begin(), outputs.end(), nameless);
  std::vector<const LoopWriter*> writers;
  for (const std::string& path : outputs) {
    if (nameless(path) && format.empty()) {
      throw InputError("-o " + path, "has no extension that says what to write",
                       "one, or --format with glb, html, csv or png");
    }
    const std::string named = nameless(path) || !format_has_use ? format : "";
    writers.push_back(&loop_writers()[format_of({"-o", path}, named, names)]);
    if (writers.back()->extension == "html" && !can_write_html()) {
      throw Error("-o " + path + ": this program was built without Node.js, which the viewer needs");
    }
  }
  return writers;
}

std::vector<Place> AnimateCommand::output_places() const {
  std::vector<Place> places{{"--report", report}};
  for (const std::string& path : outputs) places.push_back({"-o", path});
  return places;
}

RigOptions AnimateCommand::rig_options(const Subject& subject) const {
  return {.tolerance = tolerance * height_of(subject.structure), .max_joints = max_joints.value_or(0)};
}

// All but the first.
std::vector<Motion> AnimateCommand::move_in_others(const PreparedPlant& first, const Subject& subject,
                                                   const std::vector<NamedWind>& clips,
                                                   const Progress& progress, StageLog& log,
                                                   WarningLog& warnings) const {
  std::vector<Motion> motions;
  for (std::size_t i = 1; i < clips.size(); ++i) {
    Motion motion =
        plant.in_wind_of(clips[i].wind_speed).move_again(first, subject, false, progress, log, warnings);
    motions.push_back(mean_only ? lean_alone(std::move(motion)) : std::move(motion));
  }
  return motions;
}

std::vector<Gauge> AnimateCommand::placed_gauges(const Plant& of) const {
  if (gauges.empty()) return {};
  need_tree(of, "--gauge");
  std::vector<Gauge> placed;
  for (const std::string& place : gauges) placed.push_back(place_gauge(of.imported.skeleton, place));
  return placed;
}

// A table is of the gauges, where there are any. Returns the last model.
WrittenModel AnimateCommand::encode_outputs(const Loop& loop, const std::vector<GaugeSeries>& series,
                                            const std::vector<const LoopWriter*>& writers,
                                            const LoopWriteOptions& options, double model_error,
                                            StageLog& log, Outputs& files) const {
  WrittenModel model;
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    log.begin("write ." + std::string(writers[i]->extension));
    const bool of_gauges = !series.empty() && writers[i]->extension == "csv";
    const std::string bytes =
        of_gauges ? encode_gauge_table(series, options.frames) : writers[i]->encode(loop, options);
    if (writers[i]->extension == "glb") {
      model = model_of(loop, bytes, model_error);
      files.add(outputs[i], bytes, told(model));
    } else {
      files.add(outputs[i], bytes);
    }
  }
  log.finish();
  return model;
}

// The page looks at the shapes of the strongest wind one by one.
std::shared_ptr<const Rig> AnimateCommand::fit_bones(const Subject& subject, const Surface& surface,
                                                     const std::vector<ClipSource>& clips, bool for_page,
                                                     bool for_engines, StageLog& log,
                                                     WarningLog& warnings) const {
  RigOptions options = rig_options(subject);
  if (for_page && !mean_only) {
    const auto strongest = std::ranges::max_element(clips, {}, &ClipSource::wind_speed);
    options.shapes_of = static_cast<int>(strongest - clips.begin());
  }
  log.begin("bones");
  auto rig = std::make_shared<const Rig>(fit_rig(subject.structure, surface, clips, options));
  log.finish();
  warnings.add(warnings_of(*rig, options, for_engines));
  return rig;
}

// The plant that an object of a scene is, where the input is one; else nothing.
std::unique_ptr<SceneObjectCommand> AnimateCommand::take_from_scene(const CLI::App& flags) {
  if (!is_scene(plant.input)) {
    if (!object.empty()) throw InputError("--object", "given with " + plant.input, "a scene (.toml)");
    return {};
  }
  const Scene scene = open_scene(plant.input);
  auto command = std::make_unique<SceneObjectCommand>(scene, object_of(scene, object), flags);
  plant = command->plant();
  return command;
}

// Whatever the flags and the files they name have wrong is said before the work begins.
void AnimateCommand::run(const CLI::App& flags) {
  if (animate_volume(flags)) return;
  const std::vector<const LoopWriter*> writers = output_writers();
  if (animate_thing(flags, writers)) return;
  const std::string scene_file = plant.input;
  const std::unique_ptr<SceneObjectCommand> of_scene = take_from_scene(flags);
  const CLI::App& plant_flags = of_scene ? of_scene->flags() : flags;
  if (!of_scene) plant.settle(flags);
  check_flags(flags, writers);
  std::vector<Place> inputs = plant.input_places();
  if (of_scene) inputs.push_back({"SCENE", scene_file});
  Outputs files(output_places(), inputs);
  const std::vector<NamedWind> clips = parse_clips(clip_texts);
  Conditions conditions = (clips.empty() ? plant : plant.in_wind_of(clips[0].wind_speed)).conditions();
  const int sample_count = conditions.weather.loop.sample_count;
  const std::vector<int> poses = picked_frames(sample_count);
  LoopWriteOptions write_options{
      .frames = poses, .morphs = morph_forms.at(morphs), .compression = compressions.at(compression)};

  StageLog log;
  WarningLog warnings;
  const Progress progress = [&](std::string_view stage, double done) { log.progress(stage, done); };
  PreparedPlant prepared = plant.prepare(plant_flags, std::move(conditions), log, warnings);
  Weather& weather = prepared.conditions.weather;
  write_options.on_bones = on_bones(flags, prepared.plant);
  weather.gauges = placed_gauges(prepared.plant);
  if (!report.empty() && prepared.plant.is_tree()) weather.most_strained = 10;
  warnings.add(check_size(loop_size(prepared, sample_count, poses.size()), write_options, writers, outputs));
  Subject subject = plant.bake(prepared, progress, warnings);

  const auto writes = [&](std::string_view extension) {
    return std::any_of(writers.begin(), writers.end(),
                       [&](const LoopWriter* each) { return each->extension == extension; });
  };
  // Bent poses superpose nothing; morph targets do, whatever the poses.
  const bool has_skin = writes("glb") || writes("html");
  const Poses form_of_poses = plant.poses_of(prepared.plant);
  const bool superposed = prepared.plant.sheet ? form_of_poses == Poses::linear
                                               : prepared.plant.frame || plant.loads.pose == "linear" ||
                                                     (has_skin && !write_options.on_bones);
  std::vector<Motion> other_clips = move_in_others(prepared, subject, clips, progress, log, warnings);
  Moved moved = plant.move(subject, weather, superposed, progress, log, warnings);
  const double heading = weather.wind.reference.heading;
  std::vector<GaugeSeries> series;
  for (const GaugeReading& reading : moved.motion.readings)
    series.push_back(gauge_series(reading, moved.motion, heading));
  const Json most_stressed =
      stresses(moved.motion, prepared.plant.imported.skeleton, prepared.bake.structure.material, heading);
  const DampingBySource damping = moved.motion.damping;
  const Vec3 mean_drag = moved.motion.mean_drag;
  const std::optional<PullTest> test = moved.motion.pull;
  std::shared_ptr<const Rig> rig;
  if (has_skin && write_options.on_bones) {
    if (mean_only) moved.motion = lean_alone(std::move(moved.motion));
    std::vector<ClipSource> sources{{!clips.empty()    ? clips[0].name
                                     : plant.is_clip() ? "clip"
                                                       : "wind loop",
                                     &moved.motion, weather.wind.reference.speed}};
    for (std::size_t i = 1; i < clips.size(); ++i)
      sources.push_back({clips[i].name, &other_clips[i - 1], clips[i].wind_speed});
    rig = fit_bones(subject, prepared.surface, sources, writes("html"), writes("glb"), log, warnings);
  }
  const bool bends = moved.motion.lean_strains.size() > 0;
  const double model_error = rig ? rig->largest_error
                             : bends && writes("glb")
                                 ? linear_pose_error(subject.structure, prepared.surface, moved.motion)
                                 : 0;
  Loop loop = make_loop(subject.structure, std::move(prepared.surface), std::move(moved.motion),
                        plant.loop_facts(prepared.plant, weather.wind.reference), form_of_poses);
  loop.rig = rig;
  const WrittenModel written = encode_outputs(loop, series, writers, write_options, model_error, log, files);
  if (!report.empty()) {
    const Done done{prepared,
                    subject,
                    loop,
                    series,
                    most_stressed,
                    moved.statistics,
                    damping,
                    mean_drag,
                    test,
                    warnings.lines,
                    writes("glb") ? std::optional(written) : std::nullopt};
    files.add(report, text_of(report_of(done, log)));
  }
  files.commit();
  files.announce();
  if (test) std::cerr << "tremula: " << told(*test) << '\n';
}

}  // namespace tremula::cli
