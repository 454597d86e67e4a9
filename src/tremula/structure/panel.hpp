// Flat rectangular plates that a frame carries: a sign on a post, a table top, a shelf.
//
// All six degrees of freedom of a node move: the plate bends (plate_element.hpp), stretches and shears in its
// plane (membrane_element.hpp). Where it is fixed, the node of the plate nearest to the place goes with the
// node of the frame as if a rigid arm led there, and has no rows of its own.
//
// A single place is a point: a thin plate and its plane give way there the more, if slowly, the finer the
// elements are. A bracket holds it in several.
#pragma once

#include "tremula/structure/sheet.hpp"

#include <array>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/SparseCore>

namespace tremula {

struct PanelFixing {
  Eigen::Vector2d place;  // from the left bottom corner [m]
  int node = 0;           // of the frame
};

struct Panel {
  Sheet sheet;  // which no edge, point or tension holds: the fixings do
  std::vector<PanelFixing> fixed;
};

// How a node of a panel follows the rows of the structure: with six of them, or along a rigid arm.
struct PanelNode {
  Eigen::Index row = -1;    // the first of the six; -1: held
  Vec3 arm = Vec3::Zero();  // from what has the rows to the node [m]
  int fixed_to = -1;        // a node of the frame; -1: free, and the rows are its own
};

// A panel in its structure.
struct PlacedPanel {
  Sheet sheet;
  std::vector<PanelNode> nodes;  // as those of the sheet

  int element_count() const { return sheet.elements[0] * sheet.elements[1]; }
};

// Throws InputError, naming the panel by its index, for what check_sheet refuses, for sheets that are held or
// pulled by themselves, and for fixings that are none: to a node that is not there, beyond the panel, two of
// them at one node of the panel.
void check_panel(const Panel& panel, std::size_t index, const std::vector<Vec3>& frame_nodes);

// Which node of the frame each node of a panel is fixed to; -1: none. Takes what check_panel passes.
std::vector<int> fixed_nodes(const Panel& panel);

// One matrix of all elements of a panel, which are alike: (24 x 24) over (x y z, rotation x y z; world axes)
// of the four corners. Bending and membrane; the mass of bending has no rotatory inertia.
using PanelMatrix = Eigen::Matrix<double, 24, 24>;
PanelMatrix panel_stiffness(const Sheet& sheet);
PanelMatrix panel_mass(const Sheet& sheet);

// Adds the matrix of every element to the rows that its corners follow.
void add_panel(const PlacedPanel& panel, const PanelMatrix& element,
               std::vector<Eigen::Triplet<double>>& triplets);

// How the point at a place [m] follows its four corners: translation and rotation are the products with their
// rows, one after the other.
struct PanelPlace {
  std::array<Eigen::Index, 4> rows;          // -1: held
  Eigen::Matrix<double, 3, 24> translation;  // [1, m]
  Eigen::Matrix<double, 3, 24> rotation;     // [1/m, 1]
};
PanelPlace place_on(const PlacedPanel& panel, const Eigen::Vector2d& place);

// The displacements of the corners for that, zero where they are held: (24 x c).
Eigen::MatrixXd corner_displacements(const PanelPlace& place,
                                     Eigen::Ref<const Eigen::MatrixXd> displacements);

// The forces on the rows of the structure when all nodes speed up by 1 m/s^2 along each world axis, added.
void add_ground_inertia(const PlacedPanel& panel, Eigen::MatrixX3d& forces);

}  // namespace tremula
