#include "tremula/deformation/pose.hpp"

#include "tremula/base/check.hpp"

#include <algorithm>

#include <tbb/parallel_for.h>

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
  const auto vertices = static_cast<std::ptrdiff_t>(surface.vertex_count());
  check_equal("normals of the surface", static_cast<std::ptrdiff_t>(surface.normal.size()), vertices);
  check_equal("branches of the vertices", static_cast<std::ptrdiff_t>(surface.branch.size()), vertices);
  check_equal("places along the branches", static_cast<std::ptrdiff_t>(surface.along.size()), vertices);
  check_equal("rows of the displacement", displacement.size(), structure.size());
  constexpr std::size_t together = 4096;
  const std::size_t count = surface.vertex_count(), member_count = structure.members.size();
  SurfaceDelta delta;
  delta.position.resize(count);
  delta.normal.resize(count);
  const auto deform = [&](std::size_t first, std::size_t end) {
    MemberPoint point{Vec3::Zero(), Vec3::Zero()};
    Vec3 axis_point = Vec3::Zero();
    for (std::size_t i = first; i < end; ++i) {
      const int branch = surface.branch[i];
      // The vertices of a ring or a leaf stand one after the other: their cross section is worked out once.
      if (i == first || branch != surface.branch[i - 1] || surface.along[i] != surface.along[i - 1]) {
        if (branch < 0 || static_cast<std::size_t>(branch) >= member_count) {
          throw InputError("branch of a vertex", std::to_string(branch),
                           "0 to " + std::to_string(member_count - 1));
        }
        const Member& member = structure.members[static_cast<std::size_t>(branch)];
        const double s = static_cast<double>(surface.along[i]);
        point = member_point(member, displacement, s);
        axis_point = member.point(s);
      }
      const Vec3 arm = surface.position[i].cast<double>() - axis_point;
      delta.position[i] = (point.displacement + point.rotation.cross(arm)).cast<float>();
      delta.normal[i] = point.rotation.cross(surface.normal[i].cast<double>()).cast<float>();
    }
  };
  tbb::parallel_for(std::size_t{0}, (count + together - 1) / together, [&](std::size_t part) {
    deform(part * together, std::min(count, (part + 1) * together));
  });
  return delta;
}

}  // namespace tremula
