// From the grammar of a plant to the plant: derivation and drawing in one pass.
#pragma once

#include "tremula/geometry/lsystem.hpp"
#include "tremula/geometry/skeleton.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace tremula {

// What ends runaway growth before it fills the memory.
struct GrowLimits {
  std::size_t letters = 10'000'000;  // looked at, in all derivation steps together
  std::size_t terms = 200'000'000;   // numbers, names and operations worked out in expressions
  std::size_t branches = 1'000'000;
  std::size_t leaves = 2'000'000;
  std::size_t nesting = 100'000;  // of [ and ]
};

struct GrowOptions {
  std::optional<std::uint64_t> seed = {};                      // instead of the one in the text
  std::vector<std::pair<std::string, double>> constants = {};  // values instead of those in the text, by name
  GrowLimits limits = {};
};

struct GrownPlant {
  Skeleton skeleton;                          // has passed check_skeleton
  std::optional<Eigen::Vector3f> bark_color;  // sRGB, 0–1, where the text gives one
  std::optional<Eigen::Vector3f> leaf_color;
};

// Random numbers are addressed by line of descent (the letter's, its parent's, … position within their
// successors), so that what happens to one limb leaves the others as they are. Throws InputError with the
// line of the text where growth leaves the limits, a length or radius is not above 0, a value is not finite,
// or an option names a constant that the text does not have.
GrownPlant grow(const LSystem& system, const GrowOptions& options = {});

}  // namespace tremula
