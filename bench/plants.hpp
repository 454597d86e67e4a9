// The plants that the benchmarks share.
#pragma once

#include <string>

#include "tremula/geometry/grow.hpp"
#include "tremula/geometry/plants.hpp"

namespace tremula::bench {

// Stam's tree with any number of branches.
inline Skeleton stam_tree(int branches) {
  const LSystem system = parse_lsystem(find_preset("stam-2257").text, "stam-2257");
  return grow(system, {.seed = {}, .constants = {{"N", static_cast<double>(branches)}}, .limits = {}})
      .skeleton;
}

}  // namespace tremula::bench
