#include "tremula/dynamics/trunk_sway.hpp"
#include "tremula/geometry/impression.hpp"
#include "tremula/raytrace/impression_rays.hpp"
#include "tremula/scene/placing.hpp"

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "scene_things.hpp"

namespace tremula::cli {
namespace {

ImpressionistTree tree_of(const SceneImpression& impression) {
  ImpressionistTree tree =
      impressionist_tree(impression.shape, impression.height, impression.width, impression.seed);
  if (impression.leaf_color) tree.leaf_color = *impression.leaf_color;
  if (impression.bark_color) tree.bark_color = *impression.bark_color;
  if (!impression.name.empty()) tree.name = impression.name;
  return tree;
}

Structure trunk_of(const ImpressionistTree& tree, std::optional<double> frequency) {
  const Skeleton skeleton = trunk_skeleton(tree);
  const StructureOptions options{.material = find_material(tree.material)};
  return frequency ? tuned_structure(skeleton, options, *frequency) : assemble(skeleton, options);
}

}  // namespace

PlantedImpression plant_impression(const SceneImpression& impression, const ThingSite& site) {
  PlantedImpression planted;
  planted.tree = tree_of(impression);
  // Each feels the gusts of its own place, so that Taylor's time shifts are in them already.
  planted.instances = place_instances(impression.crowd, Vec3::Zero(), site.loop().period);
  std::vector<Vec3> places;
  for (const Instance& copy : planted.instances) places.push_back(copy.position);
  const Wind& wind = site.commands.blowing;
  const double width = planted.tree.width, spacing = std::clamp(width / 2, 0.5, 10.0);
  if (wind.reference.speed == 0) {  // no gust drives a trunk; the loop has a period all the same
    const TravellingField still = site.gusts(places, spacing, {planted.tree.height});
    planted.motion.tremble = std::make_shared<const TravellingField>(respond(still, tremble_response()));
    return planted;
  }
  const SceneObjectCommand& air = *site.commands.air;
  const Weather weather = air.at_place([&] { return air.plant().conditions().weather; });
  const TrunkSway sway = trunk_sway(trunk_of(planted.tree, impression.frequency), wind, site.loop(),
                                    {weather.loads, weather.damping, width / 2});
  planted.motion = impression_motion(sway, site.gusts(places, spacing, {sway.gust_height}));
  return planted;
}

SceneThing make_impression(const SceneImpression& impression, const ThingSite& site) {
  PlantedImpression planted = plant_impression(impression, site);
  SceneThing thing{
      .name = planted.tree.name, .kind = "impressionist trees", .count = planted.instances.size()};
  thing.shapes = {impression_shape(planted.tree, std::move(planted.instances), planted.motion)};
  return thing;
}

}  // namespace tremula::cli
