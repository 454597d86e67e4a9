// Loops as Embree has them: of every loop a few poses, of every pose its copies; posed anew for every frame.
#pragma once

#include "tremula/raytrace/embree.hpp"
#include "tremula/raytrace/raytrace.hpp"
#include "tremula/raytrace/scattering.hpp"
#include "tremula/render/patterns.hpp"

#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Core>

namespace tremula {

struct PartLook {
  enum class Kind { dull, bark, leaf, cloth, blade };
  Kind kind = Kind::dull;
  Rgb color = Rgb::Zero();  // linear
  bool two_sided = false;
  Pieces pieces;
  std::shared_ptr<const Gloss> gloss;  // none: dull
};

// What of a loop is the same in all its poses.
struct LoopShape {
  std::shared_ptr<const Loop> loop;
  std::vector<std::uint32_t> triangles;  // (3 per triangle) of all parts, one after the other
  std::vector<std::uint32_t> part_ends;  // triangles up to the end of each part
  std::vector<PartLook> parts;
  std::vector<double> shifts;               // one of each pose [s]
  std::vector<std::uint32_t> pose_of_copy;  // (instances)
};

// Throws InputError for a loop that cannot be drawn. Shifts that differ stay exact up to `most_poses` of
// them; else they are rounded to that many parts of the period. What is rounded is the shift, so that motion
// stays smooth.
LoopShape shape_of(std::shared_ptr<const Loop> loop, int most_poses);

struct ReleaseEmbree {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};
using EmbreeDevice = std::unique_ptr<RTCDeviceTy, ReleaseEmbree>;
using EmbreeScene = std::unique_ptr<RTCSceneTy, ReleaseEmbree>;

EmbreeDevice make_device();  // throws Error

struct Ray {
  Eigen::Vector3f origin, direction;
  float time = 0.5F;         // within the shutter, 0 to 1
  std::uint32_t random = 0;  // for what is hit by chance
};

struct Hit {
  std::uint32_t copy = RTC_INVALID_GEOMETRY_ID, triangle = 0;
  float distance = 0, u = 0, v = 0;
  bool of_shape = false;  // of what is no triangles: `shape` tells all then, and spot() nothing
  RayShapeHit shape;

  explicit operator bool() const { return copy != RTC_INVALID_GEOMETRY_ID; }
};

struct Spot {
  Eigen::Vector3f point, plane,
      normal;              // plane, normal: unit, of the triangle and of the smooth surface; outwards
  Eigen::Vector3f lifted;  // the point on the smooth surface, where that bulges beyond the triangle
  Eigen::Vector2f uv, uv_ab, uv_ac;
  Eigen::Vector3f ab, ac;  // edges [m]
  const PartLook* part = nullptr;
  std::uint32_t piece = 0;  // which leaf
  std::uint32_t copy = 0;
};

class PosedScene {
 public:
  // `path_count`: how many paths will be followed in it. Throws Error where Embree has no memory left, and
  // where a loop gives numbers that are none.
  PosedScene(RTCDevice device, const std::vector<const LoopShape*>& shapes,
             const std::vector<std::shared_ptr<const RayShape>>& ray_shapes, double time, double shutter,
             double path_count);
  PosedScene(const PosedScene&) = delete;  // Embree knows where it lies

  Hit closest(const Ray& ray, float farthest) const;
  bool blocked(const Ray& ray, float farthest) const;
  Spot spot(const Ray& ray, const Hit& hit) const;

  std::uint64_t triangle_count() const { return triangles_; }
  std::size_t copy_count() const { return copies_.size(); }
  std::size_t pose_count() const { return poses_.size(); }
  std::size_t shape_count() const { return ray_shapes_.size(); }
  RTCScene top() const { return top_.get(); }

 private:
  struct Pose {
    const LoopShape* shape = nullptr;
    double shift = 0;
    std::vector<std::vector<Eigen::Vector3f>>
        steps;                             // positions at instants of the shutter, and one more for Embree
    std::vector<Eigen::Vector3f> normals;  // the mean of first and last
    EmbreeScene scene;                     // none: drawn in the world itself, for its only copy
    const Instance* only_copy = nullptr;
  };
  struct Copy {  // from its pose to the world; of a pose in the world nothing is left to do
    const Pose* pose = nullptr;
    Eigen::Vector3f position = Eigen::Vector3f::Zero();
    float scale = 1, cosine = 1, sine = 0;

    Eigen::Vector3f turned(const Eigen::Vector3f& v) const {
      return {cosine * v.x() - sine * v.y(), sine * v.x() + cosine * v.y(), v.z()};
    }
  };
  void build(RTCDevice device, const std::vector<const LoopShape*>& shapes, bool many_rays);
  void attach_ray_shapes(RTCDevice device);

  std::vector<Pose> poses_;
  std::vector<Copy> copies_;
  std::vector<PosedRayShape> ray_shapes_;  // primitives of one geometry, whose number is after all copies
  EmbreeScene top_;
  std::uint64_t triangles_ = 0;
};

}  // namespace tremula
