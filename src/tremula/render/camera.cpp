#include "tremula/render/camera.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "tremula/base/error.hpp"

namespace tremula {
namespace {

constexpr double smallest = 0.005;  // half a width [m]

void check_sizes(double aspect, const Framing& framing) {
  if (!(aspect > 0.01 && aspect < 100)) {
    throw InputError("camera: aspect", std::to_string(aspect), "a number from 0.01 to 100");
  }
  if (!(framing.half_height > 1e-6 && framing.half_height < 1e3) ||
      !(framing.margin >= 0 && framing.margin < 0.495)) {
    throw InputError("camera: framing",
                     std::to_string(framing.half_height) + ", margin " + std::to_string(framing.margin),
                     "a field of view below half a turn, and a margin from 0 to 0.49");
  }
}

Camera look_from(double azimuth, double elevation, double aspect, const Framing& framing) {
  if (!std::isfinite(azimuth) || !(std::abs(elevation) < std::numbers::pi / 2)) {
    throw InputError("camera",
                     "azimuth " + std::to_string(azimuth) + ", elevation " + std::to_string(elevation),
                     "a finite azimuth and an elevation within (-pi/2, pi/2)");
  }
  check_sizes(aspect, framing);
  Camera camera;
  camera.aspect = aspect;
  camera.half_height = framing.half_height;
  const double level = std::cos(elevation);
  camera.forward = -Vec3(level * std::cos(azimuth), level * std::sin(azimuth), std::sin(elevation));
  camera.right = Vec3(-std::sin(azimuth), std::cos(azimuth), 0);
  camera.up = camera.right.cross(camera.forward);
  return camera;
}

// From an eye at -distance * forward + x * right, a point (a, b) (to the right, forward) is in the frame if
// |a - x| <= (b + distance) * slope: two linear conditions, so the nearest eye is known outright.
class Span {
 public:
  Span(const Vec3& axis, const Vec3& forward, double slope) : axis_(axis), forward_(forward), slope_(slope) {}
  void add(const Vec3& point) {
    const double across = point.dot(axis_);
    const double depth = point.dot(forward_) * slope_;
    right_ = std::max(right_, across - depth);
    left_ = std::max(left_, -across - depth);
    nearest_ = std::min(nearest_, point.dot(forward_));
  }
  // No nearer than half a centimetre would fill the picture, or a lone point would lie in the eye.
  double distance() const { return std::max((right_ + left_) / (2 * slope_), smallest / slope_ - nearest_); }
  double middle() const { return (right_ - left_) / 2; }

 private:
  Vec3 axis_, forward_;
  double slope_;
  double right_ = -std::numeric_limits<double>::infinity();
  double left_ = -std::numeric_limits<double>::infinity();
  double nearest_ = std::numeric_limits<double>::infinity();
};

// for_each(add): calls add for every point.
template <typename ForEach>
void move_back_to_fit(Camera& camera, double margin, const ForEach& for_each) {
  const double slope = camera.half_height * (1 - 2 * margin);
  Span across(camera.right, camera.forward, slope * camera.aspect);
  Span upright(camera.up, camera.forward, slope);
  for_each([&](const Vec3& point) {
    across.add(point);
    upright.add(point);
  });
  camera.eye = across.middle() * camera.right + upright.middle() * camera.up -
               std::max(across.distance(), upright.distance()) * camera.forward;
}

}  // namespace

Camera frame_points(std::span<const Eigen::Vector3f> points, double azimuth, double elevation, double aspect,
                    const Framing& framing) {
  Camera camera = look_from(azimuth, elevation, aspect, framing);
  if (points.empty()) throw InputError("camera", "no points", "at least one");
  for (const Eigen::Vector3f& point : points) {
    if (!point.allFinite()) throw InputError("camera", "a point that is not finite", "finite numbers");
  }
  move_back_to_fit(camera, framing.margin, [&](const auto& add) {
    for (const Eigen::Vector3f& point : points) add(point.cast<double>());
  });
  return camera;
}

Camera frame_extent(const Vec3& low, const Vec3& high, double azimuth, double elevation, double aspect,
                    const Framing& framing) {
  Camera camera = look_from(azimuth, elevation, aspect, framing);
  if (!low.allFinite() || !high.allFinite() || (high - low).minCoeff() < 0) {
    throw InputError("camera: extent", "a box that is not finite or ends below its start", "a box");
  }
  const Vec3 centre = (low + high) / 2;
  const Vec3 half = (high - low) / 2;
  move_back_to_fit(camera, framing.margin, [&](const auto& add) {
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3 sign((corner & 1) * 2 - 1, (corner & 2) - 1, (corner & 4) / 2 - 1);
      add(centre + half.cwiseProduct(sign));
    }
  });
  return camera;
}

Camera look_at(const Vec3& eye, const Vec3& point, double aspect, double half_height) {
  check_sizes(aspect, {half_height, 0});
  const Vec3 towards = point - eye;
  const double distance = towards.norm();
  if (!(distance > 0) || !std::isfinite(distance))
    throw InputError("camera", "an eye and what it looks at at one place", "two finite places");
  Camera camera;
  camera.eye = eye;
  camera.aspect = aspect;
  camera.half_height = half_height;
  camera.forward = towards / distance;
  const Vec3 across = camera.forward.cross(Vec3::UnitZ());
  camera.right = across.norm() > 1e-9 ? Vec3(across.normalized()) : Vec3(Vec3::UnitX());
  camera.up = camera.right.cross(camera.forward);
  return camera;
}

double azimuth_across(std::span<const std::vector<Eigen::Vector3f>> normals, double heading) {
  const auto shown_from = [&](double azimuth) {
    const auto towards = Eigen::Vector3d(std::cos(azimuth), std::sin(azimuth), 0).cast<float>().eval();
    double sum = 0;
    for (const auto& pose : normals) {
      for (const Eigen::Vector3f& normal : pose) sum += static_cast<double>(std::abs(normal.dot(towards)));
    }
    return sum;
  };
  constexpr double degree = std::numbers::pi / 180;
  const double across = heading - 105 * degree, upwind = heading - 145 * degree;
  return shown_from(across) < 0.5 * shown_from(upwind) ? upwind : across;
}

std::optional<Eigen::Vector2d> project(const Camera& camera, const Vec3& point) {
  const Vec3 offset = point - camera.eye;
  const double depth = offset.dot(camera.forward);
  if (!(depth > 0)) return std::nullopt;
  const double x = offset.dot(camera.right) / (depth * camera.half_height * camera.aspect);
  const double y = offset.dot(camera.up) / (depth * camera.half_height);
  return Eigen::Vector2d(0.5 + 0.5 * x, 0.5 - 0.5 * y);
}

}  // namespace tremula
