// A plant in the wind, by flag: what tremula animate writes and every object of a scene is. In parts: its
// flags (plant_in_wind_flags.cpp), what they make blow (plant_weather.cpp), and the cascade from the file of
// the plant to its loop (plant_in_wind.cpp).
#pragma once

#include "tremula/deformation/loop.hpp"
#include "tremula/dynamics/motion_statistics.hpp"
#include "tremula/pipeline.hpp"
#include "tremula/wind/waves.hpp"

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common.hpp"
#include "load_flags.hpp"
#include "wind_flags.hpp"

namespace tremula::cli {

inline const std::map<std::string, Dynamics> kinds_of_dynamics{{"modal", Dynamics::modal},
                                                               {"oscillators", Dynamics::oscillators},
                                                               {"time", Dynamics::time},
                                                               {"flapping", Dynamics::flapping}};

// Said at once, and kept for the report.
struct WarningLog {
  std::vector<std::string> lines;

  void add(const std::vector<std::string>& more);  // of another clip: once
};

// What blows, and how it is described in the report.
struct ChosenWind {
  Wind wind;
  Json described;
};

struct Conditions {
  Weather weather;
  std::optional<Waves> sea = {};
  Json described_wind;
};

// Ready to be baked and moved.
struct PreparedPlant {
  Plant plant;
  Conditions conditions;
  BakeOptions bake;
  int mode_count = 0;  // that move it
  Surface surface;

  bool flaps() const { return conditions.weather.dynamics == Dynamics::flapping; }
};

struct Moved {
  Motion motion;
  MotionStatistics statistics;
};

struct PlantInWind {
  std::string input;
  // Of what is grown, and of the looks of anything: by the file of a scene alone.
  std::optional<std::uint64_t> growth_seed = {};
  std::vector<std::string> constants = {};
  PlantColors colors = {};             // in place of its own
  std::string pull, gust;              // what is let go; what the wind does
  std::optional<double> pull_heading;  // [degrees]
  bool from_rest = false;
  WindFlags wind_flags;
  bool shares_wind = false;  // with all that is in a scene
  double across = 0;         // how far to the left of the wind's heading it stands [m]
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
  ReadFlags read;
  StructureFlags structure;
  std::optional<GustScript> script = {};  // of --gust, once settle() has read it

  bool is_stam() const { return wind == "stam" || wind == "stam-printed"; }
  bool is_field() const { return lower_extension(wind) == ".bts"; }
  std::string what_makes_it_a_clip() const;  // the flag
  bool is_damped_by_ratio() const {
    return !mass_damping && !stiffness_damping && !decay_time && mode_damping.empty();
  }
  bool is_clip() const { return !pull.empty() || !gust.empty() || from_rest; }
  bool poses_superpose() const { return loads.pose == "linear" || loads.model == "paper"; }

  // plant_in_wind_flags.cpp. All flags but that of the input.
  void add_to(CLI::App& command);
  bool asks_for_turbulence() const;

  // plant_weather.cpp
  // Takes what the plant and the files of the wind say of themselves, once: where it lives, how long a clip
  // is. Throws as check() does, and for those files.
  void settle(const CLI::App& flags);
  // The same plant where the wind has another speed [m/s] or goes elsewhere.
  PlantInWind in_wind_of(double wind_speed) const;
  PlantInWind turned_by(double degrees) const;
  Conditions conditions() const;
  std::vector<Place> input_places() const;

  // plant_in_wind.cpp
  Plant open() const;  // as it stands, in its colours
  PreparedPlant prepare(const CLI::App& flags, Conditions conditions, StageLog& log,
                        WarningLog& warnings) const;
  Subject bake(const PreparedPlant& prepared, const Progress& progress, WarningLog& warnings) const;
  // Takes the shapes of the modes and leaves the rest of the subject. `superposed`: whether displacements
  // will be (Advice).
  Moved move(Subject& subject, const Weather& weather, bool superposed, const Progress& progress,
             StageLog& log, WarningLog& warnings) const;
  // The same baked plant in the wind of these flags, `first` being that of others that differ from them in
  // speed or heading alone.
  Motion move_again(const PreparedPlant& first, const Subject& subject, bool superposed,
                    const Progress& progress, StageLog& log, WarningLog& warnings) const;
  LoopFacts loop_facts(const Plant& plant, const ReferenceWind& reference) const;
  Poses poses_of(const Plant& plant) const;

 private:
  // Throws InputError for flags that would have no effect beside others.
  void check(const CLI::App& flags) const;
  void settle_in(const Habitat& habitat, const CLI::App& flags);
  void read_gust(const CLI::App& flags);
  double current_under(double wind_speed) const;
  WindFlags flags_of_wind() const;
  ChosenWind chosen_wind() const;
  StamWind stam_wind() const;
  std::optional<Waves> chosen_waves() const;
  Weather weather(const Wind& blowing) const;
  void check_clip(const CLI::App& flags) const;
  Plant read_plant(StageLog& log) const;
  int modes_of(const Plant& plant, WarningLog& warnings) const;
  // How it moves where nobody says: a flag by its threads.
  Dynamics dynamics_of(const CLI::App& flags, const Plant& plant, const Wind& blowing) const;
  void refuse_of_modes(const CLI::App& flags) const;
  Subject bake_sheet(Sheet sheet, BakeOptions options, const Weather& conditions, const Progress& progress,
                     WarningLog& warnings) const;
};

// The height above the ground of what stands highest [m].
double height_of(const Structure& structure);

}  // namespace tremula::cli
