// From the file of a plant to its motion, as flags and scenes say: read prepare(), bake() and move().
#include "plant_in_wind.hpp"

#include "tremula/deformation/panel_pose.hpp"
#include "tremula/deformation/sheet_pose.hpp"
#include "tremula/dynamics/flutter.hpp"
#include "tremula/structure/plausibility.hpp"
#include "tremula/wind/profile.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>
#include <utility>

namespace tremula::cli {
namespace {

double height_of(const Skeleton& skeleton) {
  const Extent box = extent(skeleton);
  return box.high.z() - box.low.z();
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
  return wind.reference.speed * heading_direction(wind.reference.heading);
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

}  // namespace

double height_of(const Structure& structure) {
  double highest = -std::numeric_limits<double>::infinity();
  for (const Node& node : structure.nodes) highest = std::max(highest, node.position.z());
  return highest - ground_height(structure);
}

void WarningLog::add(const std::vector<std::string>& more) {
  for (const std::string& line : more) {
    if (std::ranges::find(lines, line) != lines.end()) continue;
    print_warnings(std::vector<std::string>{line});
    lines.push_back(line);
  }
}

Plant PlantInWind::open() const {
  Plant plant = under_weight(open_plant(input, read, growth_seed, constants), structure);
  if (colors.bark) plant.imported.colors.bark = colors.bark;
  if (colors.leaf) plant.imported.colors.leaf = colors.leaf;
  if (!std::filesystem::exists(input)) turn_into_wind(plant, wind_flags.heading);
  return plant;
}

Plant PlantInWind::read_plant(StageLog& log) const {
  log.begin("read");
  Plant plant = open();
  log.finish();
  print_warnings(plant);
  return plant;
}

// How many move the plant: all that it has, where more are asked for.
int PlantInWind::modes_of(const Plant& plant, WarningLog& warnings) const {
  const int most = plant.sheet   ? static_cast<int>(assemble_sheet(*plant.sheet, {.gravity = 0}).size())
                   : plant.frame ? free_rows(*plant.frame)
                                 : 6 * plant.imported.skeleton.branch_count();
  if (mode_count <= most) return mode_count < 0 ? most : mode_count;
  warnings.add({"--modes " + std::to_string(mode_count) + ": the plant has " + std::to_string(most) +
                ", and all are taken"});
  return most;
}

Dynamics PlantInWind::dynamics_of(const CLI::App& flags, const Plant& plant, const Wind& blowing) const {
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
void PlantInWind::refuse_of_modes(const CLI::App& flags) const {
  for (const char* flag :
       {"--modes", "--drag", "--transfer", "--no-static-correction", "--no-aerodynamic-damping"}) {
    if (flags.count(flag) > 0)
      throw InputError(flag, "given with a flag that flaps", "--dynamics modal with it");
  }
}

// The mean wind drags along the sheet and so pulls it straight.
Subject PlantInWind::bake_sheet(Sheet sheet, BakeOptions options, const Weather& conditions,
                                const Progress& progress, WarningLog& warnings) const {
  options.sheet = structure.sheet_options(input);
  const Vec3 mean = wind_at_middle(sheet, conditions.wind);
  options.sheet.pull = drag_along(sheet, mean, options.sheet.fluid_density);
  return in_file(input, [&] {
    if (conditions.dynamics != Dynamics::flapping)
      warnings.add(pull_until_stable(sheet, options.sheet, mean));
    return tremula::bake(sheet, options, progress);
  });
}

Subject PlantInWind::bake(const PreparedPlant& prepared, const Progress& progress,
                          WarningLog& warnings) const {
  const Plant& plant = prepared.plant;
  BakeOptions options = prepared.bake;
  if (plant.sheet) return bake_sheet(*plant.sheet, options, prepared.conditions.weather, progress, warnings);
  if (plant.frame) {
    options.frame = structure.frame_options(input);
    return tremula::bake(*plant.frame, options, progress);
  }
  const Skeleton& skeleton = plant.imported.skeleton;
  Subject subject = with_likely_reason(skeleton, options.structure,
                                       [&] { return tremula::bake(skeleton, options, progress); });
  warnings.add(plausibility(skeleton, options.structure, subject.modes.frequency[0]));
  return subject;
}

PreparedPlant PlantInWind::prepare(const CLI::App& flags, Conditions conditions, StageLog& log,
                                   WarningLog& warnings) const {
  Plant plant = read_plant(log);
  Weather& weather = conditions.weather;
  if (conditions.sea) {
    Waves& sea = *conditions.sea;
    if (!water_depth && plant.sheet)
      throw InputError("--waves", "given with a sheet", "--water-depth with it");
    if (!water_depth && !under_water) sea.water_depth = 1.25 * height_of(plant.imported.skeleton);
    weather.wind = add_waves(weather.wind, sea);
  }
  if (!pull.empty()) {
    need_tree(plant, "--pull");
    weather.pull = place_pull(plant.imported.skeleton, pull, pull_heading.value_or(wind_flags.heading));
  }
  BakeOptions options{.structure = structure.options(), .modes = {.count = mode_count}};
  const int modes = modes_of(plant, warnings);
  if (mode_count > modes) options.modes.count = all_modes;
  log.begin("surface");
  Surface surface = skin_of(plant);
  log.finish();
  weather.dynamics = dynamics_of(flags, plant, weather.wind);
  if (weather.dynamics == Dynamics::flapping) refuse_of_modes(flags);
  if (is_clip() && plant.sheet && weather.dynamics != Dynamics::flapping)
    throw InputError(gust.empty() ? "--from-rest" : "--gust", "a sheet that no wind makes flap",
                     "a flag, a tree or a frame");
  if (plant.sheet) weather.flapping.gravity = structure.gravity;
  return {std::move(plant), std::move(conditions), options, modes, std::move(surface)};
}

Moved PlantInWind::move(Subject& subject, const Weather& weather, bool superposed, const Progress& progress,
                        StageLog& log, WarningLog& warnings) const {
  Eigen::MatrixXd shapes = std::move(subject.modes.shapes);
  Modes modes = subject.modes;
  modes.shapes = std::move(shapes);
  std::vector<std::string> of_wind;
  Motion motion = set_in_motion(subject.structure, std::move(modes), weather, progress, &of_wind);
  log.finish();
  MotionStatistics statistics = motion_statistics(subject.structure, motion);
  warnings.add(of_wind);
  warnings.add(advice(subject, weather, statistics, superposed));
  if (motion.pull) warnings.add(warnings_of(*motion.pull, subject.structure));
  return {std::move(motion), std::move(statistics)};
}

Motion PlantInWind::move_again(const PreparedPlant& first, const Subject& subject, bool superposed,
                               const Progress& progress, StageLog& log, WarningLog& warnings) const {
  Weather weather = first.conditions.weather;
  const Conditions own = conditions();
  weather.wind = own.weather.wind;
  weather.script = own.weather.script;
  std::optional<Waves> sea = waves.empty() ? own.sea : first.conditions.sea;
  if (sea) {
    sea->heading = wind_flags.heading;
    weather.wind = add_waves(weather.wind, *sea);
  }
  weather.most_strained = 0;
  Subject again = subject;
  return move(again, weather, superposed, progress, log, warnings).motion;
}

LoopFacts PlantInWind::loop_facts(const Plant& plant, const ReferenceWind& reference) const {
  return {.name = plant.name,
          .frames_per_second = frames_per_second,
          .wind_speed = reference.speed,
          .heading = reference.heading,
          .seed = wind_flags.seed,
          .under_water = structure.medium == "water"};
}

Poses PlantInWind::poses_of(const Plant& plant) const {
  return plant.sheet && poses_superpose() ? Poses::linear : Poses::bent;
}

}  // namespace tremula::cli
