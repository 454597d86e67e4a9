#include "tremula/scene/scene.hpp"

#include <algorithm>

namespace tremula {

std::string text_of(const FilePlace& place) {
  if (place.line <= 0) return place.file;
  return place.file + ":" + std::to_string(place.line) + ":" + std::to_string(place.column);
}

std::vector<Setting> settings_of(const Scene& scene, const SceneObject& object) {
  std::vector<Setting> all = scene.wind;
  for (const auto* some : {&scene.motion, &object.settings}) {
    for (const Setting& setting : *some) {
      const auto same = std::ranges::find(all, setting.key, &Setting::key);
      if (same == all.end()) {
        all.push_back(setting);
      } else {
        *same = setting;
      }
    }
  }
  std::erase_if(all,
                [](const Setting& setting) { return setting.values == std::vector<std::string>{"false"}; });
  return all;
}

}  // namespace tremula
