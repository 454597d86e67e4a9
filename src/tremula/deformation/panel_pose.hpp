// Where a frame puts the skin of its panels.
#pragma once

#include "tremula/deformation/pose.hpp"
#include "tremula/geometry/surface.hpp"
#include "tremula/structure/structure.hpp"

#include <Eigen/Core>

namespace tremula {

// Adds to the skin of the members that of the panels: each is a part of its own, two-sided and without
// thickness, in `pieces` squares along either side of an element. Surface::branch goes on behind the members,
// element by element and panel by panel; `along` is 0.
void add_panels(const Frame& frame, const SurfaceMaterial& material, Surface& surface, int pieces = 2);

// How many members and elements of panels may carry a vertex.
int carrier_count(const Structure& structure);

// The vertices from `first` on, all of them of panels, under a displacement of the structure (rows): each
// moves with its place on the panel and turns with it. Linear in the displacement. `delta` has room for all
// vertices. Throws InputError for vertices that no panel carries.
void deform_panels(const Structure& structure, const Surface& surface, const Eigen::VectorXd& displacement,
                   std::size_t first, SurfaceDelta& delta);

}  // namespace tremula
