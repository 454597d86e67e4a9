// A perspective camera, and how to get something into its frame.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "tremula/base/types.hpp"

namespace tremula {

struct Camera {
  Vec3 eye = Vec3::Zero();      // [m]
  Vec3 right = Vec3(0, -1, 0);  // right, up and forward: unit vectors at right angles
  Vec3 up = Vec3::UnitZ();
  Vec3 forward = Vec3::UnitX();
  double half_height = 0.25;  // of the picture at distance 1: tangent of half the vertical field of view
  double aspect = 1;          // width / height of the picture
};

// How large and how close to the border a picture shows what it frames.
struct Framing {
  double half_height = 0.25;  // of the camera
  double margin = 0.06;       // of the picture, on each side, 0 … 0.49
};

// Looks from the compass direction `azimuth` (0: from +x, pi/2: from +y) and from `elevation` above [rad,
// within
// (-pi/2, pi/2)], as near as all the points fit with a margin all around. A single point is taken for a
// centimetre. Throws InputError for no points, for some that are not finite, and for angles, an aspect or
// a framing out of range.
Camera frame_points(std::span<const Eigen::Vector3f> points, double azimuth, double elevation, double aspect,
                    const Framing& framing = {});

// The same for the corners of a box. Throws InputError also for a box turned inside out.
Camera frame_extent(const Vec3& low, const Vec3& high, double azimuth, double elevation, double aspect,
                    const Framing& framing = {});

// Looks from `eye` at a point, which is in the middle of the picture. What is level stays level; straight
// down or up, +y (-y) is above. Throws InputError for places that are one or not finite, and for sizes out of
// range.
Camera look_at(const Vec3& eye, const Vec3& point, double aspect, double half_height = Framing{}.half_height);

// From where a wind that blows towards `heading` [rad] is best looked across: 105 degrees to its right, so
// that lean and sway show; but where a sheet, by the unit normals of its poses, shows less than half as much
// there as from further upwind, from there [rad].
double azimuth_across(std::span<const std::vector<Eigen::Vector3f>> normals, double heading);

// Where a point appears: x from left, y from top, both 0 to 1 inside the picture; nothing for points behind
// the eye.
std::optional<Eigen::Vector2d> project(const Camera& camera, const Vec3& point);

}  // namespace tremula
