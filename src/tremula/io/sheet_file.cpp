#include "tremula/io/sheet_file.hpp"

#include "tremula/base/suggestion.hpp"
#include "tremula/io/atomic_file.hpp"
#include "tremula/io/plate_keys.hpp"
#include "tremula/io/toml_reading.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace tremula {
namespace {

constexpr std::size_t largest_file = std::size_t{1} << 20;

constexpr std::array<std::pair<const char*, SheetEdge>, 4> edges{{{"left", SheetEdge::left},
                                                                  {"right", SheetEdge::right},
                                                                  {"bottom", SheetEdge::bottom},
                                                                  {"top", SheetEdge::top}}};

std::vector<SheetEdge> edges_of(const TomlPlace& place, const toml::table& table, const char* key) {
  std::vector<SheetEdge> result;
  const toml::node* node = table.get(key);
  if (node == nullptr) return result;
  const char* wanted = "some of left, right, bottom, top";
  for (const toml::node& entry : list(place, *node, key, "a list of edges: left, right, bottom, top")) {
    const std::string name = text(place, entry, key, wanted);
    std::vector<std::string> names;
    for (const auto& [known, edge] : edges) {
      if (name == known) result.push_back(edge);
      names.emplace_back(known);
    }
    if (std::find(names.begin(), names.end(), name) == names.end())
      place.fail(entry, key, "no edge '" + name + "'" + suggestion(name, names), wanted);
  }
  return result;
}

MembraneForce tension_of(const TomlPlace& place, const toml::node& node) {
  const char* wanted = "a pull along the width and one along the height [N/m], or one for both";
  constexpr double any = -1e15;
  if (!node.is_array()) {
    const double pull = number(place, node, "tension", any, wanted);
    return {pull, pull, 0};
  }
  const std::vector<double> pulls = numbers(place, node, "tension", 2, any, wanted);
  return {pulls[0], pulls[1], 0};
}

void place_in_world(const TomlPlace& place, const toml::table& table, Sheet& sheet) {
  if (const toml::node* node = table.get("corner")) {
    const std::vector<double> corner =
        numbers(place, *node, "corner", 3, -1e6, "three numbers within 1000 km [m]");
    sheet.corner = {corner[0], corner[1], corner[2]};
  }
  if (const toml::node* node = table.get("heading")) {
    const double heading = number(place, *node, "heading", -1e6, "degrees") * std::numbers::pi / 180;
    sheet.along_width = {std::cos(heading), std::sin(heading), 0};
  }
}

Sheet sheet_of(const TomlPlace& place, const toml::table& table) {
  check_keys(place, table, "a sheet",
             {"width", "height", "thickness", "youngs_modulus", "poisson_ratio", "density", "elements",
              "clamp", "pin", "points", "tension", "cloth", "corner", "heading"});
  Sheet sheet;
  read_plate(place, table, "sheet", sheet);
  sheet.clamped = edges_of(place, table, "clamp");
  sheet.pinned = edges_of(place, table, "pin");
  if (const toml::node* node = table.get("points")) {
    for (const toml::node& entry : list(place, *node, "points", "a list of places [[x, y], ...]")) {
      const std::vector<double> at = numbers(place, entry, "points", 2, 0, "two numbers on the sheet [m]");
      sheet.pinned_points.emplace_back(at[0], at[1]);
    }
  }
  if (const toml::node* node = table.get("tension")) sheet.tension = tension_of(place, *node);
  if (const toml::node* node = table.get("cloth")) {
    if (!node->is_boolean()) place.fail(*node, "cloth", kind_of(*node), "true or false");
    sheet.wrinkles = node->as_boolean()->get();
  }
  place_in_world(place, table, sheet);
  if (sheet.clamped.empty() && sheet.pinned.empty() && sheet.pinned_points.empty())
    place.fail(table, "sheet", "clamped nowhere", "clamp or pin with an edge: left, right, bottom, top");
  try {
    check_sheet(sheet);
  } catch (const InputError& error) {
    const toml::source_position at = table.source().begin;
    throw InputError(place.file + ":" + std::to_string(at.line) + ":" + std::to_string(at.column) + ": " +
                     error.what());
  }
  return sheet;
}

SheetFile read_text(const std::string& text_of_file, const std::string& name) {
  const toml::table file = parse_toml(text_of_file, name);
  const TomlPlace place{name};
  check_keys(place, file, "a sheet file", {"name", "sheet"});
  SheetFile result;
  if (const toml::node* title = file.get("name")) result.name = text(place, *title, "name", "a name");
  const toml::node& table = needed(place, file, "sheet", "file");
  if (!table.is_table()) place.fail(table, "sheet", kind_of(table), "a table [sheet]");
  result.sheet = sheet_of(place, *table.as_table());
  return result;
}

}  // namespace

bool is_sheet_file(const std::string& text) {
  try {
    return parse_toml(text, "").contains("sheet");
  } catch (const InputError&) {
    return false;  // whoever reads it says why
  }
}

SheetFile parse_sheet(const std::string& text_of_file, const std::string& name) {
  return with_printable_errors(name, [&] { return read_text(text_of_file, name); });
}

SheetFile read_sheet(const std::string& path) { return parse_sheet(read_file(path, largest_file), path); }

}  // namespace tremula
