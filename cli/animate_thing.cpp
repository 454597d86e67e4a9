// tremula animate of what is not baked but looked up in the wind: grass and what drifts, of a scene or by the
// name of a species.
#include "tremula/base/error.hpp"
#include "tremula/base/memory.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "animate.hpp"
#include "scene_things.hpp"

namespace tremula::cli {
namespace {

// Flags that shape plants say nothing of these.
void refuse_flags_of_plants(const CLI::App& flags, const std::string& name) {
  constexpr std::array known{"--object",   "--output",  "--format", "--report", "--morphs",
                             "--compress", "--threads", "--period", "--fps",    "--help"};
  for (const CLI::Option* option : flags.get_options()) {
    if (option->count() == 0 || option->get_lnames().empty()) continue;
    const std::string flag = option->get_name();
    if (option->get_group() == wind_flag_group) continue;
    if (std::ranges::any_of(known, [&](const char* each) { return flag == each; })) continue;
    if (option->check_lname("output")) continue;
    throw InputError(flag, "given with " + name,
                     "flags of the wind, --period, --fps and those of the output");
  }
}

const SceneGrass* find_grass(const Scene& scene, const std::string& name) {
  const auto found = std::ranges::find(scene.grass, name, &SceneGrass::name);
  return found != scene.grass.end() ? &*found : nullptr;
}

void refuse_unless_grass(const Scene& scene, const std::string& name) {
  const auto named = [&](const auto& things) {
    return std::ranges::find(things, name, [](const auto& one) { return one.name; }) != things.end();
  };
  if (named(scene.drift) || named(scene.impressions) || named(scene.volumes)) {
    throw InputError("--object", "'" + name + "', which only tremula render shows",
                     "an object or grass: files for engines hold neither what drifts nor textures");
  }
}

}  // namespace

bool AnimateCommand::animate_grass(const CLI::App& flags,
                                   const std::vector<const LoopWriter*>& writers) const {
  constexpr double half = 0.5;  // of a patch, to be laid side by side [m]
  const bool preset = is_grass(plant.input);
  if (!preset && !is_scene(plant.input)) return false;
  if (preset && !object.empty()) throw InputError("--object", "given with " + plant.input, "a scene (.toml)");
  const Scene scene =
      preset ? scene_of_grass(plant.input, {-half, -half}, {half, half}) : open_scene(plant.input);
  const bool only = object.empty() && scene.objects.empty() && scene.grass.size() == 1;
  const SceneGrass* grass = preset || only ? &scene.grass.front() : find_grass(scene, object);
  if (grass == nullptr) {
    refuse_unless_grass(scene, object);
    return false;
  }
  refuse_flags_of_plants(flags, grass->name);
  for (std::size_t i = 0; i < writers.size(); ++i) {
    if (writers[i]->extension == "csv")
      throw InputError("-o " + outputs[i], "a table of nodes, which grass has not", ".glb, .html or .png");
  }
  const SceneCommands commands = commands_of(scene, flags);
  std::vector<Place> inputs = commands.input_places();
  inputs.push_back({"SCENE", preset ? "" : plant.input});
  Outputs files(output_places(), inputs);
  StageLog log;
  WarningLog warnings;
  const FilmCamera nobody;
  log.begin("grass");
  const SceneThing thing = make_grass(*grass, {scene, commands, nobody, log, warnings});
  const Loop& loop = *thing.loops.front();
  if (loop.coordinates.cols() == 0 && !writers.empty()) {
    throw InputError(grass->name, std::to_string(loop.rest->vertex_count()) + " vertices",
                     "fewer, for files that move by morph targets: a smaller field or a lower density");
  }
  const LoopWriteOptions options{.morphs = morph_forms.at(morphs),
                                 .compression = compressions.at(compression)};
  encode_outputs(loop, {}, writers, options, 0, log, files);
  log.finish();
  if (!report.empty()) {
    files.add(report, text_of({{"tremula", TREMULA_VERSION},
                               {"input", plant.input},
                               {"species", grass->species},
                               {"blades", thing.count},
                               {"vertices", loop.rest->vertex_count()},
                               {"shapes", loop.coordinates.cols()},
                               {"wind_speed_m_s", commands.wind.speed},
                               {"heading_deg", commands.wind.heading},
                               {"period_s", commands.loop.period},
                               {"frames_per_second", commands.frames_per_second},
                               {"warnings", warnings.lines},
                               {"outputs", outputs},
                               {"stages", log.json()},
                               {"peak_bytes", peak_bytes()}}));
  }
  files.commit();
  files.announce();
  return true;
}

}  // namespace tremula::cli
