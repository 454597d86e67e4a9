#include "tremula/base/error.hpp"

#include <exception>
#include <iostream>
#include <new>
#include <string>

#include "commands.hpp"

namespace {

constexpr int could_not = 1, bad_input = 2;

// An error is one line on stderr, whatever characters stood in the file that caused it.
int fail(std::string message, int code) {
  for (char& c : message) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = ' ';
  }
  std::cerr << "tremula: error: " << message << '\n';
  return code;
}

// CLI11 would only say that some command is missing.
void refuse_unknown_command(const CLI::App& app, int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-') return;
  std::string names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (command->get_name() == argv[1]) return;
    names += (names.empty() ? "" : ", ") + command->get_name();
  }
  throw tremula::InputError("tremula", "no command '" + std::string(argv[1]) + "'", "one of " + names);
}

int run(int argc, char** argv) {
  CLI::App app{
      "tremula gives plants the motion that turbulent wind gives them, as loops that close exactly."};
  app.name("tremula");
  app.set_version_flag("--version", "tremula " TREMULA_VERSION);
  app.require_subcommand(1);
  app.footer(
      "Examples:\n"
      "  tremula animate tree.swc -o tree.glb           a looping tree for Blender or a game engine\n"
      "  tremula animate oak -o oak.html                a grown oak that plays in any browser\n"
      "  tremula modes scan.mat --count 20              natural frequencies of a laser-scanned tree\n"
      "  tremula wind --wind-speed 8 -o gusts.bts       a turbulent wind field, --plot shows how good it is\n"
      "  tremula COMMAND --help                         all options of a command, with examples\n");
  tremula::cli::add_animate(app);
  tremula::cli::add_modes(app);
  tremula::cli::add_grow(app);
  tremula::cli::add_wind(app);
  tremula::cli::add_info(app);
  refuse_unknown_command(app, argc, argv);
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp& e) {
    return app.exit(e);
  } catch (const CLI::CallForAllHelp& e) {
    return app.exit(e);
  } catch (const CLI::CallForVersion& e) {
    return app.exit(e);
  } catch (const CLI::ParseError& e) {
    return fail(std::string(e.what()) + " (see tremula --help)", bad_input);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const tremula::InputError& e) {
    return fail(e.what(), bad_input);
  } catch (const std::bad_alloc&) {
    return fail("out of memory", could_not);
  } catch (const std::exception& e) {
    return fail(e.what(), could_not);
  }
}
