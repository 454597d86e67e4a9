#include "tremula/io/treeqsm.hpp"

#include "tremula/base/error.hpp"
#include "tremula/io/matlab_file.hpp"
#include "tremula/io/repair.hpp"
#include "tremula/io/text_table.hpp"

#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

namespace tremula {
namespace {

struct Cylinder {
  double radius, length;  // [m]
  Vec3 start, axis;       // [m], unit vector
  double parent;          // number of a cylinder from 1, or 0
  std::size_t place;      // line, or number of the cylinder
};

struct Model {
  std::string path;
  bool place_is_line = true;
  double resolution = 0x1p-52;
  std::vector<Cylinder> cylinders;
  std::vector<Repair> repairs;
};

std::string place(const Model& model, const Cylinder& cylinder) {
  return model.path + (model.place_is_line ? ":" : ": cylinder ") + std::to_string(cylinder.place);
}

void check(const Model& model, const Cylinder& cylinder, std::size_t count) {
  const auto reject = [&](const std::string& what, double value, const std::string& wanted) {
    throw InputError(place(model, cylinder), what + " is " + shown(value), wanted);
  };
  const auto check_size = [&](const char* what, double value) {
    if (!std::isfinite(value)) reject(what, value, "a finite number");
    if (std::abs(value) > largest_size) reject(what, value, "at most " + shown(largest_size));
  };
  check_size("radius", cylinder.radius);
  if (cylinder.radius <= 0) reject("radius", cylinder.radius, "a number above 0");
  if (cylinder.radius < smallest_size) reject("radius", cylinder.radius, "at least " + shown(smallest_size));
  check_size("length", cylinder.length);
  if (cylinder.length < 0) reject("length", cylinder.length, "0 or more");
  constexpr const char* start[] = {"start x", "start y", "start z"};
  constexpr const char* axis[] = {"axis x", "axis y", "axis z"};
  for (int i = 0; i < 3; ++i) check_size(start[i], cylinder.start[i]);
  for (int i = 0; i < 3; ++i) check_size(axis[i], cylinder.axis[i]);
  // Files keep four decimals or single precision of a unit vector. One of zero length may have no axis.
  const double norm = cylinder.axis.norm();
  if (cylinder.length > 0 && std::abs(norm - 1) > 0.01) {
    throw InputError(place(model, cylinder), "length of the axis is " + rounded(norm), "1");
  }
  if (!(cylinder.parent >= 0 && cylinder.parent <= static_cast<double>(count)) ||
      cylinder.parent != std::floor(cylinder.parent)) {
    reject("parent", cylinder.parent,
           "0 or the number of one of the " + std::to_string(count) + " cylinders");
  }
}

ImportedSkeleton to_skeleton(Model model, const std::string& format) {
  RawTree tree;
  tree.path = model.path;
  tree.place_is_line = model.place_is_line;
  tree.resolution = model.resolution;
  tree.repairs = std::move(model.repairs);
  tree.branches.reserve(model.cylinders.size());
  for (const Cylinder& cylinder : model.cylinders) {
    RawBranch branch;
    branch.start = branch.end = cylinder.start;
    if (cylinder.length > 0) branch.end += cylinder.length * cylinder.axis.normalized();
    branch.start_radius = branch.end_radius = cylinder.radius;
    branch.parent = static_cast<int>(cylinder.parent) - 1;
    branch.place = cylinder.place;
    if (branch.parent < 0) {
      branch.root = static_cast<int>(tree.roots.size());
      tree.roots.push_back(cylinder.start);
    }
    tree.branches.push_back(branch);
  }
  return repair(std::move(tree), format, RootRule::base, CarrierRule::nearer_end);
}

// One model of a MATLAB file: the five arrays by the names of its version.
struct Arrays {
  std::string where;  // for messages
  std::array<const char*, 5> names;
  std::array<std::optional<MatlabArray>, 5> array;
};
enum { radius_array, length_array, start_array, axis_array, parent_array };
constexpr std::array<const char*, 5> new_names = {"radius", "length", "start", "axis", "parent"};
constexpr std::array<const char*, 5> old_names = {"Rad", "Len", "Sta", "Axe", "CPar"};

void note_others(std::vector<Repair>& repairs, const MatlabArray& models) {
  if (models.size() <= 1) return;
  repairs.push_back(
      {"first_of_several", models.size() - 1,
       "the first of " + std::to_string(models.size()) + " models in " + shown(models.name) + " read"});
}

Arrays find_arrays(const MatlabFile& file, std::vector<Repair>& repairs) {
  std::vector<const MatlabArray*> candidates;  // the usual names first
  for (const char* name : {"QSM", "OptQSM", "QSMs", "qsm"}) {
    if (const MatlabArray* variable = file.find(name)) candidates.push_back(variable);
  }
  for (const MatlabArray& variable : file.variables) candidates.push_back(&variable);
  for (const MatlabArray* variable : candidates) {
    if (!variable->is_struct()) continue;
    const std::string where = file.path + ": " + shown(variable->name);
    const std::optional<MatlabArray> cylinder = find_field(*variable, "cylinder", where);
    if (!cylinder) continue;
    note_others(repairs, *variable);
    Arrays arrays{where + ".cylinder", new_names, {}};
    for (std::size_t i = 0; i < new_names.size(); ++i) {
      arrays.array[i] = find_field(*cylinder, new_names[i], arrays.where);
    }
    return arrays;
  }
  Arrays arrays{file.path, old_names, {}};
  bool any = false;
  for (std::size_t i = 0; i < old_names.size(); ++i) {
    const MatlabArray* variable = file.find(old_names[i]);
    if (variable == nullptr) continue;
    arrays.array[i] = *variable;
    any = true;
  }
  if (!any) {
    throw InputError(
        file.path, "a MATLAB file without cylinders",
        "a TreeQSM model: a struct QSM with a field cylinder, or the arrays Rad Len Sta Axe CPar");
  }
  return arrays;
}

}  // namespace

bool is_treeqsm_header(std::string_view line) {
  return line.starts_with("radius") && line.find("length") != std::string_view::npos &&
         line.find("axis") != std::string_view::npos && line.find("parent") != std::string_view::npos;
}

ImportedSkeleton read_treeqsm_text(std::string_view text, const std::string& path) {
  Model model;
  model.path = path;
  TextLines lines{text};
  std::string_view line;
  std::size_t columns = 0;
  bool header_may_come = true;
  while (lines.next(line)) {
    if (line.empty() || line[0] == '#') continue;
    if (std::exchange(header_may_come, false) && is_treeqsm_header(line)) continue;
    const Fields fields = split_at_blanks(line);
    const Row row{path, lines.number, fields};
    if (columns == 0 && (fields.count == 15 || fields.count == 17)) columns = fields.count;
    if (fields.count != columns) {
      throw InputError(row.place(), counted(fields.count, "column"),
                       columns == 0 ? "the 15 or 17 of TreeQSM: radius length start(3) axis(3) parent ..."
                                    : std::to_string(columns) + " as in the lines before");
    }
    if (model.cylinders.size() == most_branches) {
      throw InputError(row.place(), "yet another cylinder", "at most " + std::to_string(most_branches));
    }
    constexpr const char* names[] = {"radius", "length", "start x", "start y", "start z",
                                     "axis x", "axis y", "axis z",  "parent"};
    double value[9];
    for (std::size_t c = 0; c < 9; ++c) value[c] = row.number(c, names[c]);
    for (std::size_t c = 9; c < columns; ++c) {
      double ignored;
      if (!parse_number(fields.at[c], ignored))
        row.reject(c, ("column " + std::to_string(c + 1)).c_str(), "a number");
    }
    model.cylinders.push_back({value[0],
                               value[1],
                               {value[2], value[3], value[4]},
                               {value[5], value[6], value[7]},
                               value[8],
                               row.line});
  }
  for (const Cylinder& cylinder : model.cylinders) check(model, cylinder, model.cylinders.size());
  return to_skeleton(std::move(model), "treeqsm-text");
}

ImportedSkeleton read_treeqsm_mat(std::string_view bytes, const std::string& path) {
  const MatlabFile file = read_matlab_file(bytes, path);
  Model model;
  model.path = path;
  model.place_is_line = false;
  const Arrays arrays = find_arrays(file, model.repairs);

  std::array<std::vector<double>, 5> values;
  std::size_t count = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::string where = arrays.where + (arrays.names == old_names ? ": " : ".") + arrays.names[i];
    if (!arrays.array[i]) throw InputError(where, "missing", "an array of numbers");
    const MatlabArray& array = *arrays.array[i];
    if (i == radius_array) count = array.size();
    if (count > most_branches) {
      throw InputError(where, std::to_string(count) + " cylinders",
                       "at most " + std::to_string(most_branches));
    }
    const bool is_vector = i == start_array || i == axis_array;
    const bool fits =
        is_vector ? array.dimensions == std::vector<std::size_t>{count, 3} : array.size() == count;
    if (!fits) {
      std::string found;
      for (const std::size_t n : array.dimensions) found += (found.empty() ? "" : " x ") + std::to_string(n);
      throw InputError(
          where, found + " numbers",
          std::to_string(count) + (is_vector ? " x 3" : "") + " for as many cylinders as have a radius");
    }
    values[i] = numbers(array, where);
    if (i == start_array && array.is_single()) model.resolution = 0x1p-23;
  }
  for (std::size_t k = 0; k < count; ++k) {
    const auto row = [&](const std::vector<double>& v) { return Vec3(v[k], v[count + k], v[2 * count + k]); };
    model.cylinders.push_back({values[radius_array][k], values[length_array][k], row(values[start_array]),
                               row(values[axis_array]), values[parent_array][k], k + 1});
    check(model, model.cylinders.back(), count);
  }
  return to_skeleton(std::move(model), "treeqsm-mat");
}

}  // namespace tremula
