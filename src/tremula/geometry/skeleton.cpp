#include "tremula/geometry/skeleton.hpp"

#include "tremula/base/error.hpp"
#include "tremula/geometry/skeleton_checks.hpp"

#include <charconv>
#include <cmath>
#include <utility>

namespace tremula {
namespace {

std::string shown(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

[[noreturn]] void reject(const std::string& name, const char* what, std::size_t index,
                         const std::string& found, const std::string& wanted) {
  throw InputError(name + ": " + what + " " + std::to_string(index), found, wanted);
}

void check_point(const Vec3& point, const std::string& name, const char* what, std::size_t index,
                 const char* which) {
  for (int axis = 0; axis < 3; ++axis) {
    if (std::isfinite(point[axis])) continue;
    reject(name, what, index, std::string(which) + " " + "xyz"[axis] + " is " + shown(point[axis]),
           "a finite number");
  }
}

void check_size(double size, const std::string& name, const char* what, std::size_t index,
                const char* which) {
  if (std::isfinite(size) && size > 0) return;
  reject(name, what, index, std::string(which) + " is " + shown(size), "a finite number above 0");
}

void check_unit(const Vec3& axis, const std::string& name, std::size_t leaf, const char* which) {
  if (std::abs(axis.norm() - 1) <= 1e-6) return;
  reject(name, "leaf", leaf, std::string(which) + " has length " + shown(axis.norm()), "a unit vector");
}

}  // namespace

void check_skeleton(const Skeleton& skeleton, const std::string& name, const SkeletonLeniency& leniency) {
  if (skeleton.roots.empty()) throw InputError(name, "no root", "at least one");
  if (skeleton.branches.empty()) throw InputError(name, "no branch", "at least one");
  if (!skeleton.origin.allFinite()) throw InputError(name, "the origin is not finite", "finite coordinates");
  for (std::size_t k = 0; k < skeleton.roots.size(); ++k) {
    check_point(skeleton.roots[k], name, "root", k, "coordinate");
  }
  for (std::size_t k = 0; k < skeleton.branches.size(); ++k) {
    const Branch& branch = skeleton.branches[k];
    const int end_node = skeleton.end_node(static_cast<int>(k));
    if (branch.start_node < 0 || branch.start_node >= end_node) {
      reject(name, "branch", k, "start node is " + std::to_string(branch.start_node),
             "a root or the end of an earlier branch (0 to " + std::to_string(end_node - 1) + ")");
    }
    check_point(branch.start, name, "branch", k, "start");
    check_point(branch.end, name, "branch", k, "end");
    check_size(branch.start_radius, name, "branch", k, "start radius");
    check_size(branch.end_radius, name, "branch", k, "end radius");
    if (!(branch.wall > 0 && branch.wall <= 1)) {
      reject(name, "branch", k, "its wall is " + shown(branch.wall) + " of the radius",
             "above 0, and no thicker than the radius (1: solid)");
    }
    if (branch.length() == 0 && leniency.branches_without_length) continue;
    check_size(branch.length(), name, "branch", k, "length");
  }
  for (std::size_t k = 0; k < skeleton.leaves.size(); ++k) {
    const Leaf& leaf = skeleton.leaves[k];
    if (leaf.branch < 0 || leaf.branch >= skeleton.branch_count()) {
      reject(name, "leaf", k, "branch is " + std::to_string(leaf.branch),
             "one of 0 to " + std::to_string(skeleton.branch_count() - 1));
    }
    if (leniency.leaves_of_any_shape) continue;
    if (!(leaf.position >= 0 && leaf.position <= 1)) {
      reject(name, "leaf", k, "position is " + shown(leaf.position), "0 (start of the branch) to 1 (end)");
    }
    check_point(leaf.base, name, "leaf", k, "base");
    check_unit(leaf.axis, name, k, "axis");
    check_unit(leaf.normal, name, k, "normal");
    if (!(std::abs(leaf.axis.dot(leaf.normal)) <= 1e-6)) {
      reject(name, "leaf", k, "cosine between axis and normal is " + shown(leaf.axis.dot(leaf.normal)), "0");
    }
    for (const auto& [what, size] : {std::pair{"length", leaf.length}, std::pair{"width", leaf.width},
                                     std::pair{"area", leaf.area}, std::pair{"mass", leaf.mass}}) {
      if (size == 0 && leniency.leaves_without_size) continue;
      check_size(size, name, "leaf", k, what);
    }
    if (leaf.is_ribbon) check_size(leaf.end_width, name, "ribbon", k, "end width");
  }
}

void check_skeleton(const Skeleton& skeleton, const std::string& name) { check_skeleton(skeleton, name, {}); }

Extent extent(const Skeleton& skeleton) {
  Extent box{Vec3::Constant(HUGE_VAL), Vec3::Constant(-HUGE_VAL)};
  const auto include = [&](const Vec3& point) {
    box.low = box.low.cwiseMin(point);
    box.high = box.high.cwiseMax(point);
  };
  for (const Vec3& root : skeleton.roots) include(root);
  for (const Branch& branch : skeleton.branches) {
    include(branch.start);
    include(branch.end);
  }
  for (const Leaf& leaf : skeleton.leaves) include(leaf.base);
  return box;
}

}  // namespace tremula
