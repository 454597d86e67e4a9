// Where a motion puts a tree that bends far (Motion::lean_strains): poses by strains, which keep the length
// of every branch whatever the angles.
//
//   bent(t) = bend(tree, lean_strains + strains_about(lean, sum over r of y_r(t) phi_r))
//
// Pointwise in time, so loops close and any frame is direct; to first order in the coordinates it is S eq. 1
// about the bent lean.
#pragma once

#include "tremula/deformation/pose.hpp"
#include "tremula/dynamics/motion.hpp"
#include "tremula/structure/bent_tree.hpp"
#include "tremula/structure/structure.hpp"

#include <memory>
#include <vector>

#include <Eigen/Core>

namespace tremula {

// The lean of a motion and what all poses about it share.
struct BentLean {
  std::shared_ptr<const BeamTree> tree;  // at rest
  Eigen::VectorXd strains;               // (6N)
  std::vector<BentBranch> bent;          // (N)
  StrainMaps maps;
};

// Throws InputError for a structure that is no tree, and for strains that are not as many as its rows or not
// finite.
BentLean bend_lean(const Structure& structure, const Motion& motion);

// What moves about the lean, superposed: all but the lean itself. (rows) Throws as coordinates_at does.
Eigen::VectorXd displacement_about_lean(const Motion& motion, double time);

// (N) The tree at any time [s]. The same bytes whether asked for alone or in a sequence. Throws as
// coordinates_at does. The second form prepares the lean for this one pose.
std::vector<BentBranch> bent_at(const BentLean& lean, const Motion& motion, double time);
std::vector<BentBranch> bent_at(const Structure& structure, const Motion& motion, double time);

// The skin of a bent tree: each vertex stays where it is in its cross section, x = point_on + frame (x_rest -
// axis), so rings stay round and leaves keep their shape. Gives the change from rest of positions and normals
// per vertex, as deform_surface does. Throws InputError for a structure that is no tree, and for sizes that
// do not agree.
SurfaceDelta bend_surface(const Structure& structure, const Surface& surface,
                          const std::vector<BentBranch>& bent);

// Where a node of a bent tree stands, and how it has turned from rest; held ones with the foot of the beam on
// their spring, as node_displacement has it.
BentPoint bent_node(const Structure& structure, const std::vector<BentBranch>& bent, std::size_t node);

// How the tree moves when a small displacement grows about its lean: shapes on both sides of it. What hangs
// on them changes by half their difference over `step`, to nine digits.
struct BentChange {
  std::vector<BentBranch> after, before;  // by step times the displacement, and by as much the other way
  double step = 1;
};
BentChange change_about(const BentLean& lean, const Eigen::VectorXd& displacement);

// To first order, what a displacement about the lean adds to the skin: the derivative of bend_surface times
// the displacement, linear in it.
SurfaceDelta change_of_surface(const Structure& structure, const Surface& surface, const BentChange& change);

// The same of a node: how its position grows [m] and how it turns, rotation vector about its own place (rad).
Vec6 change_of_node(const Structure& structure, const BentChange& change, std::size_t node);

}  // namespace tremula
