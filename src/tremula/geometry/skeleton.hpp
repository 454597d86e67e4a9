// A plant as axes: straight branches with a radius at both ends, hung on nodes, and the leaves they carry.
// Everything from here on (structure, surface, deformation) is made from this.
#pragma once

#include <string>
#include <vector>

#include "tremula/base/types.hpp"

namespace tremula {

// A straight piece of stem or twig. Branch k ends at node `roots + k`; it starts at (or, where a scan says
// so, a rigid arm away from) the node `start_node`, which a root or an earlier branch provides.
struct Branch {
  int start_node = 0;         // node that carries the start; always below this branch's own end node
  Vec3 start = Vec3::Zero();  // [m]
  Vec3 end = Vec3::Zero();    // [m]
  double start_radius = 0;    // [m] > 0
  double end_radius = 0;      // [m] > 0
  double wall = 1;            // of a tube: thickness of the wall over the radius, all along; 1: solid

  double length() const { return (end - start).norm(); }
};

// A leaf blade, rigidly carried by a point of a branch. Or a piece of a ribbon, a long blade that runs along
// its branches, flat, and bends with them; they are its midrib.
struct Leaf {
  int branch = 0;               // index of the branch that carries it
  double position = 1;          // where along the branch, 0 start to 1 end
  Vec3 base = Vec3::Zero();     // where the blade begins (the end of the petiole) [m]
  Vec3 axis = Vec3::UnitX();    // unit vector from the base to the tip of the blade
  Vec3 normal = Vec3::UnitZ();  // unit vector out of the upper side, at right angles to the axis
  double length = 0;            // of the blade [m]
  double width = 0;             // of the blade [m]
  double area = 0;              // one side [m^2]
  double mass = 0;              // [kg]
  bool is_ribbon = false;
  double end_width = 0;  // of a piece of ribbon, whose width goes from `width` to this [m]
};

// Nodes 0 … roots-1 are clamped; node roots + k is the end of branch k. Parents stand before their children.
struct Skeleton {
  std::vector<Vec3> roots;  // positions of the clamped nodes [m]
  std::vector<Branch> branches;
  std::vector<Leaf> leaves;
  Vec3 origin = Vec3::Zero();  // what was subtracted from the file's coordinates to recentre them [m]

  int root_count() const { return static_cast<int>(roots.size()); }
  int branch_count() const { return static_cast<int>(branches.size()); }
  int node_count() const { return root_count() + branch_count(); }
  int end_node(int branch) const { return root_count() + branch; }
  // The branch that ends at the node that carries this branch, or -1 where that is a root.
  int parent(int branch) const {
    const int node = branches[static_cast<std::size_t>(branch)].start_node;
    return node < root_count() ? -1 : node - root_count();
  }
  const Vec3& node_position(int node) const {
    return node < root_count() ? roots[static_cast<std::size_t>(node)]
                               : branches[static_cast<std::size_t>(node - root_count())].end;
  }
};

// Throws InputError (place: `name`) unless the skeleton is one the later stages can work with: at least one
// root and one branch, start nodes before end nodes, finite coordinates, radii > 0, walls no thicker than
// those, lengths > 0, leaves on existing branches with finite positive sizes.
void check_skeleton(const Skeleton& skeleton, const std::string& name);

struct Extent {
  Vec3 low, high;  // [m]
};
Extent extent(const Skeleton& skeleton);  // of nodes, branch starts and leaf bases

}  // namespace tremula
