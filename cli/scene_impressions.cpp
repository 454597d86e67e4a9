#include "tremula/base/error.hpp"

#include "scene_things.hpp"

namespace tremula::cli {

SceneThing make_impression(const SceneImpression&, const ThingSite&) {
  throw Error("impressions: not there yet");
}

}  // namespace tremula::cli
