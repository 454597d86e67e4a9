// What a command might know, for the readers of scenes.
#pragma once

#include "tremula/scene/scene_file.hpp"

namespace tremula::test {

inline SceneVocabulary vocabulary() {
  using enum SettingKind;
  using enum SettingScope;
  return {{{"wind_speed", number, wind, "Mean wind speed [m/s]"},
           {"heading", number, wind, "Where the wind blows to [degrees]"},
           {"seed", integer, wind, "Of the gusts"},
           {"turbulence_intensity", number, wind, "Of the gusts"},
           {"terrain", text, wind, "What the ground is"},
           {"profile", file, wind, "How the mean wind grows with height"},
           {"decay_y", list, wind, "Coherence decay"},
           {"period", number, film, "Length of the loop [s]"},
           {"fps", number, film, "Frames per second"},
           {"modes", integer, object, "How many modes"},
           {"damping_ratio", number, object, "Of every mode"},
           {"mode_damping", list, object, "Of each mode"},
           {"material", text, object, "What it is made of"},
           {"no_shelter", toggle, object, "No shelter"}},
          {"oak", "birch", "sapling", "flag", "stam-62"}};
}

inline Scene parsed(const std::string& text) { return parse_scene(text, "scene.toml", vocabulary()); }

}  // namespace tremula::test
