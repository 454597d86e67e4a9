#include "tremula/base/error.hpp"

#include "scene_things.hpp"

namespace tremula::cli {

SceneThing make_grass(const SceneGrass&, const ThingSite&) { throw Error("grass: not there yet"); }

}  // namespace tremula::cli
