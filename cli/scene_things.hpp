// What of a scene is not baked, but looked up in its wind: grass, snow, impressionist trees, volumes, the
// gusts themselves. All of them take the wind that the objects have; none makes one.
#pragma once

#include "tremula/deformation/drift_pose.hpp"
#include "tremula/deformation/grass_pose.hpp"
#include "tremula/deformation/impression_motion.hpp"
#include "tremula/deformation/volume.hpp"
#include "tremula/geometry/impression.hpp"
#include "tremula/io/volume_page.hpp"
#include "tremula/scene/film_camera.hpp"
#include "tremula/wind/travelling_field.hpp"

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "scene_objects.hpp"

namespace tremula {
struct RayShape;
}

namespace tremula::cli {

// What `make` gives; what it refuses is said with the place in the file of the scene.
template <class Make>
auto made_at(const FilePlace& place, const Make& make) {
  try {
    return make();
  } catch (const InputError& error) {
    throw InputError(text_of(place) + ": " + error.what());
  }
}

// Where a thing is made: in this scene, seen from there.
struct ThingSite {
  const Scene& scene;
  const SceneCommands& commands;
  const FilmCamera& camera;
  StageLog& log;
  WarningLog& warnings;

  const TimeAxis& loop() const { return commands.loop; }
  double ground() const { return scene.ground.height; }
  // The gusts over points [m], columns `spacing` [m] apart, in layers at heights above the ground [m].
  TravellingField gusts(std::span<const Vec3> points, double spacing, std::vector<double> heights) const;
  // The same over a field from `low` to `high`.
  TravellingField gusts(const Eigen::Vector2d& low, const Eigen::Vector2d& high, double spacing,
                        std::vector<double> heights) const;
  // What files say of a thing.
  LoopFacts facts(const std::string& name, std::uint64_t seed) const;
};

// Each in its own file: cli/scene_grass.cpp, …
SceneThing make_grass(const SceneGrass& grass, const ThingSite& site);
SceneThing make_drift(const SceneDrift& drift, const ThingSite& site);
SceneThing make_impression(const SceneImpression& impression, const ThingSite& site);
SceneThing make_volume(const SceneVolume& volume, const ThingSite& site);
SceneThing make_gusts(const SceneGusts& gusts, const ThingSite& site);

// The same grass as a page holds it (io/grass_page.hpp). Throws InputError for more than one can.
struct GrassOfPage {
  GrassInWind grass;
  LoopFacts facts;
};
GrassOfPage make_grass_of_page(const SceneGrass& grass, const ThingSite& site);

// What drifts, as a page holds it (io/drift_page.hpp).
struct DriftOfPage {
  Drift drift;
  DriftPaths paths;
  DriftLook look;
  LoopFacts facts;
};
DriftOfPage make_drift_of_page(const SceneDrift& drift, const ThingSite& site);

// Impressionist trees, as a picture takes them and as a page holds them (io/impression_page.hpp).
struct PlantedImpression {
  ImpressionistTree tree;
  std::vector<Instance> instances;
  ImpressionMotion motion;
};
PlantedImpression plant_impression(const SceneImpression& impression, const ThingSite& site);

// A volume before anybody looks at it.
struct GrownVolume {
  std::shared_ptr<const VolumeField> field;
  double scale = 1;         // of the species
  std::size_t strands = 0;  // of one patch
};
GrownVolume grow_volume(const SceneVolume& volume, const ThingSite& site);

// The same as a page holds it.
StrandField grow_strand_field(const SceneVolume& volume, const ThingSite& site);

// Grass of the ground near the cameras of the film, where there is any and it moves; and the circles (x, y
// and radius) that it covers [m].
std::optional<SceneThing> make_ground_grass(const ThingSite& site, std::vector<Eigen::Vector3d>& sown);

// Of a whole scene, in the order of these. Says the place in the file of what is wrong. Throws InputError
// where the motion of the scene is a clip.
std::vector<SceneThing> make_things(const ThingSite& site);

}  // namespace tremula::cli
