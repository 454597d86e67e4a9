// What a scene shows, made with the flags of tremula animate: every object is a plant in the wind by the
// settings of the file, and over them by the flags of the command line.
#pragma once

#include "tremula/deformation/loop.hpp"
#include "tremula/scene/scene.hpp"
#include "tremula/scene/scene_file.hpp"

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "plant_in_wind.hpp"

namespace tremula {
struct RayShape;
}

namespace tremula::cli {

// One object, with a command line of its own.
class SceneObjectCommand {
 public:
  // `line`: the flags that count instead of what the file says. Throws InputError with the place of the
  // setting in the file.
  SceneObjectCommand(const Scene& scene, const SceneObject& object, const CLI::App& line);
  SceneObjectCommand(const SceneObjectCommand&) = delete;
  SceneObjectCommand& operator=(const SceneObjectCommand&) = delete;

  const CLI::App& flags() const { return app_; }
  const PlantInWind& plant() const { return plant_; }
  // Runs what may find a setting wrong, and says its place then.
  template <class Work>
  auto at_place(const Work& work) const {
    try {
      return work();
    } catch (const InputError& error) {
      throw InputError(with_place(error.what()));
    }
  }

 private:
  std::string with_place(const std::string& message) const;

  CLI::App app_;
  PlantInWind plant_;
  FilePlace place_;                          // of the object
  std::map<std::string, FilePlace> places_;  // of its settings, by flag
};

// A loop for every heading that its copies stand in, or for every copy in gusts of its own (own_gusts), with
// those that take it. The presets of sheets and
// frames face the wind, wherever their copies would turn.
using SharedLoops = std::vector<std::shared_ptr<const Loop>>;
SharedLoops move_object(const SceneObjectCommand& command, const SceneObject& object,
                        std::vector<Instance> instances, StageLog& log, WarningLog& warnings);

// The objects of a scene, each with its settings checked, before any is read.
struct SceneCommands {
  std::vector<std::unique_ptr<SceneObjectCommand>> objects;
  std::unique_ptr<SceneObjectCommand> air;  // of no object: what blows
  Wind blowing;                             // for all that is in the air
  ReferenceWind wind;                       // over all
  TimeAxis loop;
  double frames_per_second = 0;               // [1/s]
  bool is_clip = false, under_water = false;  // where any object is

  std::vector<Place> input_places() const;
};
SceneCommands commands_of(const Scene& scene, const CLI::App& line);

// Where and when the copies of every object stand.
std::vector<std::vector<Instance>> copies_of(const Scene& scene, const SceneCommands& commands);

// What is not baked, but looked up in the wind (scene_things.hpp).
struct SceneThing {
  std::string name, kind;
  std::size_t count = 0;  // of blades, flakes, trees, …
  SharedLoops loops = {};
  std::vector<std::shared_ptr<const RayShape>> shapes = {};
  // What it lays over the ground (GroundLook::tint).
  std::function<Eigen::Vector4f(const Eigen::Vector2f& place, double time)> ground_tint = {};
};

// The loops of every object, in their order, and all else.
struct MovingScene {
  std::vector<SharedLoops> objects;
  std::size_t instance_count = 0;
  std::vector<SceneThing> things = {};

  SharedLoops loops() const;
  std::vector<std::shared_ptr<const RayShape>> shapes() const;
};
MovingScene move_scene(const Scene& scene, const SceneCommands& commands, StageLog& log,
                       WarningLog& warnings);

// What a file can name: flags and presets of this program.
SceneVocabulary scene_vocabulary();

// The name of a species of grass; and a scene with nothing else on such a piece of ground [m].
bool is_grass(const std::string& input);
Scene scene_of_grass(const std::string& species, const Eigen::Vector2d& low, const Eigen::Vector2d& high);

// Of all that --object can name: objects, grass, what drifts, painted trees and volumes.
std::vector<std::string> names_in(const Scene& scene);
// The name; where none is said, that of the only thing there is, if there is but one.
std::string name_or_only(const Scene& scene, const std::string& name);

// INPUT as a scene: that of its file, or of the plant or grass that it names alone.
Scene open_scene(const std::string& input);
bool is_scene(const std::string& input);
// The one of that name; of a scene of one object that one, for no name. Throws InputError.
const SceneObject& object_of(const Scene& scene, const std::string& name);

}  // namespace tremula::cli
