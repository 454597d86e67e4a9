// The plants that come with tremula, as texts in the language of lsystem.hpp. They are part of the library:
// nothing is looked up on the disk.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace tremula {

struct PlantPreset {
  std::string name;         // "oak"
  std::string description;  // one line
  std::string text;         // for parse_lsystem
};

const std::vector<PlantPreset>& plant_presets();

// Throws InputError that lists the names where there is none of this name.
const PlantPreset& find_preset(std::string_view name);

}  // namespace tremula
