#include "tremula/deformation/pose.hpp"

#include "tremula/base/check.hpp"
#include "tremula/deformation/carry_surface.hpp"
#include "tremula/deformation/panel_pose.hpp"
#include "tremula/deformation/sheet_pose.hpp"

#include <algorithm>

namespace tremula {

MemberPoint member_point(const Member& member, Eigen::Ref<const Eigen::VectorXd> displacement, double s) {
  if (!(s >= 0 && s <= 1)) throw InputError("place along a member", std::to_string(s), "0 to 1");
  if (std::max(member.start_row, member.end_row) + 6 > displacement.size()) {
    throw InputError("rows of the displacement", std::to_string(displacement.size()),
                     std::to_string(std::max(member.start_row, member.end_row) + 6) + " or more");
  }
  const EndDisplacements ends = end_displacements(member, displacement);
  const Vec6 foot = foot_displacement(member, displacement);
  const Vec3 start = ends.start_translation + foot.head<3>(),
             start_rotation = ends.start_rotation + foot.tail<3>();
  const double length = member.beam.length;
  const Vec3& direction = member.direction;

  // Hermite's cubics across the member, from the deflections and slopes theta x d at the ends; linear along
  // it.
  const double s2 = s * s, s3 = s2 * s;
  const Vec3 slope0 = length * start_rotation.cross(direction),
             slope1 = length * ends.end_rotation.cross(direction);
  const Vec3 cubic = (1 - 3 * s2 + 2 * s3) * start + (s - 2 * s2 + s3) * slope0 +
                     (3 * s2 - 2 * s3) * ends.end_translation + (s3 - s2) * slope1;
  const Vec3 straight = (1 - s) * start + s * ends.end_translation;
  const Vec3 slope = ((6 * s2 - 6 * s) * (start - ends.end_translation) + (1 - 4 * s + 3 * s2) * slope0 +
                      (3 * s2 - 2 * s) * slope1) /
                     length;
  const double twist = ((1 - s) * start_rotation + s * ends.end_rotation).dot(direction);
  return {cubic + (straight - cubic).dot(direction) * direction, twist * direction + direction.cross(slope)};
}

SurfaceDelta deform_surface(const Structure& structure, const Surface& surface,
                            const Eigen::VectorXd& displacement) {
  check_equal("rows of the displacement", displacement.size(), structure.size());
  if (structure.sheet) return deform_sheet(structure, surface, displacement);
  struct Carrier {
    MemberPoint point;
    Vec3 position(const Vec3& arm) const { return point.displacement + point.rotation.cross(arm); }
    Vec3 normal(const Vec3& n) const { return point.rotation.cross(n); }
  };
  // Skins of panels come last.
  const auto of_members = static_cast<std::int32_t>(structure.members.size());
  const auto first_of_panels = structure.panels.empty()
                                   ? surface.branch.end()
                                   : std::find_if(surface.branch.begin(), surface.branch.end(),
                                                  [&](std::int32_t b) { return b >= of_members; });
  const auto first = static_cast<std::size_t>(first_of_panels - surface.branch.begin());
  SurfaceDelta delta = carry_surface(structure, surface, first, [&](std::size_t branch, double s) {
    return Carrier{member_point(structure.members[branch], displacement, s)};
  });
  deform_panels(structure, surface, displacement, first, delta);
  return delta;
}

}  // namespace tremula
