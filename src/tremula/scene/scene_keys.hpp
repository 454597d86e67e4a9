// The keys of a scene's file: one table, which reads them, checks them and prints their reference.
#pragma once

#include "tremula/scene/scene.hpp"

#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace tremula {

// Settings of the motion are not in this table: whoever makes the motion says which it knows.
enum class SettingKind {
  number,
  integer,
  text,
  file,    // a text that may be a file beside the scene's
  toggle,  // true or false
  list,    // of numbers, or one
};
enum class SettingScope {
  wind,    // in [wind]
  film,    // in [motion]: all objects share it
  object,  // in [motion] for all objects, or in [[objects]] for one
};
struct KnownSetting {
  std::string key;
  SettingKind kind = SettingKind::text;
  SettingScope scope = SettingScope::object;
  std::string meaning = {};
};

// A key and where its value goes in an Owner, whose own value is the default. An optional has none by
// default.
template <class Owner>
struct SceneKey {
  using Target =
      std::variant<double Owner::*, std::optional<double> Owner::*, int Owner::*, std::uint64_t Owner::*,
                   std::optional<std::uint64_t> Owner::*, bool Owner::*, std::string Owner::*, Vec3 Owner::*,
                   std::optional<Vec3> Owner::*, Eigen::Vector2d Owner::*, Eigen::Vector2i Owner::*,
                   Eigen::Vector3f Owner::*, std::optional<Eigen::Vector3f> Owner::*,
                   std::vector<Polygon> Owner::*, std::vector<std::string> Owner::*>;
  std::string_view name;
  Target target;
  std::string_view unit = "";  // "degrees" are kept as radians
  double least = -std::numeric_limits<double>::infinity(), most = std::numeric_limits<double>::infinity();
  std::vector<std::string> choices = {};  // of a text
  std::string_view word = "";  // that may stand for a value: "auto" for none, "random" for all turns
  bool needed = false, on_ground = false;  // the last of three numbers may be left out
  std::string_view otherwise = "";         // in words, where the default is none
  std::string_view meaning = "";
};

template <class Owner>
struct SceneTable {
  std::string_view header;  // "[ground]", "[[objects.grid]]"
  std::string_view path;    // "ground", for messages: "ground.kind"
  std::string_view meaning;
  std::vector<SceneKey<Owner>> keys;
};

struct SceneKeys {
  SceneTable<Scene> scene;  // the keys before the first header
  SceneTable<SceneGround> ground;
  SceneTable<SceneSky> sky;
  SceneTable<SceneMedium> medium;
  SceneTable<SceneCamera> camera;
  SceneTable<CameraKey> path;
  SceneTable<ScenePicture> picture;
  SceneTable<SceneObject> object;
  SceneTable<Crowd> crowd;  // the rest of [[objects]]
  SceneTable<Instance> instance;
  SceneTable<Grid> grid;
  SceneTable<Scatter> scatter;
  SceneTable<SceneGrass> grass;
  SceneTable<SceneDrift> drift;
  SceneTable<SceneImpression> impression;  // and all that a crowd has
  SceneTable<SceneVolume> volume;
  SceneTable<SceneGusts> gusts;
};
const SceneKeys& scene_keys();

// What a value should be, for messages: "a number from 1 to 10".
const char* wanted_of(SettingKind kind);
template <class Owner>
std::string wanted_of(const SceneKey<Owner>& key);

// All keys with kind, unit, default and meaning, in Markdown; with those of the settings where they are
// given.
std::string scene_reference(std::span<const KnownSetting> settings = {});

}  // namespace tremula
