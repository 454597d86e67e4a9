// The flags of tremula animate beside those of the plant, and which of them have no use together.

#include "tremula/io/html.hpp"

#include <algorithm>
#include <memory>

#include "animate.hpp"
#include "commands.hpp"
#include "usage.hpp"

namespace tremula::cli {

void AnimateCommand::check_flags(const CLI::App& flags, const std::vector<const LoopWriter*>& writers) const {
  const auto writes = [&](std::string_view name) {
    return std::any_of(writers.begin(), writers.end(),
                       [&](const LoopWriter* each) { return each->extension == name; });
  };
  const bool table = writes("csv"), model = writes("glb"), skin = model || writes("html");
  const IdleFlags rules[] = {
      {writers.empty(), "given without -o", "an output that it shapes", {"--format"}},
      {!table, "given without a table of poses", "-o FILE.csv", {"--frames"}},
      {true,
       "given without a volume",
       "-o rice/%04d.vdb and an object of the [[volumes]] of a scene",
       {"--texel-size", "--resume"}},
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
      {plant.is_field(),
       "given with --wind " + plant.wind,
       "--wind turbulent: a field has a speed of its own",
       {"--clip"}},
      {plant.is_clip(),
       "given with " + plant.what_makes_it_a_clip(),
       "one clip: it is one already",
       {"--clip"}},
      {form == "skin", "given with --form skin", "--form morph, whose targets it shapes", {"--morphs"}},
      {form == "morph",
       "given with --form morph",
       "--form skin, whose joints it counts",
       {"--max-joints", "--tolerance", "--clip"}},
      {form.empty() && flags.count("--morphs") > 0,
       "given with --morphs",
       "one of them",
       {"--max-joints", "--tolerance"}},
      {plant.poses_superpose(),
       "given where displacements superpose (--pose linear, --loads paper)",
       "--pose bent: joints only turn",
       {"--max-joints", "--tolerance", "--clip"}},
  };
  refuse_idle_flags(flags, rules);
  for (std::size_t i = 0; i < writers.size() && !clip_texts.empty(); ++i) {
    if (writers[i]->extension != "glb" && writers[i]->extension != "html")
      throw InputError("-o " + outputs[i], "given with --clip", "a .glb or .html: no other output has clips");
  }
}

// Bones for all that bends, unless somebody asks for targets.
bool AnimateCommand::on_bones(const CLI::App& flags, const Plant& read) const {
  if (form == "morph" || flags.count("--morphs") > 0) return false;
  if (read.is_tree() && !plant.poses_superpose()) return true;
  for (const char* flag : {"--clip", "--max-joints", "--tolerance", "--form"}) {
    if (flags.count(flag) == 0) continue;
    throw InputError(form == "skin" ? "--form skin" : flag,
                     read.is_tree() ? "given with linear poses" : "given with " + std::string(read.kind()),
                     "--form morph, or a tree with --pose bent");
  }
  return false;
}

void add_animate(CLI::App& app) {
  auto command = std::make_shared<AnimateCommand>();
  CLI::App& sub = *app.add_subcommand("animate", "A plant in the wind, as a loop that closes exactly");
  sub.add_option("INPUT", command->plant.input,
                 "A tree file (SWC, TreeQSM .mat or text, SimpleForest CSV), an L-system (.lsys), a frame, "
                 "a sheet or a scene (.toml), or a preset: a plant, on land or in water, or flag, banner, "
                 "curtain, sail, sign")
      ->required();
  sub.add_option("--object", command->object,
                 "What of a scene, by name: an object, grass, what drifts, painted trees or a volume (the "
                 "only object, or the only thing)");
  sub.add_option(
      "-o,--output", command->outputs,
      "What to write, by extension: .glb (Blender, engines), .html (plays in a browser), .csv (node poses "
      "per frame), .png (contact sheet); - is standard output; may be repeated. Of what drifts in a scene "
      "and of painted trees .html alone; of a volume .html, or .vdb (OpenVDB): rice/%04d.vdb is a file for "
      "every frame");
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
  sub.add_option("--frames", command->frames,
                 "Frames for .csv and .vdb: 17, 10-20, or 0-90:10 for every tenth (all)");
  sub.add_option("--texel-size", command->texel_size,
                 "Edge of a texel of .vdb [m] (that of the texture; larger where the field is large)")
      ->group("Volumes");
  sub.add_flag("--resume", command->resume, "Leave files of frames that are there as they are")
      ->group("Volumes");
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
  command->plant.add_to(sub);
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
      "  tremula animate field.toml --object rice -o rice/%04d.vdb --texel-size 0.03\n"
      "  tremula animate field.toml --object snow -o snow.html\n"
      "  tremula animate scan.mat -o tree.glb -o pose.csv --wind-speed 6 --period 20 --report report.json\n");
  sub.callback([command, &sub] { command->threads.run([&] { command->run(sub); }); });
}

}  // namespace tremula::cli
