// A straight beam of a structure, hung between two of its nodes.
#pragma once

#include "tremula/base/types.hpp"
#include "tremula/structure/beam.hpp"

#include <Eigen/Core>

namespace tremula {

// The ends move with the nodes that carry them. A node has six rows in the displacements and forces of the
// structure (x y z, rotation or moment x y z; world axes); what the ground holds has none.
struct Member {
  Eigen::Index start_row = -1, end_row = -1;  // the first of the six of each node; -1: held
  Vec3 start = Vec3::Zero();                  // [m]
  Vec3 direction = Vec3::UnitX();             // unit vector along the beam
  Vec3 start_arm = Vec3::Zero();              // rigid, from the node that carries the start to it [m]
  Beam beam = {};

  Vec3 point(double s) const { return start + s * beam.length * direction; }  // 0 start … 1 end [m]
};

// The displacement of both ends, in world axes: what S eq. 1 calls (u_i, u_j) and what Shape wants, the first
// one carried from its node to the start of the beam. Zero where the ground holds it, with a spring too, for
// its give is part of the beam's Shape: foot_displacement tells it.
struct EndDisplacements {
  Vec3 start_translation = Vec3::Zero(), start_rotation = Vec3::Zero();  // [m, rad]
  Vec3 end_translation = Vec3::Zero(), end_rotation = Vec3::Zero();
};
EndDisplacements end_displacements(const Member& member, Eigen::Ref<const Eigen::VectorXd> displacement);

// How the start of a beam that the ground carries moves on its spring: translation and rotation, zero where
// the ground is rigid. Times the stiffnesses it is the wrench on the ground.
Vec6 foot_displacement(const Member& member, Eigen::Ref<const Eigen::VectorXd> displacement);

// The translation of the point of a member at s (0 start … 1 end) is the transpose of this times the
// displacements of its ends, stacked in the order of EndDisplacements (S eq. 1). Also: the forces on the ends
// that a force there makes (S eq. 4, B before it is integrated).
using PointShape = Eigen::Matrix<double, 12, 3>;
PointShape point_shape(const Member& member, double s);
PointShape point_shape(const Shape& shape, const Vec3& direction);

// The rotation of the cross section at s is the transpose of this times the same displacements.
PointShape turn_shape(const Member& member, double s);
PointShape turn_shape(const Shape& shape, const Vec3& direction);

// A 6-vector at the end of a beam as along / twist scalars and two vectors across: for displacements v and
// phi = theta x d, for wrenches the force across and moment x d, which is what does work on phi.
struct Split {
  double along, twist;
  Vec3 across, bend;

  Split(const Vec3& translation, const Vec3& rotation, const Vec3& direction)
      : along(translation.dot(direction)),
        twist(rotation.dot(direction)),
        across(translation - along * direction),
        bend(rotation.cross(direction)) {}
  Split(double along_, double twist_, const Vec3& across_, const Vec3& bend_)
      : along(along_), twist(twist_), across(across_), bend(bend_) {}

  Vec3 translation(const Vec3& direction) const { return along * direction + across; }
  Vec3 rotation(const Vec3& direction) const { return twist * direction + direction.cross(bend); }
};

}  // namespace tremula
