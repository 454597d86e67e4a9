// What branches are made of, by name or by numbers.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace tremula {

// The numbers alone, for beams, of which there are many.
struct Moduli {
  double youngs_modulus = 0;  // E, along the grain [Pa]
  double shear_modulus = 0;   // G, of torsion [Pa]
  double density = 0;         // rho [kg/m^3]
};

struct Material {
  std::string name = "custom";
  double youngs_modulus = 0;      // E, along the grain [Pa]
  double shear_modulus = 0;       // G, of torsion [Pa]
  double density = 0;             // rho, as it stands: wood and water [kg/m^3]
  std::string source;             // where the numbers come from
  double modulus_of_rupture = 0;  // bending stress at which it breaks [Pa]; 0: not known

  operator Moduli() const { return {youngs_modulus, shear_modulus, density}; }
};

// "paper" (S appendix A), green wood by species, and "green-wood", the default.
const std::vector<Material>& material_presets();

// Throws InputError that lists the names there are.
const Material& find_material(std::string_view name);

// Throws InputError unless E, G and rho lie between 1e-15 and 1e30, where the numbers of a structure stay in
// their range.
void check_material(const Material& material);

}  // namespace tremula
