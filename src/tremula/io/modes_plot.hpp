// The modes of a plant as one picture: the frequencies with the mass that moves, and the first shapes.
#pragma once

#include "tremula/modes/mode_quality.hpp"
#include "tremula/modes/modes.hpp"
#include "tremula/structure/structure.hpp"

#include <string>

namespace tremula {

struct ModesPlotOptions {
  std::string title = "tree";
  int shape_count = 10;           // how many of the lowest modes are drawn as shapes, fewer where there are
  double displacement = 0.12;     // of what moves most, as part of the size of the plant
  double largest_rotation = 0.5;  // [rad]; short twigs would stretch to the former
  int branch_count = 4000;        // no drawing has more: those that move most, and the thickest
};

// SVG text. Each shape is seen from the side, so that the horizontal direction in which the mode moves most
// lies across (heading: its angle from x towards y); torsion of a wide crown from above; a sheet, or a frame
// with panels, slanting, as lines along its elements. At rest grey;
// displaced in the colour of the kind, the stronger the more it moves; feet on springs move too. The same
// arguments give the same bytes.
std::string plot_modes(const Structure& structure, const Modes& modes, const ModeQuality& quality,
                       const ModesPlotOptions& options = {});

}  // namespace tremula
