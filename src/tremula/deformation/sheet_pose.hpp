// Where a structure that is a sheet puts its skin.
//
// Displacements across the sheet superpose (S eq. 1); they stretch what sways far. Bent, every line of the
// skin that runs from the edge that holds the sheet to the free edge opposite keeps its length: its slope
// dw/ds is taken for the tangent of the angle at which it runs on, x = int cos, w = int sin. That is the
// shape of a thread in a wind that presses it sideways, and the same to first order. A sheet that is held on
// two opposite sides has no length to spare: its displacements superpose.
//
// A flag that flaps goes where its nodes go in space (Motion::in_space); between them it is a cubic.
#pragma once

#include "tremula/deformation/pose.hpp"
#include "tremula/geometry/surface.hpp"
#include "tremula/structure/bent_tree.hpp"
#include "tremula/structure/structure.hpp"

#include <vector>

#include <Eigen/Core>

namespace tremula {

// Two-sided, of one part, `pieces` squares along either side of an element, in rows from the bottom; texture
// runs from 0 to 1 from left to right and from bottom to top. Surface::branch counts the elements.
Surface sheet_surface(const Sheet& sheet, const SurfaceMaterial& material, int pieces = 2);

// The skin under a displacement of the structure (rows), superposed and bent. The surface is one of
// sheet_surface. Throw InputError for a structure that is no sheet and for sizes that do not agree.
SurfaceDelta deform_sheet(const Structure& structure, const Surface& surface,
                          const Eigen::VectorXd& displacement);
SurfaceDelta bend_sheet(const Structure& structure, const Surface& surface,
                        const Eigen::VectorXd& displacement);

// Bent, where all nodes stand and how the sheet has turned there from rest.
std::vector<BentPoint> bent_nodes(const Structure& structure, const Eigen::VectorXd& displacement);

// The same for displacements of the nodes in space: cubics along width and height (Catmull and Rom) run
// through the nodes; rotations in the displacement are not asked.
SurfaceDelta carry_sheet(const Structure& structure, const Surface& surface,
                         const Eigen::VectorXd& displacement);
std::vector<BentPoint> carried_nodes(const Structure& structure, const Eigen::VectorXd& displacement);

}  // namespace tremula
