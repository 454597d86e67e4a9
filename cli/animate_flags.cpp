// The flags of tremula animate, and which of them have no use together.

#include "tremula/io/html.hpp"

#include <algorithm>
#include <map>
#include <memory>

#include "animate.hpp"
#include "commands.hpp"
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

// A clip with an end goes through time, once.
void AnimateCommand::check_clip_flags(const CLI::App& flags) const {
  const std::string what = !pull.empty() ? "--pull" : !gust.empty() ? "--gust" : "--from-rest";
  const std::string with = "given with " + what;
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
      {is_clip(), with, "one clip: it is one already", {"--clip"}},
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

void AnimateCommand::check_flags(const CLI::App& flags, const std::vector<const LoopWriter*>& writers) const {
  const auto writes = [&](std::string_view name) {
    return std::any_of(writers.begin(), writers.end(),
                       [&](const LoopWriter* each) { return each->extension == name; });
  };
  const bool table = writes("csv"), model = writes("glb"), skin = model || writes("html");
  const std::string with_wind = "given with --wind " + wind;
  const IdleFlags rules[] = {
      {writers.empty(), "given without -o", "an output that it shapes", {"--format"}},
      {!table, "given without a table of poses", "-o FILE.csv", {"--frames"}},
      {!table && report.empty(),
       "given without a table or a report",
       "-o FILE.csv or --report FILE.json",
       {"--gauge"}},
      {!model, "given without a .glb", "-o FILE.glb", {"--morphs", "--compress"}},
      {!skin,
       "given without a .glb or a page",
       "-o FILE.glb or FILE.html",
       {"--form", "--tolerance", "--max-joints", "--clip"}},
      {clip_texts.empty(), "given without --clip", "--clip NAME:SPEED", {"--mean-only"}},
      {!clip_texts.empty(), "given with --clip, which has a wind speed", "one of them", {"--wind-speed"}},
      {!clip_texts.empty(), "given with --clip, which bends bones", "one of them", {"--morphs"}},
      {is_field(), with_wind, "--wind turbulent: a field has a speed of its own", {"--clip"}},
      {form == "skin", "given with --form skin", "--form morph, whose targets it shapes", {"--morphs"}},
      {form == "morph",
       "given with --form morph",
       "--form skin, whose joints it counts",
       {"--max-joints", "--tolerance", "--clip"}},
      {form.empty() && flags.count("--morphs") > 0,
       "given with --morphs",
       "one of them",
       {"--max-joints", "--tolerance"}},
      {loads.pose == "linear" || loads.model == "paper",
       "given where displacements superpose (--pose linear, --loads paper)",
       "--pose bent: joints only turn",
       {"--max-joints", "--tolerance", "--clip"}},
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
  check_clip_flags(flags);
  loads.check(flags);
  for (std::size_t i = 0; i < writers.size() && !clip_texts.empty(); ++i) {
    if (writers[i]->extension != "glb" && writers[i]->extension != "html")
      throw InputError("-o " + outputs[i], "given with --clip", "a .glb or .html: no other output has clips");
  }
}

// Bones for all that bends, unless somebody asks for targets.
bool AnimateCommand::on_bones(const CLI::App& flags, const Plant& plant) const {
  if (form == "morph" || flags.count("--morphs") > 0) return false;
  if (plant.is_tree() && loads.pose == "bent" && loads.model != "paper") return true;
  for (const char* flag : {"--clip", "--max-joints", "--tolerance", "--form"}) {
    if (flags.count(flag) == 0) continue;
    throw InputError(form == "skin" ? "--form skin" : flag,
                     plant.is_tree() ? "given with linear poses" : "given with " + std::string(plant.kind()),
                     "--form morph, or a tree with --pose bent");
  }
  return false;
}

void add_animate(CLI::App& app) {
  auto command = std::make_shared<AnimateCommand>();
  CLI::App& sub = *app.add_subcommand("animate", "A plant in the wind, as a loop that closes exactly");
  sub.add_option(
         "INPUT", command->input,
         "A tree file (SWC, TreeQSM .mat or text, SimpleForest CSV), an L-system (.lsys), a frame or "
         "a sheet (.toml), or a preset: a plant, on land or in water, or flag, banner, curtain, sail, sign")
      ->required();
  sub.add_option(
      "-o,--output", command->outputs,
      "What to write, by extension: .glb (Blender, engines), .html (plays in a browser), .csv (node poses "
      "per frame), .png (contact sheet); - is standard output; may be repeated");
  sub.add_option("--format", command->format,
                 "glb, html, csv or png, for an output whose name does not say it (-o -)")
      ->check(CLI::IsMember({"glb", "html", "csv", "png"}));
  sub.add_option("--report", command->report,
                 "What was done, as JSON: settings, frequencies, seconds and memory");
  sub.add_option(
         "--gauge", command->gauges,
         "Where to read bending moment, shear, axial force, torsion and strain: base, stem:1.3 (metres along "
         "the stem) or branch:12:0.5; may be repeated. Into the .csv instead of poses, and into the report")
      ->take_all();
  sub.add_option("--frames", command->frames, "Frames for .csv: 17 or 10-20 (all)");
  sub.add_option("--form", command->form,
                 "Of .glb and .html. skin: bones, which bend; morph: targets, which stretch what sways far "
                 "(skin; morph for "
                 "frames, linear poses and with --morphs)")
      ->check(CLI::IsMember({"skin", "morph"}))
      ->group(bones_group);
  sub.add_option(
         "--tolerance", command->tolerance,
         "How far the skin of .glb and .html may be off the poses, as a part of the height of the plant")
      ->capture_default_str()
      ->group(bones_group);
  sub.add_option("--clip", command->clip_texts,
                 "A wind of its own in .glb and .html, by name and speed [m/s]: calm:2; may be repeated. All "
                 "have the "
                 "same joints, period and gusts, so that an engine can fade from one to another")
      ->take_all()
      ->group(bones_group);
  sub.add_flag("--mean-only", command->mean_only,
               "Clips are the lean in the mean wind alone, for an engine that adds the gusts")
      ->group(bones_group);
  sub.add_option("--max-joints", command->max_joints,
                 "At most so many bones, whatever error that costs (what --tolerance takes)")
      ->group(bones_group);
  sub.add_option(
         "--morphs", command->morphs,
         "Targets in .glb. biased: one a mode, weights 0 to 1 (plays everywhere); paired: a plus and a minus "
         "target a mode; signed: one a mode, weights of either sign, which Blender clamps")
      ->check(CLI::IsMember(morph_forms))
      ->capture_default_str();
  sub.add_option(
         "--compress", command->compression,
         "Of .glb. quantised: 16 and 8 bits (Blender, three.js); meshopt: those packed to a fifth (three.js, "
         "not Blender 3.4); none: floats, for Godot and whatever knows no extensions")
      ->check(CLI::IsMember(compressions))
      ->capture_default_str();
  sub.add_option("--modes", command->mode_count, "How many of the lowest modes move the plant; -1: all")
      ->capture_default_str();

  const char* wind = wind_group;
  sub.add_option(
         "--wind", command->wind,
         "turbulent: gusts that travel (Shinya & Fournier, or --spectrum); stam: eq. 8 of Stam with unit "
         "variance and a spectrum; stam-printed: eq. 8 as printed, white; or a field FILE.bts (TurbSim)")
      ->capture_default_str()
      ->group(wind);
  sub.add_option("--wind-model", command->wind, "The same")->group("");
  command->wind_flags.add_to(sub, true);
  sub.add_option("--correlation-time", command->correlation_time, "t_c of Stam's filter [s]")
      ->default_str("1")
      ->group(wind);
  sub.add_option("--correlation-length", command->correlation_length, "d_c of Stam's filter [m]")
      ->default_str("4")
      ->group(wind);

  sub.add_option(
         "--current", command->current,
         "Speed of the current, in water [m/s]. Kelp, seagrass and algae have --wind-speed for the wind "
         "over the water, which makes waves, and a current of their own and 1 % of the wind's if not given")
      ->group(wind);
  sub.add_option(
         "--waves", command->waves,
         "Waves over the plant, in water: significant height [m] and peak period [s], as in 0.5:4. They "
         "run where the current goes")
      ->group(wind);
  sub.add_option("--water-depth", command->water_depth,
                 "Of the water under waves [m]; otherwise that of the plant (kelp, seagrass, algae), or a "
                 "quarter more than its height")
      ->group(wind);

  const char* clip = "Clips with a beginning and an end";
  sub.add_option(
         "--pull", command->pull,
         "Pulled and let go at t = 0 in still air, or in the mean wind of --wind-speed: a place and a "
         "horizontal force, as in 1.3m:200N (height on the main stem), stem:1.3:200N (metres along it) "
         "or branch:12:0.5:2kN. Says frequency and damping by logarithmic decrement, beside the mode's")
      ->group(clip);
  sub.add_option("--pull-heading", command->pull_heading,
                 "Where the pull goes, from +x towards +y [degrees] (default: --heading)")
      ->group(clip);
  sub.add_option(
         "--gust", command->gust,
         "What the wind does: a table FILE.csv with columns time_s,speed_m_s and perhaps heading_deg, linear "
         "between its rows, which is the wind at the reference height; or "
         "1-cosine:AMPLITUDE:DURATION[:START] "
         "[m/s, s, s] on top of --wind-speed. Without turbulence, unless --turbulence-intensity asks for "
         "some")
      ->group(clip);
  sub.add_flag("--from-rest", command->from_rest,
               "The wind begins at t = 0, on a plant that stands in still air")
      ->group(clip);

  const char* motion = "Motion";
  sub.add_option("--period", command->period,
                 "Length of the loop or clip [s] (with a table as --gust: its own)")
      ->capture_default_str()
      ->group(motion);
  sub.add_option("--fps", command->frames_per_second, "Frames per second [1/s]")
      ->capture_default_str()
      ->group(motion);
  sub.add_option("--damping-ratio", command->damping_ratio, "Of every mode, 1 is critical")
      ->capture_default_str()
      ->group(motion);
  sub.add_option("--mass-damping", command->mass_damping,
                 "alpha of C = alpha M (Stam) instead of the ratio [1/s]")
      ->group(motion);
  sub.add_option("--stiffness-damping", command->stiffness_damping,
                 "c of c omega^2 (Shinya & Fournier) instead of the ratio [s]")
      ->group(motion);
  sub.add_option(
         "--decay-time", command->decay_time,
         "tau_0: the stiffness damping under which the first mode alone falls to 1/e in this time [s]")
      ->group(motion);
  sub.add_option("--mode-damping", command->mode_damping,
                 "A damping ratio for each mode in turn, 0.03,0.02,0.01; modes behind the last have the last")
      ->delimiter(',')
      ->group(motion);
  sub.add_flag("--no-aerodynamic-damping", command->no_aerodynamic_damping,
               "Only the damping of the wood; by default the wind damps what moves in it, too")
      ->group(motion);
  sub.add_option(
         "--dynamics", command->dynamics,
         "modal: modes of the plant, synthesised; time: the same, integrated in time until they repeat; "
         "oscillators: every branch a beam of its own, as in Shinya and Fournier 1992; flapping: a sheet "
         "held on "
         "one edge by its threads, the default where it flaps by itself")
      ->check(CLI::IsMember(kinds_of_dynamics))
      ->capture_default_str()
      ->group(motion);
  sub.add_option("--oscillator-modes", command->oscillator_modes,
                 "Of every branch, with --dynamics oscillators")
      ->capture_default_str()
      ->group(motion);
  sub.add_flag("--carried-mass", command->carried_mass,
               "A branch swings with the mass of what it carries, with --dynamics oscillators")
      ->group(motion);
  sub.add_option("--transfer", command->transfer,
                 "bin-averaged: right variance for every period; sampled: as in the papers")
      ->check(CLI::IsMember({"bin-averaged", "sampled"}))
      ->capture_default_str()
      ->group(motion);
  sub.add_flag("--no-static-correction", command->no_static_correction,
               "Leave out the static shapes that stand for the modes beyond --modes")
      ->group(motion);
  command->loads.add_to(sub, motion);
  command->read.add_to(sub);
  command->structure.add_to(sub);
  command->threads.add_to(sub);
  sub.footer(
      "Examples:\n"
      "  tremula animate tree.swc -o tree.glb\n"
      "  tremula animate oak -o oak.html -o oak.png --wind-speed 8 --terrain parkland --seed 3\n"
      "  tremula animate oak -o oak.glb --wind measured.bts --period 60\n"
      "  tremula animate flag --wind-speed 8 -o flag.glb\n"
      "  tremula animate kelp --wind-speed 8 -o kelp.glb\n"
      "  tremula animate seagrass --current 0.3 --waves 0.4:4 -o seagrass.html\n"
      "  tremula animate willow --medium water --current 0.2 --waves 0.6:5 -o willow.html\n"
      "  tremula animate oak --pull 1.3m:2kN -o pull.html --report pull.json\n"
      "  tremula animate sapling --wind-speed 3 --gust 1-cosine:8:2.5:1 --period 10 -o gust.glb\n"
      "  tremula animate oak --gust squall.csv --from-rest --turbulence-intensity 0.15 -o squall.html\n"
      "  tremula animate oak --clip calm:2 --clip gale:16 --compress meshopt -o oak.glb\n"
      "  tremula animate scan.mat -o tree.glb -o pose.csv --wind-speed 6 --period 20 --report report.json\n");
  sub.callback([command, &sub] {
    command->settle_in(habitat_of(command->input), sub);
    command->threads.run([&] { command->run(sub); });
  });
}

}  // namespace tremula::cli
