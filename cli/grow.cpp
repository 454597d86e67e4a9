// tremula grow: a plant from an L-system.

#include "tremula/base/error.hpp"
#include "tremula/geometry/plants.hpp"

#include <iostream>

#include "commands.hpp"
#include "common.hpp"

namespace tremula::cli {
namespace {

struct GrowCommand {
  std::string input, output;
  std::optional<std::uint64_t> seed;
  std::vector<std::string> constants;
  ReadFlags read;
  bool list = false;

  void run() const {
    if (list) {
      for (const PlantPreset& preset : plant_presets()) {
        std::cout << preset.name << std::string(preset.name.size() < 14 ? 14 - preset.name.size() : 1, ' ')
                  << preset.description << '\n';
      }
      return;
    }
    if (input.empty())
      throw InputError("grow", "no plant", "a preset (tremula grow --list) or an L-system file");
    if (output.empty()) throw InputError("grow", "no output", "-o FILE.swc");
    if (lower_extension(output) != ".swc")
      throw InputError("-o " + output, "'" + lower_extension(output) + "'", ".swc");
    const Plant plant = open_plant(input, read, seed, constants);
    print_warnings(plant);
    write_swc(plant.imported.skeleton, output, plant.imported.colors);
    const Skeleton& skeleton = plant.imported.skeleton;
    std::cerr << "tremula: " << output << ": " << skeleton.branch_count() << " branches, "
              << skeleton.leaves.size() << " leaves; next: tremula animate " << output << " -o " << plant.name
              << ".html\n";
  }
};

}  // namespace

void add_grow(CLI::App& app) {
  auto command = std::make_shared<GrowCommand>();
  CLI::App& sub = *app.add_subcommand("grow", "Grow a plant from a preset or an L-system file");
  sub.add_option("PRESET|FILE", command->input,
                 "Name of a preset, an L-system (.lsys), or a tree file to write as SWC");
  sub.add_option("-o,--output", command->output, "The tree to write (.swc)");
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
  sub.callback([command] { command->run(); });
}

}  // namespace tremula::cli
