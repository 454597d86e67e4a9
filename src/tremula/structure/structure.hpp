// What vibrates, whatever it is made of: all that modes, loads and motion ask of it. A tree answers by sweeps
// (beam_tree.hpp), a frame and a sheet by sparse Cholesky factors (frame.hpp, sheet.hpp).
#pragma once

#include "tremula/base/types.hpp"
#include "tremula/structure/beam_tree.hpp"
#include "tremula/structure/bent_tree.hpp"
#include "tremula/structure/eigen_problem.hpp"
#include "tremula/structure/frame.hpp"
#include "tremula/structure/load_margin.hpp"
#include "tremula/structure/member.hpp"
#include "tremula/structure/panel.hpp"
#include "tremula/structure/prestress.hpp"
#include "tremula/structure/sheet.hpp"
#include "tremula/structure/sites.hpp"

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace tremula {

// A place whose motion is told: where a member ends, or what holds it.
struct Node {
  Vec3 position = Vec3::Zero();  // at rest [m]
  Eigen::Index row = -1;         // the first of its six; -1: the ground holds it
  int foot_of = -1;              // the member on whose spring a held node stands; -1: it does not move
};

// M_fa 1_d, the forces on the free nodes when all nodes, held ones too, speed up by 1 m/s^2 along each world
// axis: (rows x 3) [kg, kg m]. And the mass of all there is, held or not [kg].
struct GroundInertia {
  Eigen::MatrixX3d forces;
  double total_mass = 0;
};

// Vectors of displacements and forces have six rows a free node (x y z, rotation or moment x y z; world
// axes) [m, rad, N, N m]. Copies share what the functions work on.
struct Structure {
  std::vector<Node> nodes;
  std::span<const Member> members;  // kept by the functions below
  // M u and K^-1 f, the exact static deflection (K under the weight). Throw InputError for another size.
  std::function<Eigen::VectorXd(const Eigen::VectorXd& displacement)> mass;
  std::function<Eigen::VectorXd(const Eigen::VectorXd& force)> flexibility;
  EigenParts eigen;
  std::function<Sites()> find_sites;                   // where the wind takes hold
  std::function<GroundInertia()> find_ground_inertia;  // how it answers to ground that speeds up
  std::function<LoadMargin()> find_load_margin;        // none where nothing has weight: a frame, gravity 0
  Eigen::Index row_count = 0;
  std::shared_ptr<const BeamTree>
      tree;               // what bends as far as one likes (bent_tree.hpp); null for frames and sheets
  DeadLoads weight = {};  // that a tree stands under; empty: none
  std::shared_ptr<const Sheet> sheet = {};   // what is flat; null for trees and frames
  std::span<const PlacedPanel> panels = {};  // of a frame; kept by the functions above

  Eigen::Index size() const { return row_count; }
};

// The nodes of a tree are its roots and then the ends of its branches; its members are the branches. Under
// gravity the skeleton is the shape that its weight has made, and stays as it is. Throws as assemble_tree
// does, and InputError where the plant cannot carry its weight: the message names the branch and the
// stiffness that would.
Structure assemble(const Skeleton& skeleton, const StructureOptions& options);

// Nodes and members are those of the frame, and then the nodes of its panels that are fixed to none of them;
// it counts as one part, even where it stands in several. Throws as assemble_frame does, and InputError where
// the stiffness is not positive definite to working precision.
Structure assemble(const Frame& frame, const FrameOptions& options = {});

// Nodes are those of the sheet, row by row from the bottom; it has no members. The load margin is that of its
// weight and tension together. Throws as assemble_sheet does, and InputError where nothing holds it, where it
// can turn about what does, and where it buckles: the message says what share of its weight and tension it
// bears.
Structure assemble(const Sheet& sheet, const SheetOptions& options = {});

// A tree as it stands bent (bent_tree.hpp) under its weight and other dead forces, for what is small about
// that: nodes, members and sites are where they then are, straight between their ends. Throws InputError for
// a structure that is no tree and for another number of branches, and Error where it would buckle.
Structure bent_structure(const Structure& structure, const std::vector<BentBranch>& bent,
                         std::span<const PointForce> forces = {});
// The sites of that, whatever the forces: it may be the wind on them that tells these. Throws as it does, but
// for the last.
Sites bent_sites(const Structure& structure, const std::vector<BentBranch>& bent);

// The height of the lowest node that the ground holds [m]. Sheets are held by other things: 0.
double ground_height(const Structure& structure);

// What is flat in a structure: its panels, or a sheet as one of which all nodes have their rows, or none.
std::vector<PlacedPanel> flat_parts(const Structure& structure);

// Where a node has gone: translation and rotation, zero where it is held and rigid.
Vec6 node_displacement(const Structure& structure, Eigen::Ref<const Eigen::VectorXd> displacement,
                       std::size_t node);

}  // namespace tremula
