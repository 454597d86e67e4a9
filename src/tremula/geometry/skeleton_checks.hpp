// What stages can do with that check_skeleton would refuse.
#pragma once

#include "tremula/geometry/skeleton.hpp"

#include <string>

namespace tremula {

struct SkeletonLeniency {
  bool branches_without_length = false;  // pictures can draw them
  bool leaves_without_size = false;      // a mass on a branch is one
  bool leaves_of_any_shape = false;      // only the branch that carries a leaf is looked at
};

// As check_skeleton, but for what is let pass.
void check_skeleton(const Skeleton& skeleton, const std::string& name, const SkeletonLeniency& leniency);

}  // namespace tremula
