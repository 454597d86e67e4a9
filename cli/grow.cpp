// tremula grow: a plant from an L-system.

#include "tremula/base/error.hpp"
#include "tremula/geometry/plants.hpp"

#include <array>
#include <iostream>

#include "commands.hpp"
#include "common.hpp"
#include "usage.hpp"

namespace tremula::cli {
namespace {

struct GrowCommand {
  std::string input, output;
  std::optional<std::uint64_t> seed;
  std::vector<std::string> constants;
  ReadFlags read;
  bool list = false;

  void run(const CLI::App& flags) const {
    refuse_idle_flags(flags,
                      std::array{IdleFlags{list,
                                           "given with --list",
                                           "no other flag",
                                           {"--output", "--seed", "--set", "--unit", "--allow-gaps"}}});
    if (list) {
      std::string text;
      for (const PlantPreset& preset : plant_presets()) {
        text += std::string(preset.name) +
                std::string(preset.name.size() < 14 ? 14 - preset.name.size() : 1, ' ') +
                std::string(preset.description) + '\n';
      }
      print(text);
      return;
    }
    if (input.empty())
      throw InputError("grow", "no plant", "a preset (tremula grow --list) or an L-system file");
    if (output.empty()) throw InputError("grow", "no output", "-o FILE.swc");
    format_of({"-o", output}, "", {{"swc", "a tree"}}, 0);
    Outputs outputs({{"-o", output}}, {{"PRESET|FILE", input}});
    const Plant plant = open_plant(input, read, seed, constants);
    need_tree(plant, "grow " + input);
    print_warnings(plant);
    outputs.add(output, encode_swc(plant.imported.skeleton, plant.imported.colors));
    outputs.commit();
    if (output == "-") return;
    const Skeleton& skeleton = plant.imported.skeleton;
    // A tree file does not say where the plant lives.
    const Habitat habitat = habitat_of(input);
    std::string lives = habitat.in_water ? " --medium water --current 0.15" : "";
    if (habitat.drawn_unloaded) lives.append(" --shape unloaded");
    if (!habitat.material.empty()) lives.append(" --material ").append(habitat.material);
    std::cerr << "tremula: " << output << ": " << skeleton.branch_count() << " branches, "
              << skeleton.leaves.size() << " leaves; next: tremula animate " << output << lives << " -o "
              << plant.name << ".html\n";
  }
};

}  // namespace

void add_grow(CLI::App& app) {
  auto command = std::make_shared<GrowCommand>();
  CLI::App& sub = *app.add_subcommand("grow", "Grow a plant from a preset or an L-system file");
  sub.add_option("PRESET|FILE", command->input,
                 "Name of a preset, an L-system (.lsys), or a tree file to write as SWC");
  sub.add_option("-o,--output", command->output, "The tree to write (.swc; - is standard output)");
  sub.add_option("--seed", command->seed, "Another seed gives another plant of the same kind (0 or more)");
  sub.add_option("--set", command->constants,
                 "NAME=NUMBER: change a constant of the L-system; may be repeated");
  sub.add_flag("--list", command->list, "List the presets");
  command->read.add_to(sub);
  sub.footer(
      "Examples:\n"
      "  tremula grow --list\n"
      "  tremula grow oak -o oak.swc --seed 7\n"
      "  tremula grow my_plant.lsys -o plant.swc --set nodes=20\n");
  sub.callback([command, &sub] { command->run(sub); });
}

}  // namespace tremula::cli
