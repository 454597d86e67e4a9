#include "tremula/structure/member.hpp"

#include <cassert>

namespace tremula {

EndDisplacements end_displacements(const Member& member, Eigen::Ref<const Eigen::VectorXd> displacement) {
  assert(member.start_row + 6 <= displacement.size() && member.end_row + 6 <= displacement.size());
  EndDisplacements ends;
  if (member.end_row >= 0) {
    ends.end_translation = displacement.segment<3>(member.end_row);
    ends.end_rotation = displacement.segment<3>(member.end_row + 3);
  }
  if (member.start_row >= 0) {
    ends.start_rotation = displacement.segment<3>(member.start_row + 3);
    ends.start_translation =
        displacement.segment<3>(member.start_row) + ends.start_rotation.cross(member.start_arm);
  }
  return ends;
}

Vec6 foot_displacement(const Member& member, Eigen::Ref<const Eigen::VectorXd> displacement) {
  if (member.start_row >= 0 || member.end_row < 0) return Vec6::Zero();
  assert(member.end_row + 6 <= displacement.size());
  const Shape foot = shape_at(member.beam, 0);
  const Vec3& direction = member.direction;
  const Split end(displacement.segment<3>(member.end_row), displacement.segment<3>(member.end_row + 3),
                  direction);
  const Split moved(foot.axial[1] * end.along, foot.torsion[1] * end.twist,
                    foot.deflection[2] * end.across + foot.deflection[3] * end.bend,
                    foot.slope[2] * end.across + foot.slope[3] * end.bend);
  Vec6 result;
  result << moved.translation(direction), moved.rotation(direction);
  return result;
}

PointShape point_shape(const Member& member, double s) {
  return point_shape(shape_at(member.beam, s), member.direction);
}

// A force across the beam makes moments d x f on the slopes.
PointShape point_shape(const Shape& shape, const Vec3& direction) {
  const Mat3 along = direction * direction.transpose();
  const Mat3 across = Mat3::Identity() - along, cross = cross_matrix(direction);
  PointShape forces;
  forces << shape.axial[0] * along + shape.deflection[0] * across, shape.deflection[1] * cross,
      shape.axial[1] * along + shape.deflection[2] * across, shape.deflection[3] * cross;
  return forces;
}

PointShape turn_shape(const Member& member, double s) {
  return turn_shape(shape_at(member.beam, s), member.direction);
}

// The slope of the deflection v is theta x d, so theta is the twist along d and d x slope.
PointShape turn_shape(const Shape& shape, const Vec3& direction) {
  const Mat3 along = direction * direction.transpose();
  const Mat3 across = Mat3::Identity() - along, cross = cross_matrix(direction);
  PointShape turning;
  turning << -shape.slope[0] * cross, shape.torsion[0] * along + shape.slope[1] * across,
      -shape.slope[2] * cross, shape.torsion[1] * along + shape.slope[3] * across;
  return turning;
}

}  // namespace tremula
