// Whether a plant and its wood are of this world: numbers in the wrong unit give answers without a fault in
// them that are wrong by powers of ten.
#pragma once

#include "tremula/geometry/skeleton.hpp"
#include "tremula/structure/beam_tree.hpp"

#include <optional>
#include <string>
#include <vector>

namespace tremula {

// A line for each of height, slenderness, mass of wood, density, Young's modulus, shear modulus and, where
// given, lowest frequency [Hz] that lies outside what plants have; it names the unit that was likely meant.
// The ranges and their sources stand in plausibility.cpp.
std::vector<std::string> plausibility(const Skeleton& skeleton, const StructureOptions& options,
                                      std::optional<double> lowest_frequency = {});

}  // namespace tremula
