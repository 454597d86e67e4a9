// tremula animate of grass, which is not baked but looked up in the wind: of a scene, or by the name of a
// species.
#include "tremula/base/error.hpp"
#include "tremula/base/memory.hpp"
#include "tremula/io/grass_page.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <optional>
#include <string>
#include <utility>

#include "animate.hpp"
#include "scene_things.hpp"

namespace tremula::cli {
namespace {

const SceneGrass* find_grass(const Scene& scene, const std::string& name) {
  const auto found = std::ranges::find(scene.grass, name, &SceneGrass::name);
  return found != scene.grass.end() ? &*found : nullptr;
}

void refuse_unless_grass(const Scene& scene, const std::string& name) {
  const auto named = [&](const auto& things) {
    return std::ranges::find(things, name, [](const auto& one) { return one.name; }) != things.end();
  };
  if (named(scene.drift) || named(scene.impressions)) {
    throw InputError("--object", "'" + name + "', which only tremula render shows",
                     "an object, grass or a volume: files for engines hold neither what drifts nor textures");
  }
}

bool is_page(const LoopWriter* writer) { return writer->extension == "html"; }

SceneGrass around_origin(SceneGrass grass, double half) {
  grass.low.setConstant(-half);
  grass.high.setConstant(half);
  return grass;
}

void check_moves(const SceneThing& model) {
  const Loop& loop = *model.loops.front();
  if (loop.coordinates.cols() > 0) return;
  throw InputError(model.name, std::to_string(loop.rest->vertex_count()) + " vertices",
                   "fewer, for files that move by morph targets: a smaller field or a lower density");
}

}  // namespace

void refuse_flags_of_plants(const CLI::App& flags, const std::string& name,
                            std::span<const std::string_view> known) {
  for (const CLI::Option* option : flags.get_options()) {
    if (option->count() == 0 || option->get_lnames().empty()) continue;
    const std::string flag = option->get_name();
    if (option->get_group() == wind_flag_group || std::ranges::find(known, flag) != known.end()) continue;
    throw InputError(flag, "given with " + name,
                     "flags of the wind, --period, --fps and those of the output");
  }
}

bool AnimateCommand::animate_grass(const CLI::App& flags,
                                   const std::vector<const LoopWriter*>& writers) const {
  constexpr double half = 0.5;       // of a patch, to be laid side by side [m]
  constexpr double page_half = 3.0;  // of one to look at
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
  constexpr std::array<std::string_view, 9> known{"--object",  "--output", "--format",
                                                  "--report",  "--morphs", "--compress",
                                                  "--threads", "--period", "--fps"};
  refuse_flags_of_plants(flags, grass->name, known);
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
  const ThingSite site{scene, commands, nobody, log, warnings};
  const auto pages = std::ranges::count_if(writers, is_page);
  std::optional<GrassOfPage> page;
  std::optional<SceneThing> model;
  if (pages > 0) page = make_grass_of_page(preset ? around_origin(*grass, page_half) : *grass, site);
  if (pages < std::ssize(writers) || writers.empty()) model = make_grass(*grass, site);
  if (model && !writers.empty()) check_moves(*model);
  const LoopWriteOptions options{.morphs = morph_forms.at(morphs),
                                 .compression = compressions.at(compression)};
  for (std::size_t i = 0; i < writers.size(); ++i) {
    log.begin("write ." + std::string(writers[i]->extension));
    if (is_page(writers[i])) {
      files.add(outputs[i], encode_grass_page(page->grass, page->facts),
                std::to_string(page->grass.blade_count()) + " blades");
    } else {
      files.add(outputs[i], writers[i]->encode(*model->loops.front(), options),
                writers[i]->extension == "glb" ? "morph targets" : "");
    }
  }
  log.finish();
  if (!report.empty()) {
    Json told = {{"tremula", TREMULA_VERSION}, {"input", plant.input}, {"species", grass->species}};
    if (model) {
      told["blades"] = model->count;
      told["vertices"] = model->loops.front()->rest->vertex_count();
      told["shapes"] = model->loops.front()->coordinates.cols();
    }
    if (page) told["page"] = {{"blades", page->grass.blade_count()}, {"vertices", page->grass.all_vertices}};
    told.update({{"wind_speed_m_s", commands.wind.speed},
                 {"heading_deg", commands.wind.heading},
                 {"period_s", commands.loop.period},
                 {"frames_per_second", commands.frames_per_second},
                 {"warnings", warnings.lines},
                 {"outputs", outputs},
                 {"stages", log.json()},
                 {"peak_bytes", peak_bytes()}});
    files.add(report, text_of(told));
  }
  files.commit();
  files.announce();
  return true;
}

}  // namespace tremula::cli
