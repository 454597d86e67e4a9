// How a plant takes the wind, by flag: what tremula animate and tremula load ask alike.
#pragma once

#include "tremula/pipeline.hpp"

#include <string>
#include <vector>

#include "common.hpp"

namespace tremula::cli {

// --loads, --drag, --pose, --leaf-..., --no-shelter, --shelter-cell
struct LoadFlags {
  std::string model = "stochastic", drag = "linear", pose = "bent";
  double leaf_drag_coefficient = LoadOptions{}.leaf_drag_coefficient,
         leaf_lift_coefficient = LoadOptions{}.leaf_lift_coefficient,
         leaf_vogel_exponent = FoliageLaw{}.vogel_exponent, leaf_folding_speed = FoliageLaw{}.folding_speed,
         shelter_cell = ShelterOptions{}.cell;
  bool no_shelter = false;

  void add_to(CLI::App& command, const char* group);
  void set(const StructureFlags& structure, Weather& weather) const;
  // Throws InputError for flags that would have no effect.
  void check(const CLI::App& command) const;
};
Json describe(const LoadFlags& flags);

}  // namespace tremula::cli
