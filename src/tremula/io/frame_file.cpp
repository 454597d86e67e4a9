#include "tremula/io/frame_file.hpp"

#include "tremula/base/error.hpp"
#include "tremula/base/number_text.hpp"
#include "tremula/base/suggestion.hpp"
#include "tremula/io/atomic_file.hpp"
#include "tremula/io/plate_keys.hpp"
#include "tremula/io/toml_reading.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <utility>
#include <vector>

namespace tremula {
namespace {

constexpr std::size_t largest_file = std::size_t{16} << 20, most_elements = 200'000;
constexpr int most_pieces = 1000;

// What reading goes through: the name of the file for messages, and the points as they are met.
struct Reader : TomlPlace {
  FrameFile result = {};
  std::map<std::string, int, std::less<>> points = {};
};

int point_named(const Reader& reader, const toml::node& node, const std::string& what) {
  const std::string name = text(reader, node, what, "the name of a point");
  const auto found = reader.points.find(name);
  if (found != reader.points.end()) return found->second;
  std::vector<std::string> names;
  for (const auto& [known, index] : reader.points) names.push_back(known);
  reader.fail(node, what, "no point '" + name + "'" + suggestion(name, names), "one of [points]");
}

Material material_of(const Reader& reader, const toml::node& node) {
  if (const toml::table* table = node.as_table()) {
    check_keys(reader, *table, "a material", {"youngs_modulus", "shear_modulus", "density"});
    const auto value = [&](const char* key, const char* wanted) {
      return number(reader, needed(reader, *table, key, "material"), key, 1e-15, wanted);
    };
    Material material;
    material.youngs_modulus = value("youngs_modulus", "a number above 0 [Pa]");
    material.shear_modulus = value("shear_modulus", "a number above 0 [Pa]");
    material.density = value("density", "a number above 0 [kg/m^3]");
    material.source = "the file";
    return material;
  }
  const std::string name =
      text(reader, node, "material", "the name of a material, or a table of its numbers");
  try {
    return find_material(name);
  } catch (const InputError& error) {
    throw InputError(reader.file + ":" + std::to_string(node.source().begin.line) + ":" +
                     std::to_string(node.source().begin.column) + ": " + error.what());
  }
}

int pieces_of(const Reader& reader, const toml::node& node) {
  const auto value = node.value_exact<std::int64_t>();
  if (!value || *value < 1 || *value > most_pieces)
    reader.fail(node, "pieces", kind_of(node), "a whole number from 1 to " + std::to_string(most_pieces));
  return static_cast<int>(*value);
}

void read_points(Reader& reader, const toml::table& file) {
  const toml::node& node = needed(reader, file, "points", "frame");
  if (!node.is_table()) reader.fail(node, "points", kind_of(node), "a table of names and positions [m]");
  for (const auto& [key, value] : *node.as_table()) {
    const std::string what = "point '" + std::string(key.str()) + "'";
    const toml::array& position = list(reader, value, what.c_str(), "three numbers [m]");
    if (position.size() != 3)
      reader.fail(value, what, std::to_string(position.size()) + " numbers", "three [m]");
    Vec3 point;
    for (std::size_t i = 0; i < 3; ++i)
      point[static_cast<Eigen::Index>(i)] = number(reader, position[i], what, -1e6, "metres within 1000 km");
    reader.points.emplace(key.str(), static_cast<int>(reader.result.frame.nodes.size()));
    reader.result.frame.nodes.push_back(point);
  }
}

// Radii at the beginning and the end of a beam.
std::array<double, 2> radii(const Reader& reader, const toml::node& node) {
  const std::string wanted = "a radius above 0 m, or two of them";
  if (!node.is_array()) {
    const double radius = number(reader, node, "radius", 1e-9, wanted);
    return {radius, radius};
  }
  const toml::array& both = *node.as_array();
  if (both.size() != 2) reader.fail(node, "radius", std::to_string(both.size()) + " numbers", wanted);
  return {number(reader, both[0], "radius", 1e-9, wanted), number(reader, both[1], "radius", 1e-9, wanted)};
}

// What a beam is like all along.
struct BeamKeys {
  std::array<double, 2> radius;
  double wall;  // [m]; 0: solid
  Material material;
  int pieces;
};

double wall_of(const Reader& reader, const toml::table& beam, const std::array<double, 2>& radius) {
  const toml::node* node = beam.get("wall");
  if (node == nullptr) return 0;
  const double thinner = std::min(radius[0], radius[1]);
  const std::string wanted =
      "a thickness above 0 m and up to the radius, " + number_text(thinner) + " m; none for a solid beam";
  const double wall = number(reader, *node, "wall", 1e-9, wanted);
  if (wall > thinner) reader.fail(*node, "wall", number_text(wall) + " m", wanted);
  return wall;
}

// One straight piece after the other, through new nodes between the points.
void add_beam(Reader& reader, const toml::node& beam, const std::vector<int>& through, const BeamKeys& keys) {
  const std::array<double, 2>& radius = keys.radius;
  const int pieces = keys.pieces;
  Frame& frame = reader.result.frame;
  const auto node = [&](int i) { return frame.nodes[static_cast<std::size_t>(i)]; };
  double whole = 0, done = 0;
  for (std::size_t i = 0; i + 1 < through.size(); ++i)
    whole += (node(through[i + 1]) - node(through[i])).norm();
  for (std::size_t i = 0; i + 1 < through.size(); ++i) {
    const Vec3 start = node(through[i]), end = node(through[i + 1]);
    const double length = (end - start).norm();
    if (!(length > 0)) reader.fail(beam, "beam", "two points at one place", "a length above 0");
    int last = through[i];
    for (int piece = 1; piece <= pieces; ++piece) {
      int next = through[i + 1];
      if (piece < pieces) {
        next = static_cast<int>(frame.nodes.size());
        frame.nodes.push_back(start + (end - start) * piece / pieces);
      }
      const auto at = [&](double share) {
        return radius[0] + (radius[1] - radius[0]) * (done + share * length) / whole;
      };
      const double before = at(static_cast<double>(piece - 1) / pieces),
                   after = at(static_cast<double>(piece) / pieces);
      frame.elements.push_back({last, next, before, after, keys.material,
                                keys.wall > 0 ? std::min(1.0, 2 * keys.wall / (before + after)) : 1});
      last = next;
    }
    done += length;
    if (frame.elements.size() > most_elements) {
      reader.fail(beam, "beams", "more than " + std::to_string(most_elements) + " pieces",
                  "fewer beams or fewer pieces");
    }
  }
}

void read_beams(Reader& reader, const toml::table& file) {
  const Material material =
      file.contains("material") ? material_of(reader, *file.get("material")) : find_material("green-wood");
  const int pieces = file.contains("pieces") ? pieces_of(reader, *file.get("pieces")) : 4;
  const toml::node& node = needed(reader, file, "beams", "frame");
  for (const toml::node& entry : list(reader, node, "beams", "[[beams]]")) {
    if (!entry.is_table()) reader.fail(entry, "beams", kind_of(entry), "[[beams]]");
    const toml::table& beam = *entry.as_table();
    check_keys(reader, beam, "a beam", {"through", "radius", "wall", "material", "pieces"});
    std::vector<int> through;
    const toml::node& names = needed(reader, beam, "through", "beam");
    for (const toml::node& name : list(reader, names, "through", "names of points"))
      through.push_back(point_named(reader, name, "through"));
    if (through.size() < 2)
      reader.fail(names, "through", std::to_string(through.size()) + " points", "two or more");
    const std::array<double, 2> radius = radii(reader, needed(reader, beam, "radius", "beam"));
    add_beam(reader, entry, through,
             {radius, wall_of(reader, beam, radius),
              beam.contains("material") ? material_of(reader, *beam.get("material")) : material,
              beam.contains("pieces") ? pieces_of(reader, *beam.get("pieces")) : pieces});
  }
}

void read_masses(Reader& reader, const toml::table& file) {
  const toml::node* node = file.get("masses");
  if (node == nullptr) return;
  for (const toml::node& entry : list(reader, *node, "masses", "[[masses]]")) {
    if (!entry.is_table()) reader.fail(entry, "masses", kind_of(entry), "[[masses]]");
    const toml::table& mass = *entry.as_table();
    check_keys(reader, mass, "a mass", {"at", "mass"});
    reader.result.frame.masses.push_back(
        {point_named(reader, needed(reader, mass, "at", "mass"), "at"),
         number(reader, needed(reader, mass, "mass", "mass"), "mass", 0, "0 kg or more")});
  }
}

// A unit vector.
Vec3 direction_of(const Reader& reader, const toml::table& panel, const char* key, const Vec3& otherwise) {
  const toml::node* node = panel.get(key);
  if (node == nullptr) return otherwise;
  const char* wanted = "a direction in three numbers";
  const std::vector<double> along = numbers(reader, *node, key, 3, -1e6, wanted);
  const Vec3 direction(along[0], along[1], along[2]);
  if (!(direction.norm() > 1e-9)) reader.fail(*node, key, "no direction", wanted);
  return direction.normalized();
}

std::vector<PanelFixing> fixings_of(const Reader& reader, const toml::table& panel) {
  const char* wanted = "places and names of points [[x, y, \"point\"], ...]";
  std::vector<PanelFixing> fixings;
  for (const toml::node& entry : list(reader, needed(reader, panel, "fixed", "panel"), "fixed", wanted)) {
    const toml::array& fixing = list(reader, entry, "fixed", wanted);
    if (fixing.size() != 3) reader.fail(entry, "fixed", "a list of " + std::to_string(fixing.size()), wanted);
    const double x = number(reader, fixing[0], "fixed", 0, "two numbers on the panel [m], and a point"),
                 y = number(reader, fixing[1], "fixed", 0, "two numbers on the panel [m], and a point");
    fixings.push_back({{x, y}, point_named(reader, fixing[2], "fixed")});
  }
  return fixings;
}

void read_panels(Reader& reader, const toml::table& file) {
  const toml::node* node = file.get("panels");
  if (node == nullptr) return;
  Frame& frame = reader.result.frame;
  for (const toml::node& entry : list(reader, *node, "panels", "[[panels]]")) {
    if (!entry.is_table()) reader.fail(entry, "panels", kind_of(entry), "[[panels]]");
    const toml::table& table = *entry.as_table();
    check_keys(reader, table, "a panel",
               {"width", "height", "thickness", "youngs_modulus", "poisson_ratio", "density", "elements",
                "corner", "along_width", "along_height", "fixed"});
    Panel panel;
    panel.sheet.elements = {8, 8};
    read_plate(reader, table, "panel", panel.sheet);
    const std::vector<double> corner = numbers(reader, needed(reader, table, "corner", "panel"), "corner", 3,
                                               -1e6, "three numbers within 1000 km [m]");
    panel.sheet.corner = {corner[0], corner[1], corner[2]};
    panel.sheet.along_width = direction_of(reader, table, "along_width", Vec3::UnitX());
    panel.sheet.along_height = direction_of(reader, table, "along_height", Vec3::UnitZ());
    panel.fixed = fixings_of(reader, table);
    const std::size_t index = frame.panels.size();
    try {
      check_panel(panel, index, frame.nodes);
    } catch (const InputError& error) {
      const toml::source_position at = entry.source().begin;
      throw InputError(reader.file + ":" + std::to_string(at.line) + ":" + std::to_string(at.column) + ": " +
                       error.what());
    }
    frame.panels.push_back(std::move(panel));
  }
}

FrameFile read_text(const std::string& text_of_file, const std::string& name) {
  const toml::table file = parse_toml(text_of_file, name);
  Reader reader{{name}};
  check_keys(reader, file, "a frame",
             {"name", "material", "pieces", "clamped", "points", "beams", "masses", "panels"});
  if (const toml::node* title = file.get("name")) reader.result.name = text(reader, *title, "name", "a name");
  read_points(reader, file);
  const toml::node& clamped = needed(reader, file, "clamped", "frame");
  for (const toml::node& point : list(reader, clamped, "clamped", "names of points"))
    reader.result.frame.clamped.push_back(point_named(reader, point, "clamped"));
  read_beams(reader, file);
  read_masses(reader, file);
  read_panels(reader, file);
  try {
    check_frame(reader.result.frame);
  } catch (const InputError& error) {
    throw InputError(name + ": " + error.what());
  }
  return std::move(reader.result);
}

}  // namespace

FrameFile parse_frame(const std::string& text_of_file, const std::string& name) {
  return with_printable_errors(name, [&] { return read_text(text_of_file, name); });
}

FrameFile read_frame(const std::string& path) { return parse_frame(read_file(path, largest_file), path); }

}  // namespace tremula
