// Where what drifts puts its skin. A loop has the same vertices all the time, and more are born in it than
// are ever seen at once: each small mesh shows one path after the other, with a pause between two in which it
// is a point, first where the last one went, then where the next one comes. So no shutter that is open no
// longer than a sample of the loop sees it fly from one to the other.
#pragma once

#include "tremula/deformation/loop.hpp"
#include "tremula/dynamics/drift.hpp"
#include "tremula/geometry/surface.hpp"

#include <cstdint>
#include <memory>
#include <vector>

namespace tremula {

// A stay of a path on a mesh: seen from `begin` to below `end` [s], as old as the time less `birth`. The mesh
// is its own from the middle of the pause before to that of the pause after.
struct DriftStay {
  float begin = 0, end = 0;  // begin within the loop; the end may lie in the next one
  float taken = 0;           // since when the mesh is its own, within the loop or before it
  float birth = 0;           // may lie loops before
  std::uint32_t path = 0;
};

// Stays of each mesh, one after the other in time; those of mesh m from first[m] to below first[m + 1].
struct DriftStays {
  std::vector<DriftStay> stays;
  std::vector<std::uint32_t> first;
  double pause = 0;  // at least so long between two [s]

  std::size_t mesh_count() const { return first.size() - 1; }
};

// On few meshes more than are ever seen at once. A path that does not fit on one goes on on another at once.
DriftStays share_meshes(const DriftPaths& paths, const std::vector<std::uint32_t>& members, double pause);
// The same for all paths, those of each of so many materials by themselves; pauses of two samples of the loop
// and a little more.
std::vector<DriftStays> share_meshes(const DriftPaths& paths, std::size_t materials);

struct DriftLook {
  std::vector<SurfaceMaterial> materials;  // one or more: every path has one of them
};
DriftLook look_of(DriftForm form);

// The small mesh of a form, of size 1: shown in the size of its path.
struct DriftMesh {
  std::vector<Eigen::Vector3f> position, normal;
  std::vector<Eigen::Vector2f> texture;
  std::vector<std::uint32_t> triangles;
};
DriftMesh mesh_of(DriftForm form);

// How a leaf or a seed turns on its way. At an age [s], of which it was in the air for `air`, it is turned by
//
//   R_z(yaw + yaw_rate air) R_y(flying tilt) R_x(flying lean),
//   tilt = swing sin(phase + rate age), or phase + rate age where it tumbles,
//
// and stands off its path by -flying glide cos(phase + rate age) along the x axis that R_z turns. `flying` is
// 1, but of those that come to rest it goes smoothly to 0 in the last settling_time.
struct DriftTurns {
  float phase = 0, rate = 0;    // [rad], [rad/s]
  float yaw = 0, yaw_rate = 0;  // [rad], [rad/s]
  float swing = 0, lean = 0;    // [rad]
  float glide = 0;              // [m]
  bool tumbles = false;
};
DriftTurns turns_of(DriftForm form, const DriftPath& path);
bool has_turns(DriftForm form);

inline constexpr float settling_time = 0.35F;  // in which one that comes to rest lays itself flat [s]

// A loop of no shapes: its coordinates have no columns, what moves is in skin_at alone. Throws InputError for
// paths of none.
Loop make_loop(std::shared_ptr<const DriftPaths> paths, const LoopFacts& facts, const DriftLook& look);

}  // namespace tremula
