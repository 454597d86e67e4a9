#include "load_flags.hpp"

#include <array>
#include <cmath>
#include <map>

#include "usage.hpp"

namespace tremula::cli {
namespace {

const std::map<std::string, LoadModel> models{{"stochastic", LoadModel::stochastic},
                                              {"linearised", LoadModel::linearised},
                                              {"paper", LoadModel::paper}};

}  // namespace

void LoadFlags::add_to(CLI::App& command, const char* group) {
  const auto number = [&](const char* flag, double& value, const char* text) {
    command.add_option(flag, value, text)->capture_default_str()->group(group);
  };
  command
      .add_option(
          "--loads", model,
          "stochastic: drag averaged over the gusts; linearised: about the mean wind; paper: eq. 3 of Stam "
          "as printed")
      ->check(CLI::IsMember(models))
      ->capture_default_str()
      ->group(group);
  command
      .add_option("--drag", drag,
                  "linear: that of gusts by its best linear fit; quadratic: as it is at every instant, for "
                  "true peaks")
      ->check(CLI::IsMember({"linear", "quadratic"}))
      ->capture_default_str()
      ->group(group);
  command
      .add_option("--pose", pose,
                  "bent: branches lean and sway as far as they do and keep their lengths; linear: small "
                  "displacements superposed, eq. 1 of Stam")
      ->check(CLI::IsMember({"bent", "linear"}))
      ->capture_default_str()
      ->group(group);
  number("--leaf-drag-coefficient", leaf_drag_coefficient,
         "Of foliage that folds in the wind, on one side of its area");
  number("--leaf-lift-coefficient", leaf_lift_coefficient,
         "Of flat blades that stay as they are: a force along their normal");
  number("--leaf-vogel-exponent", leaf_vogel_exponent,
         "E of leaves that fold: in fast wind their drag grows with the speed to the power 2 + E; 0: they do "
         "not "
         "fold");
  number("--leaf-folding-speed", leaf_folding_speed,
         "The wind at which they begin to fold [m/s]; in water a current of the same pressure");
  command.add_flag("--no-shelter", no_shelter, "Every leaf and branch meets the free wind")->group(group);
  number("--shelter-cell", shelter_cell,
         "Width of the wakes that leaves and branches of a crown leave behind [m]");
}

void LoadFlags::set(const StructureFlags& structure, Weather& weather) const {
  if (structure.medium == "vacuum") throw InputError("--medium vacuum", "given with a wind", "air or water");
  double folding_speed = leaf_folding_speed;
  if (structure.medium == "water") {
    weather.loads.fluid_density = water_density;
    weather.loads.inertia_coefficient = 2;
    folding_speed *= std::sqrt(air_density / water_density);  // where the pressure is the same
  }
  weather.loads.model = models.at(model);
  weather.drag = drag == "quadratic" ? Drag::quadratic : Drag::linear;
  weather.loads.leaf_drag_coefficient = leaf_drag_coefficient;
  weather.loads.leaf_lift_coefficient = leaf_lift_coefficient;
  weather.loads.foliage = {leaf_vogel_exponent, folding_speed};
  weather.lean.rotations = pose == "linear" ? Rotations::small : Rotations::large;
  weather.lean.shelter = {.on = !no_shelter, .cell = shelter_cell};
}

void LoadFlags::check(const CLI::App& command) const {
  refuse_idle_flags(
      command, std::array{IdleFlags{model == "paper",
                                    "given with --loads paper, which has no leaves and no lean",
                                    "--loads stochastic",
                                    {"--drag", "--leaf-drag-coefficient", "--leaf-lift-coefficient",
                                     "--leaf-vogel-exponent", "--leaf-folding-speed", "--no-shelter",
                                     "--shelter-cell", "--pose"}},
                          IdleFlags{no_shelter, "given with --no-shelter", "one of them", {"--shelter-cell"}},
                          IdleFlags{leaf_vogel_exponent == 0,
                                    "given with --leaf-vogel-exponent 0",
                                    "an exponent below 0",
                                    {"--leaf-folding-speed"}}});
}

Json describe(const LoadFlags& flags) {
  return {{"loads", flags.model},
          {"drag", flags.drag},
          {"pose", flags.pose},
          {"leaf_drag_coefficient", flags.leaf_drag_coefficient},
          {"leaf_lift_coefficient", flags.leaf_lift_coefficient},
          {"leaf_vogel_exponent", flags.leaf_vogel_exponent},
          {"leaf_folding_speed_m_s", flags.leaf_folding_speed},
          {"shelter_cell_m", flags.no_shelter ? Json() : Json(flags.shelter_cell)}};
}

}  // namespace tremula::cli
