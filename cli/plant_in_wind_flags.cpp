// The flags of a plant in the wind, and which of them have no use together.

#include <algorithm>

#include "plant_in_wind.hpp"
#include "usage.hpp"

namespace tremula::cli {
namespace {

constexpr const char* wind_group = "Wind";

std::vector<std::string> flags_in_group(const CLI::App& command, const char* group,
                                        std::initializer_list<std::string_view> but) {
  std::vector<std::string> flags;
  for (const CLI::Option* option : command.get_options()) {
    const std::string name = option->get_name();
    if (option->get_group() == group && std::find(but.begin(), but.end(), name) == but.end())
      flags.push_back(name);
  }
  return flags;
}

}  // namespace

bool PlantInWind::asks_for_turbulence() const {
  const auto given = [](const CLI::Option* option) { return option->count() > 0; };
  return wind_flags.turbulence_intensity || wind_flags.friction_velocity ||
         std::ranges::any_of(wind_flags.of_turbulence, given);
}

std::string PlantInWind::what_makes_it_a_clip() const {
  return !pull.empty() ? "--pull" : !gust.empty() ? "--gust" : "--from-rest";
}

// A clip with an end goes through time, once.
void PlantInWind::check_clip(const CLI::App& flags) const {
  const std::string with = "given with " + what_makes_it_a_clip();
  const bool by_table = !gust.empty() && !gust.starts_with("1-cosine:");
  const std::initializer_list<std::string_view> of_mean = {
      "--wind",         "--wind-speed",    "--reference-height", "--heading",
      "--terrain",      "--profile",       "--power-exponent",   "--roughness-length",
      "--displacement", "--canopy-height", "--canopy-decay"};
  const IdleFlags rules[] = {
      {pull.empty(), "given without --pull", "--pull PLACE:FORCE", {"--pull-heading"}},
      {!pull.empty(), with, "one of them", {"--gust", "--from-rest"}},
      {is_clip() && dynamics != "time",
       with + ", which goes through time",
       "--dynamics time",
       {"--dynamics"}},
      {(!pull.empty() || !gust.empty()) && wind != "turbulent",
       with + ", which takes the mean of a turbulent wind",
       "--wind turbulent",
       {"--wind"}},
      {!pull.empty(), with + ", in which the mean wind blows alone", "none of it",
       flags_in_group(flags, wind_group, of_mean)},
      {by_table, with + ", which has the speeds", "one of them", {"--wind-speed"}},
      {!gust.empty() && !asks_for_turbulence(),
       with + " without turbulence",
       "--turbulence-intensity with it",
       {"--seed", "--amplitudes"}},
      {is_clip(), with, "a wind without waves", {"--waves"}},
      {is_clip(), with + ", which has no bins to average", "--dynamics modal without it", {"--transfer"}},
      {is_clip(), with + ", whose static shapes belong to it", "a loop", {"--no-static-correction"}},
      {!pull.empty(), with + ", which decays as its modes do", "a loop", {"--drag"}},
      {is_clip() && pull.empty(), with + ", whose drag is quadratic", "a loop", {"--drag"}},
      {is_clip() && pull.empty() && loads.model != "stochastic",
       with + ", whose drag is taken at every instant",
       "--loads stochastic",
       {"--loads"}},
  };
  refuse_idle_flags(flags, rules);
}

void PlantInWind::check(const CLI::App& flags) const {
  const std::string with_wind = "given with --wind " + wind;
  const IdleFlags rules[] = {
      {is_field(), with_wind, "--wind turbulent: a field is taken as it is",
       flags_in_group(flags, wind_group, {"--wind", "--heading"})},
      {is_field(), with_wind, "--wind turbulent: a field has one realisation", {"--transfer"}},
      {is_stam(), with_wind, "--wind turbulent",
       flags_in_group(flags, wind_group,
                      {"--wind", "--wind-speed", "--reference-height", "--heading", "--terrain", "--profile",
                       "--turbulence-intensity", "--friction-velocity", "--power-exponent",
                       "--roughness-length", "--displacement", "--canopy-height", "--canopy-decay", "--seed",
                       "--correlation-time", "--correlation-length"})},
      {!is_stam(),
       with_wind,
       "--wind stam or stam-printed, whose filter it sets",
       {"--correlation-time", "--correlation-length"}},
      {structure.medium != "water", "given with --medium air", "--medium water", {"--waves", "--current"}},
      {waves.empty() && !under_water, "given without --waves", "--waves HEIGHT:PERIOD", {"--water-depth"}},
      {under_water && current && !waves.empty(),
       "given with --current and --waves, which are what it makes",
       "two of them at most",
       {"--wind-speed"}},
      {is_field(), with_wind, "--wind turbulent: a field has a current of its own", {"--current"}},
      {loads.model == "paper",
       "given with --loads paper, which knows no statistics of the flow",
       "--loads stochastic",
       {"--waves"}},
      {dynamics != "modal",
       "given with --dynamics " + dynamics,
       "--dynamics modal, whose bins it averages",
       {"--transfer"}},
      {dynamics == "oscillators",
       "given with --dynamics oscillators",
       "--dynamics modal or time",
       {"--no-static-correction", "--drag", "--modes"}},
      {dynamics != "oscillators",
       "given with --dynamics " + dynamics,
       "--dynamics oscillators",
       {"--oscillator-modes", "--carried-mass"}},
      {mass_damping.has_value(),
       "given with --mass-damping",
       "one of them",
       {"--damping-ratio", "--stiffness-damping", "--decay-time", "--mode-damping"}},
      {stiffness_damping.has_value(),
       "given with --stiffness-damping",
       "one of them",
       {"--damping-ratio", "--decay-time", "--mode-damping"}},
      {decay_time.has_value(),
       "given with --decay-time",
       "one of them",
       {"--damping-ratio", "--mode-damping"}},
      {!mode_damping.empty(), "given with --mode-damping", "one of them", {"--damping-ratio"}},
  };
  refuse_idle_flags(flags, rules);
  check_clip(flags);
  loads.check(flags);
}

void PlantInWind::add_to(CLI::App& command) {
  command.add_option("--modes", mode_count, "How many of the lowest modes move the plant; -1: all")
      ->capture_default_str();

  command
      .add_option(
          "--wind", wind,
          "turbulent: gusts that travel (Shinya & Fournier, or --spectrum); stam: eq. 8 of Stam with unit "
          "variance and a spectrum; stam-printed: eq. 8 as printed, white; or a field FILE.bts (TurbSim)")
      ->capture_default_str()
      ->group(wind_group);
  command.add_option("--wind-model", wind, "The same")->group("");
  wind_flags.add_to(command, true);
  command.add_option("--correlation-time", correlation_time, "t_c of Stam's filter [s]")
      ->default_str("1")
      ->group(wind_group);
  command.add_option("--correlation-length", correlation_length, "d_c of Stam's filter [m]")
      ->default_str("4")
      ->group(wind_group);

  command
      .add_option(
          "--current", current,
          "Speed of the current, in water [m/s]. Kelp, seagrass and algae have --wind-speed for the wind "
          "over the water, which makes waves, and a current of their own and 1 % of the wind's if not given")
      ->group(wind_group);
  command
      .add_option(
          "--waves", waves,
          "Waves over the plant, in water: significant height [m] and peak period [s], as in 0.5:4. They "
          "run where the current goes")
      ->group(wind_group);
  command
      .add_option("--water-depth", water_depth,
                  "Of the water under waves [m]; otherwise that of the plant (kelp, seagrass, algae), or a "
                  "quarter more than its height")
      ->group(wind_group);

  const char* clip = "Clips with a beginning and an end";
  command
      .add_option(
          "--pull", pull,
          "Pulled and let go at t = 0 in still air, or in the mean wind of --wind-speed: a place and a "
          "horizontal force, as in 1.3m:200N (height on the main stem), stem:1.3:200N (metres along it) "
          "or branch:12:0.5:2kN. Says frequency and damping by logarithmic decrement, beside the mode's")
      ->group(clip);
  command
      .add_option("--pull-heading", pull_heading,
                  "Where the pull goes, from +x towards +y [degrees] (default: --heading)")
      ->group(clip);
  command
      .add_option(
          "--gust", gust,
          "What the wind does: a table FILE.csv with columns time_s,speed_m_s and perhaps heading_deg, "
          "linear "
          "between its rows, which is the wind at the reference height; or "
          "1-cosine:AMPLITUDE:DURATION[:START] "
          "[m/s, s, s] on top of --wind-speed. Without turbulence, unless --turbulence-intensity asks for "
          "some")
      ->group(clip);
  command.add_flag("--from-rest", from_rest, "The wind begins at t = 0, on a plant that stands in still air")
      ->group(clip);

  const char* motion = "Motion";
  command.add_option("--period", period, "Length of the loop or clip [s] (with a table as --gust: its own)")
      ->capture_default_str()
      ->group(motion);
  command.add_option("--fps", frames_per_second, "Frames per second [1/s]")
      ->capture_default_str()
      ->group(motion);
  command.add_option("--damping-ratio", damping_ratio, "Of every mode, 1 is critical")
      ->capture_default_str()
      ->group(motion);
  command
      .add_option("--mass-damping", mass_damping, "alpha of C = alpha M (Stam) instead of the ratio [1/s]")
      ->group(motion);
  command
      .add_option("--stiffness-damping", stiffness_damping,
                  "c of c omega^2 (Shinya & Fournier) instead of the ratio [s]")
      ->group(motion);
  command
      .add_option(
          "--decay-time", decay_time,
          "tau_0: the stiffness damping under which the first mode alone falls to 1/e in this time [s]")
      ->group(motion);
  command
      .add_option(
          "--mode-damping", mode_damping,
          "A damping ratio for each mode in turn, 0.03,0.02,0.01; modes behind the last have the last")
      ->delimiter(',')
      ->group(motion);
  command
      .add_flag("--no-aerodynamic-damping", no_aerodynamic_damping,
                "Only the damping of the wood; by default the wind damps what moves in it, too")
      ->group(motion);
  command
      .add_option(
          "--dynamics", dynamics,
          "modal: modes of the plant, synthesised; time: the same, integrated in time until they repeat; "
          "oscillators: every branch a beam of its own, as in Shinya and Fournier 1992; flapping: a sheet "
          "held on "
          "one edge by its threads, the default where it flaps by itself")
      ->check(CLI::IsMember(kinds_of_dynamics))
      ->capture_default_str()
      ->group(motion);
  command.add_option("--oscillator-modes", oscillator_modes, "Of every branch, with --dynamics oscillators")
      ->capture_default_str()
      ->group(motion);
  command
      .add_flag("--carried-mass", carried_mass,
                "A branch swings with the mass of what it carries, with --dynamics oscillators")
      ->group(motion);
  command
      .add_option("--transfer", transfer,
                  "bin-averaged: right variance for every period; sampled: as in the papers")
      ->check(CLI::IsMember({"bin-averaged", "sampled"}))
      ->capture_default_str()
      ->group(motion);
  command
      .add_flag("--no-static-correction", no_static_correction,
                "Leave out the static shapes that stand for the modes beyond --modes")
      ->group(motion);
  loads.add_to(command, motion);
  read.add_to(command);
  structure.add_to(command);
}

}  // namespace tremula::cli
