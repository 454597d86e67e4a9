// tremula animate: a plant in the wind, as a loop in whatever form the outputs' extensions ask for.

#include "tremula/base/error.hpp"
#include "tremula/dynamics/motion_statistics.hpp"
#include "tremula/io/atomic_file.hpp"
#include "tremula/io/gltf.hpp"
#include "tremula/io/html.hpp"
#include "tremula/io/pose_table.hpp"
#include "tremula/io/turbsim.hpp"
#include "tremula/render/render.hpp"

#include <charconv>
#include <cmath>
#include <iostream>
#include <map>
#include <memory>
#include <numbers>
#include <numeric>

#include "commands.hpp"
#include "common.hpp"
#include "wind_flags.hpp"

namespace tremula::cli {
namespace {

const std::map<std::string, MorphForm> morph_forms{
    {"biased", MorphForm::biased}, {"paired", MorphForm::paired}, {"signed", MorphForm::signed_weights}};
const std::map<std::string, MeshCompression> compressions{{"none", MeshCompression::none},
                                                          {"quantised", MeshCompression::quantised},
                                                          {"meshopt", MeshCompression::meshopt}};

struct AnimateCommand {
  std::string input, report;
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
  StructureFlags structure;
  ThreadsFlag threads;

  Wind chosen_wind() const;
  Json describe_wind(const Wind& chosen) const;
  Weather weather() const;
  std::vector<int> picked_frames(int sample_count) const;
  void check_outputs() const;
  void run() const;
};

// Everything the writers draw from.
struct Loop {
  const Plant& plant;
  const Subject& subject;
  const Motion& motion;
  const Surface& surface;
  LoopInfo info;
  MorphForm morphs;             // of .glb
  MeshCompression compression;  // of .glb
};

Wind AnimateCommand::chosen_wind() const {
  const bool stam_wind = wind == "stam" || wind == "stam-printed";
  if (!stam_wind && (correlation_time || correlation_length)) {
    throw InputError(correlation_time ? "--correlation-time" : "--correlation-length",
                     "given with --wind " + wind, "--wind stam or stam-printed, whose filter it sets");
  }
  if (wind == "turbulent") return wind_flags.wind();
  if (stam_wind) {
    StamWind stam{
        .mean = wind_flags.mean_wind(),
        .turbulence_intensity = wind_flags.turbulence_intensity.value_or(default_turbulence_intensity),
        .correlation_time = correlation_time.value_or(StamWind{}.correlation_time),
        .correlation_length = correlation_length.value_or(StamWind{}.correlation_length),
        .seed = wind_flags.seed};
    if (wind == "stam-printed") {
      stam.rows = StamRows::as_printed;
      stam.cutoff = 1e-4;  // its tails are not normalised away
    }
    return stam;
  }
  if (lower_extension(wind) == ".bts") {
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

void AnimateCommand::check_outputs() const {
  if (outputs.empty() && report.empty()) {
    throw InputError("animate", "no output", "-o FILE.glb, .html, .csv or .png, or --report FILE.json");
  }
  for (const std::string& path : outputs) {
    const std::string extension = lower_extension(path);
    if (extension != ".glb" && extension != ".html" && extension != ".csv" && extension != ".png") {
      throw InputError("-o " + path, "'" + extension + "'",
                       ".glb, .html, .csv (poses) or .png (contact sheet)");
    }
    if (extension == ".html" && !can_write_html()) {
      throw Error("-o " + path + ": this program was built without Node.js, which the viewer needs");
    }
  }
}

void write_contact_sheet(const std::string& path, const Loop& loop) {
  constexpr int columns = 4, rows = 3, cells = columns * rows;
  std::vector<std::vector<Eigen::Vector3f>> positions, normals;
  std::vector<Eigen::Vector3f> everywhere;
  std::vector<std::string> labels;
  for (int i = 0; i < cells; ++i) {
    const double time = loop.motion.period * i / cells;
    const SurfaceDelta delta = deform_surface(loop.subject.skeleton, loop.subject.structure, loop.surface,
                                              displacement_at(loop.subject.modes, loop.motion, time));
    positions.push_back(loop.surface.position);
    normals.push_back(loop.surface.normal);
    for (std::size_t v = 0; v < loop.surface.vertex_count(); ++v) {
      positions.back()[v] += delta.position[v];
      normals.back()[v] = (normals.back()[v] + delta.normal[v]).normalized();
    }
    everywhere.insert(everywhere.end(), positions.back().begin(), positions.back().end());
    char label[32];
    std::snprintf(label, sizeof label, "t = %.2f s", time);
    labels.emplace_back(label);
  }
  // Seen across the wind, so that lean and sway show.
  const double azimuth = (loop.info.heading - 105) * std::numbers::pi / 180;
  const Camera camera = frame_points(everywhere, azimuth, 0.12, 1);
  std::vector<Image> images;
  for (int i = 0; i < cells; ++i) {
    const auto cell = static_cast<std::size_t>(i);
    images.push_back(
        render_surface(loop.surface, positions[cell], normals[cell], camera, {.width = 400, .height = 400}));
  }
  write_file_atomically(path, encode_png(contact_sheet(images, columns, labels)));
}

void write_output(const std::string& path, const Loop& loop, std::span<const int> frames) {
  const std::string extension = lower_extension(path);
  const auto morphs = [&](MorphForm form) {
    return make_morph_targets(loop.subject.skeleton, loop.subject.structure, loop.surface, loop.subject.modes,
                              loop.motion, form);
  };
  if (extension == ".glb") {
    write_glb(path, loop.surface, morphs(loop.morphs), loop.info, {.compression = loop.compression});
  }
  if (extension == ".html") write_html(path, loop.surface, morphs(MorphForm::signed_weights), loop.info);
  if (extension == ".png") write_contact_sheet(path, loop);
  if (extension == ".csv") {
    write_file_atomically(path, encode_pose_table(loop.subject.skeleton, loop.subject.structure,
                                                  loop.subject.modes, loop.motion, frames));
  }
}

Json describe(const MotionStatistics& statistics) {
  return {{"largest_lean_m", statistics.largest_lean},
          {"largest_lean_rotation_rad", statistics.largest_lean_rotation},
          {"largest_rms_m", statistics.largest_rms},
          {"largest_rms_rotation_rad", statistics.largest_rms_rotation},
          {"most_moved_branch", statistics.most_moved_branch}};
}

Json AnimateCommand::describe_wind(const Wind& chosen) const {
  if (const auto* turbulent = std::get_if<TurbulentWind>(&chosen)) return describe(wind_flags, *turbulent);
  if (const auto* stam = std::get_if<StamWind>(&chosen)) {
    return {{"speed_m_s", stam->mean.speed},
            {"reference_height_m", stam->mean.reference_height},
            {"profile", wind_flags.profile},
            {"roughness_length_m", stam->mean.roughness_length},
            {"heading_deg", stam->mean.heading},
            {"turbulence_intensity", stam->turbulence_intensity},
            {"correlation_time_s", stam->correlation_time},
            {"correlation_length_m", stam->correlation_length}};
  }
  const WindGrid& grid = std::get<GivenWind>(chosen).field->grid;
  return {{"mean_speed_m_s", grid.mean_speed},
          {"period_s", grid.period()},
          {"points", {grid.y_count, grid.z_count}},
          {"heading_deg", wind_flags.heading}};
}

void AnimateCommand::run() const {
  check_outputs();
  const Weather conditions = weather();
  const std::vector<int> frames_for_poses = picked_frames(conditions.loop.sample_count);
  const BakeOptions bake_options{structure.options(), {.count = mode_count}};

  StageLog log;
  const Progress progress = [&](std::string_view stage, double done) { log.progress(stage, done); };
  log.begin("read");
  const Plant plant = open_plant(input);
  log.finish();
  print_warnings(plant);

  const Skeleton& skeleton = plant.imported.skeleton;
  // A sapling of two branches has twelve modes: as many as it has is what was meant.
  BakeOptions options = bake_options;
  if (mode_count > 6 * skeleton.branch_count()) options.modes.count = all_modes;
  const Subject subject = bake(skeleton, options, progress);
  std::vector<std::string> warnings;
  const Motion motion = set_in_motion(subject, conditions, progress, &warnings);
  log.finish();

  const MotionStatistics statistics = motion_statistics(subject.modes, motion);
  for (std::string& line : advice(subject, conditions, statistics)) warnings.push_back(std::move(line));
  for (const std::string& line : warnings) std::cerr << "tremula: warning: " << line << '\n';

  log.begin("surface");
  Surface surface = mesh_surface(skeleton);
  surface.bark_color = plant.imported.colors.bark.value_or(surface.bark_color);
  surface.leaf_color = plant.imported.colors.leaf.value_or(surface.leaf_color);
  const Loop loop{plant,
                  subject,
                  motion,
                  surface,
                  {.name = plant.name,
                   .frames_per_second = frames_per_second,
                   .wind_speed = wind_flags.speed,
                   .heading = wind_flags.heading,
                   .seed = wind_flags.seed},
                  morph_forms.at(morphs),
                  compressions.at(compression)};
  for (const std::string& path : outputs) {
    log.begin("write " + lower_extension(path));
    write_output(path, loop, frames_for_poses);
  }
  log.finish();
  for (const std::string& path : outputs) std::cerr << "tremula: wrote " << path << '\n';

  if (report.empty()) return;
  const Json json = {
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
  write_file_atomically(report, json.dump(1) + '\n');
  std::cerr << "tremula: wrote " << report << '\n';
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
      "per frame), .png (contact sheet); may be repeated");
  sub.add_option("--report", command->report,
                 "What was done, as JSON: settings, frequencies, seconds and memory");
  sub.add_option("--frames", command->frames, "Frames for .csv: 17 or 10-20 (all)");
  sub.add_option(
         "--morphs", command->morphs,
         "Targets in .glb. biased: one a mode, weights 0 to 1 (plays everywhere); paired: a plus and a minus "
         "target a mode; signed: one a mode, weights -1 to 1, which Blender clamps")
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

  const char* wind = "Wind";
  sub.add_option(
         "--wind", command->wind,
         "turbulent: gusts that travel (Shinya & Fournier, or --spectrum); stam: eq. 8 of Stam with unit "
         "variance and a spectrum; stam-printed: eq. 8 as printed, white; or a field FILE.bts (TurbSim)")
      ->capture_default_str()
      ->group(wind);
  sub.add_option("--wind-model", command->wind, "The same")->group("");
  command->wind_flags.add_to(sub, {.group = wind});
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
  command->structure.add_to(sub);
  command->threads.add_to(sub);
  sub.footer(
      "Examples:\n"
      "  tremula animate tree.swc -o tree.glb\n"
      "  tremula animate oak -o oak.html -o oak.png --wind-speed 8 --terrain parkland --seed 3\n"
      "  tremula animate oak -o oak.glb --wind measured.bts --period 60\n"
      "  tremula animate scan.mat -o tree.glb -o pose.csv --wind-speed 6 --period 20 --report report.json\n");
  sub.callback([command] { command->threads.run([&] { command->run(); }); });
}

}  // namespace tremula::cli
