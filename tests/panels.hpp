// Small frames with panels for the tests, made here.
#pragma once

#include "frames.hpp"
#include "tremula/structure/frame.hpp"

namespace tremula::test {

// 1 x 0.6 m, 4 x 3 elements, in y and z, facing x.
inline Sheet panel_sheet(double thickness = 0.01) {
  Sheet sheet;
  sheet.width = 1;
  sheet.height = 0.6;
  sheet.thickness = thickness;
  sheet.youngs_modulus = 70e9;
  sheet.density = 2700;
  sheet.elements = {4, 3};
  sheet.along_width = Vec3::UnitY();
  return sheet;
}

// A post from the ground up with a panel whose middle stands at its top, held there alone.
inline Frame post_with_panel(double length, double radius, const Material& material, Sheet sheet,
                             int pieces = 12) {
  Frame frame;
  frame.nodes = {{0, 0, 0}, {0, 0, length}};
  frame.clamped = {0};
  add_beam(frame, 0, 1, pieces, radius, material);
  sheet.corner =
      Vec3(0, 0, length) - 0.5 * sheet.width * sheet.along_width - 0.5 * sheet.height * sheet.along_height;
  frame.panels = {{sheet, {{{0.5 * sheet.width, 0.5 * sheet.height}, 1}}}};
  return frame;
}

// A panel alone, its left edge held by the ground.
inline Frame wall_with_panel(const Sheet& sheet) {
  Frame frame;
  frame.nodes = {sheet.corner};
  frame.clamped = {0};
  Panel panel{sheet, {}};
  for (int j = 0; j <= sheet.elements[1]; ++j)
    panel.fixed.push_back({{0, sheet.height * j / sheet.elements[1]}, 0});
  frame.panels = {panel};
  return frame;
}

}  // namespace tremula::test
