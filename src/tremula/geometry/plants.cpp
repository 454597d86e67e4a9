#include "tremula/geometry/plants.hpp"

#include "tremula/base/error.hpp"
#include "tremula/geometry/plants/texts.hpp"

#include <algorithm>

namespace tremula {

const std::vector<PlantPreset>& plant_presets() {
  static const std::vector<PlantPreset> presets = [] {
    std::vector<PlantPreset> list;
    for (const PresetText& preset : preset_texts) {
      // The first line of a text is a comment that says what grows from it.
      const std::string_view first = preset.text.substr(0, preset.text.find('\n'));
      list.push_back({std::string(preset.name), std::string(first.substr(2)), std::string(preset.text)});
    }
    return list;
  }();
  return presets;
}

const PlantPreset& find_preset(std::string_view name) {
  const auto found = std::ranges::find(plant_presets(), name, &PlantPreset::name);
  if (found != plant_presets().end()) return *found;
  std::string names;
  for (const PlantPreset& preset : plant_presets()) names += (names.empty() ? "" : ", ") + preset.name;
  throw InputError("preset", "'" + std::string(name) + "'", "one of " + names);
}

}  // namespace tremula
