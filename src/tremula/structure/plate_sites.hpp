// Where the wind takes hold of what is flat.
#pragma once

#include "tremula/structure/panel.hpp"
#include "tremula/structure/sheet.hpp"
#include "tremula/structure/sites.hpp"

#include <span>
#include <vector>

#include <Eigen/Core>

namespace tremula {

// One point an element, in its middle, and four sites, at the Gauss points: an even force makes no moments on
// a free edge then, to which cloth would have nothing to oppose.
struct PlateSites {
  Eigen::Matrix3Xd points;              // (3 x E) [m]
  std::vector<Site> sites;              // (4E) in the order of their points
  std::vector<Eigen::Vector2d> places;  // (4E) of the sites on the sheet [m]
};
PlateSites lay_sites(const Sheet& sheet);

// Of panels one after the other. row_count: of the structure.
Sites find_sites(std::span<const PlacedPanel> panels, Eigen::Index row_count);

}  // namespace tremula
