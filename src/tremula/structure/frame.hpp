// Structures that a tree cannot say: with loops, with several clamps, of several materials. A trellis, an
// arch, a stem that is tied to a stake, a sign on a post.
//
// A loop is statically indeterminate, so K^-1 is not known beforehand: K and M are assembled. That costs
// digits which a BeamTree keeps (beam_tree.hpp), about as many as the highest frequency is above the lowest,
// squared. The elements are the same beams.
#pragma once

#include "tremula/base/types.hpp"
#include "tremula/geometry/skeleton.hpp"
#include "tremula/structure/material.hpp"
#include "tremula/structure/member.hpp"
#include "tremula/structure/panel.hpp"

#include <vector>

#include <Eigen/SparseCore>

namespace tremula {

// A straight beam, rigidly joined to the nodes at its ends. Its frequencies converge as it is cut into more.
struct FrameElement {
  int start_node = 0, end_node = 0;
  double start_radius = 0, end_radius = 0;  // [m] > 0
  Material material = find_material("green-wood");
  double wall = 1;  // as Branch::wall
};

struct FramePointMass {
  int node = 0;
  double mass = 0;  // [kg]
};

struct Frame {
  std::vector<Vec3> nodes;  // [m]
  std::vector<FrameElement> elements;
  std::vector<int> clamped;  // nodes that neither move nor turn; at least one
  std::vector<FramePointMass> masses;
  std::vector<Panel> panels;
};

struct FrameOptions {
  Section section = Section::exact;
  bool rotatory_inertia = true;  // as in StructureOptions
};

// K and M over the six degrees of freedom (x y z, rotation x y z; world axes) of each free node, both
// triangles. Both are positive definite. After the nodes of the frame come those of its panels that are fixed
// to none of them, panel by panel.
struct FrameMatrices {
  Eigen::SparseMatrix<double> stiffness, mass;  // (6F x 6F)
  std::vector<int> row;             // of each node of the frame, the first of its six; -1 where clamped
  std::vector<Member> members;      // the elements, in their order
  std::vector<PlacedPanel> panels;  // in their order

  Eigen::Index size() const { return stiffness.rows(); }
};

// Throws InputError, naming the element or node, for what is no frame: indices of nodes that do not exist,
// numbers that are not finite, elements without length or radius, materials that are none (check_material),
// walls that are none or thicker than the radius, panels that are none (check_panel), negative masses,
// nothing clamped, and nodes that no elements and panels connect with a clamp.
void check_frame(const Frame& frame);

// Throws as check_frame does, and InputError where nothing is free.
FrameMatrices assemble_frame(const Frame& frame, const FrameOptions& options = {});

// Six for each node that is not clamped, those of panels too. This and outline_of take what check_frame
// passes.
int free_rows(const Frame& frame);

// The elements as branches, for a skin: element i is branch i, and a row of elements that go on straight from
// end to start is one axis.
Skeleton outline_of(const Frame& frame);

}  // namespace tremula
