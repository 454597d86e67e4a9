#include "tremula/base/error.hpp"

#include "scene_things.hpp"

namespace tremula::cli {

SceneThing make_volume(const SceneVolume&, const ThingSite&) { throw Error("volumes: not there yet"); }

}  // namespace tremula::cli
