// Scenes from TOML. docs/guide/scenes.md has every key.
//
//   [wind]
//   wind_speed = 8                    # as the flags of `tremula animate`, with _ for -
//
//   [sky]
//   sun_elevation = 30                # degrees
//
//   [[objects]]
//   source = "oak"                    # or a file beside this one
//
//   [[objects.scatter]]
//   density = 0.004                   # per square metre
//   low = [-200, -200]
//   high = [200, 200]
//   distance = 9
#pragma once

#include "tremula/scene/scene.hpp"
#include "tremula/scene/scene_keys.hpp"

#include <span>
#include <string>
#include <vector>

namespace tremula {

// What whoever moves and grows the objects of a scene knows.
struct SceneVocabulary {
  std::vector<KnownSetting> settings;
  std::vector<std::string> presets;  // sources that are no files
};

// Whether the text of a .toml file is a scene: it has objects, or other things that a scene shows.
bool is_scene_file(const std::string& text);

// Throws InputError that names the file, the line and the column for what is no scene: other keys, with the
// nearest that there is; values of another kind or out of range; sources that are not there; a camera that is
// below the ground or looks at itself; more copies than place_objects takes. Settings are known by name and
// of the right kind; what they are worth is for those who use them. Throws Error for a file that cannot be
// read.
Scene read_scene(const std::string& path, const SceneVocabulary& known);

// The same from the text of a file. `name`: for messages; files are looked for in its folder.
Scene parse_scene(const std::string& text, const std::string& name, const SceneVocabulary& known);

}  // namespace tremula
