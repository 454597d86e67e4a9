#include "tremula/deformation/drift_pose.hpp"
#include "tremula/dynamics/drift.hpp"

#include "tremula/base/error.hpp"

#include <algorithm>
#include <memory>
#include <utility>

#include "scene_things.hpp"

namespace tremula::cli {
namespace {

DriftKind kind_of(const SceneDrift& said) {
  DriftKind kind = drift_kind_named(said.kind);
  if (said.intensity) kind = with_intensity(std::move(kind), *said.intensity);
  if (said.size) kind = with_size(std::move(kind), *said.size);
  if (said.matter_density) kind = with_matter_density(std::move(kind), *said.matter_density);
  if (said.fall_speed) kind.fall_speed = *said.fall_speed;
  if (said.density) kind.number_density = *said.density;
  return kind;
}

Drift drift_of(const SceneDrift& said) {
  if (said.density && said.intensity)
    throw InputError("density and intensity of " + said.kind, "both", "one of them");
  Drift drift{.kind = kind_of(said),
              .low = said.low,
              .high = said.high,
              .lying_time = said.lie_time,
              .seed = said.seed};
  if (said.source_low || said.source_high) {
    if (!said.source_low || !said.source_high)
      throw InputError("source of " + said.kind, "one corner", "source_low and source_high");
    if (said.density || said.intensity)
      throw InputError("density of " + said.kind, "that of a source", "source_rate");
    drift.source = {.low = *said.source_low, .high = *said.source_high, .rate = said.source_rate};
  }
  check_drift(drift);
  return drift;
}

DriftLook look_of(const SceneDrift& said, DriftForm form) {
  DriftLook look = tremula::look_of(form);
  if (said.color) {
    for (SurfaceMaterial& material : look.materials) material.color = *said.color;
  }
  return look;
}

}  // namespace

DriftOfPage make_drift_of_page(const SceneDrift& said, const ThingSite& site) {
  const Drift drift = drift_of(said);
  const Wind& wind = site.commands.blowing;
  TravellingField gusts =
      gust_field(wind, site.loop(), plane_around(drift, wind.reference.heading, site.ground()));
  gusts.ground = site.ground();
  return {.drift = drift,
          .paths = carry(gusts, drift),
          .look = look_of(said, drift.kind.form),
          .facts = site.facts(said.name, said.seed)};
}

SceneThing make_drift(const SceneDrift& said, const ThingSite& site) {
  DriftOfPage made = make_drift_of_page(said, site);
  SceneThing thing{.name = said.name, .kind = said.kind};
  if (made.paths.paths.empty()) return thing;  // so few that none comes in this loop
  thing.count = drift_at(made.paths, 0).size();
  auto paths = std::make_shared<const DriftPaths>(std::move(made.paths));
  thing.loops = {std::make_shared<const Loop>(make_loop(std::move(paths), made.facts, made.look))};
  return thing;
}

}  // namespace tremula::cli
