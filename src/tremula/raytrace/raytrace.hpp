// Pictures by path tracing (Embree): what is in a picture, and the picture.
#pragma once

#include "tremula/deformation/loop.hpp"
#include "tremula/raytrace/ray_shape.hpp"
#include "tremula/render/camera.hpp"
#include "tremula/render/daylight.hpp"
#include "tremula/render/linear_image.hpp"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

namespace tremula {

enum class GroundKind { none, grass, soil, sand, snow, plain };

struct GroundLook {
  GroundKind kind = GroundKind::grass;
  double height = 0;                              // [m]
  Eigen::Vector3f color = {0.18F, 0.18F, 0.18F};  // linear albedo, of a plain one
  double grass_height = 0;  // [m] of grass that stands in blades near the camera, 0 … 1; 0: a pattern alone
  // What is laid over it at a place and a time [s]: a linear albedo, and how much of the ground that covers,
  // 0–1. Empty: nothing. Called by several threads.
  std::function<Eigen::Vector4f(const Eigen::Vector2f& place, double time)> tint = {};
  double time = 0;  // of the tint; a Tracer takes that of the picture
  // Where a loop of the scene brings such blades itself, that move: circles (x, y and radius) [m].
  std::vector<Eigen::Vector3d> sown = {};
};

// What is between things: air that hazes what is far, or water.
struct Haze {
  Eigen::Vector3f extinction = Eigen::Vector3f::Zero();  // [1/m] red, green, blue; 0: clear
};

// What a film shows. Loops are shared: many scenes may show one. Each has its instances (Loop::instances),
// whose time shifts are rounded so that at most `poses_per_loop` poses of a loop are held at a time; and of
// large scenes fewer, but no fewer than two, so that all poses together have no more than `posed_triangles`.
struct TraceScene {
  std::vector<std::shared_ptr<const Loop>> loops = {};
  std::vector<std::shared_ptr<const RayShape>> ray_shapes = {};  // beside them: what is no triangles
  GroundLook ground = {};
  Haze haze = {};
  bool under_water = false;
  DaylightSettings daylight = {};
  std::optional<Eigen::Vector3f> uniform_sky =
      {};  // instead of sun and sky: the same radiance from everywhere
  int poses_per_loop = 24;
  double posed_triangles = 6e6;  // of about 120 bytes each
};

struct Lens {
  double radius = 0;          // [m]; 0: a pinhole
  double focus_distance = 1;  // [m]
};

struct TraceOptions {
  int width = 960, height = 540;  // [pixels] 1 … 16384
  int samples = 64;               // a pixel, 1 … 65536
  int bounces = 6;                // of light, 0 … 64: 0 sees the sky alone
  double shutter = 0;             // how long it is open, centred on the frame's time [s]
  Lens lens = {};
  std::uint64_t seed = 1;
};

struct TraceCounts {
  std::uint64_t rays = 0;                                 // all that were shot
  std::uint64_t triangles = 0, instances = 0, poses = 0;  // poses: that were held of all loops
  std::uint64_t shapes = 0;                               // that are no triangles
  double seconds_build = 0, seconds_trace = 0;
};

// False where the library was built without Embree: a Tracer then throws Error.
bool can_trace();

// Embree's device and what of a scene does not change from frame to frame.
class Tracer {
 public:
  // Throws InputError for a scene that is none: a loop without vertices, numbers out of range.
  explicit Tracer(TraceScene scene);
  ~Tracer();
  Tracer(Tracer&&) noexcept;
  Tracer& operator=(Tracer&&) noexcept;

  // The picture at `time` [s] that the camera (of that time; `camera(t)` within the shutter) takes. The same
  // bytes on any number of threads. `done` is told how much is done, 0 to 1, and stops the work by throwing.
  TracedImage trace(const std::function<Camera(double time)>& camera, double time,
                    const TraceOptions& options, const std::function<void(double)>& done = {},
                    TraceCounts* counts = nullptr) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tremula
