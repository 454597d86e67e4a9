// tremula wind: wind fields, written in the forms that programs read and held against what they should be.

#include "tremula/base/error.hpp"
#include "tremula/io/atomic_file.hpp"
#include "tremula/io/turbsim.hpp"
#include "tremula/io/vti.hpp"
#include "tremula/io/wind_plot.hpp"

#include <cstdio>
#include <filesystem>
#include <iostream>

#include "commands.hpp"
#include "common.hpp"
#include "wind_report.hpp"

namespace tremula::cli {
namespace {

struct WindCommand {
  std::string input, report, plot;
  std::vector<std::string> outputs;
  double bands_per_decade = 10;
  std::vector<int> separations = {1, 2, 4, 8, 16};
  int segment_length = 0;

  void check_outputs() const;
  void run() const;
};

// A field and where it comes from, as far as the outputs say it.
struct FieldWithOrigin {
  WindField field;
  std::string text;     // in .bts
  WindTargets targets;  // what the field should be like, where that is known
};

FieldWithOrigin read_field(const std::string& path) {
  const TurbSimFile file = read_turbsim(path);
  return {wind_field(file), file.text, {}};
}

void WindCommand::check_outputs() const {
  if (outputs.empty() && report.empty() && plot.empty()) {
    throw InputError("wind", "no output", "--report FILE.json, --plot FILE.svg or -o FILE.bts or .vti");
  }
  for (const std::string& path : outputs) {
    const std::string extension = lower_extension(path);
    if (extension != ".bts" && extension != ".vti")
      throw InputError("-o " + path, "'" + extension + "'", ".bts (TurbSim) or .vti (ParaView)");
  }
  if (!plot.empty() && lower_extension(plot) != ".svg")
    throw InputError("--plot " + plot, "'" + lower_extension(plot) + "'", ".svg");
}

void WindCommand::run() const {
  check_outputs();
  StageLog log;
  log.begin("read");
  const FieldWithOrigin wind = read_field(input);
  log.finish();

  WindReport checked{
      .title = std::filesystem::path(input).stem().string(), .statistics = {}, .targets = wind.targets};
  if (!report.empty() || !plot.empty()) {
    log.begin("check");
    checked.statistics = field_statistics(wind.field, {.bands_per_decade = bands_per_decade,
                                                       .y_separations = separations,
                                                       .z_separations = separations,
                                                       .segment_length = segment_length});
  }
  for (const std::string& path : outputs) {
    log.begin("write " + lower_extension(path));
    if (lower_extension(path) == ".bts") write_turbsim(path, wind.field, wind.text);
    if (lower_extension(path) == ".vti") write_vti(path, wind.field);
  }
  if (!plot.empty()) write_wind_plot(plot, checked);
  log.finish();
  for (const std::string& path : outputs) std::cerr << "tremula: wrote " << path << '\n';
  if (!plot.empty()) std::cerr << "tremula: wrote " << plot << '\n';
  if (report.empty()) return;

  Json json = {{"tremula", TREMULA_VERSION},
               {"input", input},
               {"settings", {{"bands_per_decade", bands_per_decade}, {"separations_cells", separations}}},
               {"grid", describe(wind.field.grid)}};
  json.update(describe(checked.statistics));
  json.update({{"outputs", outputs}, {"stages", log.json()}, {"peak_bytes", peak_bytes()}});
  write_file_atomically(report, json.dump(1) + '\n');
  std::cerr << "tremula: wrote " << report << '\n';
}

}  // namespace

void add_wind(CLI::App& app) {
  auto command = std::make_shared<WindCommand>();
  CLI::App& sub = *app.add_subcommand("wind", "Check a wind field and write it in other forms");
  sub.add_option("FIELD", command->input, "A wind field of TurbSim or of any program that writes .bts")
      ->required();
  sub.add_option("-o,--output", command->outputs,
                 "What to write, by extension: .bts (TurbSim, OpenFAST), .vti (ParaView: the frozen gusts as "
                 "a box); may be "
                 "repeated");
  sub.add_option(
      "--report", command->report,
      "Mean [m/s], deviation [m/s], spectra [(m/s)^2/Hz] by height and coherence by distance [m], as JSON");
  sub.add_option("--plot", command->plot, "The same as a picture (.svg)");
  sub.add_option("--bands", command->bands_per_decade,
                 "Frequency bands per decade in report and plot (1 to 1000)")
      ->capture_default_str();
  sub.add_option("--separations", command->separations,
                 "Distances at which coherence is measured [cells of the grid]")
      ->delimiter(',')
      ->capture_default_str();
  sub.add_option(
         "--segment", command->segment_length,
         "Length of the segments that a field that is not periodic is cut into [steps]; 0: a quarter of it")
      ->capture_default_str();
  sub.footer(
      "Examples:\n"
      "  tremula wind field.bts --report check.json --plot check.svg\n"
      "  tremula wind field.bts -o field.vti\n"
      "  tremula wind field.bts --plot check.svg --separations 1,3,9 --bands 5\n");
  sub.callback([command] { command->run(); });
}

}  // namespace tremula::cli
