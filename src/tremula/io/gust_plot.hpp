// The wind over a piece of ground at one instant, seen from above: arrows on a lattice (F figure 3) over a
// tint of its speed. In axes of the wind: x along its heading, to the right; y to its left, up.
#pragma once

#include "tremula/render/image.hpp"
#include "tremula/wind/field.hpp"
#include "tremula/wind/travelling_field.hpp"

#include <string>

#include <Eigen/Core>

namespace tremula {

// Between which nearly all horizontal speeds of a field lie, over its loop and in all layers [m/s]: two and a
// half deviations about the mean. The rarest gusts would leave a tint no contrast.
struct SpeedRange {
  double slowest = 0, fastest = 0;
};
SpeedRange speeds_of(const TravellingField& field);

// The colour of the tint from still air (0) to the strongest gusts (1): sRGB, 0–1.
Eigen::Vector3f gust_color(double share);

struct GustView {
  Eigen::Vector2d low{-20, -10}, high{0, 10};  // what is shown, along and across [m]
  double z = 10;                               // [m]
  double time = 0;                             // [s]
  double spacing = 1;                          // from arrow to arrow [m]
  double scale = 0.1;                          // length of an arrow for 1 m/s [s]
  bool without_mean = false;                   // arrows of the gusts alone; the tint stays
  double slowest = 0, fastest = 10;            // ends of the tint [m/s]
};

// What is upwind of the plane, as long as it is wide but no longer than the loop, at its middle layer: `most`
// arrows across at the most. Tint and arrows fit the whole loop, so that all its pictures are alike. Throws
// InputError for a field of one column or without speed.
GustView view_of_gusts(const TravellingField& field, int most_arrows = 40, bool without_mean = false);

// SVG text, with axes in metres and a scale. Both throw InputError for a view that is none: no area, lengths
// not above 0, more than 40 000 arrows.
std::string plot_gusts(const TravellingField& field, const GustView& view);

// The same without axes, for films: `longer_side` [pixels] 16 … 8192.
Image picture_of_gusts(const TravellingField& field, const GustView& view, int longer_side = 720);

// The row of a field that is nearest to a height [m].
TravellingField travelling_row(const WindField& field, double height);

}  // namespace tremula
