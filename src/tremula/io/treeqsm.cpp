#include "tremula/io/treeqsm.hpp"

#include "tremula/base/error.hpp"
#include "tremula/io/cylinders.hpp"
#include "tremula/io/matlab_file.hpp"
#include "tremula/io/text_table.hpp"

#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

namespace tremula {
namespace {

Cylinder cylinder(const CylinderModel& model, double radius, double length, const Vec3& start,
                  const Vec3& axis, double parent, std::size_t place) {
  Cylinder made{.start = start, .end = start, .radius = radius, .parent = parent, .place = place};
  check_cylinder(model, made);
  made.end = end_by_axis(model, made, length, axis);
  return made;
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

// The fields of a struct that holds cylinders.
Arrays fields_of(const MatlabArray& cylinder, const std::string& where) {
  if (cylinder.is_struct() && cylinder.size() > 1) {
    throw InputError(where, "an array of " + std::to_string(cylinder.size()) + " structs",
                     "one struct of arrays with a row for each cylinder");
  }
  Arrays arrays{where, new_names, {}};
  for (std::size_t i = 0; i < new_names.size(); ++i) {
    arrays.array[i] = find_field(cylinder, new_names[i], where);
  }
  return arrays;
}

bool holds_cylinders(const MatlabArray& array, const std::string& where) {
  return array.is_struct() && array.size() > 0 && find_field(array, "radius", where) &&
         find_field(array, "axis", where);
}

// The names of what a file holds, for people.
std::string contents(const MatlabFile& file) {
  std::string text;
  for (std::size_t i = 0; i < file.variables.size() && i < 6; ++i) {
    const MatlabArray& variable = file.variables[i];
    text += (text.empty() ? "" : ", ") + shown(variable.name) + " (" + kind_of(variable) + ")";
  }
  if (file.variables.size() > 6) text += ", ...";
  return text.empty() ? "nothing" : text;
}

Arrays find_arrays(const MatlabFile& file, std::vector<Repair>& repairs) {
  std::vector<const MatlabArray*> candidates;  // the usual names first
  for (const char* name : {"QSM", "OptQSM", "QSMs", "qsm", "cylinder"}) {
    if (const MatlabArray* variable = file.find(name)) candidates.push_back(variable);
  }
  for (const MatlabArray& variable : file.variables) candidates.push_back(&variable);
  for (const MatlabArray* variable : candidates) {
    std::string where = file.path + ": " + shown(variable->name);
    std::optional<MatlabArray> model = *variable;
    if (variable->is_cell()) {
      model = first_cell(*variable, where);
      where += "{1}";
    }
    if (!model || !model->is_struct()) continue;
    if (holds_cylinders(*model, where)) return fields_of(*model, where);
    const std::optional<MatlabArray> cylinder = find_field(*model, "cylinder", where);
    if (!cylinder) continue;
    note_others(repairs, *variable);
    return fields_of(*cylinder, where + ".cylinder");
  }
  for (const auto& names : {old_names, new_names}) {
    Arrays arrays{file.path, names, {}};
    bool any = false;
    for (std::size_t i = 0; i < names.size(); ++i) {
      const MatlabArray* variable = file.find(names[i]);
      if (variable == nullptr) continue;
      arrays.array[i] = *variable;
      any = true;
    }
    if (any) return arrays;
  }
  throw InputError(
      file.path, "a MATLAB file that holds " + contents(file),
      "a TreeQSM model: a struct QSM with a field cylinder, a struct cylinder, or the arrays Rad "
      "Len Sta Axe CPar");
}

}  // namespace

ImportedSkeleton read_treeqsm_text(std::string_view text, const std::string& path,
                                   const ReadOptions& options) {
  CylinderModel model;
  model.path = path;
  TextLines lines{text};
  std::string_view line;
  std::size_t columns = 0;
  while (lines.next(line)) {
    if (line.empty() || line[0] == '#') continue;
    const Fields fields = split_at_blanks(line);
    const TableRow row{path, lines.number, fields};
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
    model.cylinders.push_back(cylinder(model, value[0], value[1], {value[2], value[3], value[4]},
                                       {value[5], value[6], value[7]}, value[8], row.line));
  }
  return to_skeleton(std::move(model), "treeqsm-text", options);
}

ImportedSkeleton read_treeqsm_mat(std::string_view bytes, const std::string& path,
                                  const ReadOptions& options) {
  const MatlabFile file = read_matlab_file(bytes, path);
  CylinderModel model;
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
    model.cylinders.push_back(cylinder(model, values[radius_array][k], values[length_array][k],
                                       row(values[start_array]), row(values[axis_array]),
                                       values[parent_array][k], k + 1));
  }
  return to_skeleton(std::move(model), "treeqsm-mat", options);
}

}  // namespace tremula
