// tremula check: is this scene right?

#include "tremula/base/error.hpp"

#include <memory>
#include <string>
#include <vector>

#include "commands.hpp"
#include "scene_objects.hpp"
#include "usage.hpp"

namespace tremula::cli {
namespace {

struct CheckCommand {
  std::string input;
  bool keys = false;

  // All but the growing, moving and drawing.
  void run() const {
    if (keys) {
      if (!input.empty()) throw InputError("--keys", "given with " + input, "one of them");
      return print(scene_reference(scene_vocabulary().settings));
    }
    if (input.empty()) throw InputError("check", "no scene", "a file such as scene.toml");
    const Scene scene = read_scene(input, scene_vocabulary());
    const CLI::App no_flags;
    const SceneCommands commands = commands_of(scene, CLI::App());
    const std::vector<std::vector<Instance>> copies = copies_of(scene, commands);
    std::string text = input + ":\n";
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
      const SceneObjectCommand& object = *commands.objects[i];
      const Plant plant = object.at_place([&] {
        object.plant().structure.options();
        return object.plant().open();
      });
      text += "  " + scene.objects[i].name + ": " + plant.kind() + " from " + scene.objects[i].source +
              printed(", %zu cop%s\n", copies[i].size(), copies[i].size() == 1 ? "y" : "ies");
    }
    const auto add = [&](const auto& things, const std::string& table, const auto& kind) {
      for (const auto& thing : things)
        text += "  " + thing.name + ": " + kind(thing) + " of [[" + table + "]]\n";
    };
    add(scene.grass, "grass", [](const SceneGrass& one) { return one.species; });
    add(scene.drift, "drift", [](const SceneDrift& one) { return one.kind; });
    add(scene.impressions, "impressions", [](const SceneImpression& one) { return one.shape; });
    add(scene.volumes, "volumes", [](const SceneVolume& one) { return one.species; });
    text += printed("  wind %.3g m/s towards %.3g degrees; %d frames of %.4g s\n", commands.wind.speed,
                    commands.wind.heading, commands.loop.sample_count, commands.loop.period);
    print(text);
  }
};

}  // namespace

void add_check(CLI::App& app) {
  auto command = std::make_shared<CheckCommand>();
  CLI::App& sub = *app.add_subcommand("check", "Is this scene file right, and what is in it");
  sub.add_option("SCENE", command->input, "A scene (.toml)");
  sub.add_flag("--keys", command->keys,
               "Every key that a scene may have, with unit, default and meaning (Markdown)");
  sub.footer(
      "Examples:\n"
      "  tremula check scene.toml\n"
      "  tremula check --keys\n");
  sub.callback([command] { command->run(); });
}

}  // namespace tremula::cli
