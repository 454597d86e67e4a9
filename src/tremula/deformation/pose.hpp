// Where every node is at one instant, and where that puts the points of branches and of the skin.
#pragma once

#include "tremula/base/types.hpp"
#include "tremula/dynamics/motion.hpp"
#include "tremula/geometry/skeleton.hpp"
#include "tremula/geometry/surface.hpp"
#include "tremula/modes/modes.hpp"
#include "tremula/structure/structure.hpp"

#include <vector>

#include <Eigen/Core>

namespace tremula {

// Displacement of all branch ends at once: (6N), rows as in Modes::shapes. The feet of stems have no rows:
// they stand still, or move on the springs of the structure (foot_displacement).
using Displacement = Eigen::VectorXd;

// lean + shapes * coordinates (S section 3 and 6). The same bytes whether asked for alone or in a sequence.
// This and the functions below throw InputError for what does not fit together, for a time that is not
// finite, and for branches and places that there are not.
Displacement displacement_at(const Modes& modes, const Motion& motion, double time,
                             Interpolation interpolation = Interpolation::linear);

struct BranchPoint {
  Vec3 displacement;  // of the axis point [m]
  Vec3 rotation;      // of the cross section, rotation vector [rad]
};

// S eq. 1: A_k(s) (u_i, u_j): cubic across the branch, linear along it and in twist. s = 0 start … 1 end.
// The start may be a rigid arm away from its node (Branch::start). On a root it moves by foot_displacement.
BranchPoint branch_point(const Skeleton& skeleton, const Structure& structure,
                         const Displacement& displacement, int branch, double s);

// The skin carried along, to first order: each vertex moves with its cross section, x + u + theta x (x -
// axis). Gives the change of positions and of normals per vertex; linear in `displacement`, so a mode shape
// gives a morph target. (V) each.
struct SurfaceDelta {
  std::vector<Eigen::Vector3f> position;  // [m]
  std::vector<Eigen::Vector3f> normal;
};
SurfaceDelta deform_surface(const Skeleton& skeleton, const Structure& structure, const Surface& surface,
                            const Displacement& displacement);

}  // namespace tremula
