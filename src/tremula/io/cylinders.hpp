// Cylinders fitted to a scan, whichever file they came from, and who carries whom.
#pragma once

#include "tremula/io/skeleton_files.hpp"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace tremula {

struct Cylinder {
  Vec3 start = Vec3::Zero(), end = Vec3::Zero();  // in the unit of the file
  double radius = 0;
  double wall = 1;        // its thickness over the radius
  double parent = 0;      // as it stands in the file; NaN: nothing does
  std::size_t place = 0;  // line, or number of the cylinder
};

struct CylinderModel {
  std::string path;
  bool place_is_line = true;
  double resolution = 0x1p-52;  // see RawTree
  std::vector<Cylinder> cylinders;
  // What parents name, one a cylinder; empty: parents count cylinders, from 1.
  std::vector<long long> ids;
  std::string id_name = "ID", parent_name = "parent";  // what the columns are called
  bool missing_parent_is_ground = false;  // a parent that names no cylinder is where the plant stands
  std::vector<Repair> repairs;
};

// "tree.txt:7" or "tree.mat: cylinder 7".
std::string place(const CylinderModel& model, const Cylinder& cylinder);

// Throws InputError unless the radius is a size, start and end are coordinates.
void check_cylinder(const CylinderModel& model, const Cylinder& cylinder);

// The end of a cylinder given by its axis. Throws InputError unless the length is 0 or more and the axis,
// where there is a length, within 1 % of a unit vector.
Vec3 end_by_axis(const CylinderModel& model, const Cylinder& cylinder, double length, const Vec3& axis);

// Finds the parents and mends what can be mended. Where there are no ids and counting from 1 cannot be meant
// (a parent out of range, a circle, children that start far from their parents), counting from 0 is tried,
// and a repair says so.
ImportedSkeleton to_skeleton(CylinderModel model, const std::string& format, const ReadOptions& options);

}  // namespace tremula
