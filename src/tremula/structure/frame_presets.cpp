#include "tremula/structure/frame_presets.hpp"

namespace tremula {
namespace {

// Steel of EN 1993-1-1, 3.2.6.
Material steel() {
  Material steel;
  steel.name = "steel";
  steel.youngs_modulus = 210e9;
  steel.shear_modulus = 81e9;
  steel.density = 7850;
  steel.source = "EN 1993-1-1, 3.2.6";
  return steel;
}

// Aluminium of EN 1999-1-1, 3.2.5.
Sheet aluminium(double width, double height, double thickness) {
  Sheet sheet;
  sheet.width = width;
  sheet.height = height;
  sheet.thickness = thickness;
  sheet.youngs_modulus = 70e9;
  sheet.poisson_ratio = 0.3;
  sheet.density = 2700;
  return sheet;
}

// A straight tube between two nodes, in pieces.
void add_tube(Frame& frame, int start, int end, int pieces, double radius, double wall) {
  const Vec3 low = frame.nodes[index_of(start)], high = frame.nodes[index_of(end)];
  int last = start;
  for (int piece = 1; piece <= pieces; ++piece) {
    int next = end;
    if (piece < pieces) {
      next = static_cast<int>(frame.nodes.size());
      frame.nodes.push_back(low + (high - low) * piece / pieces);
    }
    frame.elements.push_back({last, next, radius, radius, steel(), wall / radius});
    last = next;
  }
}

// A traffic sign, a plain plate of 2 mm, as European ones are put up: on a tube of 60.3 mm, the lower
// edge 2.2 m above the ground, across the wind. Two clamps hold it, each in two places.
Frame sign() {
  constexpr double radius = 0.03015, wall = 0.002, bottom = 2.2, height = 0.9, width = 0.6;
  Frame frame;
  frame.nodes = {
      {0, 0, 0}, {0, 0, bottom + 0.2 * height}, {0, 0, bottom + 0.8 * height}, {0, 0, bottom + height}};
  frame.clamped = {0};
  add_tube(frame, 0, 1, 6, radius, wall);
  add_tube(frame, 1, 2, 2, radius, wall);
  add_tube(frame, 2, 3, 2, radius, wall);
  Panel panel{aluminium(width, height, 0.002), {}};
  panel.sheet.elements = {12, 15};
  panel.sheet.corner = {-0.04, 0.5 * width, bottom};  // it faces the wind
  panel.sheet.along_width = -Vec3::UnitY();
  for (const int clamp : {1, 2}) {
    for (const double x : {0.25, 0.35})
      panel.fixed.push_back({{x, (clamp == 1 ? 0.2 : 0.8) * height}, clamp});
  }
  frame.panels = {panel};
  return frame;
}

}  // namespace

const std::vector<FramePreset>& frame_presets() {
  static const std::vector<FramePreset> presets = {{"sign",
                                                    "a traffic sign of 0.6 x 0.9 m on a steel post",
                                                    sign(),
                                                    {0.56F, 0.57F, 0.58F},
                                                    {0.10F, 0.27F, 0.58F}}};
  return presets;
}

}  // namespace tremula
