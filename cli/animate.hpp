// tremula animate, in parts: its flags (animate_flags.cpp), the run (animate.cpp), what is told of it
// (animate_report.cpp).
#pragma once

#include "tremula/deformation/fit_rig.hpp"
#include "tremula/deformation/loop.hpp"
#include "tremula/dynamics/gauge.hpp"
#include "tremula/dynamics/motion_statistics.hpp"
#include "tremula/io/loop_writers.hpp"
#include "tremula/pipeline.hpp"
#include "tremula/wind/waves.hpp"

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "clips.hpp"
#include "common.hpp"
#include "load_flags.hpp"
#include "wind_flags.hpp"

namespace tremula::cli {

inline const std::map<std::string, MorphForm> morph_forms{
    {"biased", MorphForm::biased}, {"paired", MorphForm::paired}, {"signed", MorphForm::signed_weights}};
inline const std::map<std::string, Dynamics> kinds_of_dynamics{{"modal", Dynamics::modal},
                                                               {"oscillators", Dynamics::oscillators},
                                                               {"time", Dynamics::time},
                                                               {"flapping", Dynamics::flapping}};
inline const std::map<std::string, MeshCompression> compressions{{"none", MeshCompression::none},
                                                                 {"quantised", MeshCompression::quantised},
                                                                 {"meshopt", MeshCompression::meshopt}};

// What blows, and how it is described in the report.
struct ChosenWind {
  Wind wind;
  Json described;
};

// Said at once, and kept for the report.
struct WarningLog {
  std::vector<std::string> lines;

  void add(const std::vector<std::string>& more);  // of another clip: once
};

// A .glb as it was written.
struct WrittenModel {
  std::string form;
  std::size_t joints = 0, clips = 0, keys = 0;
  double largest_error = 0;  // [m]
  std::size_t bytes = 0;
};

// What a run works with and makes, for the report.
struct Done {
  const Plant& plant;
  const StructureOptions& structure;
  const Json& wind_settings;
  const std::optional<Waves>& sea;
  const Weather& conditions;
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

struct Moved {
  Motion motion;
  MotionStatistics statistics;
};

struct AnimateCommand {
  std::string input, report, format;
  std::vector<std::string> outputs, clip_texts;
  bool mean_only = false;
  std::string pull, gust;              // what is let go; what the wind does
  std::optional<double> pull_heading;  // [degrees]
  bool from_rest = false;
  WindFlags wind_flags;
  std::string wind = "turbulent", transfer = "bin-averaged";
  std::string waves;                                           // significant height and peak period
  std::optional<double> water_depth, current;                  // [m, m/s]
  std::optional<Habitat> under_water = {};                     // of a plant that lives there, and is
  double wind_over_water = 0;                                  // [m/s]
  std::optional<double> correlation_time, correlation_length;  // of StamWind
  double period = 20, frames_per_second = 30, damping_ratio = 0.05;
  std::optional<double> mass_damping, stiffness_damping, decay_time;
  std::vector<double> mode_damping;
  LoadFlags loads;
  bool no_aerodynamic_damping = false, no_static_correction = false;
  std::string dynamics = "modal";
  int oscillator_modes = 1;
  bool carried_mass = false;
  int mode_count = 20;
  std::vector<std::string> gauges;
  std::string frames, form, morphs = "biased", compression = "quantised";
  double tolerance = 0.005;  // of the height
  std::optional<int> max_joints;
  ReadFlags read;
  StructureFlags structure;
  ThreadsFlag threads;

  bool is_stam() const { return wind == "stam" || wind == "stam-printed"; }
  bool is_damped_by_ratio() const {
    return !mass_damping && !stiffness_damping && !decay_time && mode_damping.empty();
  }
  bool is_clip() const { return !pull.empty() || !gust.empty() || from_rest; }
  bool is_field() const { return lower_extension(wind) == ".bts"; }
  void settle_in(const Habitat& habitat, const CLI::App& flags);
  double current_under(double wind_speed) const;
  std::optional<GustScript> script = {};  // of --gust, once run() has read it

  bool asks_for_turbulence() const;
  void read_gust(const CLI::App& flags);
  WindFlags flags_of_wind() const;
  ChosenWind chosen_wind() const;
  ChosenWind wind_of(const NamedWind& clip) const;
  StamWind stam_wind() const;
  std::optional<Waves> chosen_waves(double wind_speed) const;
  Weather weather(const Wind& blowing) const;
  std::vector<int> picked_frames(int sample_count) const;
  std::vector<const LoopWriter*> output_writers() const;
  void check_flags(const CLI::App& flags, const std::vector<const LoopWriter*>& writers) const;
  void check_clip_flags(const CLI::App& flags) const;
  std::vector<Place> output_places() const;
  Plant read_plant(StageLog& log) const;
  int modes_of(const Plant& plant, WarningLog& warnings) const;
  // How it moves where nobody says: a flag by its threads.
  Dynamics dynamics_of(const CLI::App& flags, const Plant& plant, const Wind& blowing) const;
  void refuse_of_modes(const CLI::App& flags) const;
  Subject bake_plant(const Plant& plant, BakeOptions options, const Weather& conditions,
                     const Progress& progress, WarningLog& warnings) const;
  Subject bake_sheet(Sheet sheet, BakeOptions options, const Weather& conditions, const Progress& progress,
                     WarningLog& warnings) const;
  LoopFacts loop_facts(const Plant& plant, const ReferenceWind& reference) const;
  std::vector<Gauge> placed_gauges(const Plant& plant) const;
  std::vector<Motion> move_in_others(const Subject& subject, const Weather& first,
                                     const std::vector<NamedWind>& clips, const std::optional<Waves>& sea,
                                     const Progress& progress, StageLog& log, WarningLog& warnings) const;
  bool on_bones(const CLI::App& flags, const Plant& plant) const;
  RigOptions rig_options(const Subject& subject) const;
  std::shared_ptr<const Rig> fit_bones(const Subject& subject, const Surface& surface,
                                       const std::vector<ClipSource>& clips, bool for_page, bool for_engines,
                                       StageLog& log, WarningLog& warnings) const;
  WrittenModel encode_outputs(const Loop& loop, const std::vector<GaugeSeries>& series,
                              const std::vector<const LoopWriter*>& writers, const LoopWriteOptions& options,
                              double model_error, StageLog& log, Outputs& files) const;
  Json report_of(const Done& done, const StageLog& log) const;
  void run(const CLI::App& flags);
};

// What a pull was and what came of it, for the report and in a line.
Json describe(const PullTest& test);
std::string told(const PullTest& test);

// Stress at the feet of the branches that bear most, beside what they can bear.
Json stresses(const Motion& motion, const Skeleton& skeleton, const Material& material, double heading);

}  // namespace tremula::cli
