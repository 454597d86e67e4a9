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

// Where a plant of a text lives, and of what it is: the defaults of whoever puts it there.
struct Habitat {
  bool in_water = false;
  bool drawn_unloaded = false;  // its weight, or what floats, has yet to bend it (structure/sag.hpp)
  std::string material = {};    // a name of material_presets (structure/material.hpp); empty: none said
  double current = 0;           // that there is without wind [m/s]
  double water_depth = 0;       // [m]
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

// Throws as grow does, for numbers out of range.
Habitat habitat_of(const LSystem& system, const GrowOptions& options = {});

}  // namespace tremula
