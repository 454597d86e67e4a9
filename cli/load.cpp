// tremula load: what a plant and its root bear, wind speed by wind speed.

#include "tremula/base/error.hpp"
#include "tremula/dynamics/gauge.hpp"
#include "tremula/structure/plausibility.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <functional>
#include <memory>

#include "commands.hpp"
#include "common.hpp"
#include "load_flags.hpp"
#include "tremula/wind/profile.hpp"
#include "usage.hpp"
#include "wind_flags.hpp"

namespace tremula::cli {
namespace {

// One wind speed. Moments are those at the base of the thickest stem.
struct LoadRow {
  double wind_speed, mean_drag;          // m/s, N
  Extremes base_moment, surface_strain;  // N m, 1
  double lean;                           // the farthest that an end stands from rest [m]
  double drag_exponent;                  // d ln drag/d ln speed, between this row and its neighbours
  int most_strained_branch;              // at its foot
  Extremes largest_strain;
};

// What the plant can bear, and the wind that asks it of it.
struct Limits {
  double calm_moment = 0;         // that the weight of an uneven crown brings along the wind [N m]
  double modulus_of_rupture = 0;  // Pa
  std::optional<double> breaks_at = {}, root_turns_at = {};  // m/s
};

struct LoadCommand {
  std::string input, speeds = "5:40:5", format, output = "-";
  double period = 60, duration = 600, damping_ratio = Damping{}.ratio;
  int mode_count = 20;
  std::optional<double> modulus_of_rupture, root_moment_capacity;
  ReadFlags read;
  StructureFlags structure;
  WindFlags wind;
  LoadFlags loads;
  ThreadsFlag threads;

  Weather weather(double speed) const;
  Limits limits_of(const std::vector<LoadRow>& rows, const Material& material) const;
  Subject bake_plant(const Plant& plant, const StructureOptions& options, StageLog& log) const;
  void run(const CLI::App& flags) const;
};

constexpr double slowest_wind = 1e-3, fastest_wind = 100;  // [m/s]
constexpr int most_speeds = 1000;

// "5:40:5" is from 5 to 40 by 5; "5,10,20"; "12".
std::vector<double> wind_speeds(const std::string& text) {
  const auto refuse = [&] {
    throw InputError("--wind-speed", "'" + text + "'",
                     "FIRST:LAST:STEP or a list such as 5,10,20, rising, within 0.001 to 100 m/s");
  };
  std::vector<double> numbers;
  const bool range = text.find(':') != std::string::npos;
  const char *at = text.data(), *end = at + text.size();
  for (;;) {
    double value = 0;
    const auto parsed = std::from_chars(at, end, value);
    if (parsed.ec != std::errc{} || !std::isfinite(value)) refuse();
    numbers.push_back(value);
    if (parsed.ptr == end) break;
    if (*parsed.ptr != (range ? ':' : ',') || static_cast<int>(numbers.size()) == most_speeds) refuse();
    at = parsed.ptr + 1;
  }
  if (range) {
    if (numbers.size() != 3 || !(numbers[2] > 0)) refuse();
    const double first = numbers[0], step = numbers[2],
                 count = std::floor((numbers[1] - first) / step + 1e-9);
    if (!(count >= 0 && count < most_speeds)) refuse();
    numbers.clear();
    for (int i = 0; i <= static_cast<int>(count); ++i) numbers.push_back(first + i * step);
  }
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (!(numbers[i] >= slowest_wind && numbers[i] <= fastest_wind) ||
        (i > 0 && numbers[i] <= numbers[i - 1]))
      refuse();
  }
  return numbers;
}

Weather LoadCommand::weather(double speed) const {
  WindFlags flags = wind;
  flags.speed = speed;
  Weather weather;
  weather.wind = flags.wind();
  loads.set(structure, weather);
  weather.damping.ratio = damping_ratio;
  weather.loop = {period, static_cast<int>(std::lround(period * 20))};
  return weather;
}

// Between neighbours, and at the ends to the only one.
void find_exponents(std::vector<LoadRow>& rows) {
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const LoadRow &low = rows[i == 0 ? 0 : i - 1], &high = rows[std::min(i + 1, rows.size() - 1)];
    const double ratio = std::log(high.wind_speed / low.wind_speed);
    rows[i].drag_exponent =
        low.mean_drag > 0 && ratio > 0 ? std::log(high.mean_drag / low.mean_drag) / ratio : 2;
  }
}

// The wind speed at which the size of what rises with it reaches a limit: a power law between two rows.
std::optional<double> speed_at(const std::vector<LoadRow>& rows, double limit,
                               const std::function<double(const LoadRow&)>& value) {
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double high = std::abs(value(rows[i]));
    if (high < limit) continue;
    if (i == 0) return high == limit ? std::optional(rows[0].wind_speed) : std::nullopt;
    const double low = std::abs(value(rows[i - 1]));
    const double share = std::log(limit / low) / std::log(high / low);
    return rows[i - 1].wind_speed * std::pow(rows[i].wind_speed / rows[i - 1].wind_speed, share);
  }
  return {};
}

std::string as_table(const std::vector<LoadRow>& rows, const Limits& limits, const LoadCommand& command,
                     double youngs_modulus) {
  std::string text =
      printed("%14s %12s %14s %13s %14s %8s %9s %10s\n", "wind_speed_m_s", "mean_drag_n", "mean_base_n_m",
              "rms_base_n_m", "peak_base_n_m", "lean_m", "exponent", "stress_mpa");
  for (const LoadRow& row : rows) {
    text += printed("%14.4g %12.4g %14.5g %13.5g %14.5g %8.3f %9.3f %10.3g\n", row.wind_speed, row.mean_drag,
                    row.base_moment.mean, row.base_moment.rms, row.base_moment.expected_peak, row.lean,
                    row.drag_exponent, 1e-6 * youngs_modulus * row.surface_strain.expected_peak);
  }
  text += printed("peaks are those of %g s (Davenport); of the moments %.5g N m are there in calm air\n",
                  command.duration, limits.calm_moment);
  if (limits.modulus_of_rupture == 0) {
    text += "no modulus of rupture is known\n";
  } else if (limits.breaks_at) {
    text += printed("the foot of the stem reaches %.3g MPa, its modulus of rupture, at %.3g m/s\n",
                    1e-6 * limits.modulus_of_rupture, *limits.breaks_at);
  } else {
    text += printed(
        "the foot of the stem does not reach %.3g MPa, its modulus of rupture, between these speeds\n",
        1e-6 * limits.modulus_of_rupture);
  }
  if (!command.root_moment_capacity) return text;
  if (limits.root_turns_at) {
    return text + printed("the root reaches %.4g N m, all it holds, at %.3g m/s\n",
                          *command.root_moment_capacity, *limits.root_turns_at);
  }
  return text + printed("the root does not reach %.4g N m, all it holds, between these speeds\n",
                        *command.root_moment_capacity);
}

std::string as_csv(const std::vector<LoadRow>& rows, double youngs_modulus) {
  std::string text =
      "wind_speed_m_s,mean_drag_n,mean_base_moment_n_m,rms_base_moment_n_m,peak_base_moment_n_m,lean_m,"
      "drag_exponent,peak_stress_pa\n";
  for (const LoadRow& row : rows) {
    text += printed("%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.6g,%.9g\n", row.wind_speed, row.mean_drag,
                    row.base_moment.mean, row.base_moment.rms, row.base_moment.expected_peak, row.lean,
                    row.drag_exponent, youngs_modulus * row.surface_strain.expected_peak);
  }
  return text;
}

Json as_json(const std::vector<LoadRow>& rows, const Limits& limits, const LoadCommand& command,
             double youngs_modulus, const std::vector<std::string>& warnings) {
  Json list = Json::array();
  for (const LoadRow& row : rows) {
    list.push_back({{"wind_speed_m_s", row.wind_speed},
                    {"mean_drag_n", row.mean_drag},
                    {"mean_base_moment_n_m", row.base_moment.mean},
                    {"rms_base_moment_n_m", row.base_moment.rms},
                    {"peak_base_moment_n_m", row.base_moment.expected_peak},
                    {"largest_base_moment_of_the_loop_n_m", row.base_moment.peak},
                    {"peak_factor", row.base_moment.peak_factor},
                    {"skewness_of_base_moment", row.base_moment.skewness},
                    {"peak_stress_pa", youngs_modulus * row.surface_strain.expected_peak},
                    {"most_stressed_branch", row.most_strained_branch},
                    {"peak_stress_of_that_branch_pa", youngs_modulus * row.largest_strain.expected_peak},
                    {"lean_m", row.lean},
                    {"drag_exponent", row.drag_exponent}});
  }
  const auto number = [](const std::optional<double>& value) { return value ? Json(*value) : Json(); };
  return {{"rows", list},
          {"peaks_of_s", command.duration},
          {"base_moment_in_calm_n_m", limits.calm_moment},
          {"modulus_of_rupture_pa", limits.modulus_of_rupture},
          {"breaks_at_m_s", number(limits.breaks_at)},
          {"root_moment_capacity_n_m", number(command.root_moment_capacity)},
          {"root_turns_at_m_s", number(limits.root_turns_at)},
          {"settings", describe(command.loads)},
          {"warnings", warnings}};
}

// The moment at the foot along the wind, over the loop.
GaugeSeries base_of(const Motion& motion, const Weather& weather) {
  return gauge_series(motion.readings.front(), motion, weather.wind.reference.heading);
}

// That without wind: the weight of a crown that is not even.
double moment_in_calm_air(const Subject& subject, Weather weather) {
  const double heading = weather.wind.reference.heading;
  weather.wind = turbulent_wind({.speed = 0, .heading = heading}, 0.2);
  weather.loop = {1, 1};
  return base_of(set_in_motion(subject, weather), weather).along_wind.mean();
}

LoadRow row_of(const Subject& subject, const Weather& weather, double duration) {
  const Motion motion = set_in_motion(subject, weather);
  const GaugeSeries series = base_of(motion, weather);
  return {weather.wind.reference.speed,
          motion.mean_drag.dot(heading_direction(weather.wind.reference.heading)),
          extremes_of(series.along_wind, motion.period, duration),
          extremes_of(series.strain, motion.period, duration),
          motion_statistics(subject.structure, motion).largest_lean,
          0,
          motion.most_strained[0].gauge.branch,
          extremes_of(gauge_series(motion.most_strained[0], motion, weather.wind.reference.heading).strain,
                      motion.period, duration)};
}

Limits LoadCommand::limits_of(const std::vector<LoadRow>& rows, const Material& material) const {
  Limits limits{.modulus_of_rupture = modulus_of_rupture.value_or(material.modulus_of_rupture)};
  if (limits.modulus_of_rupture > 0) {
    limits.breaks_at = speed_at(rows, limits.modulus_of_rupture, [&](const LoadRow& row) {
      return material.youngs_modulus * row.surface_strain.expected_peak;
    });
  }
  if (root_moment_capacity) {
    limits.root_turns_at = speed_at(rows, *root_moment_capacity,
                                    [](const LoadRow& row) { return row.base_moment.expected_peak; });
  }
  return limits;
}

Subject LoadCommand::bake_plant(const Plant& plant, const StructureOptions& options, StageLog& log) const {
  const int most = 6 * plant.imported.skeleton.branch_count();
  const int count = mode_count < 0 || mode_count > most ? all_modes : mode_count;
  return bake(plant.imported.skeleton, {.structure = options, .modes = {.count = count}},
              [&](std::string_view stage, double done) { log.progress(stage, done); });
}

void LoadCommand::run(const CLI::App& flags) const {
  loads.check(flags);
  const std::vector<double> all_speeds = wind_speeds(speeds);
  const std::size_t form =
      format_of({"-o", output}, format == "table" ? "txt" : format,
                {{"txt", "a table"}, {"json", "with everything"}, {"csv", "a row a speed"}}, 0);
  Outputs outputs({{"-o", output}},
                  {{"INPUT", input}, {"--spectrum", wind.spectrum}, {"--profile", wind.profile}});
  std::vector<Weather> conditions;  // what is wrong with the flags is said first
  for (const double speed : all_speeds) conditions.push_back(weather(speed));
  StageLog log;
  log.begin("read");
  const Plant plant = under_weight(open_plant(input, read), structure);
  log.finish();
  print_warnings(plant);
  need_tree(plant, "load");
  const StructureOptions options = structure.options();
  const Subject subject = bake_plant(plant, options, log);
  std::vector<std::string> warnings =
      plausibility(plant.imported.skeleton, options, subject.modes.frequency[0]);

  const Gauge base = place_gauge(plant.imported.skeleton, "base");
  std::vector<LoadRow> rows;
  for (Weather& each : conditions) {
    each.gauges = {base};
    each.most_strained = 1;
    rows.push_back(row_of(subject, each, duration));
    log.progress("wind speeds", static_cast<double>(rows.size()) / static_cast<double>(conditions.size()));
  }
  log.finish();
  find_exponents(rows);
  Limits limits = limits_of(rows, options.material);
  limits.calm_moment = moment_in_calm_air(subject, conditions.front());
  if (limits.modulus_of_rupture == 0) {
    warnings.push_back("the modulus of rupture of " + options.material.name +
                       " is not known: give --modulus-of-rupture");
  }
  print_warnings(warnings);
  const double youngs_modulus = options.material.youngs_modulus;
  outputs.add(output, form == 1   ? text_of(as_json(rows, limits, *this, youngs_modulus, warnings))
                      : form == 2 ? as_csv(rows, youngs_modulus)
                                  : as_table(rows, limits, *this, youngs_modulus));
  outputs.commit();
}

}  // namespace

void add_load(CLI::App& app) {
  auto command = std::make_shared<LoadCommand>();
  CLI::App& sub = *app.add_subcommand("load", "Drag, moments and lean of a plant, wind speed by wind speed");
  sub.add_option("INPUT", command->input,
                 "A tree file (SWC, TreeQSM .mat or text, SimpleForest CSV), an L-system (.lsys) or a preset")
      ->required();
  sub.add_option(
         "--wind-speed", command->speeds,
         "Mean wind speeds at the reference height [m/s]: FIRST:LAST:STEP, or a list such as 5,10,20. "
         "In water, those of the current (0.1:0.8:0.1 for a plant that lives there)")
      ->capture_default_str();
  sub.add_option("--format", command->format, "table, json or csv, where no extension says it")
      ->check(CLI::IsMember({"table", "json", "csv"}))
      ->default_str("table");
  sub.add_option("-o,--output", command->output,
                 "File to write instead of standard output: .txt (table), .json or .csv");
  sub.add_option("--peak-duration", command->duration,
                 "How long the wind blows whose largest moment is told (Davenport's peak factor) [s]")
      ->capture_default_str();
  sub.add_option("--modulus-of-rupture", command->modulus_of_rupture,
                 "Bending stress at which the wood breaks [Pa] (default: that of the material)");
  sub.add_option("--root-moment-capacity", command->root_moment_capacity,
                 "Moment at which the root gives way [N m]; tells the wind that it takes");
  sub.add_option("--modes", command->mode_count, "How many of the lowest modes move the plant; -1: all")
      ->capture_default_str();
  sub.add_option("--period", command->period, "Length of the loop that rms and peaks are taken from [s]")
      ->capture_default_str();
  sub.add_option("--damping-ratio", command->damping_ratio, "Of every mode, 1 is critical")
      ->capture_default_str();
  command->loads.add_to(sub, "Loads");
  command->wind.add_to(sub, true, false);
  command->read.add_to(sub);
  command->structure.add_to(sub);
  command->threads.add_to(sub);
  sub.footer(
      "Examples:\n"
      "  tremula load oak\n"
      "  tremula load scan.mat --wind-speed 10:40:2 --material oak --format csv -o loads.csv\n"
      "  tremula load oak --wind-speed 20,30 --profile constant --root-moment-capacity 5e4 --format json\n");
  sub.callback([command, &sub] {
    const Habitat habitat = habitat_of(command->input);
    command->structure.settle_in(habitat);
    if (habitat.in_water && sub.count("--wind-speed") == 0) command->speeds = "0.1:0.8:0.1";
    command->threads.run([&] { command->run(sub); });
  });
}

}  // namespace tremula::cli
