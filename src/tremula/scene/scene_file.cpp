#include "tremula/scene/scene_file.hpp"

#include "tremula/base/number_text.hpp"
#include "tremula/base/suggestion.hpp"
#include "tremula/io/atomic_file.hpp"
#include "tremula/io/toml_reading.hpp"
#include "tremula/scene/placing.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <numbers>
#include <set>
#include <type_traits>
#include <utility>

namespace tremula {
namespace {

constexpr std::size_t largest_file = std::size_t{8} << 20;
constexpr std::size_t most_objects = 1000, most_rules = 1000, most_corners = 10'000, most_path_keys = 10'000;
constexpr std::size_t longest_name = 100;

// What reading goes through.
struct Reader : TomlPlace {
  const SceneVocabulary& known;
  double ground_height = 0;
  std::int64_t instances = 0;  // counted so far

  FilePlace place_of(const toml::source_region& source) const {
    return {file, static_cast<int>(source.begin.line), static_cast<int>(source.begin.column)};
  }
  [[noreturn]] void fail_at(const toml::source_region& source, const std::string& what,
                            const std::string& found, const std::string& wanted) const {
    throw InputError(text_of(place_of(source)) + ": " + what, found, wanted);
  }
};

// A value in words, not too long for a line.
std::string found_in(const toml::node& node) {
  if (node.is_string()) return "'" + shown(node.as_string()->get()) + "'";
  if (node.is_array()) return "a list of " + std::to_string(node.as_array()->size());
  return kind_of(node);
}

std::string nearest_of(const std::string& name, const std::vector<std::string>& names) {
  return name.size() <= longest_name ? suggestion(name, names) : "";
}

std::string one_of(const std::vector<std::string>& names, const std::string& header) {
  if (names.size() > 14) return "a key of " + header + ", which tremula check --keys lists";
  std::string words;
  for (const std::string& name : names) words += (words.empty() ? "" : ", ") + name;
  return "one of " + words;
}

// ---- One value

// Reads a node into a member by the row of its key.
template <class Owner>
struct ValueReader {
  const Reader& reader;
  const SceneKey<Owner>& key;
  const toml::node& node;
  const std::string& what;
  Owner& owner;

  [[noreturn]] void refuse(const toml::node& at) const {
    reader.fail(at, what, found_in(at), wanted_of(key));
  }

  double factor() const { return key.unit == "degrees" ? std::numbers::pi / 180 : 1; }
  bool is_word() const {
    return !key.word.empty() && node.is_string() && node.as_string()->get() == key.word;
  }

  double number_of(const toml::node& from) const {
    const auto value = from.value<double>();
    if (!from.is_number() || !value || !std::isfinite(*value) || *value < key.least || *value > key.most)
      refuse(from);
    return *value;
  }
  std::int64_t integer_of(const toml::node& from) const {
    const auto value = from.value_exact<std::int64_t>();
    if (!value || static_cast<double>(*value) < key.least || static_cast<double>(*value) > key.most)
      refuse(from);
    return *value;
  }
  template <std::size_t count>
  std::array<double, count> numbers_of(const toml::node& from) const {
    if (!from.is_array() || from.as_array()->size() != count) refuse(from);
    std::array<double, count> values;
    for (std::size_t i = 0; i < count; ++i) values[i] = number_of((*from.as_array())[i]);
    return values;
  }

  void read(double& value) const { value = number_of(node) * factor(); }
  void read(int& value) const { value = static_cast<int>(integer_of(node)); }
  void read(std::uint64_t& value) const {
    const std::int64_t whole = integer_of(node);
    if (whole < 0) reader.fail(node, what, found_in(node), "a whole number, 0 or more");
    value = static_cast<std::uint64_t>(whole);
  }
  void read(bool& value) const {
    if (!node.is_boolean()) refuse(node);
    value = node.as_boolean()->get();
  }
  void read(std::string& value) const {
    if (!node.is_string()) refuse(node);
    const std::string& text = node.as_string()->get();
    if (!key.choices.empty() && std::ranges::find(key.choices, text) == key.choices.end()) {
      reader.fail(node, what, found_in(node) + nearest_of(text, key.choices), wanted_of(key));
    }
    if (text.empty()) reader.fail(node, what, "nothing", wanted_of(key));
    value = text;
  }
  void read(Vec3& value) const {
    const bool flat = key.on_ground && node.is_array() && node.as_array()->size() == 2;
    if (flat) {
      const std::array<double, 2> at = numbers_of<2>(node);
      value = {at[0], at[1], reader.ground_height};
    } else {
      const std::array<double, 3> at = numbers_of<3>(node);
      value = {at[0], at[1], at[2]};
    }
  }
  void read(Eigen::Vector3f& value) const {
    const std::array<double, 3> values = numbers_of<3>(node);
    value = Vec3(values[0], values[1], values[2]).cast<float>();
  }
  void read(Eigen::Vector2d& value) const {
    if (is_word()) {
      value = {0, key.most * factor()};
    } else if (node.is_array() || key.needed) {
      const std::array<double, 2> values = numbers_of<2>(node);
      value = {values[0] * factor(), values[1] * factor()};
    } else {
      value.setConstant(number_of(node) * factor());
    }
  }
  void read(Eigen::Vector2i& value) const {
    if (node.is_string()) {
      int width = 0, height = 0, end = 0;
      const std::string text = node.as_string()->get().substr(0, longest_name);
      if (std::sscanf(text.c_str(), "%5dx%5d%n", &width, &height, &end) != 2 ||
          static_cast<std::size_t>(end) != text.size() || std::min(width, height) < key.least ||
          std::max(width, height) > key.most)
        refuse(node);
      value = {width, height};
      return;
    }
    if (!node.is_array() || node.as_array()->size() != 2) refuse(node);
    const toml::array& both = *node.as_array();
    value = {static_cast<int>(integer_of(both[0])), static_cast<int>(integer_of(both[1]))};
  }
  template <class Value>
  void read(std::optional<Value>& value) const {
    if (is_word()) {
      value.reset();
    } else {
      read(value.emplace());
    }
  }
  void read(std::vector<std::string>& values) const {
    values.clear();
    if (is_word()) return;
    const auto add = [&](const toml::node& from) {
      if (!from.is_string()) refuse(from);
      values.push_back(from.as_string()->get());
    };
    if (!node.is_array()) return add(node);
    for (const toml::node& each : *node.as_array()) add(each);
  }
  Polygon polygon_of(const toml::node& from) const {
    if (!from.is_array()) refuse(from);
    Polygon polygon;
    for (const toml::node& corner : *from.as_array()) {
      const std::array<double, 2> at = numbers_of<2>(corner);
      polygon.emplace_back(at[0], at[1]);
    }
    if (polygon.size() < 3)
      reader.fail(from, what, "a polygon of " + counted(polygon.size(), "corner"), "three or more");
    return polygon;
  }
  // Polygons, or a single one.
  void read(std::vector<Polygon>& values) const {
    if (!node.is_array()) refuse(node);
    const toml::array& entries = *node.as_array();
    if (entries.empty()) reader.fail(node, what, "an empty list", "a polygon or more");
    const toml::node* first =
        entries[0].is_array() && !entries[0].as_array()->empty() ? &(*entries[0].as_array())[0] : nullptr;
    values.clear();
    if (first != nullptr && first->is_number()) {
      values.push_back(polygon_of(node));
    } else {
      for (const toml::node& each : entries) values.push_back(polygon_of(each));
    }
  }
};

template <class Owner>
std::vector<std::string> names_of(const SceneTable<Owner>& keys) {
  std::vector<std::string> names;
  for (const SceneKey<Owner>& key : keys.keys) names.emplace_back(key.name);
  return names;
}

template <class Owner>
void read_keys(const Reader& reader, const toml::table& table, const SceneTable<Owner>& keys, Owner& owner) {
  for (const SceneKey<Owner>& key : keys.keys) {
    const std::string what =
        (keys.header.empty() && keys.path == "scene" ? "" : std::string(keys.path) + ".") +
        std::string(key.name);
    const toml::node* node = table.get(key.name);
    if (node == nullptr) {
      if (key.needed) reader.fail(table, what, "none", wanted_of(key));
      continue;
    }
    const ValueReader<Owner> value{reader, key, *node, what, owner};
    std::visit([&](const auto member) { value.read(owner.*member); }, key.target);
  }
}

void check_names(const Reader& reader, const toml::table& table, std::string_view header,
                 std::string_view path, const std::vector<std::string>& names) {
  for (const auto& [key, value] : table) {
    const std::string name(key.str());
    if (std::ranges::find(names, name) != names.end()) continue;
    reader.fail_at(key.source(), path.empty() ? shown(name) : std::string(path) + "." + shown(name),
                   "no such key" + nearest_of(name, names), one_of(names, std::string(header)));
  }
}

const toml::table& table_of(const Reader& reader, const toml::node& node, std::string_view path,
                            std::string_view header) {
  if (!node.is_table()) reader.fail(node, std::string(path), found_in(node), std::string(header));
  return *node.as_table();
}

template <class Owner>
void read_table(const Reader& reader, const toml::node& node, const SceneTable<Owner>& keys, Owner& owner) {
  const toml::table& table = table_of(reader, node, keys.path, keys.header);
  check_names(reader, table, keys.header, keys.path, names_of(keys));
  read_keys(reader, table, keys, owner);
}

// Refuses a key that says nothing beside another.
void refuse_beside(const Reader& reader, const toml::table& table, std::string_view path,
                   std::initializer_list<const char*> keys, const std::string& with,
                   const std::string& wanted) {
  for (const char* key : keys) {
    if (const toml::node* node = table.get(key))
      reader.fail(*node, std::string(path) + "." + key, "given " + with, wanted);
  }
}

// ---- Settings of the motion

std::string text_of_value(const toml::node& node) {
  if (const auto* integer = node.as_integer()) return std::to_string(integer->get());
  if (const auto* number = node.as_floating_point()) {
    char text[32];
    const auto end = std::to_chars(text, text + sizeof text, number->get()).ptr;
    return {text, end};
  }
  return node.as_string()->get();
}

bool is_finite_number(const toml::node& node) {
  const auto value = node.value<double>();
  return node.is_number() && value && std::isfinite(*value);
}

std::filesystem::path beside(const Reader& reader, const std::string& name) {
  return std::filesystem::path(reader.file).parent_path() / name;
}

bool is_there(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::exists(path, ignored);
}

std::vector<std::string> values_of(const Reader& reader, const toml::node& node, const std::string& what,
                                   SettingKind kind) {
  const auto refuse = [&](const toml::node& at) { reader.fail(at, what, found_in(at), wanted_of(kind)); };
  const auto is_value = [](const toml::node& each) { return each.is_string() || is_finite_number(each); };
  std::vector<std::string> values;
  if (kind == SettingKind::number && !is_finite_number(node)) refuse(node);
  if (kind == SettingKind::integer && !node.is_integer()) refuse(node);
  if ((kind == SettingKind::text || kind == SettingKind::file) && !node.is_string()) refuse(node);
  if (kind == SettingKind::list && node.is_array()) {
    for (const toml::node& each : *node.as_array()) {
      if (!is_value(each)) refuse(each);
      values.push_back(text_of_value(each));
    }
    if (values.empty()) refuse(node);
    return values;
  }
  if (!is_value(node)) refuse(node);
  values.push_back(text_of_value(node));
  if (kind == SettingKind::file && values[0].size() <= 4096) {
    const std::filesystem::path path = beside(reader, values[0]);
    if (is_there(path)) values[0] = path.string();
  }
  return values;
}

const char* home_of(SettingScope scope) {
  switch (scope) {
    case SettingScope::wind:
      return "in [wind]: one wind blows through a scene";
    case SettingScope::film:
      return "in [motion]: all objects share it";
    case SettingScope::object:
      return "in [motion] for all objects, or in [[objects]] for one";
  }
  return "";
}

// The settings among the keys of a table; all other keys are in `others`.
std::vector<Setting> read_settings(const Reader& reader, const toml::table& table, std::string_view header,
                                   std::string_view path, std::initializer_list<SettingScope> scopes,
                                   const std::vector<std::string>& others = {}) {
  std::vector<std::string> names = others;
  for (const KnownSetting& known : reader.known.settings) {
    if (std::ranges::find(scopes, known.scope) != scopes.end()) names.push_back(known.key);
  }
  for (const auto& [key, value] : table) {
    const std::string name(key.str());
    if (std::ranges::find(names, name) != names.end()) continue;
    const auto elsewhere = std::ranges::find(reader.known.settings, name, &KnownSetting::key);
    if (elsewhere != reader.known.settings.end())
      reader.fail_at(key.source(), std::string(path) + "." + name, "in " + std::string(header),
                     home_of(elsewhere->scope));
  }
  check_names(reader, table, header, path, names);
  std::vector<Setting> settings;
  for (const KnownSetting& known : reader.known.settings) {
    const toml::node* node = table.get(known.key);
    if (node == nullptr || std::ranges::find(scopes, known.scope) == scopes.end()) continue;
    const std::string what = std::string(path) + "." + known.key;
    Setting setting{known.key, {}, reader.place_of(node->source())};
    if (known.kind == SettingKind::toggle) {
      if (!node->is_boolean()) reader.fail(*node, what, found_in(*node), wanted_of(known.kind));
      if (!node->as_boolean()->get()) setting.values = {"false"};
    } else {
      setting.values = values_of(reader, *node, what, known.kind);
    }
    settings.push_back(std::move(setting));
  }
  return settings;
}

// ---- The tables

SceneGround ground_of(const Reader& reader, const toml::node& node) {
  SceneGround ground;
  read_table(reader, node, scene_keys().ground, ground);
  if (ground.kind != "plain")
    refuse_beside(reader, *node.as_table(), "ground", {"color"}, "with kind \"" + ground.kind + '"',
                  "kind = \"plain\"");
  return ground;
}

SceneSky sky_of(const Reader& reader, const toml::node& node) {
  SceneSky sky;
  read_table(reader, node, scene_keys().sky, sky);
  if (sky.uniform)
    refuse_beside(reader, *node.as_table(), "sky", {"sun_elevation", "sun_azimuth", "turbidity"},
                  "with uniform", "one of them");
  return sky;
}

void check_view(const Reader& reader, const SceneGround& ground, const toml::table& table,
                const std::string& path, const Vec3& eye, const Vec3& look_at) {
  if (ground.kind != "none" && eye.z() <= ground.height) {
    reader.fail(*table.get("eye"), path + ".eye", "at a height of " + number_text(eye.z()) + " m",
                "above the ground, which is at " + number_text(ground.height) + " m");
  }
  if ((look_at - eye).norm() < 1e-6)
    reader.fail(*table.get("look_at"), path + ".look_at", "where the eye is", "another point");
}

std::vector<CameraKey> path_of(const Reader& reader, const SceneGround& ground, const toml::node& node) {
  const std::string header(scene_keys().path.header);
  if (!node.is_array()) reader.fail(node, "camera.path", found_in(node), header);
  const toml::array& entries = *node.as_array();
  if (entries.size() < 2 || entries.size() > most_path_keys) {
    reader.fail(node, "camera.path", counted(entries.size(), "key"),
                "two or more, and up to " + std::to_string(most_path_keys));
  }
  std::vector<CameraKey> path;
  for (const toml::node& entry : entries) {
    CameraKey key;
    read_table(reader, entry, scene_keys().path, key);
    const toml::table& table = *entry.as_table();
    key.place = reader.place_of(table.source());
    check_view(reader, ground, table, "camera.path", key.eye, key.look_at);
    if (!path.empty() && !(key.time > path.back().time)) {
      reader.fail(*table.get("time"), "camera.path.time", number_text(key.time) + " s",
                  "a time after the last, " + number_text(path.back().time) + " s");
    }
    path.push_back(key);
  }
  return path;
}

SceneCamera camera_of(const Reader& reader, const SceneGround& ground, const toml::node& node) {
  SceneCamera camera;
  const SceneTable<SceneCamera>& keys = scene_keys().camera;
  const toml::table& table = table_of(reader, node, keys.path, keys.header);
  std::vector<std::string> names = names_of(keys);
  names.emplace_back("path");
  check_names(reader, table, keys.header, keys.path, names);
  read_keys(reader, table, keys, camera);
  camera.place = reader.place_of(table.source());
  if (const toml::node* path = table.get("path")) {
    camera.path = path_of(reader, ground, *path);
    refuse_beside(reader, table, "camera", {"eye", "look_at"}, "with a path", "one of them");
  } else {
    refuse_beside(reader, table, "camera", {"path_repeats"}, "without a path", "[[camera.path]]");
  }
  if (camera.eye.has_value() != camera.look_at.has_value()) {
    const char* given = camera.eye ? "eye" : "look_at";
    reader.fail(*table.get(given), std::string("camera.") + given, "alone", "eye and look_at, or neither");
  }
  if (camera.eye) check_view(reader, ground, table, "camera", *camera.eye, *camera.look_at);
  if (camera.eye || !camera.path.empty()) {
    refuse_beside(reader, table, "camera", {"frame", "azimuth", "elevation", "margin"},
                  camera.eye ? "with an eye" : "with a path", "one of them");
  }
  if (camera.aperture == 0)
    refuse_beside(reader, table, "camera", {"focus_distance", "focus_at"}, "with a lens of 0 m",
                  "an aperture");
  if (camera.focus_at)
    refuse_beside(reader, table, "camera", {"focus_distance"}, "with focus_at", "one of them");
  return camera;
}

// ---- Objects

// Counts what a rule adds, before anybody makes room for it.
void count_rule(Reader& reader, const toml::node& node, const std::string& path, const Crowd& rule) {
  const std::int64_t count = count_instances(rule);
  const std::int64_t all = count > most_instances ? count : reader.instances + count;
  if (all > most_instances) {
    reader.fail(
        node, path,
        counted(static_cast<std::size_t>(all), "instance") + (count == all ? "" : " with those before"),
        "at most " + std::to_string(most_instances));
  }
  reader.instances = all;
}

template <class Rule>
void check_variation(const Reader& reader, const toml::table& table, const std::string& path,
                     const Rule& rule) {
  for (const auto& [name, range] : {std::pair{"scale", rule.scale}, std::pair{"turn", rule.turn}}) {
    if (range[0] > range[1])
      reader.fail(*table.get(name), path + "." + name, "a largest below the smallest", "the smallest first");
  }
}

void check_scatter_at(const Reader& reader, const toml::table& table, const std::string& path,
                      const Scatter& scatter) {
  std::size_t corners = 0;
  for (const auto* masks : {&scatter.inside, &scatter.outside}) {
    for (const Polygon& polygon : *masks) corners += polygon.size();
  }
  if (corners > most_corners) {
    reader.fail(table, path, "masks of " + std::to_string(corners) + " corners",
                "at most " + std::to_string(most_corners));
  }
  try {
    check_scatter(scatter);
  } catch (const InputError& error) {
    throw InputError(text_of(reader.place_of(table.source())) + ": " + path + ": " + error.what());
  }
}

// Reads each of the tables of a rule and hands it to `take`.
template <class Rule, class Take>
void read_rules(Reader& reader, const toml::table& object, const char* name, const SceneTable<Rule>& keys,
                std::size_t most, const Rule& otherwise, const Take& take) {
  const toml::node* node = object.get(name);
  if (node == nullptr) return;
  if (!node->is_array())
    reader.fail(*node, std::string(keys.path), found_in(*node), std::string(keys.header));
  const toml::array& entries = *node->as_array();
  if (entries.empty() || entries.size() > most)
    reader.fail(*node, std::string(keys.path), counted(entries.size(), "table"),
                "1 to " + std::to_string(most));
  for (const toml::node& entry : entries) {
    Rule rule = otherwise;
    read_table(reader, entry, keys, rule);
    take(rule, *entry.as_table());
  }
}

// A table of rules as it is called under `owner`.
template <class Rule>
SceneTable<Rule> under(std::string_view header, std::string_view path, SceneTable<Rule> keys) {
  keys.header = header;
  keys.path = path;
  return keys;
}

// `owner`: "objects" or "impressions".
Crowd crowd_of(Reader& reader, const toml::table& object, const std::string& owner) {
  const SceneKeys& all = scene_keys();
  const std::string paths[] = {owner + ".instances", owner + ".grid", owner + ".scatter"};
  const std::string headers[] = {"[[" + paths[0] + "]]", "[[" + paths[1] + "]]", "[[" + paths[2] + "]]"};
  struct {
    SceneTable<Instance> instance;
    SceneTable<Grid> grid;
    SceneTable<Scatter> scatter;
  } keys{under(headers[0], paths[0], all.instance), under(headers[1], paths[1], all.grid),
         under(headers[2], paths[2], all.scatter)};
  Crowd crowd;
  read_keys(reader, object, under("", owner, all.crowd), crowd);
  Instance on_ground;
  on_ground.position.z() = reader.ground_height;
  read_rules(reader, object, "instances", keys.instance, static_cast<std::size_t>(most_instances), on_ground,
             [&](const Instance& instance, const toml::table& table) {
               count_rule(reader, table, paths[0], {.instances = {instance}});
               crowd.instances.push_back(instance);
             });
  Grid grid_on_ground;
  grid_on_ground.centre.z() = reader.ground_height;
  read_rules(reader, object, "grid", keys.grid, most_rules, grid_on_ground,
             [&](const Grid& grid, const toml::table& table) {
               count_rule(reader, table, paths[1], {.grids = {grid}});
               check_variation(reader, table, paths[1], grid);
               crowd.grids.push_back(grid);
             });
  Scatter scatter_on_ground;
  scatter_on_ground.height = reader.ground_height;
  read_rules(reader, object, "scatter", keys.scatter, most_rules, scatter_on_ground,
             [&](const Scatter& scatter, const toml::table& table) {
               check_variation(reader, table, paths[2], scatter);
               check_scatter_at(reader, table, paths[2], scatter);
               count_rule(reader, table, paths[2], {.scatters = {scatter}});
               crowd.scatters.push_back(scatter);
             });
  if (crowd.instances.empty() && crowd.grids.empty() && crowd.scatters.empty())
    count_rule(reader, object, owner, crowd);
  return crowd;
}

// A file beside the scene's, or a preset.
std::string source_of(const Reader& reader, const toml::node& node, const std::string& source) {
  const std::filesystem::path path = source.size() <= 4096 ? beside(reader, source) : std::filesystem::path();
  std::error_code ignored;
  if (!path.empty() && std::filesystem::is_directory(path, ignored))
    reader.fail(node, "objects.source", "'" + shown(source) + "', which is a folder", "a file or a preset");
  if (!path.empty() && is_there(path)) return path.string();
  const std::vector<std::string>& presets = reader.known.presets;
  if (std::ranges::find(presets, source) != presets.end()) return source;
  reader.fail(node, "objects.source", "'" + shown(source) + "'" + nearest_of(source, presets),
              "a file that is there, beside the scene's, or a preset");
}

SceneObject object_of(Reader& reader, const toml::node& node) {
  const SceneKeys& keys = scene_keys();
  const toml::table& table = table_of(reader, node, keys.object.path, keys.object.header);
  std::vector<std::string> names = names_of(keys.object);
  for (const std::string& name : names_of(keys.crowd)) names.push_back(name);
  for (const char* name : {"instances", "grid", "scatter"}) names.emplace_back(name);
  SceneObject object;
  object.settings =
      read_settings(reader, table, keys.object.header, keys.object.path, {SettingScope::object}, names);
  read_keys(reader, table, keys.object, object);
  object.place = reader.place_of(table.source());
  const std::string source = object.source;
  object.source = source_of(reader, *table.get("source"), source);
  if (object.name.empty()) object.name = std::filesystem::path(source).stem().string();
  object.crowd = crowd_of(reader, table, "objects");
  return object;
}

std::vector<SceneObject> objects_of(Reader& reader, const toml::table& file) {
  const toml::node* node = file.get("objects");
  if (node == nullptr) return {};
  if (!node->is_array()) reader.fail(*node, "objects", found_in(*node), "[[objects]]");
  const toml::array& entries = *node->as_array();
  if (entries.empty() || entries.size() > most_objects)
    reader.fail(*node, "objects", std::to_string(entries.size()), "1 to " + std::to_string(most_objects));
  std::vector<SceneObject> objects;
  std::set<std::string> names;
  for (const toml::node& entry : entries) {
    SceneObject object = object_of(reader, entry);
    const toml::node* given = entry.as_table()->get("name");
    if (given != nullptr && names.contains(object.name))
      reader.fail(*given, "objects.name", "'" + shown(object.name) + "' again", "another name");
    const std::string plain = object.name;
    for (int again = 2; names.contains(object.name); ++again)
      object.name = plain + "-" + std::to_string(again);
    names.insert(object.name);
    objects.push_back(std::move(object));
  }
  return objects;
}

// ---- What is looked up in the wind of the scene

// Things without a name have that of their kind, and a number behind it where there are more.
class ThingNames {
 public:
  explicit ThingNames(const std::vector<SceneObject>& objects) {
    for (const SceneObject& object : objects) known_.insert(object.name);
  }
  template <class Thing>
  void settle(const Reader& reader, const toml::table& table, const std::string& path,
              const std::string& kind, Thing& thing) {
    const toml::node* given = table.get("name");
    if (given != nullptr && known_.contains(thing.name))
      reader.fail(*given, path + ".name", "'" + shown(thing.name) + "' again", "another name");
    if (given == nullptr) {
      thing.name = kind;
      for (int again = 2; known_.contains(thing.name); ++again)
        thing.name = kind + "-" + std::to_string(again);
    }
    known_.insert(thing.name);
  }

 private:
  std::set<std::string> known_;
};

template <class Thing>
void check_field(const Reader& reader, const toml::table& table, const std::string& path,
                 const Thing& thing) {
  if (!((thing.high - thing.low).minCoeff() > 0))
    reader.fail(*table.get("high"), path + ".high", "not above low", "larger than low in every direction");
  if constexpr (requires { thing.inside; }) {
    Scatter masks;  // has the same masks, which are checked with it
    masks.low = thing.low;
    masks.high = thing.high;
    masks.inside = thing.inside;
    masks.outside = thing.outside;
    check_scatter_at(reader, table, path, masks);
  }
}

// `kind_of_thing`: what it is called where it has no name.
template <class Thing, class Kind>
std::vector<Thing> things_of(Reader& reader, const toml::table& file, const SceneTable<Thing>& keys,
                             ThingNames& names, const Kind& kind_of_thing) {
  std::vector<Thing> things;
  const std::string path(keys.path);
  const toml::node* node = file.get(path);
  if (node == nullptr) return things;
  if (!node->is_array()) reader.fail(*node, path, found_in(*node), std::string(keys.header));
  const toml::array& entries = *node->as_array();
  if (entries.empty() || entries.size() > most_objects)
    reader.fail(*node, path, std::to_string(entries.size()), "1 to " + std::to_string(most_objects));
  constexpr bool has_crowd = requires(Thing thing) { thing.crowd; };
  for (const toml::node& entry : entries) {
    Thing thing;
    const toml::table& table = table_of(reader, entry, keys.path, keys.header);
    std::vector<std::string> known = names_of(keys);
    if constexpr (has_crowd) {
      for (const std::string& name : names_of(scene_keys().crowd)) known.push_back(name);
      for (const char* name : {"instances", "grid", "scatter"}) known.emplace_back(name);
    }
    check_names(reader, table, keys.header, keys.path, known);
    read_keys(reader, table, keys, thing);
    thing.place = reader.place_of(table.source());
    if constexpr (has_crowd) {
      thing.crowd = crowd_of(reader, table, path);
    } else {
      check_field(reader, table, path, thing);
    }
    names.settle(reader, table, path, kind_of_thing(thing), thing);
    things.push_back(std::move(thing));
  }
  return things;
}

void read_things(Reader& reader, const toml::table& file, Scene& scene) {
  const SceneKeys& keys = scene_keys();
  ThingNames names(scene.objects);
  scene.grass = things_of(reader, file, keys.grass, names, [](const SceneGrass& one) { return one.species; });
  scene.drift = things_of(reader, file, keys.drift, names, [](const SceneDrift& one) { return one.kind; });
  scene.impressions =
      things_of(reader, file, keys.impression, names, [](const SceneImpression& one) { return one.shape; });
  scene.volumes =
      things_of(reader, file, keys.volume, names, [](const SceneVolume& one) { return one.species; });
  if (const toml::node* node = file.get("gusts")) {
    SceneGusts gusts;
    read_table(reader, *node, keys.gusts, gusts);
    gusts.place = reader.place_of(node->source());
    check_field(reader, *node->as_table(), "gusts", gusts);
    scene.gusts = gusts;
  }
}

void check_framed(const Reader& reader, const toml::table& file, const Scene& scene) {
  if (scene.camera.frame.empty()) return;
  std::vector<std::string> names;
  for (const SceneObject& object : scene.objects) names.push_back(object.name);
  for (const std::string& name : scene.camera.frame) {
    if (std::ranges::find(names, name) == names.end())
      reader.fail(*file.get("camera")->as_table()->get("frame"), "camera.frame",
                  "no object '" + shown(name) + "'" + nearest_of(name, names),
                  "the name of an object, or \"all\"");
  }
}

Scene read_text(const std::string& text_of_file, const std::string& name, const SceneVocabulary& known) {
  const toml::table file = parse_toml(text_of_file, name);
  Reader reader{{name}, known};
  const SceneKeys& keys = scene_keys();
  std::vector<std::string> names = names_of(keys.scene);
  for (const char* table : {"wind", "motion", "ground", "sky", "medium", "camera", "picture", "objects",
                            "grass", "drift", "impressions", "volumes", "gusts"})
    names.emplace_back(table);
  check_names(reader, file, "a scene", "", names);

  Scene scene;
  scene.name = std::filesystem::path(name).stem().string();
  read_keys(reader, file, keys.scene, scene);
  const auto with = [&](const char* table, const auto& read) {
    if (const toml::node* node = file.get(table)) read(*node);
  };
  with("wind", [&](const toml::node& node) {
    scene.wind = read_settings(reader, table_of(reader, node, "wind", "[wind]"), "[wind]", "wind",
                               {SettingScope::wind});
  });
  with("motion", [&](const toml::node& node) {
    scene.motion = read_settings(reader, table_of(reader, node, "motion", "[motion]"), "[motion]", "motion",
                                 {SettingScope::film, SettingScope::object});
  });
  with("ground", [&](const toml::node& node) { scene.ground = ground_of(reader, node); });
  reader.ground_height = scene.ground.height;
  with("sky", [&](const toml::node& node) { scene.sky = sky_of(reader, node); });
  with("medium", [&](const toml::node& node) { read_table(reader, node, keys.medium, scene.medium); });
  with("camera", [&](const toml::node& node) { scene.camera = camera_of(reader, scene.ground, node); });
  with("picture", [&](const toml::node& node) { read_table(reader, node, keys.picture, scene.picture); });
  scene.objects = objects_of(reader, file);
  read_things(reader, file, scene);
  if (scene.objects.empty() && scene.grass.empty() && scene.drift.empty() && scene.impressions.empty() &&
      scene.volumes.empty() && !scene.gusts) {
    reader.fail(file, "objects", "none",
                "one or more [[objects]], [[grass]], [[drift]], [[impressions]] or [[volumes]]");
  }
  check_framed(reader, file, scene);
  return scene;
}

}  // namespace

bool is_scene_file(const std::string& text) {
  try {
    const toml::table file = parse_toml(text, "");
    constexpr const char* tables[] = {"objects", "grass", "drift", "impressions", "volumes", "gusts"};
    return std::ranges::any_of(tables, [&](const char* table) { return file.contains(table); });
  } catch (const InputError&) {
    return false;  // whoever reads it says why
  }
}

Scene parse_scene(const std::string& text_of_file, const std::string& name, const SceneVocabulary& known) {
  return with_printable_errors(name, [&] { return read_text(text_of_file, name, known); });
}

Scene read_scene(const std::string& path, const SceneVocabulary& known) {
  return parse_scene(read_file(path, largest_file), path, known);
}

}  // namespace tremula
