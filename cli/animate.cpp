// tremula animate: a plant in the wind, as a loop in whatever form the outputs' extensions ask for. Read
// run(), the last.

#include "tremula/base/error.hpp"
#include "tremula/base/memory.hpp"
#include "tremula/deformation/panel_pose.hpp"
#include "tremula/deformation/sheet_pose.hpp"
#include "tremula/dynamics/flutter.hpp"
#include "tremula/io/gauge_table.hpp"
#include "tremula/io/gust_table.hpp"
#include "tremula/io/html.hpp"
#include "tremula/io/turbsim.hpp"
#include "tremula/structure/plausibility.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <limits>
#include <memory>
#include <numbers>
#include <numeric>

#include "animate.hpp"

namespace tremula::cli {
namespace {

// The height above the ground of what stands highest [m].
double height_of(const Structure& structure) {
  double highest = -std::numeric_limits<double>::infinity();
  for (const Node& node : structure.nodes) highest = std::max(highest, node.position.z());
  return highest - ground_height(structure);
}

double height_of(const Skeleton& skeleton) {
  const Extent box = extent(skeleton);
  return box.high.z() - box.low.z();
}

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

// Frames are sawn and have no bark.
Surface skin_of(const Plant& plant) {
  SurfaceOptions options;
  const PlantColors& colors = plant.imported.colors;
  if (plant.sheet) {
    const Eigen::Vector3f grey(0.7F, 0.7F, 0.7F);
    return sheet_surface(*plant.sheet,
                         {.name = "cloth", .color = colors.leaf.value_or(grey), .two_sided = true});
  }
  options.tube.color = colors.bark.value_or(options.tube.color);
  options.leaf.color = colors.leaf.value_or(options.leaf.color);
  const Eigen::Vector3f timber(0.62F, 0.49F, 0.34F), aluminium(0.7F, 0.7F, 0.7F);
  if (plant.frame) options.tube = {.name = "timber", .color = colors.bark.value_or(timber)};
  Surface surface = mesh_surface(plant.imported.skeleton, options);
  if (plant.frame) {
    add_panels(
        *plant.frame,
        {.name = "panel", .color = colors.leaf.value_or(aluminium), .roughness = 0.5F, .two_sided = true},
        surface);
  }
  return surface;
}

LoopSize loop_size(const Plant& plant, const Surface& surface, int mode_count, int sample_count,
                   std::size_t frame_count) {
  int nodes = plant.sheet ? plant.sheet->node_count() : plant.imported.skeleton.node_count();
  if (plant.frame) {
    for (const Panel& panel : plant.frame->panels) nodes += panel.sheet.node_count();
  }
  return {.node_count = static_cast<double>(nodes),
          .vertex_count = static_cast<double>(surface.vertex_count()),
          .mode_count = static_cast<double>(mode_count),
          .sample_count = static_cast<double>(sample_count),
          .frame_count = static_cast<double>(frame_count)};
}

// The presets are made for a wind along x: about the vertical through the origin.
void turn_into_wind(Sheet& sheet, double heading) {
  const Eigen::AngleAxisd turn(heading * std::numbers::pi / 180, Vec3::UnitZ());
  for (Vec3* vector : {&sheet.corner, &sheet.along_width, &sheet.along_height}) *vector = turn * *vector;
}

void turn_into_wind(Plant& plant, double heading) {
  if (plant.sheet) turn_into_wind(*plant.sheet, heading);
  if (!plant.frame) return;
  const Eigen::AngleAxisd turn(heading * std::numbers::pi / 180, Vec3::UnitZ());
  for (Vec3& node : plant.frame->nodes) node = turn * node;
  for (Panel& panel : plant.frame->panels) turn_into_wind(panel.sheet, heading);
  plant.imported.skeleton = outline_of(*plant.frame);
}

// The mean; of a wind that does not say, that of its reference height.
Vec3 wind_at_middle(const Sheet& sheet, const Wind& wind) {
  if (wind.statistics) return wind.statistics(sheet.position({sheet.width / 2, sheet.height / 2})).mean;
  const double heading = wind.reference.heading * std::numbers::pi / 180;
  return wind.reference.speed * Vec3(std::cos(heading), std::sin(heading), 0);
}

// A sheet that flaps by itself in this wind, yet shall not, is taken with the pull at which it just does not:
// that by which its waves run somewhat faster than the wind, N = m U^2, as those of flags in flight nearly do
// (Alben 2022, arXiv 2106.14988). Says so.
std::vector<std::string> pull_until_stable(Sheet& sheet, const SheetOptions& options, const Vec3& wind) {
  constexpr double faster = 1.3;  // than the square of the wind's speed
  const double speed = wind.norm();
  if (!(speed > 0) || std::abs(wind.dot(sheet.normal())) > 0.5 * speed) return {};
  const FlutterOnset onset = find_flutter(sheet, options, wind / speed, speed);
  if (!std::isfinite(onset.speed)) return {};
  const bool along_width = std::abs(wind.dot(sheet.along_width)) > std::abs(wind.dot(sheet.along_height));
  const double across = along_width ? sheet.height : sheet.width;
  const double mass = sheet.density * sheet.thickness + options.fluid_density * std::numbers::pi / 4 * across;
  (along_width ? sheet.tension.x : sheet.tension.y) += faster * mass * speed * speed;
  return {
      printed("in a wind of %.3g m/s this sheet is above its flutter speed of %.3g m/s: it would flap by "
              "itself (--dynamics flapping, if it is held on one edge), and what is made is how gusts run "
              "along it, pulled until it does not",
              speed, onset.speed)};
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

// AMPLITUDE:DURATION or AMPLITUDE:DURATION:START, of a whole text.
OneMinusCosine parse_gust(const std::string& text, const std::string& numbers) {
  double values[3] = {};
  std::size_t count = 0;
  const char *at = numbers.data(), *end = at + numbers.size();
  while (count < 3) {
    const auto read = std::from_chars(at, end, values[count]);
    if (read.ec != std::errc{} || !std::isfinite(values[count])) break;
    ++count;
    at = read.ptr;
    if (at == end || *at != ':') break;
    ++at;
  }
  if (at != end || count < 2 || numbers.ends_with(':')) {
    throw InputError("--gust", "'" + text + "'",
                     "an amplitude [m/s], a duration [s] and perhaps a start [s], such as 1-cosine:8:2.5");
  }
  return {values[0], values[1], values[2]};
}

// A pull that bends the plant beyond what is linear.
std::vector<std::string> warnings_of(const PullTest& test, const Structure& structure) {
  constexpr double far = 0.3;  // of the height
  const Member& member = structure.members[static_cast<std::size_t>(test.pull.place.branch)];
  const double height = member.point(test.pull.place.place).z() - ground_height(structure);
  const double pulled = test.released_from.norm();
  if (!(pulled > far * height)) return {};
  return {
      printed("the pull moves the plant by %.2g m at a height of %.2g m: too far for modes, which are of "
              "small displacements; pull less",
              pulled, height)};
}

std::string told(const WrittenModel& model) {
  const std::string off = printed(", %.2g m off the poses at most", model.largest_error);
  if (model.form != "skin") return "morph targets" + (model.largest_error > 0 ? off : "");
  return std::to_string(model.joints) + " joints, " + std::to_string(model.keys) + " keys" + off;
}

}  // namespace

void WarningLog::add(const std::vector<std::string>& more) {
  for (const std::string& line : more) {
    if (std::ranges::find(lines, line) != lines.end()) continue;
    print_warnings(std::vector<std::string>{line});
    lines.push_back(line);
  }
}

// A plant that lives in water has the wind over it: that makes waves, and drifts the water besides the
// current that there is anyway. Any other may be put into a current.
void AnimateCommand::settle_in(const Habitat& habitat, const CLI::App& flags) {
  structure.settle_in(habitat);
  if (habitat.in_water && structure.medium == "water") {
    under_water = habitat;
    if (water_depth) under_water->water_depth = *water_depth;
    wind_over_water = wind_flags.speed;
    wind_flags.speed = current_under(wind_over_water);
    if (flags.count("--reference-height") == 0) wind_flags.reference_height = under_water->water_depth;
  } else if (current) {
    if (flags.count("--wind-speed") > 0)
      throw InputError("--current", "given with --wind-speed",
                       "one of them, but for plants that live in water");
    wind_flags.speed = *current;
  }
}

double AnimateCommand::current_under(double wind_speed) const {
  return current.value_or(under_water->current + wind_drift * wind_speed);
}

bool AnimateCommand::asks_for_turbulence() const {
  const auto given = [](const CLI::Option* option) { return option->count() > 0; };
  return wind_flags.turbulence_intensity || wind_flags.friction_velocity ||
         std::ranges::any_of(wind_flags.of_turbulence, given);
}

// A pull is let go in still air, and what a script says blows smoothly, unless flags want more.
WindFlags AnimateCommand::flags_of_wind() const {
  WindFlags flags = wind_flags;
  if (pull.empty() && gust.empty()) return flags;
  if (!pull.empty() && flags.speed_option->count() == 0) flags.speed = 0;
  if (!asks_for_turbulence()) flags.turbulence_intensity = 0;
  return flags;
}

// A clip is as long as the table, unless somebody says how long; what blows is the script's wind on the
// average.
void AnimateCommand::read_gust(const CLI::App& flags) {
  if (gust.empty()) return;
  constexpr std::string_view discrete = "1-cosine:";
  if (gust.starts_with(discrete)) {
    const double speed = flags_of_wind().mean_wind().speed;
    script = GustScript{{{0, speed, wind_flags.heading}}, parse_gust(gust, gust.substr(discrete.size()))};
  } else if (std::filesystem::exists(gust)) {
    script = read_gust_table(gust, wind_flags.heading);
    if (flags.count("--period") == 0 && script->rows.back().time > 0) period = script->rows.back().time;
  } else {
    throw InputError("--gust", "'" + gust + "'", "1-cosine:AMPLITUDE:DURATION[:START] or a table FILE.csv");
  }
  const GustRow mean = mean_of(*script, weather({}).loop);
  if (!(mean.speed > 0))
    throw InputError("--gust", "no wind while the clip lasts", "a gust or a --wind-speed above 0 m/s");
  wind_flags.speed = mean.speed;
  wind_flags.heading = mean.heading;
}

ChosenWind AnimateCommand::chosen_wind() const {
  if (wind == "turbulent") {
    const WindFlags flags = flags_of_wind();
    const TurbulentWind turbulent = flags.wind();
    return {turbulent, describe(flags, turbulent)};
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
  other.wind_flags.speed = under_water ? current_under(clip.wind_speed) : clip.wind_speed;
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

std::optional<Waves> AnimateCommand::chosen_waves(double wind_speed) const {
  if (waves.empty() && under_water && wind_speed > 0 && loads.model != "paper") {
    Waves sea = wind_waves(wind_speed, under_water->water_depth);
    sea.heading = wind_flags.heading;
    sea.seed = wind_flags.seed;
    return sea;
  }
  if (waves.empty()) return {};
  Waves sea{.water_depth = 0, .heading = wind_flags.heading, .seed = wind_flags.seed};
  const char *begin = waves.data(), *end = begin + waves.size();
  const auto height = std::from_chars(begin, end, sea.significant_height);
  const bool parts = height.ec == std::errc{} && height.ptr != end && *height.ptr == ':';
  const auto last = parts ? std::from_chars(height.ptr + 1, end, sea.peak_period) : height;
  if (!parts || last.ec != std::errc{} || last.ptr != end) {
    throw InputError("--waves", "'" + waves + "'",
                     "a significant height [m] and a peak period [s], such as 0.5:4");
  }
  if (water_depth || under_water) {
    sea.water_depth = under_water ? under_water->water_depth : *water_depth;
    check_waves(sea);
  }
  return sea;
}

Weather AnimateCommand::weather(const Wind& blowing) const {
  Weather weather;
  weather.wind = blowing;
  loads.set(structure, weather);
  weather.damping = {.ratio = damping_ratio,
                     .ratios = Eigen::VectorXd::Map(mode_damping.data(), std::ssize(mode_damping)),
                     .mass_proportional = mass_damping,
                     .stiffness_proportional = stiffness_damping,
                     .decay_time = decay_time,
                     .aerodynamic = !no_aerodynamic_damping};
  weather.transfer = transfer == "sampled" ? Transfer::sampled : Transfer::bin_averaged;
  weather.static_correction = !no_static_correction;
  weather.dynamics = kinds_of_dynamics.at(dynamics);
  weather.oscillators = {.modes = oscillator_modes, .carried_mass = carried_mass};
  weather.script = script;
  weather.from_rest = from_rest;
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
    const int most = is_clip() ? sample_count - 1 : sample_count;  // a loop begins again
    if (!good || first < 0 || first > last || last > most) {
      throw InputError("--frames", "'" + frames + "'",
                       "a frame or a range such as 10-20 within 0-" + std::to_string(most));
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

RigOptions AnimateCommand::rig_options(const Subject& subject) const {
  return {.tolerance = tolerance * height_of(subject.structure), .max_joints = max_joints.value_or(0)};
}

Plant AnimateCommand::read_plant(StageLog& log) const {
  log.begin("read");
  Plant plant = under_weight(open_plant(input, read), structure);
  if (!std::filesystem::exists(input)) turn_into_wind(plant, wind_flags.heading);
  log.finish();
  print_warnings(plant);
  return plant;
}

// How many move the plant: all that it has, where more are asked for.
int AnimateCommand::modes_of(const Plant& plant, WarningLog& warnings) const {
  const int most = plant.sheet   ? static_cast<int>(assemble_sheet(*plant.sheet, {.gravity = 0}).size())
                   : plant.frame ? free_rows(*plant.frame)
                                 : 6 * plant.imported.skeleton.branch_count();
  if (mode_count <= most) return mode_count < 0 ? most : mode_count;
  warnings.add({"--modes " + std::to_string(mode_count) + ": the plant has " + std::to_string(most) +
                ", and all are taken"});
  return most;
}

Dynamics AnimateCommand::dynamics_of(const CLI::App& flags, const Plant& plant, const Wind& blowing) const {
  if (!plant.sheet) {
    if (dynamics == "flapping")
      throw InputError("--dynamics flapping", "given with " + std::string(plant.kind()), "a flag");
    return kinds_of_dynamics.at(dynamics);
  }
  const SheetOptions options = structure.sheet_options(input);
  const bool chosen = flags.count("--dynamics") > 0 || loads.pose == "linear" || loads.model == "paper";
  if (chosen || !flaps(*plant.sheet, options, wind_at_middle(*plant.sheet, blowing)))
    return kinds_of_dynamics.at(dynamics);
  return Dynamics::flapping;
}

// A flag that flaps has no use for what belongs to modes.
void AnimateCommand::refuse_of_modes(const CLI::App& flags) const {
  for (const char* flag :
       {"--modes", "--drag", "--transfer", "--no-static-correction", "--no-aerodynamic-damping"}) {
    if (flags.count(flag) > 0)
      throw InputError(flag, "given with a flag that flaps", "--dynamics modal with it");
  }
}

// The mean wind drags along the sheet and so pulls it straight.
Subject AnimateCommand::bake_sheet(Sheet sheet, BakeOptions options, const Weather& conditions,
                                   const Progress& progress, WarningLog& warnings) const {
  options.sheet = structure.sheet_options(input);
  const Vec3 mean = wind_at_middle(sheet, conditions.wind);
  options.sheet.pull = drag_along(sheet, mean, options.sheet.fluid_density);
  return in_file(input, [&] {
    if (conditions.dynamics != Dynamics::flapping)
      warnings.add(pull_until_stable(sheet, options.sheet, mean));
    return bake(sheet, options, progress);
  });
}

Subject AnimateCommand::bake_plant(const Plant& plant, BakeOptions options, const Weather& conditions,
                                   const Progress& progress, WarningLog& warnings) const {
  if (plant.sheet) return bake_sheet(*plant.sheet, options, conditions, progress, warnings);
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

// All but the first.
std::vector<Motion> AnimateCommand::move_in_others(const Subject& subject, const Weather& first,
                                                   const std::vector<NamedWind>& clips,
                                                   const std::optional<Waves>& sea, const Progress& progress,
                                                   StageLog& log, WarningLog& warnings) const {
  std::vector<Motion> motions;
  for (std::size_t i = 1; i < clips.size(); ++i) {
    Weather conditions = first;
    conditions.wind = wind_of(clips[i]).wind;
    const std::optional<Waves> own = waves.empty() ? chosen_waves(clips[i].wind_speed) : sea;
    if (own) conditions.wind = add_waves(conditions.wind, *own);
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
          .seed = wind_flags.seed,
          .under_water = structure.medium == "water"};
}

std::vector<Gauge> AnimateCommand::placed_gauges(const Plant& plant) const {
  if (gauges.empty()) return {};
  need_tree(plant, "--gauge");
  std::vector<Gauge> placed;
  for (const std::string& place : gauges) placed.push_back(place_gauge(plant.imported.skeleton, place));
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

// Whatever the flags and the files they name have wrong is said before the work begins.
void AnimateCommand::run(const CLI::App& flags) {
  const std::vector<const LoopWriter*> writers = output_writers();
  check_flags(flags, writers);
  Outputs files(output_places(), {{"INPUT", input},
                                  {"--wind", wind},
                                  {"--spectrum", wind_flags.spectrum},
                                  {"--profile", wind_flags.profile},
                                  {"--gust", gust}});
  read_gust(flags);
  const std::vector<NamedWind> clips = parse_clips(clip_texts);
  const ChosenWind blowing = clips.empty() ? chosen_wind() : wind_of(clips[0]);
  Weather conditions = weather(blowing.wind);
  std::optional<Waves> sea = chosen_waves(clips.empty() ? wind_over_water : clips[0].wind_speed);
  const std::vector<int> poses = picked_frames(conditions.loop.sample_count);
  LoopWriteOptions write_options{
      .frames = poses, .morphs = morph_forms.at(morphs), .compression = compressions.at(compression)};
  BakeOptions options{.structure = structure.options(), .modes = {.count = mode_count}};

  StageLog log;
  WarningLog warnings;
  const Progress progress = [&](std::string_view stage, double done) { log.progress(stage, done); };
  const Plant plant = read_plant(log);
  write_options.on_bones = on_bones(flags, plant);
  if (sea) {
    if (!water_depth && plant.sheet)
      throw InputError("--waves", "given with a sheet", "--water-depth with it");
    if (!water_depth && !under_water) sea->water_depth = 1.25 * height_of(plant.imported.skeleton);
    conditions.wind = add_waves(conditions.wind, *sea);
  }
  conditions.gauges = placed_gauges(plant);
  if (!pull.empty()) {
    need_tree(plant, "--pull");
    conditions.pull = place_pull(plant.imported.skeleton, pull, pull_heading.value_or(wind_flags.heading));
  }
  if (!report.empty() && plant.is_tree()) conditions.most_strained = 10;
  const int modes = modes_of(plant, warnings);
  if (mode_count > modes) options.modes.count = all_modes;
  log.begin("surface");
  Surface surface = skin_of(plant);
  log.finish();
  warnings.add(check_size(loop_size(plant, surface, modes, conditions.loop.sample_count, poses.size()),
                          write_options, writers, outputs));

  conditions.dynamics = dynamics_of(flags, plant, conditions.wind);
  if (conditions.dynamics == Dynamics::flapping) refuse_of_modes(flags);
  if (is_clip() && plant.sheet && conditions.dynamics != Dynamics::flapping)
    throw InputError(gust.empty() ? "--from-rest" : "--gust", "a sheet that no wind makes flap",
                     "a flag, a tree or a frame");
  if (plant.sheet) conditions.flapping.gravity = structure.gravity;
  Subject subject = bake_plant(plant, options, conditions, progress, warnings);
  const auto writes = [&](std::string_view extension) {
    return std::any_of(writers.begin(), writers.end(),
                       [&](const LoopWriter* each) { return each->extension == extension; });
  };
  // Bent poses superpose nothing; morph targets do, whatever the poses.
  const bool has_skin = writes("glb") || writes("html");
  const bool flat = plant.sheet && (loads.pose == "linear" || loads.model == "paper");
  const bool superposed =
      plant.sheet ? flat : plant.frame || loads.pose == "linear" || (has_skin && !write_options.on_bones);
  std::vector<Motion> other_clips = move_in_others(subject, conditions, clips, sea, progress, log, warnings);
  Moved moved = move_in_wind(subject, conditions, superposed, progress, log, warnings);
  std::vector<GaugeSeries> series;
  for (const GaugeReading& reading : moved.motion.readings)
    series.push_back(gauge_series(reading, moved.motion, conditions.wind.reference.heading));
  const Json most_stressed = stresses(moved.motion, plant.imported.skeleton, options.structure.material,
                                      conditions.wind.reference.heading);
  const DampingBySource damping = moved.motion.damping;
  const Vec3 mean_drag = moved.motion.mean_drag;
  const std::optional<PullTest> test = moved.motion.pull;
  if (test) warnings.add(warnings_of(*test, subject.structure));
  std::shared_ptr<const Rig> rig;
  if (has_skin && write_options.on_bones) {
    if (mean_only) moved.motion = lean_alone(std::move(moved.motion));
    const double speed = conditions.wind.reference.speed;
    std::vector<ClipSource> sources{{!clips.empty() ? clips[0].name
                                     : is_clip()    ? "clip"
                                                    : "wind loop",
                                     &moved.motion, speed}};
    for (std::size_t i = 1; i < clips.size(); ++i)
      sources.push_back({clips[i].name, &other_clips[i - 1], clips[i].wind_speed});
    rig = fit_bones(subject, surface, sources, writes("html"), writes("glb"), log, warnings);
  }
  const bool bends = moved.motion.lean_strains.size() > 0;
  const double model_error = rig ? rig->largest_error
                             : bends && writes("glb")
                                 ? linear_pose_error(subject.structure, surface, moved.motion)
                                 : 0;
  Loop loop = make_loop(subject.structure, std::move(surface), std::move(moved.motion),
                        loop_facts(plant, conditions.wind.reference), flat ? Poses::linear : Poses::bent);
  loop.rig = rig;
  const WrittenModel written = encode_outputs(loop, series, writers, write_options, model_error, log, files);
  if (!report.empty()) {
    const Done done{plant,
                    options.structure,
                    blowing.described,
                    sea,
                    conditions,
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
