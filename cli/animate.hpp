// tremula animate, in parts: its flags (animate_flags.cpp), the run (animate.cpp), what is told of it
// (animate_report.cpp).
#pragma once

#include "tremula/deformation/fit_rig.hpp"
#include "tremula/dynamics/gauge.hpp"
#include "tremula/io/loop_writers.hpp"

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "clips.hpp"
#include "scene_objects.hpp"
#include "scene_things.hpp"

namespace tremula::cli {

inline const std::map<std::string, MorphForm> morph_forms{
    {"biased", MorphForm::biased}, {"paired", MorphForm::paired}, {"signed", MorphForm::signed_weights}};
inline const std::map<std::string, MeshCompression> compressions{{"none", MeshCompression::none},
                                                                 {"quantised", MeshCompression::quantised},
                                                                 {"meshopt", MeshCompression::meshopt}};

// A .glb as it was written.
struct WrittenModel {
  std::string form;
  std::size_t joints = 0, clips = 0, keys = 0;
  double largest_error = 0;  // [m]
  std::size_t bytes = 0;
};

// What a run works with and makes, for the report.
struct Done {
  const PreparedPlant& prepared;
  const Subject& subject;
  const Loop& loop;
  const std::vector<GaugeSeries>& gauges;
  const Json& most_stressed;
  const MotionStatistics& statistics;
  const DampingBySource& damping;
  const Vec3& mean_drag;
  const std::optional<PullTest>& pull;
  const std::vector<std::string>& warnings;
  const std::optional<WrittenModel>& model;
};

struct AnimateCommand {
  PlantInWind plant;
  std::string report, format, object;  // of a scene
  std::vector<std::string> outputs, clip_texts;
  bool mean_only = false;
  std::vector<std::string> gauges;
  std::string frames, form, morphs = "biased", compression = "quantised";
  double tolerance = 0.005;  // of the height
  std::optional<int> max_joints;
  std::optional<double> texel_size;  // of a volume [m]
  bool resume = false;
  ThreadsFlag threads;

  std::vector<int> picked_frames(int sample_count) const;
  std::vector<const LoopWriter*> output_writers() const;
  void check_flags(const CLI::App& flags, const std::vector<const LoopWriter*>& writers) const;
  std::vector<Place> output_places() const;
  std::vector<Gauge> placed_gauges(const Plant& plant) const;
  std::vector<Motion> move_in_others(const PreparedPlant& first, const Subject& subject,
                                     const std::vector<NamedWind>& clips, const Progress& progress,
                                     StageLog& log, WarningLog& warnings) const;
  bool on_bones(const CLI::App& flags, const Plant& plant) const;
  RigOptions rig_options(const Subject& subject) const;
  std::shared_ptr<const Rig> fit_bones(const Subject& subject, const Surface& surface,
                                       const std::vector<ClipSource>& clips, bool for_page, bool for_engines,
                                       StageLog& log, WarningLog& warnings) const;
  WrittenModel encode_outputs(const Loop& loop, const std::vector<GaugeSeries>& series,
                              const std::vector<const LoopWriter*>& writers, const LoopWriteOptions& options,
                              double model_error, StageLog& log, Outputs& files) const;
  Json report_of(const Done& done, const StageLog& log) const;
  std::unique_ptr<SceneObjectCommand> take_from_scene(const CLI::App& flags);
  // Where the input is grass, what drifts or painted trees (animate_thing.cpp); false: it is not.
  bool animate_thing(const CLI::App& flags, const std::vector<const LoopWriter*>& writers) const;
  void write_grass(const Scene& scene, const SceneGrass& grass, bool preset, const CLI::App& flags,
                   const std::vector<const LoopWriter*>& writers) const;
  void write_drift(const Scene& scene, const SceneDrift& drift, const CLI::App& flags,
                   const std::vector<const LoopWriter*>& writers) const;
  void write_impression(const Scene& scene, const SceneImpression& impression, const CLI::App& flags,
                        const std::vector<const LoopWriter*>& writers) const;
  // Of what no file but a page holds.
  struct ThingPage {
    std::string html;
    std::string shown;  // of it, in a line
    Json told;          // for the report
  };
  using MakeThingPage = std::function<ThingPage(const ThingSite& site)>;
  void write_page(const Scene& scene, const std::string& name, const FilePlace& place,
                  const std::string& kind, const CLI::App& flags,
                  const std::vector<const LoopWriter*>& writers, const MakeThingPage& make) const;
  Outputs outputs_of(const SceneCommands& commands) const;
  // What was done, where a report is asked for.
  void add_report(Json told, const SceneCommands& commands, const WarningLog& warnings, StageLog& log,
                  Outputs& files) const;
  // Where it is a volume of a scene (animate_volume.cpp); false: it is not, and no output wants one.
  bool animate_volume(const CLI::App& flags) const;
  void write_volume(const Scene& scene, const SceneVolume& volume, const CLI::App& flags) const;
  void write_strands(const Scene& scene, const SceneVolume& volume, const CLI::App& flags) const;
  void run(const CLI::App& flags);
};

// Flags that shape plants, for what is none: all but those of the wind and the `known` are refused.
void refuse_flags_of_plants(const CLI::App& flags, const std::string& name,
                            std::span<const std::string_view> known);

// What a pull was and what came of it, for the report and in a line.
Json describe(const PullTest& test);
std::string told(const PullTest& test);

// Stress at the feet of the branches that bear most, beside what they can bear.
Json stresses(const Motion& motion, const Skeleton& skeleton, const Material& material, double heading);

}  // namespace tremula::cli
