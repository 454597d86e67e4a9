#include "tremula/structure/material.hpp"

#include "tremula/base/error.hpp"

#include <cstdio>

namespace tremula {
namespace {

// Young's modulus, density and modulus of rupture of green stems: the species parameters of ForestGALES (Hale
// et al. 2015, Forest Ecology and Management 358, and the parameter files of its implementations). Nobody
// tabulates the shear modulus of green stems; 0.075 of E lies amid the ratios 0.05 … 0.1 of G_LR to E_L of
// the Wood Handbook.
Material green_stem(const char* name, double youngs_modulus, double density, double modulus_of_rupture) {
  return {name,
          youngs_modulus,
          0.075 * youngs_modulus,
          density,
          "ForestGALES species parameters; G = 0.075 E",
          modulus_of_rupture};
}

// Soft and full of water, which hardly lets itself be pressed: Poisson's ratio is a half.
Material water_plant(const char* name, double youngs_modulus, double density, const char* source) {
  return {name, youngs_modulus, youngs_modulus / 3, density, source};
}

}  // namespace

const std::vector<Material>& material_presets() {
  static const std::vector<Material> presets = {
      {"green-wood", 28.0e9 / 3, 0.075 * 28.0e9 / 3, 3216.0 / 3, "mean of birch, beech and oak below",
       187e6 / 3},
      green_stem("birch", 9.9e9, 900, 63e6),
      green_stem("beech", 9.8e9, 1158, 65e6),
      green_stem("oak", 8.3e9, 1158, 59e6),
      green_stem("scots-pine", 7.3e9, 850, 46e6),
      green_stem("lodgepole-pine", 6.4e9, 850, 41e6),
      green_stem("norway-spruce", 6.3e9, 850, 36e6),
      green_stem("sitka-spruce", 5.9e9, 850, 34e6),
      green_stem("douglas-fir", 8.3e9, 850, 53e6),
      green_stem("european-larch", 7.9e9, 850, 53e6),
      {"walnut", 11.3e9, 11.3e9 / (2 * (1 + 0.38)), 805,
       "Rodriguez, de Langre & Moulia 2008, Am. J. Bot. 95: E, density, Poisson's ratio 0.38"},
      {"paper", 1e8, 1e5, 1e3, "Stam 1997, appendix A: chosen for looks, far softer than wood"},
      water_plant(
          "kelp", 1.3e7, 1050,
          "stipe of Macrocystis, 13 MPa (Denny & Gaylord 2002, as remembered); Utter & Denny 1996 have "
          "19 MPa at full strain; density of Zhu et al. 2021; G = E/3"),
      water_plant("seagrass", 3e8, 800,
                  "blade of Zostera, 0.05 to 0.3 GPa and 700 to 900 kg/m^3 (Fonseca & Kenworthy, as "
                  "remembered); the model of Luhar et al. 2017 has 0.3 GPa; G = E/3"),
      water_plant(
          "seaweed", 4e6, 1050,
          "Saccharina latissima, 4 +- 3 MPa (Vettori & Nikora 2017) and 1050 +- 30 kg/m^3 (Zhu et al. "
          "2021); G = E/3"),
  };
  return presets;
}

const Material& find_material(std::string_view name) {
  std::string names;
  for (const Material& material : material_presets()) {
    if (material.name == name) return material;
    names += (names.empty() ? "" : ", ") + material.name;
  }
  throw InputError("material", "'" + std::string(name) + "'", "one of " + names);
}

void check_material(const Material& material) {
  // Far beyond anything there is. What is left out would carry the numbers of the structure out of their
  // range.
  constexpr double least = 1e-15, most = 1e30;
  const auto check = [](const char* what, double value, const char* unit) {
    if (value >= least && value <= most) return;
    char found[40];
    std::snprintf(found, sizeof found, "%g", value);
    throw InputError(what, std::string(found) + " " + unit, "a number above 0, from 1e-15 to 1e+30");
  };
  check("Young's modulus", material.youngs_modulus, "Pa");
  check("shear modulus", material.shear_modulus, "Pa");
  check("density", material.density, "kg/m^3");
}

}  // namespace tremula
