// Plant files for the tests of the readers: texts, and MATLAB files made with libmatio.
#pragma once

#include <filesystem>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <matio.h>
#include <nlohmann/json.hpp>

#include "complaint.hpp"
#include "support.hpp"
#include "tremula/base/error.hpp"
#include "tremula/io/skeleton_files.hpp"

namespace tremula::test {

inline void write_text(const std::string& path, std::string_view text) {
  std::ofstream file(path, std::ios::binary);
  file.write(text.data(), static_cast<std::streamsize>(text.size()));
  if (!file.flush()) throw std::runtime_error("cannot write " + path);
}

inline ImportedSkeleton read_text(std::string_view text) { return read_skeleton(text, "plant"); }

inline std::string complaint_about_bytes(std::string_view bytes, const std::string& name) {
  return complaint_of([&] { read_skeleton(bytes, name); });
}

// The same of a file, with the folder cut off.
inline std::string complaint_about(const std::string& path) {
  std::string text = complaint_of([&] { read_skeleton(path); });
  const std::string folder = std::filesystem::path(path).parent_path().string() + "/";
  return text.starts_with(folder) ? text.substr(folder.size()) : text;
}

inline std::size_t count_of(const ImportedSkeleton& imported, const std::string& kind) {
  std::size_t count = 0;
  for (const Repair& repair : imported.repairs) count += repair.kind == kind ? repair.count : 0;
  return count;
}

inline std::string message_of(const ImportedSkeleton& imported, const std::string& kind) {
  for (const Repair& repair : imported.repairs) {
    if (repair.kind == kind) return repair.message;
  }
  return "";
}

inline nlohmann::json validation_item(const std::string& id) {
  std::ifstream file(data_folder() / "validation.json");
  const nlohmann::json document = nlohmann::json::parse(file);
  for (const nlohmann::json& item : document.at("items")) {
    if (item.at("id") == id) return item;
  }
  throw std::runtime_error("validation.json has no item " + id);
}

// MATLAB variables, owned until they are saved or given to a struct.
using MatVariable = std::unique_ptr<matvar_t, decltype(&Mat_VarFree)>;

inline MatVariable mat_array(const std::string& name, std::size_t rows, std::size_t columns,
                             const std::vector<double>& values, matio_classes type = MAT_C_DOUBLE) {
  std::size_t dimensions[] = {rows, columns};
  const auto make = [&](auto zero, matio_types stored) {
    std::vector<decltype(zero)> converted(values.begin(), values.end());
    return MatVariable(Mat_VarCreate(name.c_str(), type, stored, 2, dimensions, converted.data(), 0),
                       Mat_VarFree);
  };
  switch (type) {
    case MAT_C_SINGLE:
      return make(0.0f, MAT_T_SINGLE);
    case MAT_C_UINT16:
      return make(std::uint16_t{0}, MAT_T_UINT16);
    case MAT_C_INT32:
      return make(std::int32_t{0}, MAT_T_INT32);
    case MAT_C_UINT64:
      return make(std::uint64_t{0}, MAT_T_UINT64);
    default:
      return make(0.0, MAT_T_DOUBLE);
  }
}

inline MatVariable mat_text(const std::string& name, std::string text) {
  std::size_t dimensions[] = {1, text.size()};
  return {Mat_VarCreate(name.c_str(), MAT_C_CHAR, MAT_T_UTF8, 2, dimensions, text.data(), 0), Mat_VarFree};
}

inline MatVariable mat_complex(const std::string& name, std::vector<double> real,
                               std::vector<double> imaginary) {
  std::size_t dimensions[] = {real.size(), 1};
  mat_complex_split_t parts{real.data(), imaginary.data()};
  return {Mat_VarCreate(name.c_str(), MAT_C_DOUBLE, MAT_T_DOUBLE, 2, dimensions, &parts, MAT_F_COMPLEX),
          Mat_VarFree};
}

// A struct array; elements[i] holds the fields of element i, all with the same names.
inline MatVariable mat_struct(const std::string& name, std::vector<std::vector<MatVariable>> elements) {
  std::vector<const char*> names;
  for (const MatVariable& field : elements.at(0)) names.push_back(field->name);
  std::size_t dimensions[] = {1, elements.size()};
  MatVariable made(
      Mat_VarCreateStruct(name.c_str(), 2, dimensions, names.data(), static_cast<unsigned>(names.size())),
      Mat_VarFree);
  for (std::size_t i = 0; i < elements.size(); ++i) {
    for (MatVariable& field : elements[i]) {
      const std::string field_name = field->name;
      Mat_VarSetStructFieldByName(made.get(), field_name.c_str(), i, field.release());
    }
  }
  return made;
}

inline void save_mat(const std::string& path, std::vector<MatVariable> variables, bool compressed = true) {
  const std::unique_ptr<mat_t, decltype(&Mat_Close)> file(Mat_CreateVer(path.c_str(), nullptr, MAT_FT_MAT5),
                                                          Mat_Close);
  for (const MatVariable& variable : variables) {
    if (Mat_VarWrite(file.get(), variable.get(), compressed ? MAT_COMPRESSION_ZLIB : MAT_COMPRESSION_NONE) !=
        0) {
      throw std::runtime_error("libmatio cannot write " + path);
    }
  }
}

// Cylinders as TreeQSM has them: parents from 1, 0 = none.
struct CylinderTable {
  std::vector<double> radius, length;
  std::vector<Vec3> start, axis;
  std::vector<double> parent;

  void add(double r, double l, const Vec3& s, const Vec3& a, double p) {
    radius.push_back(r);
    length.push_back(l);
    start.push_back(s);
    axis.push_back(a);
    parent.push_back(p);
  }
  std::size_t size() const { return radius.size(); }
};

inline std::vector<double> by_column(const std::vector<Vec3>& points) {
  std::vector<double> values;
  for (int axis = 0; axis < 3; ++axis) {
    for (const Vec3& point : points) values.push_back(point[axis]);
  }
  return values;
}

inline std::vector<MatVariable> mat_cylinder_fields(const CylinderTable& table, bool old_names = false,
                                                    matio_classes real = MAT_C_DOUBLE,
                                                    matio_classes whole = MAT_C_DOUBLE) {
  const std::size_t n = table.size();
  std::vector<MatVariable> fields;
  fields.push_back(mat_array(old_names ? "Rad" : "radius", n, 1, table.radius, real));
  fields.push_back(mat_array(old_names ? "Len" : "length", n, 1, table.length, real));
  fields.push_back(mat_array(old_names ? "Sta" : "start", n, 3, by_column(table.start), real));
  fields.push_back(mat_array(old_names ? "Axe" : "axis", n, 3, by_column(table.axis), real));
  fields.push_back(mat_array(old_names ? "CPar" : "parent", n, 1, table.parent, whole));
  return fields;
}

// name.cylinder.{radius,length,start,axis,parent}
inline MatVariable mat_model(const std::string& name, std::vector<MatVariable> cylinder_fields) {
  std::vector<std::vector<MatVariable>> cylinder(1), model(1);
  cylinder[0] = std::move(cylinder_fields);
  model[0].push_back(mat_struct("cylinder", std::move(cylinder)));
  return mat_struct(name, std::move(model));
}

inline void save_model(const std::string& path, std::vector<MatVariable> cylinder_fields,
                       bool compressed = true) {
  std::vector<MatVariable> variables;
  variables.push_back(mat_model("QSM", std::move(cylinder_fields)));
  save_mat(path, std::move(variables), compressed);
}

// A stem of two cylinders and a branch.
inline CylinderTable small_table() {
  CylinderTable table;
  table.add(0.05, 1, {0, 0, 0}, {0, 0, 1}, 0);
  table.add(0.04, 1, {0, 0, 1}, {0, 0, 1}, 1);
  table.add(0.02, 0.5, {0, 0, 1}, {1, 0, 0}, 1);
  return table;
}

}  // namespace tremula::test
