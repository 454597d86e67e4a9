// tremula wind: wind fields, synthesised or read, written in the forms that programs read and held against
// what they should be.

#include "tremula/base/error.hpp"
#include "tremula/base/memory.hpp"
#include "tremula/base/number_text.hpp"
#include "tremula/io/atomic_file.hpp"
#include "tremula/io/film.hpp"
#include "tremula/io/gust_plot.hpp"
#include "tremula/io/turbsim.hpp"
#include "tremula/io/vti.hpp"
#include "tremula/io/wind_targets.hpp"
#include "tremula/io/wind_verdict.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>

#include "commands.hpp"
#include "common.hpp"
#include "wind_flags.hpp"
#include "wind_report.hpp"

namespace tremula::cli {
namespace {

void warn(const std::string& message) { std::cerr << "tremula: warning: " << message << '\n'; }

// Where and when a field is synthesised.
struct GridFlags {
  std::string points = "21x21";
  std::optional<std::string> size;
  std::optional<double> center_height, step, period;
  std::optional<int> steps;
  bool tower = false;

  std::vector<CLI::Option*> add_to(CLI::App& command);
  WindGrid grid(double reference_height) const;
};

// "51x31": across, then up.
template <typename T>
std::array<T, 2> parse_pair(const char* flag, const std::string& text, T least, const char* wanted) {
  std::array<T, 2> pair{};
  const char* end = text.data() + text.size();
  const auto first = std::from_chars(text.data(), end, pair[0]);
  bool good = first.ec == std::errc{} && first.ptr != end && *first.ptr == 'x';
  if (good) {
    const auto second = std::from_chars(first.ptr + 1, end, pair[1]);
    good = second.ec == std::errc{} && second.ptr == end;
  }
  for (const T value : pair) good = good && value >= least && std::isfinite(static_cast<double>(value));
  if (!good) throw InputError(flag, "'" + text + "'", wanted);
  return pair;
}

// Numbers beyond could not be told apart, or would be nothing or infinite, in the single precision of files.
void check_range(const char* flag, double value, const char* unit) {
  if (value >= 1e-9 && value <= 1e9) return;
  throw InputError(flag, number_text(value), std::string("above 0 ") + unit + " (1e-9 to 1e9)");
}

// Field and half of a component, in single precision; the rest is small beside it.
void check_memory(const std::string& points, double point_count, int steps) {
  const double wanted = 16 * point_count * steps;
  const auto present = static_cast<double>(available_memory());
  if (wanted <= present) return;
  throw InputError(
      "--points " + points + " with " + std::to_string(steps) + " steps",
      number_text(std::ceil(wanted / 1e8) / 10) + " GB of memory",
      "at most the " + number_text(std::floor(present / 1e8) / 10) + " GB that this machine can give");
}

std::vector<CLI::Option*> GridFlags::add_to(CLI::App& command) {
  const auto add = [&](const char* flag, auto& value, const char* text) {
    return command.add_option(flag, value, text)->group("Grid");
  };
  CLI::Option* steps_option = add("--steps", steps, "How many time steps")->default_str("4096");
  return {
      add("--points", points, "Points across the wind x points above each other")->capture_default_str(),
      add("--size", size, "From the first to the last point, across x up [m] (default: 1 m between points)"),
      add("--center-height", center_height,
          "Height of the middle of the grid [m] (default: the lowest row is half a spacing above the "
          "ground)"),
      steps_option,
      add("--step", step, "Time step [s]")->default_str("0.1"),
      add("--period", period, "Length of the loop [s], in place of --steps or of --step"),
      command
          .add_flag(
              "--tower", tower,
              "Single points below the grid too, y = 0, from the lowest row down to the ground, a row's "
              "spacing apart (for .bts)")
          ->group("Grid")};
}

WindGrid GridFlags::grid(double reference_height) const {
  const auto [across, up] =
      parse_pair<int>("--points", points, 1, "points across x up, 1x1 or more, such as 51x51");
  std::array<double, 2> extent{across - 1.0, up - 1.0};
  if (size) extent = parse_pair<double>("--size", *size, 0, "metres across x up, 0 or more, such as 145x145");
  for (const auto& [count, length] : {std::pair(across, extent[0]), std::pair(up, extent[1])}) {
    if (count > 1) check_range("--size", length, "m");
  }

  WindGrid grid{.y_count = across, .z_count = up};
  // A line of points has the spacing of its own direction in the other one too: there it does not matter.
  if (across > 1) grid.y_spacing = extent[0] / (across - 1);
  grid.z_spacing = up > 1 ? extent[1] / (up - 1) : grid.y_spacing;
  if (across == 1) grid.y_spacing = grid.z_spacing;
  const double height = up > 1 ? extent[1] : 0,
               center = center_height.value_or(up > 1 ? 0.5 * (height + grid.z_spacing) : reference_height);
  check_range("--center-height", center, "m");
  grid.bottom = center - 0.5 * height;
  if (!(grid.bottom > 0)) {
    throw InputError("--center-height " + number_text(center) + " of " + number_text(height) + " m",
                     "lowest row at " + number_text(grid.bottom) + " m", "above the ground");
  }

  if (step) check_range("--step", *step, "s");
  if (period) check_range("--period", *period, "s");
  if (period && steps && step) throw InputError("--period", "given with --steps and --step", "one of them");
  if (steps && *steps < 1) throw InputError("--steps", std::to_string(*steps), "1 or more");
  grid.step = step.value_or(0.1);
  grid.step_count = steps.value_or(4096);
  if (period && steps) {
    grid.step = *period / *steps;
  } else if (period) {
    const double count = *period / grid.step;
    if (!(count < 1e9 && std::abs(count - std::round(count)) < 1e-6 * count && count > 0.5)) {
      throw InputError("--period " + number_text(*period) + " at " + number_text(grid.step) + " s a step",
                       number_text(count) + " steps", "a whole number of them");
    }
    grid.step_count = static_cast<int>(std::lround(count));
  }
  if (tower && tower_points_above_ground(grid) < 2) {
    throw InputError("--tower",
                     "a lowest row at " + number_text(grid.bottom) + " m, " + number_text(grid.z_spacing) +
                         " m between rows",
                     "room for a point below it: a higher --center-height");
  }
  check_memory(points,
               static_cast<double>(grid.point_count()) + (tower ? tower_points_above_ground(grid) : 0),
               grid.step_count);
  check_wind_grid(grid);
  return grid;
}

// The wind over the ground, seen from above.
struct VectorFlags {
  std::string file;
  double time = 0;
  std::optional<double> height;
  bool without_mean = false;

  std::vector<CLI::Option*> add_to(CLI::App& command);
  void check(const std::vector<CLI::Option*>& beside) const;
  void draw(const WindField& field, Outputs& files, StageLog& log) const;
};

struct FieldWithOrigin;

struct WindCommand {
  std::string input, report, plot, spectra, match = "spectrum";
  std::vector<std::string> outputs;
  bool list_terrains = false, tile = false;
  CLI::Option* reference_option = nullptr;
  std::vector<CLI::Option*> of_synthesis;
  WindFlags wind;
  GridFlags grid;
  VectorFlags vectors;
  std::vector<CLI::Option*> of_vectors;
  ThreadsFlag threads;
  double bands_per_decade = 10;
  std::vector<int> separations = {1, 2, 4, 8, 16};
  int segment_length = 0;

  bool wind_given() const;
  void check_flags_beside_a_field() const;
  void check_outputs() const;
  // A field is judged on stdout, unless stdout takes something else; a wind of our own where nothing else is
  // made of it.
  bool says_verdict() const;
  Json report_of(const FieldWithOrigin& made, const WindReport& checked, const WindVerdict& verdict,
                 const StageLog& log) const;
  void run() const;
};

// A field, and what is known of what it should be.
struct FieldWithOrigin {
  WindField field;
  std::string title, text;  // text: in .bts
  WindFlags flags;
  std::optional<TurbulentWind> wind;
  std::optional<SynthesisReport> synthesis;
};

std::size_t row_nearest(const WindGrid& grid, double height) {
  const double row = grid.z_count > 1 ? std::round((height - grid.bottom) / grid.z_spacing) : 0.0;
  return static_cast<std::size_t>(std::clamp(row, 0.0, grid.z_count - 1.0));
}

// Where the result may not be what was meant.
void advise(const TurbulentWind& wind, const WindGrid& grid, const SynthesisReport& report, Match match) {
  if (wind.mean.speed == 0) warn("a wind speed of 0: there is no wind in the field");
  if (grid.step_count == 1) warn("a field of one step has the mean wind and no gusts");
  const double bytes = 6.0 * static_cast<double>(grid.point_count()) * grid.step_count;  // of a .bts
  if (bytes >= 1e9)
    warn("the field takes " + number_text(std::round(bytes / 1e8) / 10) +
         " GB as a file, twice that as .vti");
  if (wind.mean.profile == ProfileKind::table) {
    const double low = wind.mean.table.front().height, high = wind.mean.table.back().height,
                 top = grid.z(grid.z_count - 1);
    if (grid.bottom < low || top > high) {
      warn("the grid reaches from " + number_text(grid.bottom) + " to " + number_text(top) +
           " m, the profile from " + number_text(low) + " to " + number_text(high) +
           " m: beyond it the wind is that of its first or last row");
    }
  }
  const double intensity = Wind(wind).reference.intensity.value_or(0);
  if (intensity > 0.4) {
    warn("turbulence intensity " + number_text(intensity) +
         ": above 0.4 the wind blows backwards at times, and gusts are no longer carried by one mean speed");
  }
  const std::size_t row = row_nearest(grid, wind.mean.reference_height);
  const double resolved = report.resolved_share[0][row];
  if (resolved < 0.6 && resolved > 0 && match == Match::spectrum) {
    warn("a loop of " + number_text(grid.period()) + " s at " + number_text(grid.step) + " s a step holds " +
         number_text(std::round(100 * resolved)) + " % of the variance of u at " +
         number_text(grid.z(static_cast<int>(row))) +
         " m; more: a longer --period, or --match variance, hub or points");
  }
  const bool log_law = wind.mean.profile == ProfileKind::logarithmic;
  if (log_law && wind.mean.speed > 0 && mean_speed(wind.mean, grid.bottom) == 0) {
    warn("there is no wind in the lowest row, at " + number_text(grid.bottom) +
         " m: the profile begins at displacement and roughness length, " +
         number_text(wind.mean.displacement + wind.mean.roughness_length) + " m");
  }
  const double error =
      std::max({report.coherence_error[0], report.coherence_error[1], report.coherence_error[2]});
  if (error > 0.03)
    warn("the root-coherence is up to " + number_text(error) + " off the model's at low frequency");
}

FieldWithOrigin read_field(const WindCommand& command, StageLog& log) {
  log.begin("read");
  const TurbSimFile file = read_turbsim(command.input);
  FieldWithOrigin made{.field = wind_field(file),
                       .title = std::filesystem::path(command.input).stem().string(),
                       .text = file.text,
                       .flags = command.wind,
                       .wind = {},
                       .synthesis = {}};
  log.finish();
  if (!command.wind_given()) return made;
  if (command.wind.speed_option->count() == 0) made.flags.speed = made.field.grid.mean_speed;
  if (command.reference_option->count() == 0) made.flags.reference_height = made.field.grid.reference_height;
  made.wind = made.flags.wind();
  return made;
}

FieldWithOrigin synthesise_field(const WindCommand& command, StageLog& log) {
  const TurbulentWind wind = command.wind.wind();
  const WindGrid grid = command.grid.grid(wind.mean.reference_height);
  log.begin("synthesis");
  const SynthesisOptions options{.tile = command.tile,
                                 .match = match_named(command.match),
                                 .tower_count = command.grid.tower ? tower_points_above_ground(grid) : 0,
                                 .progress = [&](double done) { log.progress("synthesis", done); }};
  SynthesisReport report;
  FieldWithOrigin made{.field = synthesise_wind(wind, grid, options, &report),
                       .title = command.wind.spectrum_name() + ", " + number_text(wind.mean.speed) +
                                " m/s at " + number_text(wind.mean.reference_height) + " m, seed " +
                                std::to_string(wind.seed),
                       .text = {},
                       .flags = command.wind,
                       .wind = wind,
                       .synthesis = report};
  made.text = "tremula " TREMULA_VERSION ": " + made.title;
  log.finish();
  advise(wind, grid, report, options.match);
  return made;
}

bool WindCommand::wind_given() const {
  const auto any = [](const std::vector<CLI::Option*>& options) {
    return std::any_of(options.begin(), options.end(),
                       [](const CLI::Option* option) { return option->count() > 0; });
  };
  return any(wind.of_mean) || any(wind.of_turbulence);
}

void WindCommand::check_flags_beside_a_field() const {
  if (input.empty()) return;
  const std::string only_made = "none: it says how a field is made";
  refuse_given(of_synthesis, "the field " + input, only_made);
  refuse_given(wind.of_realisation, "the field " + input, only_made);
  if (outputs.empty()) return;
  const std::string with = "-o, which writes the field " + input + " as it is",
                    wanted = "one of the two: with a field, the wind is what it is checked against";
  refuse_given(wind.of_mean, with, wanted);
  refuse_given(wind.of_turbulence, with, wanted);
}

bool WindCommand::says_verdict() const {
  const bool to_stdout = report == "-" || plot == "-" || vectors.file == "-" ||
                         std::find(outputs.begin(), outputs.end(), "-") != outputs.end();
  return !to_stdout && (!input.empty() || (outputs.empty() && report.empty() && plot.empty() &&
                                           spectra.empty() && vectors.file.empty()));
}

std::vector<CLI::Option*> VectorFlags::add_to(CLI::App& command) {
  const char* group = "Vectors";
  command
      .add_option(
          "--vectors", file,
          "The wind over the ground upwind of the plane as arrows seen from above: .svg or .png at an "
          "instant, .mp4, .webm or .gif over all steps")
      ->group(group);
  return {
      command.add_option("--time", time, "The instant [s]")->capture_default_str()->group(group),
      command
          .add_option("--vectors-height", height,
                      "Height of the row that is shown, the nearest one [m] (default: the reference height)")
          ->group(group),
      command.add_flag("--without-mean", without_mean, "Arrows of the gusts alone, without the mean wind")
          ->group(group)};
}

enum VectorFormat : std::size_t { vector_svg, vector_png, vector_film };

std::size_t vector_format(const std::string& path) {
  const std::size_t format = format_of(
      {"--vectors", path}, "",
      {{"svg", "a picture"}, {"png", "a picture"}, {"mp4", "a film"}, {"webm", "a film"}, {"gif", "a film"}},
      vector_svg);
  return std::min<std::size_t>(format, vector_film);
}

void VectorFlags::check(const std::vector<CLI::Option*>& beside) const {
  if (file.empty()) {
    refuse_given(beside, "no --vectors", "--vectors, whose picture they change");
    return;
  }
  const bool is_film = vector_format(file) == vector_film;
  if (is_film) refuse_given({beside.front()}, "the film " + file, "none: a film shows all times");
  if (!std::isfinite(time)) throw InputError("--time", number_text(time), "a finite number of seconds");
  if (height) check_range("--vectors-height", *height, "m");
}

void VectorFlags::draw(const WindField& field, Outputs& files, StageLog& log) const {
  if (file.empty()) return;
  const WindGrid& grid = field.grid;
  if (grid.y_count < 2)
    throw InputError("--vectors", "a field of 1 point across", "2 or more, for a picture from above");
  if (!(grid.mean_speed > 0))
    throw InputError("--vectors", "a field without wind", "a mean wind above 0 m/s");
  const TravellingField row = travelling_row(field, height.value_or(grid.reference_height));
  GustView view = view_of_gusts(row, 40, without_mean);
  const std::size_t format = vector_format(file);
  // What repeats shows any instant; what does not, those whose gusts are all in it, and half of it at most.
  if (!grid.periodic) view.low.x() = std::max(view.low.x(), -0.5 * grid.mean_speed * grid.period());
  const double last = grid.period() + view.low.x() / grid.mean_speed;
  if (!grid.periodic && format != vector_film && !(time >= 0 && time <= last)) {
    throw InputError("--time", number_text(time) + " s",
                     "0 to " + number_text(last) + " s, in a field that does not repeat");
  }
  log.begin("vectors");
  view.time = time;
  if (format == vector_svg) files.add(file, plot_gusts(row, view));
  if (format == vector_png) files.add(file, encode_png(picture_of_gusts(row, view)));
  if (format == vector_film) {
    const int frames = grid.periodic ? grid.step_count : std::max(1, static_cast<int>(last / grid.step));
    const Image first = picture_of_gusts(row, view);
    Film film(file, {.width = first.width,
                     .height = first.height,
                     .frames = frames,
                     .frame_rate = 1 / grid.step,
                     .crf = {}});
    for (int k = 0; k < frames; ++k) {
      view.time = k * grid.step;
      film.add(picture_of_gusts(row, view));
      log.progress("vectors", static_cast<double>(k) / frames);
    }
    film.finish();
  }
  log.finish();
}

enum FieldFormat : std::size_t { bts, vti };

std::size_t field_format(const std::string& path) {
  return format_of({"-o", path}, "", {{"bts", "TurbSim"}, {"vti", "ParaView"}});
}

void WindCommand::check_outputs() const {
  for (const std::string& path : outputs) field_format(path);
  if (!plot.empty()) format_of({"--plot", plot}, "", {{"svg", "a picture"}}, 0);
  if (!spectra.empty()) format_of({"--spectra", spectra}, "", {{"svg", "a picture"}}, 0);
  if (!report.empty()) format_of({"--report", report}, "", {{"json", "what was done"}}, 0);
  vectors.check(of_vectors);
}

void WindCommand::run() const {
  check_flags_beside_a_field();
  check_outputs();
  std::vector<Place> places = {
      {"--report", report}, {"--plot", plot}, {"--spectra", spectra}, {"--vectors", vectors.file}};
  for (const std::string& path : outputs) places.push_back({"-o", path});
  Outputs files(places, {{"FIELD", input}, {"--spectrum", wind.spectrum}, {"--profile", wind.profile}});
  StageLog log;
  const FieldWithOrigin made = input.empty() ? synthesise_field(*this, log) : read_field(*this, log);

  WindReport checked{.title = made.title, .statistics = {}, .targets = {}};
  WindVerdict verdict;
  if (!report.empty() || !plot.empty() || !spectra.empty() || says_verdict()) {
    log.begin("check");
    checked.statistics = field_statistics(made.field, {.bands_per_decade = bands_per_decade,
                                                       .y_separations = separations,
                                                       .z_separations = separations,
                                                       .segment_length = segment_length});
    if (made.wind)
      checked.targets = wind_targets(*made.wind, made.field.grid, checked.statistics, match_named(match));
    verdict = judge_wind(made.field, checked);
  }
  for (const std::string& path : outputs) {
    log.begin("write " + lower_extension(path));
    AtomicFile& file = files.begin(path);
    if (field_format(path) == bts) write_turbsim(file, made.field, made.text);
    if (field_format(path) == vti) write_vti(file, made.field);
  }
  if (!plot.empty()) files.add(plot, plot_wind(checked));
  if (!spectra.empty()) {
    const WindGrid& of_field = made.field.grid;
    files.add(spectra, plot_spectra(checked, row_nearest(of_field, of_field.reference_height)));
  }
  log.finish();
  vectors.draw(made.field, files, log);
  if (!report.empty()) files.add(report, text_of(report_of(made, checked, verdict, log)));
  files.commit();
  files.announce();
  if (says_verdict()) print(verdict_text(made.field, checked, verdict));
}

Json WindCommand::report_of(const FieldWithOrigin& made, const WindReport& checked,
                            const WindVerdict& verdict, const StageLog& log) const {
  Json settings = {{"bands_per_decade", bands_per_decade}, {"separations_cells", separations}};
  if (made.wind) settings["wind"] = cli::describe(made.flags, *made.wind);
  if (made.synthesis) settings.update({{"tile", tile}, {"tower", grid.tower}, {"match", match}});
  Json json = {{"tremula", TREMULA_VERSION},
               {"input", input.empty() ? Json() : Json(input)},
               {"settings", settings},
               {"grid", describe(made.field.grid)}};
  if (made.synthesis) {
    json["synthesis"] =
        describe(*made.synthesis, row_nearest(made.field.grid, made.field.grid.reference_height));
  }
  json.update(describe(checked.statistics, checked.targets));
  json["verdict"] = describe(verdict);
  json.update({{"outputs", outputs}, {"stages", log.json()}, {"peak_bytes", peak_bytes()}});
  return json;
}

}  // namespace

void add_wind(CLI::App& app) {
  auto command = std::make_shared<WindCommand>();
  CLI::App& sub = *app.add_subcommand("wind", "Synthesise a wind field, or read one; write and check it");
  sub.add_option(
      "FIELD", command->input,
      "A wind field of TurbSim or of any program that writes .bts; none: one is synthesised. Of a field, "
      "numbers and a verdict are printed; the flags of the wind say what it is held against");
  sub.add_option("-o,--output", command->outputs,
                 "What to write, by extension: .bts (TurbSim, OpenFAST), .vti (ParaView: the frozen gusts as "
                 "a box); may be repeated. Without any output, numbers and a verdict are printed")
      ->allow_extra_args(false);
  sub.add_option("--report", command->report,
                 "Settings, mean [m/s], deviation [m/s], spectra [(m/s)^2/Hz] by height and coherence by "
                 "distance [m] beside their targets, seconds and memory, as JSON");
  sub.add_option("--plot", command->plot, "The same as a picture (.svg)");
  sub.add_option("--spectra", command->spectra,
                 "The spectra of u, v and w alone, in the row nearest the reference height (.svg)");
  sub.add_flag("--list-terrains", command->list_terrains, "List the terrains and their numbers");

  command->wind.add_to(sub, false);
  command->reference_option = sub.get_option("--reference-height");
  command->of_synthesis = command->grid.add_to(sub);
  command->of_synthesis.push_back(
      sub.add_flag("--tile", command->tile,
                   "The field repeats itself across and up too, one spacing beyond its "
                   "last points")
          ->group("Grid"));
  command->of_synthesis.push_back(
      sub.add_option(
             "--match", command->match,
             "What the deviations are to be. spectrum: every frequency has the power of the model, and what "
             "is slower than the loop is missing. The others scale the spectra, shape kept, up to the whole "
             "of the model's variance: variance: each row, in the mean over seeds; hub: exactly at the point "
             "nearest the reference height, everywhere by one number a component; points: exactly at each "
             "point, by its own")
          ->transform(CLI::IsMember({"spectrum", "variance", "hub", "points"}, CLI::ignore_case))
          ->capture_default_str()
          ->group("Grid"));

  command->of_vectors = command->vectors.add_to(sub);

  const char* check = "Check";
  sub.add_option("--bands", command->bands_per_decade,
                 "Frequency bands per decade in report and plot (1 to 1000)")
      ->capture_default_str()
      ->group(check);
  sub.add_option("--separations", command->separations,
                 "Distances at which coherence is measured [cells of the grid]")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->capture_default_str()
      ->group(check);
  sub.add_option(
         "--segment", command->segment_length,
         "Length of the segments that a field that is not periodic is cut into [steps]; 0: a quarter of it")
      ->capture_default_str()
      ->group(check);
  command->threads.add_to(sub);
  sub.footer(
      "Examples:\n"
      "  tremula wind --wind-speed 6 --terrain open -o gusts.bts --plot gusts.svg\n"
      "  tremula wind --spectrum iec-kaimal --wind-speed 12 --reference-height 90 --profile power:0.2 \\\n"
      "      --points 51x51 --size 145x145 --center-height 90 --steps 4096 --step 0.1 --seed 1 \\\n"
      "      -o field.bts --report wind.json\n"
      "  tremula wind field.bts --spectrum iec-kaimal --turbulence-intensity 0.16 --plot check.svg\n"
      "  tremula wind field.bts -o field.vti\n"
      "  tremula wind --points 81x1 --size 80x0 --period 20 --vectors gusts.svg\n"
      "  tremula wind field.bts --plot check.svg --separations 1,3,9 --bands 5\n");
  sub.callback([command] {
    if (command->list_terrains) {
      print(terrain_table());
      return;
    }
    command->threads.run([&] { command->run(); });
  });
}

}  // namespace tremula::cli
