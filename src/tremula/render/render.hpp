// A picture of a plant: sun with shadows, sky light dimmed by the plant itself, leaves that glow against the
// sun, and the ground it stands on. Drawn on the CPU; the same bytes on any number of threads.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "tremula/geometry/surface.hpp"
#include "tremula/render/camera.hpp"
#include "tremula/render/image.hpp"

namespace tremula {

struct RenderOptions {
  int width = 480;                    // [pixels] 1 … 8192; width / height is the camera's aspect
  int height = 480;                   // [pixels] 1 … 8192
  int samples = 3;                    // per pixel and direction, 1 … 8
  int shadow_map = 1536;              // [pixels] of the sun's view, 16 … 8192
  double sun_azimuth = 0.9;           // from the camera to its right, around the plant [rad]
  double sun_elevation = 0.8;         // above the horizon [rad], (0, pi/2]
  double exposure = 1.8;              // 0.001 … 1000
  std::optional<double> ground = {};  // its height [m]; if not given, the lowest point of the surface at rest
  bool draw_ground = true;
  bool under_water = false;  // sand for grass, and water that swallows what is far
};

// `positions` and `normals` (V each) take the place of those at rest. Throws InputError where sizes do not
// agree, an index or an option is out of range, or a number is not finite.
Image render_surface(const Surface& surface, std::span<const Eigen::Vector3f> positions,
                     std::span<const Eigen::Vector3f> normals, const Camera& camera,
                     const RenderOptions& options = {});

}  // namespace tremula
