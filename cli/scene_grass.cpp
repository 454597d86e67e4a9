#include "tremula/deformation/grass_pose.hpp"
#include "tremula/io/grass_page.hpp"
#include "tremula/scene/placing.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <utility>

#include "scene_things.hpp"

namespace tremula::cli {
namespace {

using Eigen::Vector2d;

// Blades get fewer and wider from so many of their widths away: some 3 pixels each in a picture of 540 lines.
constexpr double widths_to_the_first = 700;
constexpr int eyes_of_a_film = 16;

// What a camera sees of level ground, to either side.
struct View {
  Vector2d eye, forward;
  double half_angle;  // [rad]

  // Or nearly so: what stands `margin` [m] beside throws its shadow into the picture.
  bool sees(const Vector2d& place, double margin) const {
    const Vector2d way = place - eye;
    if (way.squaredNorm() < margin * margin) return true;
    const double depth = way.dot(forward), side = std::abs(way.x() * forward.y() - way.y() * forward.x());
    return side * std::cos(half_angle) - depth * std::sin(half_angle) < margin;
  }
};

View view_of(const Camera& camera) {
  const double level = camera.forward.head<2>().norm(), down = std::abs(camera.forward.z());
  const double nearest =
      level - camera.half_height * down;  // of the lower edge of the picture, at distance 1
  View view{.eye = camera.eye.head<2>(), .forward = Vector2d::UnitX(), .half_angle = std::numbers::pi};
  if (nearest < 0.1) return view;
  view.forward = camera.forward.head<2>() / level;
  view.half_angle = std::atan(camera.half_height * camera.aspect / nearest);
  return view;
}

// None: of a file, which is looked at from anywhere.
std::vector<View> views_of(const ThingSite& site) {
  std::vector<View> views;
  if (!site.camera.camera) return views;
  for (int i = 0; i < eyes_of_a_film; ++i) {
    views.push_back(view_of(site.camera.camera(site.loop().period * i / eyes_of_a_film)));
    if (i > 0 && views.back().eye == views.front().eye && views.back().forward == views.front().forward)
      views.pop_back();
  }
  return views;
}

GrassSpecies species_of(const SceneGrass& grass) {
  GrassSpecies species = grass_species_named(grass.species);
  if (!grass.color) return species;
  for (BladeKind& kind : species.kinds) {
    if (kind.form == BladeForm::ear) continue;
    kind.color = *grass.color;
    // Blades of that name have the colour of the ground.
    if (kind.material == "blade") kind.material = "leaf";
  }
  return species;
}

SowOptions options_of(const SceneGrass& grass, const GrassSpecies& species, const ThingSite& site) {
  SowOptions options{.low = grass.low, .high = grass.high};
  options.density = grass.density;
  options.height = grass.height;
  options.ground = site.ground();
  options.seed = grass.seed;
  Scatter masks;
  masks.low = grass.low;
  masks.high = grass.high;
  masks.inside = grass.inside;
  masks.outside = grass.outside;
  check_scatter(masks);
  const std::vector<View> views = views_of(site);
  const double margin = 1 + 3 * grass.height.value_or(species.height);
  options.density_at = [masks, views, margin](const Vector2d& place) {
    const auto sees = [&](const View& view) { return view.sees(place, margin); };
    return (views.empty() || std::ranges::any_of(views, sees)) &&
                   masks_leave(masks.inside, masks.outside, place)
               ? 1.0
               : 0.0;
  };
  if (views.empty()) return options;
  Thinning thinning{.eyes = {}, .full_until = std::max(2.0, widths_to_the_first * species.kinds[0].width)};
  for (const View& view : views) thinning.eyes.push_back(view.eye);
  options.thinning = thinning;
  return options;
}

// Over a field from `low` to `high`.
TravellingField gusts_over(const Meadow& meadow, const Vector2d& low, const Vector2d& high,
                           const ThingSite& site) {
  const double spacing = std::clamp((high - low).maxCoeff() / 200, 0.25, 2.0);
  return site.gusts(low, high, spacing, {meadow.height});
}

SceneThing thing_of(Meadow meadow, const std::string& name, const Vector2d& low, const Vector2d& high,
                    std::uint64_t seed, const ThingSite& site) {
  const TravellingField gusts = gusts_over(meadow, low, high, site);
  SceneThing thing{.name = name, .kind = meadow.species.name, .count = meadow.size()};
  thing.loops.push_back(
      std::make_shared<const Loop>(make_grass_loop(std::move(meadow), gusts, site.facts(name, seed))));
  return thing;
}

// The blades that the renderer would lay on the ground near the camera, as a species.
GrassSpecies ground_species(double height) {
  GrassSpecies species = grass_species_named("lawn");
  species.name = "grass";
  species.height = 0.75 * height;
  species.density = 1870;
  BladeKind& blade = species.kinds[0];
  blade.frequency *= grass_species_named("lawn").height / species.height;
  blade.width = 0.0045;
  blade.length_spread = 0.5;
  return species;
}

}  // namespace

SceneThing make_grass(const SceneGrass& grass, const ThingSite& site) {
  const GrassSpecies species = species_of(grass);
  Meadow meadow = sow(species, options_of(grass, species, site));
  return thing_of(std::move(meadow), grass.name, grass.low, grass.high, grass.seed, site);
}

GrassOfPage make_grass_of_page(const SceneGrass& grass, const ThingSite& site) {
  const GrassSpecies species = species_of(grass);
  Meadow meadow = sow(species, options_of(grass, species, site));
  check_blades_of_page(meadow.size());
  const TravellingField gusts = gusts_over(meadow, grass.low, grass.high, site);
  return {put_in_wind(std::move(meadow), gusts), site.facts(grass.name, grass.seed)};
}

std::optional<SceneThing> make_ground_grass(const ThingSite& site, std::vector<Eigen::Vector3d>& sown) {
  const SceneGround& ground = site.scene.ground;
  const bool moves = ground.kind == "grass" && ground.grass_height > 0 && !site.commands.is_clip &&
                     !site.commands.under_water && site.commands.wind.speed > 0;
  if (!moves) return {};
  const double unit = std::clamp(ground.grass_height, 0.04, 0.16);
  const double radius = 175 * unit;  // beyond, blades are smaller than what moves of them
  std::vector<View> views = views_of(site);
  SceneGrass grass;
  grass.low = grass.high = views.front().eye;
  for (const View& view : views) {
    grass.low = grass.low.cwiseMin(view.eye - Vector2d::Constant(radius));
    grass.high = grass.high.cwiseMax(view.eye + Vector2d::Constant(radius));
    sown.emplace_back(view.eye.x(), view.eye.y(), radius);
  }
  const GrassSpecies species = ground_species(ground.grass_height);
  SowOptions options = options_of(grass, species, site);
  options.thinning->full_until = 75 * unit;
  options.thinning->widest = 1.5;
  options.density_at = [within = options.density_at, views, radius](const Vector2d& place) {
    const auto near = [&](const View& view) { return (place - view.eye).norm() < radius; };
    return std::ranges::any_of(views, near) ? within(place) : 0.0;
  };
  Meadow meadow = sow(species, options);
  return thing_of(std::move(meadow), "ground", grass.low, grass.high, grass.seed, site);
}

}  // namespace tremula::cli
