// tremula animate: a plant in the wind, as a loop in whatever form the outputs' extensions ask for.

#include "tremula/base/error.hpp"
#include "tremula/base/memory.hpp"
#include "tremula/dynamics/motion_statistics.hpp"
#include "tremula/io/html.hpp"
#include "tremula/io/turbsim.hpp"
#include "tremula/structure/plausibility.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iostream>
#include <map>
#include <memory>
#include <numeric>

#include "commands.hpp"
#include "common.hpp"
#include "loop_formats.hpp"
#include "usage.hpp"
#include "wind_flags.hpp"

namespace tremula::cli {
namespace {

constexpr const char* wind_group = "Wind";
const std::map<std::string, MorphForm> morph_forms{
    {"biased", MorphForm::biased}, {"paired", MorphForm::paired}, {"signed", MorphForm::signed_weights}};
const std::map<std::string, MeshCompression> compressions{{"none", MeshCompression::none},
                                                          {"quantised", MeshCompression::quantised},
                                                          {"meshopt", MeshCompression::meshopt}};

struct AnimateCommand {
  std::string input, report, format;
  std::vector<std::string> outputs;
  WindFlags wind_flags;
  std::string wind = "turbulent", loads = "linearised", transfer = "bin-averaged";
  std::optional<double> correlation_time, correlation_length;  // of StamWind
  double period = 20, frames_per_second = 30, damping_ratio = 0.05, reconfiguration_angle = 0.3;
  std::optional<double> mass_damping, stiffness_damping;
  double leaf_drag_coefficient = LoadOptions{}.leaf_drag_coefficient,
         leaf_lift_coefficient = LoadOptions{}.leaf_lift_coefficient;
  bool no_aerodynamic_damping = false, no_static_correction = false;
  int mode_count = 20;
  std::string frames, morphs = "biased", compression = "quantised";
  ReadFlags read;
  StructureFlags structure;
  ThreadsFlag threads;

  bool is_stam() const { return wind == "stam" || wind == "stam-printed"; }
  bool is_field() const { return lower_extension(wind) == ".bts"; }
  Wind chosen_wind() const;
  Json describe_wind(const Wind& chosen) const;
  Weather weather() const;
  std::vector<int> picked_frames(int sample_count) const;
  std::vector<const LoopFormat*> output_formats() const;
  void check_flags(const CLI::App& flags, const std::vector<const LoopFormat*>& formats) const;
  std::vector<Place> output_places() const;
  Json report_of(const Plant& plant, const BakeOptions& options, const Weather& conditions,
                 const Subject& subject, const Motion& motion, const MotionStatistics& statistics,
                 const std::vector<std::string>& warnings, const StageLog& log) const;
  void run(const CLI::App& flags) const;
};

Wind AnimateCommand::chosen_wind() const {
  if (wind == "turbulent") return wind_flags.wind();
  if (is_stam()) {
    const MeanWind mean = wind_flags.mean_wind();
    StamWind stam{.mean = mean,
                  .turbulence_intensity = wind_flags.intensity(mean),
                  .correlation_time = correlation_time.value_or(StamWind{}.correlation_time),
                  .correlation_length = correlation_length.value_or(StamWind{}.correlation_length),
                  .seed = wind_flags.seed};
    if (wind == "stam-printed") {
      stam.rows = StamRows::as_printed;
      stam.cutoff = 1e-4;  // its tails are not normalised away
    }
    return stam;
  }
  if (is_field()) {
    return GivenWind{std::make_shared<const WindField>(wind_field(read_turbsim(wind))), wind_flags.heading};
  }
  throw InputError("--wind", "'" + wind + "'", "turbulent, stam, stam-printed or a field FILE.bts");
}

Weather AnimateCommand::weather() const {
  Weather weather;
  weather.wind = chosen_wind();
  if (structure.medium == "water") weather.loads.fluid_density = water_density;
  weather.loads.leaf_drag_coefficient = leaf_drag_coefficient;
  weather.loads.leaf_lift_coefficient = leaf_lift_coefficient;
  weather.loads.model = loads == "paper" ? LoadModel::paper : LoadModel::linearised;
  weather.reconfiguration.angle = reconfiguration_angle;
  weather.damping = {.ratio = damping_ratio,
                     .mass_proportional = mass_damping,
                     .stiffness_proportional = stiffness_damping,
                     .aerodynamic = !no_aerodynamic_damping};
  weather.transfer = transfer == "sampled" ? Transfer::sampled : Transfer::bin_averaged;
  weather.static_correction = !no_static_correction;
  const double samples = period * frames_per_second;
  if (!(samples >= 1 && samples <= 1 << 24)) {
    throw InputError("--period " + std::to_string(period) + " at --fps " + std::to_string(frames_per_second),
                     std::to_string(samples) + " frames", "1 to 16777216");
  }
  weather.loop = {period, static_cast<int>(std::lround(samples))};
  return weather;
}

std::vector<int> AnimateCommand::picked_frames(int sample_count) const {
  int first = 0, last = sample_count - 1;
  if (!frames.empty()) {
    const char *begin = frames.data(), *end = begin + frames.size();
    const auto one = std::from_chars(begin, end, first);
    bool good = one.ec == std::errc{};
    last = first;
    if (good && one.ptr != end) {
      const auto two = std::from_chars(one.ptr + 1, end, last);
      good = *one.ptr == '-' && two.ec == std::errc{} && two.ptr == end;
    }
    if (!good || first < 0 || first > last || last > sample_count) {
      throw InputError("--frames", "'" + frames + "'",
                       "a frame or a range such as 10-20 within 0-" + std::to_string(sample_count));
    }
  }
  std::vector<int> picked(static_cast<std::size_t>(last - first + 1));
  std::iota(picked.begin(), picked.end(), first);
  return picked;
}

// For every output, what is written into it.
std::vector<const LoopFormat*> AnimateCommand::output_formats() const {
  if (outputs.empty() && report.empty()) {
    throw InputError("animate", "no output", "-o FILE.glb, .html, .csv or .png, or --report FILE.json");
  }
  if (!report.empty()) format_of({"--report", report}, "", {{"json", "what was done"}}, 0);
  const std::vector<Format> names(loop_formats().begin(), loop_formats().end());
  const auto nameless = [](const std::string& path) { return lower_extension(path).empty(); };
  const bool format_has_use = std::any_of(outputs.begin(), outputs.end(), nameless);
  std::vector<const LoopFormat*> formats;
  for (const std::string& path : outputs) {
    if (nameless(path) && format.empty()) {
      throw InputError("-o " + path, "has no extension that says what to write",
                       "one, or --format with glb, html, csv or png");
    }
    const std::string named = nameless(path) || !format_has_use ? format : "";
    formats.push_back(&loop_formats()[format_of({"-o", path}, named, names)]);
    if (formats.back()->name == "html" && !can_write_html()) {
      throw Error("-o " + path + ": this program was built without Node.js, which the viewer needs");
    }
  }
  return formats;
}

std::vector<Place> AnimateCommand::output_places() const {
  std::vector<Place> places{{"--report", report}};
  for (const std::string& path : outputs) places.push_back({"-o", path});
  return places;
}

std::vector<std::string> flags_in_group(const CLI::App& command, const char* group,
                                        std::initializer_list<std::string_view> but) {
  std::vector<std::string> flags;
  for (const CLI::Option* option : command.get_options()) {
    const std::string name = option->get_name();
    if (option->get_group() == group && std::find(but.begin(), but.end(), name) == but.end())
      flags.push_back(name);
  }
  return flags;
}

void AnimateCommand::check_flags(const CLI::App& flags, const std::vector<const LoopFormat*>& formats) const {
  const auto writes = [&](std::string_view name) {
    return std::any_of(formats.begin(), formats.end(),
                       [&](const LoopFormat* each) { return each->name == name; });
  };
  const bool table = writes("csv"), model = writes("glb");
  const std::string with_wind = "given with --wind " + wind;
  const IdleFlags rules[] = {
      {formats.empty(), "given without -o", "an output that it shapes", {"--format"}},
      {!table, "given without a table of poses", "-o FILE.csv", {"--frames"}},
      {!model, "given without a .glb", "-o FILE.glb", {"--morphs", "--compress"}},
      {is_field(), with_wind, "--wind turbulent: a field is taken as it is",
       flags_in_group(flags, wind_group, {"--wind", "--heading"})},
      {is_field(), with_wind, "--wind turbulent: a field has one realisation", {"--transfer"}},
      {is_stam(), with_wind, "--wind turbulent",
       flags_in_group(flags, wind_group,
                      {"--wind", "--wind-speed", "--reference-height", "--heading", "--terrain", "--profile",
                       "--turbulence-intensity", "--friction-velocity", "--power-exponent",
                       "--roughness-length", "--displacement", "--canopy-height", "--canopy-decay", "--seed",
                       "--correlation-time", "--correlation-length"})},
      {!is_stam(),
       with_wind,
       "--wind stam or stam-printed, whose filter it sets",
       {"--correlation-time", "--correlation-length"}},
      {mass_damping.has_value(),
       "given with --mass-damping",
       "one of them",
       {"--damping-ratio", "--stiffness-damping"}},
      {stiffness_damping.has_value(), "given with --stiffness-damping", "one of them", {"--damping-ratio"}},
      {loads == "paper",
       "given with --loads paper, which has no leaves and no lean",
       "--loads linearised",
       {"--leaf-drag-coefficient", "--leaf-lift-coefficient", "--reconfiguration-angle"}},
  };
  refuse_idle_flags(flags, rules);
}

constexpr double gigabyte = 1e9;

std::string in_gigabytes(double bytes) { return printed("%.3g GB", bytes / gigabyte); }

// What would not fit is refused before it is begun; what is large is announced.
void check_size(const LoopSize& size, const std::vector<const LoopFormat*>& formats,
                const std::vector<std::string>& paths, std::vector<std::string>& warnings) {
  double largest = 0;
  for (std::size_t i = 0; i < formats.size(); ++i) {
    const double bytes = formats[i]->size(size);
    largest = std::max(largest, bytes);
    if (bytes < gigabyte) continue;
    warnings.push_back(
        paths[i] + " will have about " + in_gigabytes(bytes) +
        (formats[i]->name == "csv" ? ": fewer with --frames" : ": smaller with fewer --modes"));
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
}

Json describe(const Sway& sway) {
  return {{"largest_m", sway.displacement},
          {"largest_rotation_rad", sway.rotation},
          {"most_moved_branch", sway.branch},
          {"coordinates_m_sqrt_kg", std::vector<double>(sway.coordinates.begin(), sway.coordinates.end())}};
}

Json describe(const MotionStatistics& statistics) {
  return {{"largest_lean_m", statistics.largest_lean},
          {"largest_lean_rotation_rad", statistics.largest_lean_rotation},
          {"rms_about_lean", describe(statistics.about_lean)},
          {"rms_about_loop_mean", describe(statistics.about_mean)},
          {"largest_stretch", statistics.largest_stretch},
          {"most_stretched_branch", statistics.most_stretched_branch}};
}

Json AnimateCommand::describe_wind(const Wind& chosen) const {
  if (const auto* turbulent = std::get_if<TurbulentWind>(&chosen)) return describe(wind_flags, *turbulent);
  if (const auto* stam = std::get_if<StamWind>(&chosen)) {
    return {{"wind_speed_m_s", stam->mean.speed},
            {"reference_height_m", stam->mean.reference_height},
            {"profile", wind_flags.profile},
            {"roughness_length_m", stam->mean.roughness_length},
            {"heading_deg", stam->mean.heading},
            {"turbulence_intensity", stam->turbulence_intensity},
            {"correlation_time_s", stam->correlation_time},
            {"correlation_length_m", stam->correlation_length}};
  }
  const WindGrid& grid = std::get<GivenWind>(chosen).field->grid;
  const ReferenceWind reference = at_reference_height(chosen);
  return {{"wind_speed_m_s", reference.speed},
          {"reference_height_m", reference.height},
          {"heading_deg", reference.heading},
          {"turbulence_intensity", reference.intensity ? Json(*reference.intensity) : Json()},
          {"period_s", grid.period()},
          {"points", {grid.y_count, grid.z_count}}};
}

Json AnimateCommand::report_of(const Plant& plant, const BakeOptions& options, const Weather& conditions,
                               const Subject& subject, const Motion& motion,
                               const MotionStatistics& statistics, const std::vector<std::string>& warnings,
                               const StageLog& log) const {
  return {
      {"tremula", TREMULA_VERSION},
      {"input", input},
      {"plant", cli::describe(plant)},
      {"structure", cli::describe(options.structure)},
      {"settings",
       {{"wind", wind},
        {"wind_settings", describe_wind(conditions.wind)},
        {"loads", loads},
        {"leaf_drag_coefficient", leaf_drag_coefficient},
        {"leaf_lift_coefficient", leaf_lift_coefficient},
        {"damping_ratio", mass_damping || stiffness_damping ? Json() : Json(damping_ratio)},
        {"mass_damping_per_s", mass_damping ? Json(*mass_damping) : Json()},
        {"stiffness_damping_s", stiffness_damping ? Json(*stiffness_damping) : Json()},
        {"aerodynamic_damping", !no_aerodynamic_damping},
        {"transfer", transfer},
        {"static_shapes", motion.static_shapes.count()},
        {"period_s", period},
        {"frames_per_second", frames_per_second},
        {"samples", conditions.loop.sample_count},
        {"seed", wind_flags.seed}}},
      {"warnings", warnings},
      {"mode_count", subject.modes.count()},
      {"frequencies_hz", std::vector<double>(subject.modes.frequency.begin(), subject.modes.frequency.end())},
      {"motion", describe(statistics)},
      {"outputs", outputs},
      {"stages", log.json()},
      {"peak_bytes", peak_bytes()}};
}

void AnimateCommand::run(const CLI::App& flags) const {
  const std::vector<const LoopFormat*> formats = output_formats();
  check_flags(flags, formats);
  Outputs files(output_places(), {{"INPUT", input},
                                  {"--wind", wind},
                                  {"--spectrum", wind_flags.spectrum},
                                  {"--profile", wind_flags.profile}});
  const Weather conditions = weather();
  const std::vector<int> frames_for_poses = picked_frames(conditions.loop.sample_count);
  BakeOptions options{structure.options(), {.count = mode_count}};

  StageLog log;
  const Progress progress = [&](std::string_view stage, double done) { log.progress(stage, done); };
  log.begin("read");
  const Plant plant = open_plant(input, read);
  log.finish();
  print_warnings(plant);

  const Skeleton& skeleton = plant.imported.skeleton;
  std::vector<std::string> warnings;
  const auto warn = [&](std::vector<std::string> lines) {
    for (const std::string& line : lines) std::cerr << "tremula: warning: " << line << '\n';
    warnings.insert(warnings.end(), lines.begin(), lines.end());
  };
  const int most = 6 * skeleton.branch_count();
  if (mode_count > most) {
    warn({"--modes " + std::to_string(mode_count) + ": the plant has " + std::to_string(most) +
          ", and all are taken"});
    options.modes.count = all_modes;
  }
  log.begin("surface");
  Surface surface = mesh_surface(skeleton);
  surface.bark_color = plant.imported.colors.bark.value_or(surface.bark_color);
  surface.leaf_color = plant.imported.colors.leaf.value_or(surface.leaf_color);
  log.finish();
  std::vector<std::string> large;
  check_size({.node_count = static_cast<double>(skeleton.node_count()),
              .vertex_count = static_cast<double>(surface.vertex_count()),
              .mode_count = static_cast<double>(mode_count < 0 ? most : std::min(mode_count, most)),
              .sample_count = static_cast<double>(conditions.loop.sample_count),
              .frame_count = static_cast<double>(frames_for_poses.size()),
              .morphs = morph_forms.at(morphs),
              .compression = compressions.at(compression)},
             formats, outputs, large);
  warn(large);

  const Subject subject = bake(skeleton, options, progress);
  warn(plausibility(skeleton, options.structure, subject.modes.frequency[0]));
  std::vector<std::string> of_wind;
  const Motion motion = set_in_motion(subject, conditions, progress, &of_wind);
  log.finish();
  const MotionStatistics statistics = motion_statistics(subject.structure, subject.modes, motion);
  warn(of_wind);
  warn(advice(subject, conditions, statistics));

  const ReferenceWind reference = at_reference_height(conditions.wind);
  const Loop loop{subject,
                  motion,
                  surface,
                  frames_for_poses,
                  {.name = plant.name,
                   .frames_per_second = frames_per_second,
                   .wind_speed = reference.speed,
                   .heading = reference.heading,
                   .seed = wind_flags.seed},
                  morph_forms.at(morphs),
                  compressions.at(compression)};
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    log.begin("write ." + std::string(formats[i]->name));
    files.add(outputs[i], formats[i]->encode(loop));
  }
  log.finish();
  if (!report.empty()) {
    files.add(report,
              text_of(report_of(plant, options, conditions, subject, motion, statistics, warnings, log)));
  }
  files.commit();
  files.announce();
}

}  // namespace

void add_animate(CLI::App& app) {
  auto command = std::make_shared<AnimateCommand>();
  CLI::App& sub = *app.add_subcommand("animate", "A plant in the wind, as a loop that closes exactly");
  sub.add_option("INPUT", command->input,
                 "A tree file (SWC, TreeQSM .mat or text, SimpleForest CSV), an L-system (.lsys) or a preset")
      ->required();
  sub.add_option(
      "-o,--output", command->outputs,
      "What to write, by extension: .glb (Blender, engines), .html (plays in a browser), .csv (node poses "
      "per frame), .png (contact sheet); - is standard output; may be repeated");
  sub.add_option("--format", command->format,
                 "glb, html, csv or png, for an output whose name does not say it (-o -)")
      ->check(CLI::IsMember({"glb", "html", "csv", "png"}));
  sub.add_option("--report", command->report,
                 "What was done, as JSON: settings, frequencies, seconds and memory");
  sub.add_option("--frames", command->frames, "Frames for .csv: 17 or 10-20 (all)");
  sub.add_option(
         "--morphs", command->morphs,
         "Targets in .glb. biased: one a mode, weights 0 to 1 (plays everywhere); paired: a plus and a minus "
         "target a mode; signed: one a mode, weights of either sign, which Blender clamps")
      ->check(CLI::IsMember(morph_forms))
      ->capture_default_str();
  sub.add_option(
         "--compress", command->compression,
         "Of .glb. quantised: 16 and 8 bits (Blender, three.js); meshopt: those packed to a fifth (three.js, "
         "not Blender 3.4); none: floats, for Godot and whatever knows no extensions")
      ->check(CLI::IsMember(compressions))
      ->capture_default_str();
  sub.add_option("--modes", command->mode_count, "How many of the lowest modes move the plant; -1: all")
      ->capture_default_str();

  const char* wind = wind_group;
  sub.add_option(
         "--wind", command->wind,
         "turbulent: gusts that travel (Shinya & Fournier, or --spectrum); stam: eq. 8 of Stam with unit "
         "variance and a spectrum; stam-printed: eq. 8 as printed, white; or a field FILE.bts (TurbSim)")
      ->capture_default_str()
      ->group(wind);
  sub.add_option("--wind-model", command->wind, "The same")->group("");
  command->wind_flags.add_to(sub, true);
  sub.add_option("--correlation-time", command->correlation_time, "t_c of Stam's filter [s]")
      ->default_str("1")
      ->group(wind);
  sub.add_option("--correlation-length", command->correlation_length, "d_c of Stam's filter [m]")
      ->default_str("4")
      ->group(wind);

  const char* motion = "Motion";
  sub.add_option("--period", command->period, "Length of the loop [s]")->capture_default_str()->group(motion);
  sub.add_option("--fps", command->frames_per_second, "Frames per second [1/s]")
      ->capture_default_str()
      ->group(motion);
  sub.add_option("--damping-ratio", command->damping_ratio, "Of every mode, 1 is critical")
      ->capture_default_str()
      ->group(motion);
  sub.add_option("--mass-damping", command->mass_damping,
                 "alpha of C = alpha M (Stam) instead of the ratio [1/s]")
      ->group(motion);
  sub.add_option("--stiffness-damping", command->stiffness_damping,
                 "c of c omega^2 (Shinya & Fournier) instead of the ratio [s]")
      ->group(motion);
  sub.add_flag("--no-aerodynamic-damping", command->no_aerodynamic_damping,
               "Only the damping of the wood; by default the wind damps what moves in it, too")
      ->group(motion);
  sub.add_option("--transfer", command->transfer,
                 "bin-averaged: right variance for every period; sampled: as in the papers")
      ->check(CLI::IsMember({"bin-averaged", "sampled"}))
      ->capture_default_str()
      ->group(motion);
  sub.add_flag("--no-static-correction", command->no_static_correction,
               "Leave out the static shapes that stand for the modes beyond --modes")
      ->group(motion);
  sub.add_option("--loads", command->loads, "linearised: drag about the mean wind; paper: eq. 3 as printed")
      ->check(CLI::IsMember({"linearised", "paper"}))
      ->capture_default_str()
      ->group(motion);
  sub.add_option("--leaf-drag-coefficient", command->leaf_drag_coefficient,
                 "Of foliage that folds in the wind, on one side of its area")
      ->capture_default_str()
      ->group(motion);
  sub.add_option("--leaf-lift-coefficient", command->leaf_lift_coefficient,
                 "Of flat blades that stay as they are: a force along their normal")
      ->capture_default_str()
      ->group(motion);
  sub.add_option("--reconfiguration-angle", command->reconfiguration_angle,
                 "Rotation at which bending out of the wind has cut the drag to a quarter [rad]; 0: never")
      ->capture_default_str()
      ->group(motion);
  command->read.add_to(sub);
  command->structure.add_to(sub);
  command->threads.add_to(sub);
  sub.footer(
      "Examples:\n"
      "  tremula animate tree.swc -o tree.glb\n"
      "  tremula animate oak -o oak.html -o oak.png --wind-speed 8 --terrain parkland --seed 3\n"
      "  tremula animate oak -o oak.glb --wind measured.bts --period 60\n"
      "  tremula animate scan.mat -o tree.glb -o pose.csv --wind-speed 6 --period 20 --report report.json\n");
  sub.callback([command, &sub] { command->threads.run([&] { command->run(sub); }); });
}

}  // namespace tremula::cli
