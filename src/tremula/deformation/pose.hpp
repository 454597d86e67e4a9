// Where a displacement of the structure puts the points of members and of the skin.
#pragma once

#include "tremula/base/types.hpp"
#include "tremula/geometry/surface.hpp"
#include "tremula/structure/structure.hpp"

#include <vector>

#include <Eigen/Core>

namespace tremula {

struct MemberPoint {
  Vec3 displacement;  // of the axis point [m]
  Vec3 rotation;      // of the cross section, rotation vector [rad]
};

// S eq. 1: A_k(s) (u_i, u_j): cubic across the member, linear along it and in twist. s = 0 start … 1 end. The
// start may be a rigid arm away from its node, or move on the spring of the ground (foot_displacement). This
// and the function below throw InputError for sizes that do not agree, and for places and members that there
// are not.
MemberPoint member_point(const Member& member, Eigen::Ref<const Eigen::VectorXd> displacement, double s);

// The skin carried along, to first order: each vertex moves with its cross section, x + u + theta x (x -
// axis). Gives the change of positions and of normals per vertex; linear in `displacement`, so a mode shape
// gives a morph target. (V) each. Surface::branch counts the members.
struct SurfaceDelta {
  std::vector<Eigen::Vector3f> position;  // [m]
  std::vector<Eigen::Vector3f> normal;
};
SurfaceDelta deform_surface(const Structure& structure, const Surface& surface,
                            const Eigen::VectorXd& displacement);

}  // namespace tremula
