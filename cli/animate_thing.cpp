// tremula animate of what is not baked but looked up in the wind: grass of a scene, or by the name of a
// species, what drifts in a scene and its painted trees.
#include "tremula/base/error.hpp"
#include "tremula/base/memory.hpp"
#include "tremula/io/drift_page.hpp"
#include "tremula/io/grass_page.hpp"
#include "tremula/io/impression_page.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "animate.hpp"
#include "scene_things.hpp"

namespace tremula::cli {
namespace {

template <class Things>
auto find_thing(const Things& things, const std::string& name) {
  const auto found = std::ranges::find_if(things, [&](const auto& one) { return one.name == name; });
  return found != things.end() ? &*found : nullptr;
}

// What a command line of a plant has that these have too.
constexpr std::array<std::string_view, 9> thing_flags{"--object",  "--output", "--format",
                                                      "--report",  "--morphs", "--compress",
                                                      "--threads", "--period", "--fps"};

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

bool AnimateCommand::animate_thing(const CLI::App& flags,
                                   const std::vector<const LoopWriter*>& writers) const {
  constexpr double half = 0.5;  // of a patch, to be laid side by side [m]
  const bool preset = is_grass(plant.input);
  if (!preset && !is_scene(plant.input)) return false;
  if (preset && !object.empty()) throw InputError("--object", "given with " + plant.input, "a scene (.toml)");
  const Scene scene =
      preset ? scene_of_grass(plant.input, {-half, -half}, {half, half}) : open_scene(plant.input);
  const std::string name = name_or_only(scene, object);
  if (const SceneGrass* grass = find_thing(scene.grass, name)) {
    write_grass(scene, *grass, preset, flags, writers);
  } else if (const SceneDrift* drift = find_thing(scene.drift, name)) {
    write_drift(scene, *drift, flags, writers);
  } else if (const SceneImpression* impression = find_thing(scene.impressions, name)) {
    write_impression(scene, *impression, flags, writers);
  } else {
    return false;
  }
  return true;
}

Outputs AnimateCommand::outputs_of(const SceneCommands& commands) const {
  std::vector<Place> inputs = commands.input_places();
  inputs.push_back({"SCENE", is_scene(plant.input) ? plant.input : ""});
  return Outputs(output_places(), inputs);
}

void AnimateCommand::write_grass(const Scene& scene, const SceneGrass& grass, bool preset,
                                 const CLI::App& flags, const std::vector<const LoopWriter*>& writers) const {
  constexpr double page_half = 3.0;  // of a patch to look at [m]
  refuse_flags_of_plants(flags, grass.name, thing_flags);
  for (std::size_t i = 0; i < writers.size(); ++i) {
    if (writers[i]->extension == "csv")
      throw InputError("-o " + outputs[i], "a table of nodes, which grass has not", ".glb, .html or .png");
  }
  const SceneCommands commands = commands_of(scene, flags);
  Outputs files = outputs_of(commands);
  StageLog log;
  WarningLog warnings;
  const FilmCamera nobody;
  log.begin("grass");
  const ThingSite site{scene, commands, nobody, log, warnings};
  const auto pages = std::ranges::count_if(writers, is_page);
  std::optional<GrassOfPage> page;
  std::optional<SceneThing> model;
  const auto grow = [&](const auto& make, const SceneGrass& field) {
    return preset ? make(field, site) : made_at(field.place, [&] { return make(field, site); });
  };
  if (pages > 0) page = grow(make_grass_of_page, preset ? around_origin(grass, page_half) : grass);
  if (pages < std::ssize(writers) || writers.empty()) model = grow(make_grass, grass);
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
  Json told = {{"species", grass.species}};
  if (model) {
    told["blades"] = model->count;
    told["vertices"] = model->loops.front()->rest->vertex_count();
    told["shapes"] = model->loops.front()->coordinates.cols();
  }
  if (page) told["page"] = {{"blades", page->grass.blade_count()}, {"vertices", page->grass.all_vertices}};
  add_report(std::move(told), commands, warnings, log, files);
  files.commit();
  files.announce();
}

void AnimateCommand::write_page(const Scene& scene, const std::string& name, const FilePlace& place,
                                const std::string& kind, const CLI::App& flags,
                                const std::vector<const LoopWriter*>& writers,
                                const MakeThingPage& make) const {
  refuse_flags_of_plants(flags, name, thing_flags);
  for (std::size_t i = 0; i < writers.size(); ++i) {
    if (is_page(writers[i])) continue;
    throw InputError(
        "-o " + outputs[i],
        "given with " + name + ", " + kind + ": no " + std::string(writers[i]->extension) + " holds that",
        ".html, or tremula render for pictures and films");
  }
  const SceneCommands commands = commands_of(scene, flags);
  if (commands.is_clip)
    throw InputError("the motion of the scene", "a clip", "a loop, which " + name + " needs");
  Outputs files = outputs_of(commands);
  StageLog log;
  WarningLog warnings;
  const FilmCamera nobody;
  log.begin(name);
  const ThingSite site{scene, commands, nobody, log, warnings};
  const ThingPage page = made_at(place, [&] { return make(site); });
  for (const std::string& output : outputs) files.add(output, page.html, page.shown);
  add_report(page.told, commands, warnings, log, files);
  files.commit();
  files.announce();
}

void AnimateCommand::write_drift(const Scene& scene, const SceneDrift& drift, const CLI::App& flags,
                                 const std::vector<const LoopWriter*>& writers) const {
  const auto make = [&](const ThingSite& site) {
    DriftOfPage page = make_drift_of_page(drift, site);
    const double all = mean_seen(page.paths), share = share_of_page(page.paths);
    if (share < 1) page.paths = thinned(page.paths, share);
    const double seen = mean_seen(page.paths);
    std::string shown = printed("%.0f", seen) + " seen at a time";
    if (share < 1) {
      shown += " of " + printed("%.0f", all);
      site.warnings.add({drift.name + ": the page shows " + printed("%.3g", 100 * share) +
                         " % of the number density, each with the same chance: " + shown});
    }
    site.log.begin("write .html");
    return ThingPage{encode_drift_page(page.drift, page.paths, share, page.look, page.facts),
                     shown,
                     {{"kind", drift.kind}, {"page", {{"seen", seen}, {"all", all}, {"share", share}}}}};
  };
  write_page(scene, drift.name, drift.place, "which drifts", flags, writers, make);
}

void AnimateCommand::write_impression(const Scene& scene, const SceneImpression& impression,
                                      const CLI::App& flags,
                                      const std::vector<const LoopWriter*>& writers) const {
  const auto make = [&](const ThingSite& site) {
    const PlantedImpression planted = plant_impression(impression, site);
    const std::size_t count = planted.instances.size();
    const ImpressionMesh mesh = mesh_for_page(planted.tree, count);
    site.log.begin("write .html");
    return ThingPage{encode_impressions_page(planted.tree, planted.instances, planted.motion,
                                             site.facts(impression.name, impression.seed)),
                     std::to_string(count) + (count == 1 ? " painted tree" : " painted trees"),
                     {{"shape", impression.shape},
                      {"page",
                       {{"trees", count},
                        {"vertices", mesh.positions.size() * count},
                        {"triangles", mesh.triangles.size() / 3 * count}}}}};
  };
  write_page(scene, impression.name, impression.place, "painted trees", flags, writers, make);
}

void AnimateCommand::add_report(Json told, const SceneCommands& commands, const WarningLog& warnings,
                                StageLog& log, Outputs& files) const {
  log.finish();
  if (report.empty()) return;
  Json all = {{"tremula", TREMULA_VERSION}, {"input", plant.input}};
  all.update(told);
  all.update({{"wind_speed_m_s", commands.wind.speed},
              {"heading_deg", commands.wind.heading},
              {"period_s", commands.loop.period},
              {"frames_per_second", commands.frames_per_second},
              {"warnings", warnings.lines},
              {"outputs", outputs},
              {"stages", log.json()},
              {"peak_bytes", peak_bytes()}});
  files.add(report, text_of(all));
}

}  // namespace tremula::cli
