#include "tremula/base/error.hpp"
#include "tremula/base/suggestion.hpp"
#include "tremula/io/atomic_file.hpp"

#include <csignal>
#include <exception>
#include <iostream>
#include <new>
#include <string>

#include <fcntl.h>
#include <unistd.h>

#include "commands.hpp"
#include "outputs.hpp"
#include "usage.hpp"

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

// Nothing half-written stays, and the shell learns which signal it was.
extern "C" void stop(int signal) {
  tremula::abandon_unfinished_files();
  _exit(128 + signal);
}

// Where memory has run out, throwing may end in std::terminate: destructors of JSON take some themselves.
void stop_without_memory() {
  tremula::abandon_unfinished_files();
  constexpr char message[] = "tremula: error: out of memory\n";
  [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, message, sizeof message - 1);
  _exit(could_not);
}

void handle_signals() {
  struct sigaction action {};
  action.sa_handler = stop;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&action.sa_mask, signal);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction before {};
    sigaction(signal, nullptr, &before);
    if (before.sa_handler != SIG_IGN) sigaction(signal, &action, nullptr);  // nohup, jobs in the background
  }
  // A reader that has gone and a file that may not grow are errors of the write, which are reported.
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
}

// A file that is opened must not take the number of a stream that was closed: it would get the messages.
void occupy_closed_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(stream, F_GETFD) < 0) ::open("/dev/null", O_RDONLY);  // no write succeeds
  }
}

// The parser would only say that some command is missing.
void refuse_unknown_command(const CLI::App& app, int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-') return;
  const std::string given = argv[1];
  std::string list;
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (command->get_name() == given) return;
    list += (names.empty() ? "" : ", ") + command->get_name();
    names.push_back(command->get_name());
  }
  throw tremula::InputError("tremula", "no command '" + given + "'",
                            "one of " + list + tremula::suggestion(given, names));
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
      "  tremula render oak -o oak.png                  a picture of it; .mp4 a film\n"
      "  tremula modes scan.mat --modes 20              natural frequencies of a laser-scanned tree\n"
      "  tremula wind --wind-speed 8 -o gusts.bts       a turbulent wind field, --plot shows how good it is\n"
      "  tremula COMMAND --help                         all options of a command, with examples\n");
  tremula::cli::add_animate(app);
  tremula::cli::add_render(app);
  tremula::cli::add_check(app);
  tremula::cli::add_load(app);
  tremula::cli::add_modes(app);
  tremula::cli::add_grow(app);
  tremula::cli::add_wind(app);
  tremula::cli::add_info(app);
  tremula::cli::add_beam(app);
  for (CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
    tremula::cli::check_values(*command);
  refuse_unknown_command(app, argc, argv);
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForVersion& e) {
    tremula::cli::print(std::string(e.what()) + '\n');
  } catch (const CLI::Success&) {
    tremula::cli::print(app.help());
  } catch (const CLI::ParseError& e) {
    return fail(tremula::cli::explain(app, e), bad_input);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  occupy_closed_streams();
  handle_signals();
  std::set_new_handler(stop_without_memory);
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
