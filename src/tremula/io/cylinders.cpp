#include "tremula/io/cylinders.hpp"

#include "tremula/base/error.hpp"
#include "tremula/io/id_index.hpp"
#include "tremula/io/nearest_branch.hpp"
#include "tremula/io/repair.hpp"
#include "tremula/io/text_table.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace tremula {
namespace {

constexpr int no_parent = -1;

// A way of reading the numbers of parents.
struct Counting {
  int from;                         // the number of the first cylinder
  double root;                      // what a cylinder without parent has
  bool first_names_itself = false;  // besides, the first may
};

constexpr Counting from_one{1, 0};

// Index of every parent, or nothing where a number fits no cylinder or the parents go round in a circle.
std::optional<std::vector<int>> parents_counted(const CylinderModel& model, const Counting& counting) {
  const int count = static_cast<int>(model.cylinders.size());
  std::vector<int> parents;
  parents.reserve(model.cylinders.size());
  for (int k = 0; k < count; ++k) {
    const double number = model.cylinders[k].parent;
    const double index = number - counting.from;
    if (number == counting.root || (counting.first_names_itself && k == 0 && index == 0)) {
      parents.push_back(no_parent);
    } else if (index >= 0 && index < count && index == std::floor(index)) {
      parents.push_back(static_cast<int>(index));
    } else {
      return {};
    }
  }
  std::vector<int> seen(model.cylinders.size(), -1);  // from which cylinder the walk to the root came by
  for (int k = 0; k < count; ++k) {
    for (int p = k; p >= 0 && seen[p] < 0; p = parents[p]) {
      seen[p] = k;
      if (parents[p] >= 0 && seen[parents[p]] == k) return {};
    }
  }
  return parents;
}

// How far children start from the axes of their parents, all together.
double total_gap(const CylinderModel& model, const std::vector<int>& parents) {
  double sum = 0;
  for (std::size_t k = 0; k < parents.size(); ++k) {
    if (parents[k] < 0) continue;
    const Cylinder& parent = model.cylinders[parents[k]];
    sum += std::sqrt(squared_distance(model.cylinders[k].start, {parent.start, parent.end}));
  }
  return sum;
}

double total_length(const CylinderModel& model) {
  double sum = 0;
  for (const Cylinder& cylinder : model.cylinders) sum += (cylinder.end - cylinder.start).norm();
  return sum;
}

// Reads them as counted from 1 and says what is against it: a number out of range, or a cylinder that is its
// own parent. Longer circles are named by repair().
std::vector<int> parents_by_the_book(const CylinderModel& model) {
  const std::string count = std::to_string(model.cylinders.size());
  std::vector<int> parents;
  for (std::size_t k = 0; k < model.cylinders.size(); ++k) {
    const Cylinder& cylinder = model.cylinders[k];
    const double number = cylinder.parent;
    if (!(number >= 0 && number <= static_cast<double>(model.cylinders.size())) ||
        number != std::floor(number)) {
      throw InputError(place(model, cylinder), model.parent_name + " is " + shown(number),
                       "0 or the number of one of the " + count + " cylinders");
    }
    if (number == static_cast<double>(k + 1)) {
      throw InputError(place(model, cylinder),
                       model.parent_name + " is " + shown(number) +
                           ", the cylinder itself (were rows taken out? Parents count the rows of the whole "
                           "table)",
                       "all rows, or a column of ids that parents name");
    }
    parents.push_back(static_cast<int>(number) - 1);
  }
  return parents;
}

std::vector<int> parents_by_number(CylinderModel& model) {
  const auto usual = parents_counted(model, from_one);
  // Children that start a whole parent away from theirs make gaps as long as the wood; those of real scans
  // add up to a twentieth of it.
  const double length = total_length(model);
  const double usual_gap = usual ? total_gap(model, *usual) : HUGE_VAL;
  if (usual_gap <= 0.3 * length) return *usual;
  struct Other {
    Counting counting;
    const char* message;
  };
  constexpr Other others[] = {
      {{0, -1}, "parents count cylinders from 0, and -1 is none: so they were read"},
      {{1, -1}, "parents count cylinders from 1, and -1 is none: so they were read"},
      {{0, std::numeric_limits<double>::quiet_NaN(), true},
       "parents count cylinders from 0, and the first names itself: so they were read"},
  };
  for (const Other& other : others) {
    const auto parents = parents_counted(model, other.counting);
    if (!parents) continue;
    const double gap = total_gap(model, *parents);
    if (gap > 0.3 * length || gap > 0.1 * usual_gap) continue;
    model.repairs.push_back({"parents_counted_otherwise", model.cylinders.size(), other.message});
    return *parents;
  }
  return usual ? *usual : parents_by_the_book(model);
}

std::vector<int> parents_by_id(const CylinderModel& model, const ReadOptions& options) {
  std::vector<std::size_t> lines;
  for (const Cylinder& cylinder : model.cylinders) lines.push_back(cylinder.place);
  const IdIndex index(model.ids, lines, model.path, model.id_name);
  std::vector<int> parents;
  for (const Cylinder& cylinder : model.cylinders) {
    const double number = cylinder.parent;
    const int parent = is_whole_number(number) ? index.find(static_cast<long long>(number)) : -1;
    // Where no row has the id 0, it says that there is no parent.
    if (parent < 0 && !std::isnan(number) && number != -1 && number != 0 && !model.missing_parent_is_ground &&
        !options.allow_gaps) {
      throw InputError(place(model, cylinder),
                       model.parent_name + " is " + shown(number) + ", and no row has that " + model.id_name +
                           " (were rows taken out?)",
                       "-1 or the " + model.id_name +
                           " of a cylinder in this file, or --allow-gaps to join what it carried");
    }
    parents.push_back(parent);
  }
  return parents;
}

}  // namespace

std::string place(const CylinderModel& model, const Cylinder& cylinder) {
  return model.path + (model.place_is_line ? ":" : ": cylinder ") + std::to_string(cylinder.place);
}

void check_cylinder(const CylinderModel& model, const Cylinder& cylinder) {
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
  constexpr const char* start[] = {"start x", "start y", "start z"};
  constexpr const char* end[] = {"end x", "end y", "end z"};
  for (int i = 0; i < 3; ++i) check_size(start[i], cylinder.start[i]);
  for (int i = 0; i < 3; ++i) check_size(end[i], cylinder.end[i]);
}

Vec3 end_by_axis(const CylinderModel& model, const Cylinder& cylinder, double length, const Vec3& axis) {
  const auto reject = [&](const std::string& what, double value, const std::string& wanted) {
    throw InputError(place(model, cylinder), what + " is " + shown(value), wanted);
  };
  if (!std::isfinite(length)) reject("length", length, "a finite number");
  if (length < 0) reject("length", length, "0 or more");
  if (length > largest_size) reject("length", length, "at most " + shown(largest_size));
  constexpr const char* names[] = {"axis x", "axis y", "axis z"};
  for (int i = 0; i < 3; ++i) {
    if (!std::isfinite(axis[i])) reject(names[i], axis[i], "a finite number");
  }
  if (length == 0) return cylinder.start;  // may have no axis
  // Files keep four decimals or single precision of a unit vector.
  const double norm = axis.norm();
  if (std::abs(norm - 1) > 0.01) {
    throw InputError(place(model, cylinder), "length of the axis is " + rounded(norm), "1");
  }
  return cylinder.start + length * axis.normalized();
}

ImportedSkeleton to_skeleton(CylinderModel model, const std::string& format, const ReadOptions& options) {
  const std::vector<int> parents =
      model.ids.empty() ? parents_by_number(model) : parents_by_id(model, options);
  RawTree tree;
  tree.path = model.path;
  tree.place_is_line = model.place_is_line;
  tree.resolution = model.resolution;
  tree.repairs = std::move(model.repairs);
  tree.branches.reserve(model.cylinders.size());
  for (std::size_t k = 0; k < parents.size(); ++k) {
    const Cylinder& cylinder = model.cylinders[k];
    RawBranch branch{cylinder.start, cylinder.end, cylinder.radius, cylinder.radius, parents[k], 0,
                     cylinder.place, cylinder.wall};
    if (branch.parent < 0) {
      branch.root = static_cast<int>(tree.roots.size());
      tree.roots.push_back(cylinder.start);
    }
    tree.branches.push_back(branch);
  }
  return repair(std::move(tree), format, CarrierRule::nearer_end, options);
}

}  // namespace tremula
