// A skin carried by cross sections, whatever moves them.
#pragma once

#include "tremula/base/check.hpp"
#include "tremula/deformation/pose.hpp"

#include <algorithm>
#include <optional>

#include <tbb/parallel_for.h>

namespace tremula {

// section_at(branch, s), called by several threads, tells of the cross section at s of a member how it moves
// what it carries: position(arm) the change of a point that stands at `arm` from the axis at rest, normal(n)
// the change of a normal. What the vertices from `count` on do is left to the caller. Throws InputError for a
// surface whose arrays do not agree, and for members that there are not.
template <class SectionAt>
SurfaceDelta carry_surface(const Structure& structure, const Surface& surface, std::size_t count,
                           const SectionAt& section_at) {
  const auto vertices = static_cast<std::ptrdiff_t>(surface.vertex_count());
  check_equal("normals of the surface", static_cast<std::ptrdiff_t>(surface.normal.size()), vertices);
  check_equal("branches of the vertices", static_cast<std::ptrdiff_t>(surface.branch.size()), vertices);
  check_equal("places along the branches", static_cast<std::ptrdiff_t>(surface.along.size()), vertices);
  constexpr std::size_t together = 4096;
  const std::size_t member_count = structure.members.size();
  SurfaceDelta delta;
  delta.position.resize(surface.vertex_count());
  delta.normal.resize(surface.vertex_count());
  const auto carry = [&](std::size_t first, std::size_t end) {
    std::optional<decltype(section_at(std::size_t{0}, 0.0))> section;
    Vec3 axis_point = Vec3::Zero();
    for (std::size_t i = first; i < end; ++i) {
      const int branch = surface.branch[i];
      // The vertices of a ring or a leaf stand one after the other: their cross section is worked out once.
      if (i == first || branch != surface.branch[i - 1] || surface.along[i] != surface.along[i - 1]) {
        if (branch < 0 || static_cast<std::size_t>(branch) >= member_count) {
          throw InputError("branch of a vertex", std::to_string(branch),
                           "0 to " + std::to_string(member_count - 1));
        }
        const auto s = static_cast<double>(surface.along[i]);
        section = section_at(static_cast<std::size_t>(branch), s);
        axis_point = structure.members[static_cast<std::size_t>(branch)].point(s);
      }
      const Vec3 arm = surface.position[i].template cast<double>() - axis_point;
      delta.position[i] = section->position(arm).template cast<float>();
      delta.normal[i] = section->normal(surface.normal[i].template cast<double>()).template cast<float>();
    }
  };
  tbb::parallel_for(std::size_t{0}, (count + together - 1) / together, [&](std::size_t part) {
    carry(part * together, std::min(count, (part + 1) * together));
  });
  return delta;
}

template <class SectionAt>
SurfaceDelta carry_surface(const Structure& structure, const Surface& surface, const SectionAt& section_at) {
  return carry_surface(structure, surface, surface.vertex_count(), section_at);
}

}  // namespace tremula
