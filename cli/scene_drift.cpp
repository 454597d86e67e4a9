#include "tremula/base/error.hpp"

#include "scene_things.hpp"

namespace tremula::cli {

SceneThing make_drift(const SceneDrift&, const ThingSite&) { throw Error("drift: not there yet"); }

}  // namespace tremula::cli
