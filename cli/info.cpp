// tremula info: what is in a file, in numbers.

#include "tremula/io/text_table.hpp"
#include "tremula/io/turbsim.hpp"
#include "tremula/structure/plausibility.hpp"

#include <cmath>

#include "commands.hpp"
#include "common.hpp"
#include "wind_report.hpp"

namespace tremula::cli {
namespace {

struct TowerStatistics {
  std::array<Json, 3> mean, deviation;
};

TowerStatistics tower_statistics(const WindField& field) {
  TowerStatistics statistics;
  const auto count = static_cast<std::size_t>(field.tower_count);
  for (std::size_t c = 0; c < 3; ++c) {
    statistics.mean[c] = statistics.deviation[c] = Json::array();
    for (std::size_t k = 0; k < count; ++k) {
      const std::vector<float>& values = field.tower[c];
      const double steps = field.grid.step_count;
      double mean = 0, variance = 0;
      for (std::size_t i = k; i < values.size(); i += count) mean += static_cast<double>(values[i]) / steps;
      for (std::size_t i = k; i < values.size(); i += count)
        variance += std::pow(static_cast<double>(values[i]) - mean, 2) / steps;
      statistics.mean[c].push_back(mean);
      statistics.deviation[c].push_back(std::sqrt(variance));
    }
  }
  return statistics;
}

struct InfoCommand {
  std::string input, format = "table";
  ReadFlags read;

  void run() const {
    if (lower_extension(input) == ".bts") {
      read.refuse_for(input);
      run_on_wind();
    } else {
      run_on_plant();
    }
  }

  void run_on_plant() const;
  void run_on_wind() const;
};

// Of a tree of the default material; null, and a warning, where that could not stand.
Json load_margin_of(const Skeleton& skeleton, std::vector<std::string>& warnings) {
  try {
    const double factor = assemble(skeleton, StructureOptions{}).find_load_margin().factor;
    return std::isfinite(factor) ? Json(factor) : Json();
  } catch (const InputError& error) {
    warnings.push_back("as " + StructureOptions{}.material.name + ", " + error.what());
    return {};
  }
}

void InfoCommand::run_on_plant() const {
  const Plant plant = open_plant(input, read);
  std::vector<std::string> warnings;
  Json json = describe(plant);
  if (plant.is_tree()) {
    warnings = plausibility(plant.imported.skeleton, {});
    json["load_margin"] = load_margin_of(plant.imported.skeleton, warnings);
  }
  print_warnings(warnings);
  json["warnings"] = warnings;
  std::string text = text_of(json);
  if (format == "json") {
    print(text);
    return;
  }
  text.clear();
  for (const auto& [key, value] : json.items()) {
    if (key == "repairs" || key == "warnings") continue;
    text += key + std::string(key.size() < 16 ? 16 - key.size() : 1, ' ') +
            (value.is_string() ? value.get<std::string>() : value.dump()) + '\n';
  }
  for (const Repair& repair : plant.imported.repairs) text += "repaired        " + repair.message + '\n';
  print(text);
}

std::string line_of(double height, const std::array<double, 3>& mean,
                    const std::array<double, 3>& deviation) {
  return printed("%10.3f %9.3f %9.3f %9.3f %9.3f %9.3f %9.3f\n", height, mean[0], mean[1], mean[2],
                 deviation[0], deviation[1], deviation[2]);
}

// What is said of a wind, in whatever format.
struct FoundWind {
  const TurbSimFile& file;
  const WindGrid& grid;
  FieldStatistics statistics;
  TowerStatistics tower;
};

// Rows of the grid, from its bottom to its top.
Json by_point(const std::array<std::vector<double>, 3>& values, const WindGrid& grid) {
  std::array<Json, 3> components;
  for (std::size_t c = 0; c < 3; ++c) {
    components[c] = Json::array();
    for (int i = 0; i < grid.z_count; ++i) {
      const auto first = values[c].begin() + static_cast<std::ptrdiff_t>(i) * grid.y_count;
      components[c].push_back(std::vector<double>(first, first + grid.y_count));
    }
  }
  return by_component(components);
}

Json as_json(const FoundWind& found) {
  const auto& [file, grid, statistics, tower] = found;
  std::vector<double> heights, across, tower_heights;
  for (int i = 0; i < grid.z_count; ++i) heights.push_back(grid.z(i));
  for (int j = 0; j < grid.y_count; ++j) across.push_back(grid.y(j));
  for (int k = 0; k < file.tower_count; ++k) tower_heights.push_back(file.tower_height(k));
  Json json = {{"format", "turbsim-bts"},
               {"id", file.periodic ? 8 : 7},
               {"text", printable(file.text)}};  // who wrote it may have put anything there
  json.update(describe(grid));
  json.update(Json{{"tower_points", file.tower_count},
                   {"slope", file.slope},
                   {"offset", file.offset},
                   {"y_m", across},
                   {"z_m", heights},
                   {"mean_m_s", by_point(statistics.point_mean, grid)},
                   {"deviation_m_s", by_point(statistics.point_deviation, grid)},
                   {"tower",
                    {{"z_m", tower_heights},
                     {"mean_m_s", by_component(tower.mean)},
                     {"deviation_m_s", by_component(tower.deviation)}}}});
  return json;
}

std::string as_table(const FoundWind& found) {
  const auto& [file, grid, statistics, tower] = found;
  std::string text = printed("format      turbsim-bts (id %d, %s)\n", file.periodic ? 8 : 7,
                             file.periodic ? "periodic" : "not periodic");
  text += printed("text        %s\n", printable(file.text).c_str());
  text += printed("grid        %d x %d points (y x z), %.6g x %.6g m apart, from z = %.6g m\n", grid.y_count,
                  grid.z_count, grid.y_spacing, grid.z_spacing, grid.bottom);
  text += printed("tower       %d points\n", file.tower_count);
  text += printed("time        %d steps of %.6g s: %.6g s\n", grid.step_count, grid.step, grid.period());
  text += printed("mean speed  %.6g m/s at %.6g m\n\n", grid.mean_speed, grid.reference_height);
  text += printed("%10s %9s %9s %9s %9s %9s %9s\n", "height_m", "mean_u", "mean_v", "mean_w", "dev_u",
                  "dev_v", "dev_w");
  for (auto row = statistics.rows.rbegin(); row != statistics.rows.rend(); ++row)
    text += line_of(row->height, row->mean, row->deviation);
  if (file.tower_count > 0) text += "tower\n";
  for (int k = 0; k < file.tower_count; ++k) {
    std::array<double, 3> mean, deviation;
    for (std::size_t c = 0; c < 3; ++c) {
      mean[c] = tower.mean[c][index_of(k)].get<double>();
      deviation[c] = tower.deviation[c][index_of(k)].get<double>();
    }
    text += line_of(file.tower_height(k), mean, deviation);
  }
  return text;
}

void InfoCommand::run_on_wind() const {
  const TurbSimFile file = read_turbsim(input);
  const WindField field = wind_field(file);
  const FoundWind found{file, field.grid, field_moments(field), tower_statistics(field)};
  print(format == "json" ? text_of(as_json(found)) : as_table(found));
}

}  // namespace

void add_info(CLI::App& app) {
  auto command = std::make_shared<InfoCommand>();
  CLI::App& sub =
      *app.add_subcommand("info", "What is in a file: counts, extents, repairs, load margin, wind by height");
  sub.add_option(
         "FILE", command->input,
         "A tree file, an L-system (.lsys), a frame (.toml), the name of a preset, or a wind field (.bts)")
      ->required();
  sub.add_option("--format", command->format, "table or json")
      ->check(CLI::IsMember({"table", "json"}))
      ->capture_default_str();
  command->read.add_to(sub);
  sub.footer(
      "Examples:\n"
      "  tremula info scan.mat\n"
      "  tremula info oak --format json\n"
      "  tremula info field.bts                         mean and deviation [m/s] by height\n");
  sub.callback([command] { command->run(); });
}

}  // namespace tremula::cli
