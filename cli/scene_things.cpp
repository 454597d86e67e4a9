#include "scene_things.hpp"

#include "tremula/base/error.hpp"

#include <array>
#include <utility>

namespace tremula::cli {
namespace {

template <class Thing, class Make>
void add_things(const std::vector<Thing>& things, const ThingSite& site, const Make& make,
                std::vector<SceneThing>& made) {
  for (const Thing& thing : things) {
    site.log.begin(thing.name);
    made.push_back(made_at(thing.place, [&] { return make(thing, site); }));
    site.log.finish();
  }
}

}  // namespace

TravellingField ThingSite::gusts(std::span<const Vec3> points, double spacing,
                                 std::vector<double> heights) const {
  const Wind& wind = commands.blowing;
  TravellingField field =
      gust_field(wind, loop(), plane_across(points, wind.reference.heading, spacing, std::move(heights)));
  field.ground = ground();
  return field;
}

TravellingField ThingSite::gusts(const Eigen::Vector2d& low, const Eigen::Vector2d& high, double spacing,
                                 std::vector<double> heights) const {
  const std::array<Vec3, 4> corners{Vec3(low.x(), low.y(), 0), Vec3(high.x(), low.y(), 0),
                                    Vec3(low.x(), high.y(), 0), Vec3(high.x(), high.y(), 0)};
  return gusts(corners, spacing, std::move(heights));
}

LoopFacts ThingSite::facts(const std::string& name, std::uint64_t seed) const {
  return {.name = name,
          .frames_per_second = commands.frames_per_second,
          .wind_speed = commands.wind.speed,
          .heading = commands.wind.heading,
          .seed = seed};
}

std::vector<SceneThing> make_things(const ThingSite& site) {
  const Scene& scene = site.scene;
  std::vector<SceneThing> made;
  const bool none = scene.grass.empty() && scene.drift.empty() && scene.impressions.empty() &&
                    scene.volumes.empty() && !scene.gusts;
  if (none) return made;
  if (site.commands.is_clip)
    throw InputError("the motion of the scene", "a clip", "a loop, which grass, snow and the like need");
  add_things(scene.grass, site, make_grass, made);
  add_things(scene.drift, site, make_drift, made);
  add_things(scene.impressions, site, make_impression, made);
  add_things(scene.volumes, site, make_volume, made);
  if (scene.gusts)
    made.push_back(made_at(scene.gusts->place, [&] { return make_gusts(*scene.gusts, site); }));
  return made;
}

}  // namespace tremula::cli
