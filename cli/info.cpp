// tremula info: what is in a file, in numbers.

#include <cstdio>
#include <iostream>

#include "commands.hpp"
#include "common.hpp"

namespace tremula::cli {
namespace {

struct InfoCommand {
  std::string input, format = "table";

  void run() const {
    const Plant plant = open_plant(input);
    const Json json = describe(plant);
    if (format == "json") {
      std::cout << json.dump(1) << '\n';
      return;
    }
    for (const auto& [key, value] : json.items()) {
      if (key == "repairs") continue;
      std::cout << key << std::string(key.size() < 16 ? 16 - key.size() : 1, ' ')
                << (value.is_string() ? value.get<std::string>() : value.dump()) << '\n';
    }
    for (const Repair& repair : plant.imported.repairs)
      std::cout << "repaired        " << repair.message << '\n';
  }
};

}  // namespace

void add_info(CLI::App& app) {
  auto command = std::make_shared<InfoCommand>();
  CLI::App& sub = *app.add_subcommand("info", "What is in a file: counts, extents, repairs");
  sub.add_option("FILE", command->input, "A tree file, an L-system (.lsys) or the name of a preset")
      ->required();
  sub.add_option("--format", command->format, "table or json")
      ->check(CLI::IsMember({"table", "json"}))
      ->capture_default_str();
  sub.footer("Examples:\n  tremula info scan.mat\n  tremula info oak --format json\n");
  sub.callback([command] { command->run(); });
}

}  // namespace tremula::cli
