// tremula modes: how a plant can vibrate.

#include "tremula/base/error.hpp"
#include "tremula/io/atomic_file.hpp"

#include <cstdio>
#include <iostream>

#include "commands.hpp"
#include "common.hpp"

namespace tremula::cli {
namespace {

struct ModesCommand {
  std::string input, format = "table", output;
  int count = 40;
  std::optional<double> up_to;
  double tolerance = 1e-12;
  std::string method = "automatic";
  StructureFlags structure;
  ThreadsFlag threads;

  void run() const;
};

std::string as_table(const Plant& plant, const Modes& modes) {
  std::string text;
  char line[160];
  std::snprintf(line, sizeof line, "%s: %d branches, %d modes\n%6s %14s %12s %11s %11s\n", plant.name.c_str(),
                plant.imported.skeleton.branch_count(), modes.count(), "mode", "frequency_hz", "period_s",
                "residual", "error_bound");
  text += line;
  for (int r = 0; r < modes.count(); ++r) {
    std::snprintf(line, sizeof line, "%6d %14.6f %12.4f %11.1e %11.1e\n", r + 1, modes.frequency[r],
                  1 / modes.frequency[r], modes.residual[r], modes.error_bound[r]);
    text += line;
  }
  return text;
}

std::string as_csv(const Modes& modes) {
  std::string text = "mode,frequency_hz,residual,error_bound\n";
  char line[160];
  for (int r = 0; r < modes.count(); ++r) {
    std::snprintf(line, sizeof line, "%d,%.15g,%.3g,%.3g\n", r + 1, modes.frequency[r], modes.residual[r],
                  modes.error_bound[r]);
    text += line;
  }
  return text;
}

std::string as_json(const Plant& plant, const StructureOptions& structure, const Modes& modes, double setup,
                    double solve) {
  const int branches = plant.imported.skeleton.branch_count();
  Json list = Json::array();
  for (int r = 0; r < modes.count(); ++r) {
    list.push_back({{"frequency_hz", modes.frequency[r]},
                    {"residual", modes.residual[r]},
                    {"error_bound", modes.error_bound[r]}});
  }
  const Json json = {{"branches", branches},
                     {"dof", 6 * branches},
                     {"structure", describe(structure)},
                     {"modes", list},
                     {"count_found", modes.count_below},
                     {"count_by_inertia", modes.count_by_inertia},
                     {"operator_count", modes.operator_count},
                     {"repairs", describe(plant)["repairs"]},
                     {"seconds", {{"setup", setup}, {"solve", solve}}},
                     {"peak_bytes", peak_bytes()}};
  return json.dump(1) + '\n';
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void ModesCommand::run() const {
  const Plant plant = open_plant(input);
  print_warnings(plant);
  const StructureOptions options = structure.options();
  const ModeMethod chosen = method == "dense"       ? ModeMethod::dense
                            : method == "iterative" ? ModeMethod::iterative
                                                    : ModeMethod::automatic;
  threads.run([&] {
    const auto start = std::chrono::steady_clock::now();
    const Structure assembled = assemble(plant.imported.skeleton, options);
    const double setup = seconds_since(start);
    const ModeOptions mode_options{.count = count, .method = chosen, .tolerance = tolerance};
    const Modes modes =
        up_to ? solve_modes_up_to(assembled, *up_to, mode_options) : solve_modes(assembled, mode_options);
    const double solve = seconds_since(start) - setup;
    const std::string text = format == "json"  ? as_json(plant, options, modes, setup, solve)
                             : format == "csv" ? as_csv(modes)
                                               : as_table(plant, modes);
    if (output.empty()) {
      std::cout << text;
    } else {
      write_file_atomically(output, text);
    }
  });
}

}  // namespace

void add_modes(CLI::App& app) {
  auto command = std::make_shared<ModesCommand>();
  CLI::App& sub = *app.add_subcommand("modes", "Natural frequencies and shapes of a plant");
  sub.add_option("INPUT", command->input,
                 "A tree file (SWC, TreeQSM .mat or text, SimpleForest CSV), an L-system "
                 "(.lsys) or the name of a preset")
      ->required();
  sub.add_option("--count", command->count, "How many of the lowest modes; -1: all")->capture_default_str();
  sub.add_option("--up-to", command->up_to,
                 "All modes below this frequency [Hz], instead of a number of modes");
  sub.add_option("--format", command->format, "table, json or csv")
      ->check(CLI::IsMember({"table", "json", "csv"}))
      ->capture_default_str();
  sub.add_option("-o,--output", command->output, "File to write instead of standard output");
  sub.add_option("--tolerance", command->tolerance, "Relative residual at which an iterated mode is done")
      ->check(CLI::Range(1e-14, 1e-6))
      ->capture_default_str();
  sub.add_option("--method", command->method,
                 "automatic, dense (all modes at once) or iterative (the lowest)")
      ->check(CLI::IsMember({"automatic", "dense", "iterative"}))
      ->capture_default_str();
  command->structure.add_to(sub);
  command->threads.add_to(sub);
  sub.footer(
      "Examples:\n"
      "  tremula modes tree.swc\n"
      "  tremula modes scan.mat --count 20 --material oak --format csv -o frequencies.csv\n"
      "  tremula modes tree.txt --youngs-modulus 8e9 --shear-modulus 6e8 --density 900 --format json\n");
  sub.callback([command] { command->run(); });
}

}  // namespace tremula::cli
