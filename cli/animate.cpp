// tremula animate: a plant in the wind, as a loop in whatever form the outputs' extensions ask for.

#include "tremula/base/error.hpp"
#include "tremula/base/memory.hpp"
#include "tremula/deformation/fit_rig.hpp"
#include "tremula/dynamics/gauge.hpp"
#include "tremula/dynamics/motion_statistics.hpp"
#include "tremula/io/gauge_table.hpp"
#include "tremula/io/html.hpp"
#include "tremula/io/loop_writers.hpp"
#include "tremula/io/turbsim.hpp"
#include "tremula/structure/plausibility.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <numeric>

#include "clips.hpp"
#include "commands.hpp"
#include "common.hpp"
#include "load_flags.hpp"
#include "usage.hpp"
#include "wind_flags.hpp"

namespace tremula::cli {
namespace {

constexpr const char* wind_group = "Wind";
const std::map<std::string, MorphForm> morph_forms{
    {"biased", MorphForm::biased}, {"paired", MorphForm::paired}, {"signed", MorphForm::signed_weights}};
const std::map<std::string, Dynamics> kinds_of_dynamics{
    {"modal", Dynamics::modal}, {"oscillators", Dynamics::oscillators}, {"time", Dynamics::time}};
const std::map<std::string, MeshCompression> compressions{{"none", MeshCompression::none},
                                                          {"quantised", MeshCompression::quantised},
                                                          {"meshopt", MeshCompression::meshopt}};

// What blows, and how it is described in the report.
struct ChosenWind {
  Wind wind;
  Json described;
};

// Said at once, and kept for the report.
struct WarningLog {
  std::vector<std::string> lines;

  void add(const std::vector<std::string>& more) {
    for (const std::string& line : more) {
      if (std::ranges::find(lines, line) != lines.end()) continue;  // of another clip
      print_warnings(std::vector<std::string>{line});
      lines.push_back(line);
    }
  }
};

// A .glb as it was written.
struct WrittenModel {
  std::string form;
  std::size_t joints = 0, clips = 0, keys = 0;
  double largest_error = 0;  // [m]
  std::size_t bytes = 0;
};

// What a run works with and makes, for the report.
struct Done {
  const Plant& plant;
  const StructureOptions& structure;
  const Json& wind_settings;
  const Weather& conditions;
  const Subject& subject;
  const Loop& loop;
  const std::vector<GaugeSeries>& gauges;
  const Json& most_stressed;
  const MotionStatistics& statistics;
  const std::vector<std::string>& warnings;
  const std::optional<WrittenModel>& model;
};

struct Moved {
  Motion motion;
  MotionStatistics statistics;
};

struct AnimateCommand {
  std::string input, report, format;
  std::vector<std::string> outputs, clip_texts;
  bool mean_only = false;
  WindFlags wind_flags;
  std::string wind = "turbulent", transfer = "bin-averaged";
  std::optional<double> correlation_time, correlation_length;  // of StamWind
  double period = 20, frames_per_second = 30, damping_ratio = 0.05;
  std::optional<double> mass_damping, stiffness_damping;
  LoadFlags loads;
  bool no_aerodynamic_damping = false, no_static_correction = false;
  std::string dynamics = "modal";
  int oscillator_modes = 1;
  bool carried_mass = false;
  int mode_count = 20;
  std::vector<std::string> gauges;
  std::string frames, form, morphs = "biased", compression = "quantised";
  double tolerance = 0.005;  // of the height
  std::optional<int> max_joints;
  ReadFlags read;
  StructureFlags structure;
  ThreadsFlag threads;

  bool is_stam() const { return wind == "stam" || wind == "stam-printed"; }
  bool is_field() const { return lower_extension(wind) == ".bts"; }
  ChosenWind chosen_wind() const;
  ChosenWind wind_of(const NamedWind& clip) const;
  StamWind stam_wind() const;
  Weather weather(const Wind& blowing) const;
  std::vector<int> picked_frames(int sample_count) const;
  std::vector<const LoopWriter*> output_writers() const;
  void check_flags(const CLI::App& flags, const std::vector<const LoopWriter*>& writers) const;
  std::vector<Place> output_places() const;
  Plant read_plant(StageLog& log) const;
  int modes_of(const Plant& plant, WarningLog& warnings) const;
  Subject bake_plant(const Plant& plant, BakeOptions options, const Progress& progress,
                     WarningLog& warnings) const;
  LoopFacts loop_facts(const Plant& plant, const ReferenceWind& reference) const;
  std::vector<Gauge> placed_gauges(const Plant& plant) const;
  std::vector<Motion> move_in_others(const Subject& subject, const Weather& first,
                                     const std::vector<NamedWind>& clips, const Progress& progress,
                                     StageLog& log, WarningLog& warnings) const;
  bool on_bones(const CLI::App& flags, const Plant& plant) const;
  RigOptions rig_options(const Subject& subject) const;
  WrittenModel encode_outputs(const Loop& loop, const std::vector<GaugeSeries>& series,
                              const std::vector<const LoopWriter*>& writers, const LoopWriteOptions& options,
                              double model_error, StageLog& log, Outputs& files) const;
  Json report_of(const Done& done, const StageLog& log) const;
  void run(const CLI::App& flags) const;
};

ChosenWind AnimateCommand::chosen_wind() const {
  if (wind == "turbulent") {
    const TurbulentWind turbulent = wind_flags.wind();
    return {turbulent, describe(wind_flags, turbulent)};
  }
  if (is_stam()) {
    const StamWind stam = stam_wind();
    return {stam,
            {{"wind_speed_m_s", stam.mean.speed},
             {"reference_height_m", stam.mean.reference_height},
             {"profile", wind_flags.profile},
             {"roughness_length_m", stam.mean.roughness_length},
             {"heading_deg", stam.mean.heading},
             {"turbulence_intensity", stam.turbulence_intensity},
             {"correlation_time_s", stam.correlation_time},
             {"correlation_length_m", stam.correlation_length}}};
  }
  if (is_field()) {
    const auto field = std::make_shared<const WindField>(wind_field(read_turbsim(wind)));
    const Wind given = GivenWind{field, wind_flags.heading};
    const std::optional<double> intensity = given.reference.intensity;
    return {given,
            {{"wind_speed_m_s", given.reference.speed},
             {"reference_height_m", given.reference.height},
             {"heading_deg", given.reference.heading},
             {"turbulence_intensity", intensity ? Json(*intensity) : Json()},
             {"period_s", field->grid.period()},
             {"points", {field->grid.y_count, field->grid.z_count}}}};
  }
  throw InputError("--wind", "'" + wind + "'", "turbulent, stam, stam-printed or a field FILE.bts");
}

// The same but for its speed.
ChosenWind AnimateCommand::wind_of(const NamedWind& clip) const {
  AnimateCommand other = *this;
  other.wind_flags.speed = clip.wind_speed;
  return other.chosen_wind();
}

StamWind AnimateCommand::stam_wind() const {
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

Weather AnimateCommand::weather(const Wind& blowing) const {
  Weather weather;
  weather.wind = blowing;
  loads.set(structure, weather);
  weather.damping = {.ratio = damping_ratio,
                     .mass_proportional = mass_damping,
                     .stiffness_proportional = stiffness_damping,
                     .aerodynamic = !no_aerodynamic_damping};
  weather.transfer = transfer == "sampled" ? Transfer::sampled : Transfer::bin_averaged;
  weather.static_correction = !no_static_correction;
  weather.dynamics = kinds_of_dynamics.at(dynamics);
  weather.oscillators = {.modes = oscillator_modes, .carried_mass = carried_mass};
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

void AnimateCommand::check_flags(const CLI::App& flags, const std::vector<const LoopWriter*>& writers) const {
  const auto writes = [&](std::string_view name) {
    return std::any_of(writers.begin(), writers.end(),
                       [&](const LoopWriter* each) { return each->extension == name; });
  };
  const bool table = writes("csv"), model = writes("glb");
  const std::string with_wind = "given with --wind " + wind;
  const IdleFlags rules[] = {
      {writers.empty(), "given without -o", "an output that it shapes", {"--format"}},
      {!table, "given without a table of poses", "-o FILE.csv", {"--frames"}},
      {!table && report.empty(),
       "given without a table or a report",
       "-o FILE.csv or --report FILE.json",
       {"--gauge"}},
      {!model,
       "given without a .glb",
       "-o FILE.glb",
       {"--morphs", "--compress", "--form", "--tolerance", "--max-joints", "--clip"}},
      {clip_texts.empty(), "given without --clip", "--clip NAME:SPEED", {"--mean-only"}},
      {!clip_texts.empty(), "given with --clip, which has a wind speed", "one of them", {"--wind-speed"}},
      {!clip_texts.empty(), "given with --clip, which bends bones", "one of them", {"--morphs"}},
      {is_field(), with_wind, "--wind turbulent: a field has a speed of its own", {"--clip"}},
      {form == "skin", "given with --form skin", "--form morph, whose targets it shapes", {"--morphs"}},
      {form == "morph",
       "given with --form morph",
       "--form skin, whose joints it counts",
       {"--max-joints", "--tolerance", "--clip"}},
      {form.empty() && flags.count("--morphs") > 0,
       "given with --morphs",
       "one of them",
       {"--max-joints", "--tolerance"}},
      {loads.pose == "linear" || loads.model == "paper",
       "given where displacements superpose (--pose linear, --loads paper)",
       "--pose bent: joints only turn",
       {"--max-joints", "--tolerance", "--clip"}},
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
      {dynamics != "modal",
       "given with --dynamics " + dynamics,
       "--dynamics modal, whose bins it averages",
       {"--transfer"}},
      {dynamics == "oscillators",
       "given with --dynamics oscillators",
       "--dynamics modal or time",
       {"--no-static-correction", "--drag", "--modes"}},
      {dynamics != "oscillators",
       "given with --dynamics " + dynamics,
       "--dynamics oscillators",
       {"--oscillator-modes", "--carried-mass"}},
      {mass_damping.has_value(),
       "given with --mass-damping",
       "one of them",
       {"--damping-ratio", "--stiffness-damping"}},
      {stiffness_damping.has_value(), "given with --stiffness-damping", "one of them", {"--damping-ratio"}},
  };
  refuse_idle_flags(flags, rules);
  loads.check(flags);
  for (std::size_t i = 0; i < writers.size() && !clip_texts.empty(); ++i) {
    if (writers[i]->extension != "glb")
      throw InputError("-o " + outputs[i], "given with --clip", "a .glb: no other output has clips");
  }
}

// The height above the ground of what stands highest [m].
double height_of(const Structure& structure) {
  double highest = -std::numeric_limits<double>::infinity();
  for (const Node& node : structure.nodes) highest = std::max(highest, node.position.z());
  return highest - ground_height(structure);
}

// Bones for all that bends, unless somebody asks for targets.
bool AnimateCommand::on_bones(const CLI::App& flags, const Plant& plant) const {
  if (form == "morph" || flags.count("--morphs") > 0) return false;
  if (!plant.frame && loads.pose == "bent" && loads.model != "paper") return true;
  for (const char* flag : {"--clip", "--max-joints", "--tolerance", "--form"}) {
    if (flags.count(flag) == 0) continue;
    throw InputError(form == "skin" ? "--form skin" : flag,
                     plant.frame ? "given with a frame" : "given with linear poses",
                     "--form morph, or a tree with --pose bent");
  }
  return false;
}

RigOptions AnimateCommand::rig_options(const Subject& subject) const {
  return {.tolerance = tolerance * height_of(subject.structure), .max_joints = max_joints.value_or(0)};
}

// Where engines stop.
std::vector<std::string> warnings_of(const Rig& rig, const RigOptions& options) {
  constexpr std::size_t many = 256;
  std::vector<std::string> warnings;
  const std::string count = std::to_string(rig.joints.size());
  if (rig.joints.size() > many) {
    warnings.push_back("the .glb has " + count +
                       " joints, and Filament and Bevy take 256 a skin: fewer with --max-joints or a larger "
                       "--tolerance");
  }
  if (rig.largest_error > options.tolerance) {
    warnings.push_back("with " + count + " joints the .glb is up to " + printed("%.3g", rig.largest_error) +
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

Json describe(const Extremes& of) {
  return {{"mean", of.mean},
          {"rms", of.rms},
          {"peak", of.peak},
          {"skewness", of.skewness},
          {"peak_factor_of_600_s", of.peak_factor},
          {"expected_peak_of_600_s", of.expected_peak}};
}

Json describe(const std::vector<GaugeSeries>& gauges) {
  Json list = Json::array();
  for (const GaugeSeries& series : gauges) {
    const auto of = [&](const Eigen::VectorXd& values) {
      return describe(extremes_of(values, series.period));
    };
    list.push_back({{"gauge", series.gauge},
                    {"bending_moment_n_m", of(series.bending_moment)},
                    {"along_n_m", of(series.along_wind)},
                    {"across_n_m", of(series.across_wind)},
                    {"shear_n", of(series.shear)},
                    {"axial_n", of(series.axial)},
                    {"torsion_n_m", of(series.torsion)},
                    {"strain", of(series.strain)}});
  }
  return list;
}

// Stress at the feet of the branches that bear most, beside what they can bear.
Json stresses(const Motion& motion, const Skeleton& skeleton, const Material& material, double heading) {
  Json list = Json::array();
  for (const GaugeReading& reading : motion.most_strained) {
    const Eigen::VectorXd stress = material.youngs_modulus * gauge_series(reading, motion, heading).strain;
    const Extremes extremes = extremes_of(stress, motion.period);
    const double strength = material.modulus_of_rupture;
    const Vec3& foot = skeleton.branches[index_of(reading.gauge.branch)].start;
    list.push_back(
        {{"branch", reading.gauge.branch},
         {"foot_m", {foot.x(), foot.y(), foot.z()}},
         {"radius_m", reading.radius},
         {"stress_pa", describe(extremes)},
         {"share_of_modulus_of_rupture", strength > 0 ? Json(extremes.expected_peak / strength) : Json()}});
  }
  return list;
}

Json describe(const std::optional<WrittenModel>& model) {
  if (!model) return {};
  return {{"form", model->form},
          {"joints", model->joints},
          {"clips", model->clips},
          {"keys", model->keys},
          {"largest_error_m", model->largest_error},
          {"bytes", model->bytes}};
}

// Of the plant as it stands in the mean wind.
std::vector<double> frequencies_of_modes(const Loop& loop) {
  std::vector<double> frequencies;
  for (std::size_t c = 0; c < loop.kind.size(); ++c) {
    if (loop.kind[c] == ShapeKind::mode) frequencies.push_back(loop.frequency[static_cast<Eigen::Index>(c)]);
  }
  return frequencies;
}

Json AnimateCommand::report_of(const Done& done, const StageLog& log) const {
  const Eigen::VectorXd& frequency = done.subject.modes.frequency;
  Json settings = {{"wind", wind}, {"wind_settings", done.wind_settings}};
  settings.update(cli::describe(loads));
  settings.update(Json(
      {{"damping_ratio", mass_damping || stiffness_damping ? Json() : Json(damping_ratio)},
       {"mass_damping_per_s", mass_damping ? Json(*mass_damping) : Json()},
       {"stiffness_damping_s", stiffness_damping ? Json(*stiffness_damping) : Json()},
       {"aerodynamic_damping", !no_aerodynamic_damping},
       {"dynamics", dynamics},
       {"oscillator_modes", dynamics == "oscillators" ? Json(oscillator_modes) : Json()},
       {"carried_mass", dynamics == "oscillators" ? Json(carried_mass) : Json()},
       {"transfer", dynamics == "modal" ? Json(transfer) : Json()},
       {"static_shapes", std::count(done.loop.kind.begin(), done.loop.kind.end(), ShapeKind::static_shape)},
       {"period_s", period},
       {"frames_per_second", frames_per_second},
       {"samples", done.conditions.loop.sample_count},
       {"seed", wind_flags.seed}}));
  return {
      {"tremula", TREMULA_VERSION},
      {"input", input},
      {"plant", cli::describe(done.plant)},
      {"structure",
       done.plant.frame ? Json() : cli::describe(done.structure, done.subject.structure.find_load_margin())},
      {"settings", settings},
      {"warnings", done.warnings},
      {"mode_count", done.subject.modes.count()},
      {"frequencies_hz", std::vector<double>(frequency.begin(), frequency.end())},
      {"frequencies_in_wind_hz", frequencies_of_modes(done.loop)},
      {"motion", describe(done.statistics)},
      {"gauges", describe(done.gauges)},
      {"most_stressed_branches", done.most_stressed},
      {"glb", describe(done.model)},
      {"clips", clip_texts},
      {"outputs", outputs},
      {"stages", log.json()},
      {"peak_bytes", peak_bytes()}};
}

// Frames are sawn and have no bark.
Surface skin_of(const Plant& plant) {
  SurfaceOptions options;
  const PlantColors& colors = plant.imported.colors;
  options.tube.color = colors.bark.value_or(options.tube.color);
  options.leaf.color = colors.leaf.value_or(options.leaf.color);
  if (plant.frame) options.tube = {.name = "timber", .color = {0.62F, 0.49F, 0.34F}};
  return mesh_surface(plant.imported.skeleton, options);
}

Plant AnimateCommand::read_plant(StageLog& log) const {
  log.begin("read");
  Plant plant = under_weight(open_plant(input, read), structure);
  log.finish();
  print_warnings(plant);
  return plant;
}

// How many move the plant: all that it has, where more are asked for.
int AnimateCommand::modes_of(const Plant& plant, WarningLog& warnings) const {
  const int most = plant.frame ? free_rows(*plant.frame) : 6 * plant.imported.skeleton.branch_count();
  if (mode_count <= most) return mode_count < 0 ? most : mode_count;
  warnings.add({"--modes " + std::to_string(mode_count) + ": the plant has " + std::to_string(most) +
                ", and all are taken"});
  return most;
}

LoopSize loop_size(const Plant& plant, const Surface& surface, int mode_count, int sample_count,
                   std::size_t frame_count) {
  return {.node_count = static_cast<double>(plant.imported.skeleton.node_count()),
          .vertex_count = static_cast<double>(surface.vertex_count()),
          .mode_count = static_cast<double>(mode_count),
          .sample_count = static_cast<double>(sample_count),
          .frame_count = static_cast<double>(frame_count)};
}

Subject AnimateCommand::bake_plant(const Plant& plant, BakeOptions options, const Progress& progress,
                                   WarningLog& warnings) const {
  if (plant.frame) {
    options.frame = structure.frame_options(input);
    return bake(*plant.frame, options, progress);
  }
  const Skeleton& skeleton = plant.imported.skeleton;
  Subject subject =
      with_likely_reason(skeleton, options.structure, [&] { return bake(skeleton, options, progress); });
  warnings.add(plausibility(skeleton, options.structure, subject.modes.frequency[0]));
  return subject;
}

// Takes the shapes of the modes and leaves the rest of the subject.
Moved move_in_wind(Subject& subject, const Weather& conditions, bool superposed, const Progress& progress,
                   StageLog& log, WarningLog& warnings) {
  Eigen::MatrixXd shapes = std::move(subject.modes.shapes);
  Modes modes = subject.modes;
  modes.shapes = std::move(shapes);
  std::vector<std::string> of_wind;
  Motion motion = set_in_motion(subject.structure, std::move(modes), conditions, progress, &of_wind);
  log.finish();
  MotionStatistics statistics = motion_statistics(subject.structure, motion);
  warnings.add(of_wind);
  warnings.add(advice(subject, conditions, statistics, superposed));
  return {std::move(motion), std::move(statistics)};
}

// All but the first.
std::vector<Motion> AnimateCommand::move_in_others(const Subject& subject, const Weather& first,
                                                   const std::vector<NamedWind>& clips,
                                                   const Progress& progress, StageLog& log,
                                                   WarningLog& warnings) const {
  std::vector<Motion> motions;
  for (std::size_t i = 1; i < clips.size(); ++i) {
    Weather conditions = first;
    conditions.wind = wind_of(clips[i]).wind;
    conditions.most_strained = 0;
    Subject again = subject;
    Motion motion = move_in_wind(again, conditions, false, progress, log, warnings).motion;
    motions.push_back(mean_only ? lean_alone(std::move(motion)) : std::move(motion));
  }
  return motions;
}

LoopFacts AnimateCommand::loop_facts(const Plant& plant, const ReferenceWind& reference) const {
  return {.name = plant.name,
          .frames_per_second = frames_per_second,
          .wind_speed = reference.speed,
          .heading = reference.heading,
          .seed = wind_flags.seed};
}

std::vector<Gauge> AnimateCommand::placed_gauges(const Plant& plant) const {
  if (gauges.empty()) return {};
  need_tree(plant, "--gauge");
  std::vector<Gauge> placed;
  for (const std::string& place : gauges) placed.push_back(place_gauge(plant.imported.skeleton, place));
  return placed;
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

// Whatever the flags and the files they name have wrong is said before the work begins.
void AnimateCommand::run(const CLI::App& flags) const {
  const std::vector<const LoopWriter*> writers = output_writers();
  check_flags(flags, writers);
  Outputs files(output_places(), {{"INPUT", input},
                                  {"--wind", wind},
                                  {"--spectrum", wind_flags.spectrum},
                                  {"--profile", wind_flags.profile}});
  const std::vector<NamedWind> clips = parse_clips(clip_texts);
  const ChosenWind blowing = clips.empty() ? chosen_wind() : wind_of(clips[0]);
  Weather conditions = weather(blowing.wind);
  const std::vector<int> poses = picked_frames(conditions.loop.sample_count);
  LoopWriteOptions write_options{
      .frames = poses, .morphs = morph_forms.at(morphs), .compression = compressions.at(compression)};
  BakeOptions options{.structure = structure.options(), .modes = {.count = mode_count}};

  StageLog log;
  WarningLog warnings;
  const Progress progress = [&](std::string_view stage, double done) { log.progress(stage, done); };
  const Plant plant = read_plant(log);
  write_options.on_bones = on_bones(flags, plant);
  conditions.gauges = placed_gauges(plant);
  if (!report.empty() && !plant.frame) conditions.most_strained = 10;
  const int modes = modes_of(plant, warnings);
  if (mode_count > modes) options.modes.count = all_modes;
  log.begin("surface");
  Surface surface = skin_of(plant);
  log.finish();
  warnings.add(check_size(loop_size(plant, surface, modes, conditions.loop.sample_count, poses.size()),
                          write_options, writers, outputs));

  Subject subject = bake_plant(plant, options, progress, warnings);
  const auto writes = [&](std::string_view extension) {
    return std::any_of(writers.begin(), writers.end(),
                       [&](const LoopWriter* each) { return each->extension == extension; });
  };
  // Bent poses superpose nothing; morph targets do, whatever the poses.
  const bool superposed = plant.frame || loads.pose == "linear" || writes("html") ||
                          (writes("glb") && (form == "morph" || flags.count("--morphs") > 0));
  std::vector<Motion> other_clips = move_in_others(subject, conditions, clips, progress, log, warnings);
  Moved moved = move_in_wind(subject, conditions, superposed, progress, log, warnings);
  std::vector<GaugeSeries> series;
  for (const GaugeReading& reading : moved.motion.readings)
    series.push_back(gauge_series(reading, moved.motion, conditions.wind.reference.heading));
  const Json most_stressed = stresses(moved.motion, plant.imported.skeleton, options.structure.material,
                                      conditions.wind.reference.heading);
  std::shared_ptr<const Rig> rig;
  if (writes("glb") && write_options.on_bones) {
    log.begin("bones");
    if (mean_only) moved.motion = lean_alone(std::move(moved.motion));
    std::vector<ClipSource> sources{{clips.empty() ? "wind loop" : clips[0].name, &moved.motion}};
    for (std::size_t i = 1; i < clips.size(); ++i) sources.push_back({clips[i].name, &other_clips[i - 1]});
    rig = std::make_shared<const Rig>(fit_rig(subject.structure, surface, sources, rig_options(subject)));
    log.finish();
    warnings.add(warnings_of(*rig, rig_options(subject)));
  }
  const bool bends = moved.motion.lean_strains.size() > 0;
  const double model_error = rig ? rig->largest_error
                             : bends && writes("glb")
                                 ? linear_pose_error(subject.structure, surface, moved.motion)
                                 : 0;
  Loop loop = make_loop(subject.structure, std::move(surface), std::move(moved.motion),
                        loop_facts(plant, conditions.wind.reference));
  loop.rig = rig;
  const WrittenModel written = encode_outputs(loop, series, writers, write_options, model_error, log, files);
  if (!report.empty()) {
    const Done done{plant,
                    options.structure,
                    blowing.described,
                    conditions,
                    subject,
                    loop,
                    series,
                    most_stressed,
                    moved.statistics,
                    warnings.lines,
                    writes("glb") ? std::optional(written) : std::nullopt};
    files.add(report, text_of(report_of(done, log)));
  }
  files.commit();
  files.announce();
}

}  // namespace

void add_animate(CLI::App& app) {
  auto command = std::make_shared<AnimateCommand>();
  CLI::App& sub = *app.add_subcommand("animate", "A plant in the wind, as a loop that closes exactly");
  sub.add_option("INPUT", command->input,
                 "A tree file (SWC, TreeQSM .mat or text, SimpleForest CSV), an L-system (.lsys), a frame "
                 "(.toml) or a preset")
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
  sub.add_option(
         "--gauge", command->gauges,
         "Where to read bending moment, shear, axial force, torsion and strain: base, stem:1.3 (metres along "
         "the stem) or branch:12:0.5; may be repeated. Into the .csv instead of poses, and into the report")
      ->take_all();
  sub.add_option("--frames", command->frames, "Frames for .csv: 17 or 10-20 (all)");
  sub.add_option(
         "--form", command->form,
         "Of .glb. skin: bones, which bend; morph: targets, which stretch what sways far (skin; morph for "
         "frames, linear poses and with --morphs)")
      ->check(CLI::IsMember({"skin", "morph"}))
      ->group(bones_group);
  sub.add_option("--tolerance", command->tolerance,
                 "How far the skin of .glb may be off the poses, as a part of the height of the plant")
      ->capture_default_str()
      ->group(bones_group);
  sub.add_option("--clip", command->clip_texts,
                 "A wind of its own in .glb, by name and speed [m/s]: calm:2; may be repeated. All have the "
                 "same joints, period and gusts, so that an engine can fade from one to another")
      ->take_all()
      ->group(bones_group);
  sub.add_flag("--mean-only", command->mean_only,
               "Clips are the lean in the mean wind alone, for an engine that adds the gusts")
      ->group(bones_group);
  sub.add_option("--max-joints", command->max_joints,
                 "At most so many bones in .glb, whatever error that costs (what --tolerance takes)")
      ->group(bones_group);
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
  sub.add_option(
         "--dynamics", command->dynamics,
         "modal: modes of the plant, synthesised; time: the same, integrated in time until they repeat; "
         "oscillators: every branch a beam of its own, as in Shinya and Fournier 1992")
      ->check(CLI::IsMember(kinds_of_dynamics))
      ->capture_default_str()
      ->group(motion);
  sub.add_option("--oscillator-modes", command->oscillator_modes,
                 "Of every branch, with --dynamics oscillators")
      ->capture_default_str()
      ->group(motion);
  sub.add_flag("--carried-mass", command->carried_mass,
               "A branch swings with the mass of what it carries, with --dynamics oscillators")
      ->group(motion);
  sub.add_option("--transfer", command->transfer,
                 "bin-averaged: right variance for every period; sampled: as in the papers")
      ->check(CLI::IsMember({"bin-averaged", "sampled"}))
      ->capture_default_str()
      ->group(motion);
  sub.add_flag("--no-static-correction", command->no_static_correction,
               "Leave out the static shapes that stand for the modes beyond --modes")
      ->group(motion);
  command->loads.add_to(sub, motion);
  command->read.add_to(sub);
  command->structure.add_to(sub);
  command->threads.add_to(sub);
  sub.footer(
      "Examples:\n"
      "  tremula animate tree.swc -o tree.glb\n"
      "  tremula animate oak -o oak.html -o oak.png --wind-speed 8 --terrain parkland --seed 3\n"
      "  tremula animate oak -o oak.glb --wind measured.bts --period 60\n"
      "  tremula animate oak --clip calm:2 --clip gale:16 --compress meshopt -o oak.glb\n"
      "  tremula animate scan.mat -o tree.glb -o pose.csv --wind-speed 6 --period 20 --report report.json\n");
  sub.callback([command, &sub] { command->threads.run([&] { command->run(sub); }); });
}

}  // namespace tremula::cli
