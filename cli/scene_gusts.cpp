#include "tremula/base/error.hpp"
#include "tremula/scene/gust_arrows.hpp"

#include <algorithm>
#include <memory>
#include <utility>

#include "scene_things.hpp"

namespace tremula::cli {

SceneThing make_gusts(const SceneGusts& gusts, const ThingSite& site) {
  if (!gusts.arrows && !gusts.tint)
    throw InputError("gusts", "neither arrows nor tint", "one of them, or no [gusts]");
  // Fine enough for the tint, which shows what is between arrows.
  const double spacing = gusts.tint ? std::min(gusts.spacing, 0.5) : gusts.spacing;
  const auto field =
      std::make_shared<const TravellingField>(site.gusts(gusts.low, gusts.high, spacing, {gusts.height}));
  const ArrowLattice lattice{.low = gusts.low,
                             .high = gusts.high,
                             .z = site.ground() + gusts.height,
                             .spacing = gusts.spacing,
                             .scale = gusts.scale};
  SceneThing thing{.name = "gusts", .kind = "wind"};
  if (gusts.arrows) {
    thing.count = arrow_count(lattice);
    thing.loops.push_back(std::make_shared<const Loop>(gust_arrows(field, lattice)));
  }
  if (gusts.tint) thing.ground_tint = gust_tint(field, lattice);
  return thing;
}

}  // namespace tremula::cli
