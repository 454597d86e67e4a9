// Rods of unit length and bending stiffness, clamped at the origin: what data/rods.json is about.
#pragma once

#include "support.hpp"
#include "trees.hpp"
#include "tremula/structure/equilibrium.hpp"

#include <fstream>
#include <numbers>

#include <nlohmann/json.hpp>

namespace tremula::test {

// What others worked out for them, by name of the problem.
inline nlohmann::json rods() {
  std::ifstream file(data_folder() / "rods.json");
  return nlohmann::json::parse(file).at("values");
}

// EI = 1, GJ = 1 and EA = 4e6: hardly extensible.
inline BeamTree rod(int pieces, const Vec3& direction = Vec3::UnitZ()) {
  constexpr double radius = 1e-3;
  const double inertia = std::numbers::pi * std::pow(radius, 4) / 4;
  StructureOptions options;
  options.material.youngs_modulus = 1 / inertia;
  options.material.shear_modulus = 1 / (2 * inertia);
  options.material.density = 1 / (std::numbers::pi * radius * radius);
  return assemble_tree(straight_stem(pieces, 1, radius, radius, direction), options);
}

// Shortening along the rest axis (z), deflection (x) and angle of the tip.
inline Vec3 tip_of(const Equilibrium& rest) {
  const Vec3 end = rest.bent.back().end, along = rest.bent.back().end_frame * Vec3::UnitZ();
  return {1 - end.z(), end.x(), std::atan2(along.x(), along.z())};
}

}  // namespace tremula::test
