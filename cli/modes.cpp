// tremula modes: how a plant can vibrate.

#include "tremula/base/error.hpp"
#include "tremula/io/modes_plot.hpp"
#include "tremula/modes/mode_quality.hpp"
#include "tremula/structure/plausibility.hpp"

#include <array>
#include <chrono>
#include <cmath>
#include <utility>

#include "commands.hpp"
#include "common.hpp"
#include "usage.hpp"

namespace tremula::cli {
namespace {

// What is said of the modes, in whatever format.
struct Found {
  const Plant& plant;
  Modes modes;
  ModeQuality quality;
  LoadMargin load_margin;
  std::vector<std::string> warnings;
  Json seconds;         // of each stage
  std::string picture;  // SVG, where one is wanted
  Eigen::Index degrees_of_freedom;
};

struct ModesCommand {
  std::string input, format, output = "-", plot;
  int count = 40;
  std::optional<double> up_to;
  double tolerance = ModeOptions{}.tolerance;
  std::string method = "automatic";
  std::size_t memory_limit = ModeOptions{}.memory_limit;
  ReadFlags read;
  StructureFlags structure;
  ThreadsFlag threads;

  void check_flags(const CLI::App& flags) const;
  ModeMethod mode_method() const;
  Found find(const Plant& plant, const StructureOptions& options, StageLog& log) const;
  void run(const CLI::App& flags) const;
};

// That the list ends among equal modes, where it does.
std::string equal_modes_note(const Modes& modes) {
  if (modes.equal_left_out == 0) return "";
  const bool one = modes.equal_left_out == 1;
  return "the list ends within a cluster of " + std::to_string(modes.equal_to_last) + " equal modes; " +
         std::to_string(modes.equal_left_out) + (one ? " more lies" : " more lie") +
         " at the same frequency\n";
}

std::string as_table(const Found& found) {
  const Modes& modes = found.modes;
  const ModeQuality& quality = found.quality;
  const Eigen::MatrixX3d percent = 100 * quality.effective_mass_share();
  const double margin = found.load_margin.factor;
  const std::optional<Sheet>& sheet = found.plant.sheet;
  std::string text = printed(
      "%s: %d %s, %.4g kg, %d modes%s\n%6s %14s %12s %11s %11s %8s %9s %9s %9s\n", found.plant.name.c_str(),
      sheet ? sheet->elements[0] * sheet->elements[1] : found.plant.imported.skeleton.branch_count(),
      sheet ? "elements" : "branches", quality.total_mass, modes.count(),
      std::isfinite(margin) ? printed(", load margin %.4g", margin).c_str() : "", "mode", "frequency_hz",
      "period_s", "residual", "error_bound", "kind", "mass_x_%", "mass_y_%", "mass_z_%");
  for (int r = 0; r < modes.count(); ++r) {
    text += printed("%6d %14.6f %12.4f %11.1e %11.1e %8s %9.3f %9.3f %9.3f\n", r + 1, modes.frequency[r],
                    1 / modes.frequency[r], modes.residual[r], modes.error_bound[r],
                    name_of(quality.kind[static_cast<std::size_t>(r)]).data(), percent(r, 0), percent(r, 1),
                    percent(r, 2));
  }
  const Eigen::RowVector3d sum = percent.colwise().sum();
  return text + printed("%67s %9.3f %9.3f %9.3f\n", "all listed", sum[0], sum[1], sum[2]) +
         equal_modes_note(modes);
}

std::string as_csv(const Found& found) {
  const Modes& modes = found.modes;
  const ModeQuality& quality = found.quality;
  const Eigen::MatrixX3d share = quality.effective_mass_share();
  std::string text =
      "mode,frequency_hz,residual,error_bound,kind,effective_mass_share_x,effective_mass_share_y,"
      "effective_mass_share_z\n";
  for (int r = 0; r < modes.count(); ++r) {
    text += printed("%d,%.15g,%.3g,%.3g,%s,%.6g,%.6g,%.6g\n", r + 1, modes.frequency[r], modes.residual[r],
                    modes.error_bound[r], name_of(quality.kind[static_cast<std::size_t>(r)]).data(),
                    share(r, 0), share(r, 1), share(r, 2));
  }
  return text;
}

Json as_json(const Found& found, const StructureOptions& structure) {
  const auto& [plant, modes, quality, load_margin, warnings, seconds, picture, degrees_of_freedom] = found;
  const int branches = plant.imported.skeleton.branch_count();
  const Eigen::MatrixX3d mass = quality.effective_mass(), share = quality.effective_mass_share();
  const auto three = [](const auto& row) { return Json{row[0], row[1], row[2]}; };
  Json list = Json::array();
  for (int r = 0; r < modes.count(); ++r) {
    const auto i = static_cast<std::size_t>(r);
    const EnergyShares& energy = quality.energy[i];
    list.push_back({{"frequency_hz", modes.frequency[r]},
                    {"residual", modes.residual[r]},
                    {"error_bound", modes.error_bound[r]},
                    {"kind", name_of(quality.kind[i])},
                    {"participation", three(quality.participation.row(r))},
                    {"effective_mass_kg", three(mass.row(r))},
                    {"effective_mass_share", three(share.row(r))},
                    {"strain_energy",
                     {{"trunk", energy.trunk},
                      {"branch", energy.branch},
                      {"torsion", energy.torsion},
                      {"axial", energy.axial}}}});
  }
  Json json = {{"branches", branches},
               {"dof", degrees_of_freedom},
               {"structure", plant.is_tree() ? describe(structure, load_margin) : Json()},
               {"load_margin", std::isfinite(load_margin.factor) ? Json(load_margin.factor) : Json()},
               {"total_mass_kg", quality.total_mass},
               {"modes", list},
               {"effective_mass_share_of_all_listed", three(share.colwise().sum().eval())},
               {"count_found", modes.count_below},
               {"count_by_inertia", modes.count_by_inertia},
               {"equal_to_last", modes.equal_to_last},
               {"equal_left_out", modes.equal_left_out},
               {"operator_count", modes.operator_count},
               {"repairs", describe(plant)["repairs"]},
               {"warnings", warnings},
               {"seconds", seconds},
               {"peak_bytes", peak_bytes()}};
  if (plant.sheet) json["sheet"] = describe(*plant.sheet);
  if (plant.frame && !plant.frame->panels.empty()) json["panels"] = describe(plant.frame->panels);
  return json;
}

// Seconds since it was made, or since it was last asked.
class Stopwatch {
 public:
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    return std::chrono::duration<double>(now - std::exchange(begun_, now)).count();
  }

 private:
  std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
};

// A table is text: .txt.
std::size_t format_index(const Place& place, const std::string& named) {
  return format_of(place, named == "table" ? "txt" : named,
                   {{"txt", "a table"}, {"json", "with everything"}, {"csv", "a row a mode"}}, 0);
}

void ModesCommand::check_flags(const CLI::App& flags) const {
  refuse_idle_flags(flags,
                    std::array{IdleFlags{up_to.has_value(), "given with --up-to", "one of them", {"--modes"}},
                               IdleFlags{method == "dense",
                                         "given with --method dense, which finds all modes at once",
                                         "--method iterative",
                                         {"--tolerance"}}});
}

ModeMethod ModesCommand::mode_method() const {
  return method == "dense"       ? ModeMethod::dense
         : method == "iterative" ? ModeMethod::iterative
                                 : ModeMethod::automatic;
}

Found ModesCommand::find(const Plant& plant, const StructureOptions& options, StageLog& log) const {
  const ModeOptions mode_options{.count = count,
                                 .method = mode_method(),
                                 .tolerance = tolerance,
                                 .memory_limit = memory_limit,
                                 .progress = [&](double done) { log.progress("modes", done); }};
  Stopwatch watch;
  log.begin("structure");
  const Structure assembled = cli::assemble(plant, structure, input);
  const double setup = watch.lap();
  log.begin("modes");
  Modes modes =
      up_to ? solve_modes_up_to(assembled, *up_to, mode_options) : solve_modes(assembled, mode_options);
  const double solve = watch.lap() - modes.check_seconds;
  log.begin("quality");
  ModeQuality quality = assess_modes(assembled, modes, trunk_of(plant));
  const LoadMargin load_margin = assembled.find_load_margin();
  const double assessed = watch.lap();
  log.begin("plot");
  std::string picture = plot.empty() ? "" : plot_modes(assembled, modes, quality, {.title = plant.name});
  log.finish();
  std::vector<std::string> warnings;
  if (plant.is_tree()) warnings = plausibility(plant.imported.skeleton, options, modes.frequency[0]);
  Json seconds = {{"setup", setup}, {"solve", solve}, {"check", modes.check_seconds}, {"quality", assessed}};
  return {plant,
          std::move(modes),
          std::move(quality),
          load_margin,
          std::move(warnings),
          std::move(seconds),
          std::move(picture),
          assembled.eigen.all_degrees()};
}

void ModesCommand::run(const CLI::App& flags) const {
  check_flags(flags);
  const std::size_t form = format_index({"-o", output}, format);
  if (!plot.empty()) format_of({"--plot", plot}, "", {{"svg", "a picture"}}, 0);
  Outputs outputs({{"-o", output}, {"--plot", plot}}, {{"INPUT", input}});
  StageLog log;
  log.begin("read");
  const Plant plant = under_weight(open_plant(input, read), structure);
  log.finish();
  print_warnings(plant);
  const StructureOptions options = structure.options();
  threads.run([&] {
    const Found found = find(plant, options, log);
    print_warnings(found.warnings);
    outputs.add(output, form == 1   ? text_of(as_json(found, options))
                        : form == 2 ? as_csv(found)
                                    : as_table(found));
    if (!plot.empty()) outputs.add(plot, found.picture);
    outputs.commit();
  });
}

}  // namespace

void add_modes(CLI::App& app) {
  auto command = std::make_shared<ModesCommand>();
  CLI::App& sub = *app.add_subcommand("modes", "Natural frequencies and shapes of a plant");
  sub.add_option("INPUT", command->input,
                 "A tree file (SWC, TreeQSM .mat or text, SimpleForest CSV), an L-system (.lsys), a frame or "
                 "a sheet (.toml) or the name of a preset")
      ->required();
  sub.add_option("--modes,--count", command->count, "How many of the lowest modes; -1: all")
      ->capture_default_str();
  sub.add_option("--up-to", command->up_to,
                 "All modes below this frequency [Hz], instead of a number of modes");
  sub.add_option("--format", command->format, "table, json or csv, where no extension says it")
      ->check(CLI::IsMember({"table", "json", "csv"}))
      ->default_str("table");
  sub.add_option("-o,--output", command->output,
                 "File to write instead of standard output: .txt (table), .json or .csv");
  sub.add_option("--plot", command->plot,
                 "Picture to draw besides: the frequencies and the first shapes (.svg)");
  sub.add_option("--tolerance", command->tolerance, "Relative residual at which an iterated mode is done")
      ->capture_default_str();
  sub.add_option(
         "--max-memory", command->memory_limit,
         "Memory for the vectors of the search [bytes, or with a unit: 500MB, 2GB]; where they do not "
         "fit, it restarts and takes longer. The plant itself takes about 1.5 kB a branch")
      ->transform(CLI::AsSizeValue(false))
      ->default_str("no limit");
  sub.add_option("--method", command->method,
                 "automatic, dense (all modes at once) or iterative (the lowest)")
      ->check(CLI::IsMember({"automatic", "dense", "iterative"}))
      ->capture_default_str();
  command->read.add_to(sub);
  command->structure.add_to(sub);
  command->threads.add_to(sub);
  sub.footer(
      "Examples:\n"
      "  tremula modes tree.swc\n"
      "  tremula modes scan.mat --modes 20 --material oak --format csv -o frequencies.csv\n"
      "  tremula modes oak --plot oak.svg\n"
      "  tremula modes sheet.toml --count 6 --gravity 0 --medium vacuum\n"
      "  tremula modes sign --count 6 --plot sign.svg\n"
      "  tremula modes oak --up-to 3 --plot modes.svg\n"
      "  tremula modes forest.txt --modes 100 --max-memory 2GB\n"
      "  tremula modes tree.txt --youngs-modulus 8e9 --shear-modulus 6e8 --density 900 --format json\n");
  sub.callback([command, &sub] {
    command->structure.settle_in(habitat_of(command->input));
    command->run(sub);
  });
}

}  // namespace tremula::cli
