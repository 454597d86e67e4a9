#include "scene_objects.hpp"

#include "tremula/base/error.hpp"
#include "tremula/base/suggestion.hpp"
#include "tremula/geometry/meadow.hpp"
#include "tremula/geometry/plants.hpp"
#include "tremula/scene/placing.hpp"
#include "tremula/structure/frame_presets.hpp"
#include "tremula/structure/sheet_presets.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <utility>

#include "tremula/wind/profile.hpp"
#include "usage.hpp"

namespace tremula::cli {
namespace {

constexpr double degree = std::numbers::pi / 180;

std::string flag_of(std::string key) {
  std::ranges::replace(key, '_', '-');
  return "--" + key;
}

std::string key_of(std::string flag) {
  flag.erase(0, 2);
  std::ranges::replace(flag, '-', '_');
  return flag;
}

SettingKind kind_of(const CLI::Option& option) {
  if (option.get_items_expected_max() == 0) return SettingKind::toggle;
  if (option.get_items_expected_max() > 1) return SettingKind::list;
  const std::string type = option.get_type_name();
  if (type.starts_with("FLOAT")) return SettingKind::number;
  if (type.starts_with("INT") || type.starts_with("UINT")) return SettingKind::integer;
  const std::string name = option.get_name();
  const bool may_be_file =
      name == "--wind" || name == "--profile" || name == "--spectrum" || name == "--gust";
  return may_be_file ? SettingKind::file : SettingKind::text;
}

SettingScope scope_of(const CLI::Option& option) {
  const std::string name = option.get_name();
  if (name == "--period" || name == "--fps") return SettingScope::film;
  const bool of_all = option.get_group() == wind_flag_group || name == "--gust" || name == "--from-rest";
  return of_all ? SettingScope::wind : SettingScope::object;
}

// As a command line has them, from the last to the first.
std::vector<std::string> arguments_of(const std::vector<Setting>& settings, const CLI::App& app,
                                      const CLI::App& line) {
  std::vector<std::string> arguments;
  for (const Setting& setting : settings) {
    const std::string flag = flag_of(setting.key);
    const CLI::Option* of_line = line.get_option_no_throw(flag);
    if (of_line != nullptr && of_line->count() > 0) continue;
    if (setting.values.empty()) arguments.push_back(flag);
    const bool joined = app.get_option(flag)->get_delimiter() != '\0';
    std::string together;
    for (const std::string& value : setting.values) {
      if (!joined) arguments.push_back(flag + "=" + value);
      together += (together.empty() ? "" : ",") + value;
    }
    if (joined && !together.empty()) arguments.push_back(flag + "=" + together);
  }
  for (const CLI::Option* option : app.get_options()) {
    const CLI::Option* of_line = line.get_option_no_throw(option->get_name());
    if (option->get_lnames().empty() || of_line == nullptr || of_line->count() == 0) continue;
    const bool is_switch = option->get_items_expected_max() == 0;
    for (const std::string& value : of_line->results())
      arguments.push_back(is_switch ? option->get_name() : option->get_name() + "=" + value);
  }
  std::ranges::reverse(arguments);
  return arguments;
}

Vec3 mean_wind_of(const ReferenceWind& reference) {
  return reference.speed * heading_direction(reference.heading);
}

// How far a copy stands to the left of the wind's heading [degrees].
double across_of(const Instance& copy, double heading) {
  const Vec3 along = heading_direction(heading);
  return copy.position.y() * along.x() - copy.position.x() * along.y();
}

// Copies that share a motion: those of one heading; with gusts of their own each is alone.
std::vector<std::vector<Instance>> groups_of(const std::vector<Instance>& copies, int headings,
                                             bool own_gusts) {
  std::vector<std::vector<Instance>> groups;
  if (own_gusts) {
    for (const Instance& copy : copies) groups.push_back({copy});
    return groups;
  }
  for (std::vector<Instance>& group : split_by_heading(copies, headings)) {
    if (!group.empty()) groups.push_back(std::move(group));
  }
  return groups;
}

}  // namespace

SceneVocabulary scene_vocabulary() {
  SceneVocabulary known;
  CLI::App app;
  PlantInWind plant;
  plant.add_to(app);
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_lnames().empty() || option->get_group().empty() || option->get_name() == "--help")
      continue;
    known.settings.push_back(
        {key_of(option->get_name()), kind_of(*option), scope_of(*option), option->get_description()});
  }
  for (const PlantPreset& preset : plant_presets()) known.presets.emplace_back(preset.name);
  for (const SheetPreset& preset : sheet_presets()) known.presets.push_back(preset.name);
  for (const FramePreset& preset : frame_presets()) known.presets.push_back(preset.name);
  return known;
}

SceneObjectCommand::SceneObjectCommand(const Scene& scene, const SceneObject& object, const CLI::App& line)
    : app_("", "animate"), place_(object.place) {
  plant_.input = object.source;
  plant_.shares_wind = true;
  plant_.growth_seed = object.growth_seed;
  plant_.constants = object.constants;
  plant_.colors = {object.bark_color, object.color ? object.color : object.leaf_color};
  plant_.add_to(app_);
  check_values(app_);
  const std::vector<Setting> settings = settings_of(scene, object);
  for (const Setting& setting : settings) places_[flag_of(setting.key)] = setting.place;
  try {
    app_.parse(arguments_of(settings, app_, line));
  } catch (const CLI::ParseError& error) {
    std::string message = explain(app_, error);
    message = message.substr(0, message.rfind(" (see tremula"));
    throw InputError(with_place(message));
  }
  at_place([&] { plant_.settle(app_); });
}

// What begins with a flag of the file is said of its key there; all else of the object.
std::string SceneObjectCommand::with_place(const std::string& message) const {
  const std::string named = message.substr(0, message.find_first_of(": "));
  const std::string flag = named.starts_with("--") ? named : flag_of(named);
  const auto at = places_.find(flag);
  if (at != places_.end() && at->second.line > 0)
    return text_of(at->second) + ": " + key_of(flag) + message.substr(named.size());
  return place_.line > 0 ? text_of(place_) + ": " + message : message;
}

SharedLoops move_object(const SceneObjectCommand& command, const SceneObject& object,
                        std::vector<Instance> instances, StageLog& log, WarningLog& warnings) {
  return command.at_place([&] {
    const PlantInWind& plant = command.plant();
    const Progress progress = [&](std::string_view stage, double done) { log.progress(stage, done); };
    const PreparedPlant prepared = plant.prepare(command.flags(), plant.conditions(), log, warnings);
    const ReferenceWind& wind = prepared.conditions.weather.wind.reference;
    const bool is_tree = prepared.plant.is_tree();
    if (!is_tree && !std::filesystem::exists(plant.input)) {
      for (Instance& instance : instances) instance.turn = 0;
    }
    std::optional<Subject> subject;
    if (is_tree) subject = plant.bake(prepared, progress, warnings);
    const bool superposed = plant.poses_superpose() || prepared.plant.frame.has_value();
    SharedLoops loops;
    const bool own_gusts = object.crowd.travelling_gusts &&
                           instances.size() <= static_cast<std::size_t>(object.own_gusts) && !plant.is_clip();
    const int headings = object.headings;
    for (const std::vector<Instance>& together : groups_of(instances, headings, own_gusts)) {
      // As the wind blows for a copy that is turned.
      const double turn = own_gusts ? together.front().turn / degree
                                    : 360.0 * nearest_heading(together.front().turn, headings) / headings;
      PlantInWind turned = plant.turned_by(-turn);
      if (own_gusts) turned.across = across_of(together.front(), wind.heading);
      Loop loop;
      if (is_tree) {
        Motion motion = turned.move_again(prepared, *subject, superposed, progress, log, warnings);
        loop = make_loop(subject->structure, prepared.surface, std::move(motion),
                         turned.loop_facts(prepared.plant, wind));
      } else {
        PreparedPlant again = turn == 0 && turned.across == 0
                                  ? prepared
                                  : turned.prepare(command.flags(), turned.conditions(), log, warnings);
        Subject baked = turned.bake(again, progress, warnings);
        Motion motion =
            turned.move(baked, again.conditions.weather, superposed, progress, log, warnings).motion;
        loop = make_loop(baked.structure, std::move(again.surface), std::move(motion),
                         turned.loop_facts(again.plant, wind), turned.poses_of(again.plant));
      }
      loop.instances = together;
      loops.push_back(std::make_shared<const Loop>(std::move(loop)));
    }
    log.finish();
    return loops;
  });
}

SharedLoops MovingScene::loops() const {
  SharedLoops all;
  for (const SharedLoops& object : objects) all.insert(all.end(), object.begin(), object.end());
  for (const SceneThing& thing : things) all.insert(all.end(), thing.loops.begin(), thing.loops.end());
  return all;
}

std::vector<std::shared_ptr<const RayShape>> MovingScene::shapes() const {
  std::vector<std::shared_ptr<const RayShape>> all;
  for (const SceneThing& thing : things) all.insert(all.end(), thing.shapes.begin(), thing.shapes.end());
  return all;
}

SceneCommands commands_of(const Scene& scene, const CLI::App& line) {
  SceneCommands commands;
  for (const SceneObject& object : scene.objects) {
    commands.objects.push_back(std::make_unique<SceneObjectCommand>(scene, object, line));
    const PlantInWind& plant = commands.objects.back()->plant();
    commands.is_clip = commands.is_clip || plant.is_clip();
    commands.under_water = commands.under_water || plant.structure.medium == "water";
  }
  commands.air = std::make_unique<SceneObjectCommand>(scene, SceneObject{}, line);
  commands.blowing = commands.air->at_place([&] { return commands.air->plant().conditions().weather.wind; });
  const SceneObjectCommand& first = commands.objects.empty() ? *commands.air : *commands.objects.front();
  const Weather weather = first.at_place([&] { return first.plant().conditions().weather; });
  commands.wind = weather.wind.reference;
  commands.loop = weather.loop;
  commands.frames_per_second = first.plant().frames_per_second;
  return commands;
}

std::vector<Place> SceneCommands::input_places() const {
  std::vector<Place> places = air->plant().input_places();
  for (const auto& object : objects) {
    const std::vector<Place> own = object->plant().input_places();
    places.insert(places.end(), own.begin(), own.end());
  }
  return places;
}

std::vector<std::vector<Instance>> copies_of(const Scene& scene, const SceneCommands& commands) {
  const Vec3 advection = commands.is_clip ? Vec3::Zero() : mean_wind_of(commands.wind);
  return place_objects(scene.objects, advection, commands.is_clip ? 0 : commands.loop.period);
}

MovingScene move_scene(const Scene& scene, const SceneCommands& commands, StageLog& log,
                       WarningLog& warnings) {
  std::vector<std::vector<Instance>> copies = copies_of(scene, commands);
  MovingScene moving;
  for (std::size_t i = 0; i < copies.size(); ++i) {
    moving.instance_count += copies[i].size();
    moving.objects.push_back(
        move_object(*commands.objects[i], scene.objects[i], std::move(copies[i]), log, warnings));
  }
  return moving;
}

bool is_scene(const std::string& input) {
  return lower_extension(input) == ".toml" && std::filesystem::exists(input) &&
         is_scene_file(read_file(input, std::size_t{16} << 20));
}

std::vector<std::string> names_in(const Scene& scene) {
  std::vector<std::string> names;
  const auto add = [&](const auto& things) {
    for (const auto& thing : things) names.push_back(thing.name);
  };
  add(scene.objects), add(scene.grass), add(scene.drift), add(scene.impressions), add(scene.volumes);
  return names;
}

std::string name_or_only(const Scene& scene, const std::string& name) {
  const std::vector<std::string> names = names_in(scene);
  return name.empty() && names.size() == 1 ? names.front() : name;
}

const SceneObject& object_of(const Scene& scene, const std::string& name) {
  if (name.empty() && scene.objects.size() == 1) return scene.objects.front();
  const auto found = std::ranges::find(scene.objects, name, &SceneObject::name);
  if (!name.empty() && found != scene.objects.end()) return *found;
  const std::vector<std::string> names = names_in(scene);
  std::string list;
  for (const std::string& each : names) list += (list.empty() ? "" : ", ") + each;
  throw InputError("--object", name.empty() ? "not given" : "'" + name + "'",
                   names.empty() ? "a scene in which something stands"
                                 : "one of what is in the scene: " + list + suggestion(name, names));
}

bool is_grass(const std::string& input) {
  const auto& species = grass_species();
  return std::ranges::find(species, input, &GrassSpecies::name) != species.end() &&
         !std::filesystem::exists(input);
}

Scene scene_of_grass(const std::string& species, const Eigen::Vector2d& low, const Eigen::Vector2d& high) {
  Scene scene;
  scene.name = species;
  SceneGrass grass;
  grass.name = grass.species = species;
  grass.low = low;
  grass.high = high;
  scene.grass.push_back(std::move(grass));
  return scene;
}

// A field of it that reaches into the distance.
Scene field_of_grass(const std::string& species) {
  Scene scene = scene_of_grass(species, {-20, -6}, {20, 40});
  scene.ground.grass_height = 0;
  const double height = grass_species_named(species).height;
  scene.camera.eye = Vec3(0, -6 - 4 * height, 0.25 + 1.9 * height);
  scene.camera.look_at = Vec3(0, 4, 0.6 * height);
  scene.camera.field_of_view = 34 * degree;
  return scene;
}

Scene open_scene(const std::string& input) {
  if (is_scene(input)) return read_scene(input, scene_vocabulary());
  if (is_grass(input)) return field_of_grass(input);
  SceneObject object;
  object.source = input;
  object.name = std::filesystem::path(input).stem().string();
  Scene scene;
  scene.name = object.name;
  scene.objects.push_back(std::move(object));
  return scene;
}

}  // namespace tremula::cli
