#include "tremula/deformation/pose.hpp"

#include "tremula/base/check.hpp"
#include "tremula/dynamics/basis.hpp"

#include <algorithm>

#include <tbb/parallel_for.h>

namespace tremula {
namespace {

struct EndMotion {
  Vec3 translation, rotation;
};

// The ends of a branch, the first carried rigidly from its node to the start of the branch.
EndMotion start_motion(const Skeleton& skeleton, const Structure& structure, const Displacement& displacement,
                       int branch) {
  const int parent = skeleton.parent(branch);
  if (parent < 0) {
    const Vec6 foot = foot_displacement(structure, displacement, branch);
    return {foot.head<3>(), foot.tail<3>()};
  }
  const Branch& self = skeleton.branches[static_cast<std::size_t>(branch)];
  const Vec3 rotation = displacement.segment<3>(6 * parent + 3);
  const Vec3 arm = self.start - skeleton.node_position(self.start_node);
  return {displacement.segment<3>(6 * parent) + rotation.cross(arm), rotation};
}

}  // namespace

Displacement displacement_at(const Modes& modes, const Motion& motion, double time,
                             Interpolation interpolation) {
  return superpose(modes, motion, weights_at(motion, time, interpolation));
}

BranchPoint branch_point(const Skeleton& skeleton, const Structure& structure,
                         const Displacement& displacement, int branch, double s) {
  if (branch < 0 || branch >= skeleton.branch_count()) {
    throw InputError("branch", std::to_string(branch), "0 to " + std::to_string(skeleton.branch_count() - 1));
  }
  if (!(s >= 0 && s <= 1)) throw InputError("place along a branch", std::to_string(s), "0 to 1");
  check_equal("rows of the displacement", displacement.size(), Eigen::Index{6} * skeleton.branch_count());
  const Branch& self = skeleton.branches[static_cast<std::size_t>(branch)];
  const EndMotion start = start_motion(skeleton, structure, displacement, branch);
  const EndMotion end{displacement.segment<3>(6 * branch), displacement.segment<3>(6 * branch + 3)};
  const Vec3 chord = self.end - self.start;
  const double length = chord.norm();
  const Vec3 direction = chord / length;

  // Hermite's cubics across the branch, from the deflections and slopes theta x d at the ends; linear along
  // it.
  const double s2 = s * s, s3 = s2 * s;
  const Vec3 slope0 = length * start.rotation.cross(direction),
             slope1 = length * end.rotation.cross(direction);
  const Vec3 cubic = (1 - 3 * s2 + 2 * s3) * start.translation + (s - 2 * s2 + s3) * slope0 +
                     (3 * s2 - 2 * s3) * end.translation + (s3 - s2) * slope1;
  const Vec3 straight = (1 - s) * start.translation + s * end.translation;
  const Vec3 slope = ((6 * s2 - 6 * s) * (start.translation - end.translation) +
                      (1 - 4 * s + 3 * s2) * slope0 + (3 * s2 - 2 * s) * slope1) /
                     length;
  const double twist = ((1 - s) * start.rotation + s * end.rotation).dot(direction);

  BranchPoint point;
  point.displacement = cubic + (straight - cubic).dot(direction) * direction;
  point.rotation = twist * direction + direction.cross(slope);
  return point;
}

SurfaceDelta deform_surface(const Skeleton& skeleton, const Structure& structure, const Surface& surface,
                            const Displacement& displacement) {
  const auto vertices = static_cast<std::ptrdiff_t>(surface.vertex_count());
  check_equal("normals of the surface", static_cast<std::ptrdiff_t>(surface.normal.size()), vertices);
  check_equal("branches of the vertices", static_cast<std::ptrdiff_t>(surface.branch.size()), vertices);
  check_equal("places along the branches", static_cast<std::ptrdiff_t>(surface.along.size()), vertices);
  check_equal("branches of the structure", structure.branch_count(), skeleton.branch_count());
  constexpr std::size_t together = 4096;
  const std::size_t count = surface.vertex_count();
  SurfaceDelta delta;
  delta.position.resize(count);
  delta.normal.resize(count);
  const auto deform = [&](std::size_t first, std::size_t end) {
    BranchPoint point{Vec3::Zero(), Vec3::Zero()};
    Vec3 axis_point = Vec3::Zero();
    for (std::size_t i = first; i < end; ++i) {
      const int branch = surface.branch[i];
      // The vertices of a ring or a leaf stand one after the other: their cross section is worked out once.
      if (i == first || branch != surface.branch[i - 1] || surface.along[i] != surface.along[i - 1]) {
        const double s = static_cast<double>(surface.along[i]);
        point = branch_point(skeleton, structure, displacement, branch, s);
        const Branch& self = skeleton.branches[static_cast<std::size_t>(branch)];
        axis_point = self.start + s * (self.end - self.start);
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
