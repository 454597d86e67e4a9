#include "tremula/structure/sheet_presets.hpp"

namespace tremula {
namespace {

// Woven cloth of so many kg/m^2. Makers give 0.1 to 0.12 for knitted and nylon flags and 0.15 to 0.2 for
// cotton, and shirting to coated nylon bends at 3e-6 to 6e-5 N m (Kawabata's KES-F; Peirce 1930); the
// thickness is that at which the threads leave two thirds of the room to air.
Sheet cloth(double width, double height, double mass_per_area, double bending_stiffness,
            double density = 450) {
  Sheet sheet;
  sheet.width = width;
  sheet.height = height;
  sheet.density = density;
  sheet.thickness = mass_per_area / sheet.density;
  sheet.poisson_ratio = 0.1;
  sheet.youngs_modulus = 12 * bending_stiffness * (1 - sheet.poisson_ratio * sheet.poisson_ratio) /
                         (sheet.thickness * sheet.thickness * sheet.thickness);
  sheet.wrinkles = true;
  return sheet;
}

// At the hoist, on a pole, downwind of which it flies.
Sheet flag() {
  Sheet sheet = cloth(1.5, 1, 0.115, 4e-5);
  sheet.elements = {24, 16};
  sheet.corner = {0, 0, 4};
  sheet.clamped = {SheetEdge::left};
  return sheet;
}

// Between two posts, across the wind.
Sheet banner() {
  Sheet sheet = cloth(4, 0.9, 0.4, 1e-4);
  sheet.elements = {32, 8};
  sheet.corner = {0, -2, 3};
  sheet.along_width = Vec3::UnitY();
  sheet.pinned = {SheetEdge::left, SheetEdge::right};
  sheet.tension = {250, 0, 0};
  return sheet;
}

// On a rail, across the wind.
Sheet curtain() {
  Sheet sheet = cloth(1.4, 2.2, 0.25, 2e-5);
  sheet.elements = {16, 24};
  sheet.corner = {0, -0.7, 0.1};
  sheet.along_width = Vec3::UnitY();
  sheet.pinned = {SheetEdge::top};
  return sheet;
}

// A small square sail, bent to a yard and hauled down at its two clews, across the wind; no sail that is no
// rectangle can be said. Polyester of 0.25 kg/m^2 (makers' 6 ounces a sailmaker's yard), rolled until the
// threads leave a third of the room.
Sheet sail() {
  Sheet sheet = cloth(2.4, 2, 0.25, 2e-3, 900);
  sheet.elements = {20, 16};
  sheet.corner = {0, -1.2, 1.2};
  sheet.along_width = Vec3::UnitY();
  sheet.pinned = {SheetEdge::top};
  sheet.pinned_points = {{0, 0}, {2.4, 0}};
  sheet.tension = {150, 250, 0};
  return sheet;
}

}  // namespace

const std::vector<SheetPreset>& sheet_presets() {
  static const std::vector<SheetPreset> presets = {
      {"flag", "a flag of 1.5 x 1 m at the hoist of a pole", flag(), {0.72F, 0.13F, 0.14F}},
      {"banner", "a banner of 4 x 0.9 m between two posts", banner(), {0.16F, 0.32F, 0.60F}},
      {"curtain", "a curtain of 1.4 x 2.2 m on a rail", curtain(), {0.86F, 0.82F, 0.72F}},
      {"sail", "a square sail of 2.4 x 2 m on a yard", sail(), {0.90F, 0.87F, 0.78F}},
  };
  return presets;
}

}  // namespace tremula
