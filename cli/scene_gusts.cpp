#include "tremula/base/error.hpp"

#include "scene_things.hpp"

namespace tremula::cli {

SceneThing make_gusts(const SceneGusts&, const ThingSite&) { throw Error("gusts: not there yet"); }

}  // namespace tremula::cli
