// Things simple enough that what they look like is known.
#pragma once

#include "tremula/base/color.hpp"
#include "tremula/deformation/loop.hpp"
#include "tremula/numerics/random.hpp"
#include "tremula/raytrace/raytrace.hpp"

#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace tremula::simple {

inline Eigen::Vector3f srgb(float linear) { return Eigen::Vector3f::Constant(srgb_from_linear(linear)); }

inline Surface surface_of(const std::string& name, float albedo, bool two_sided) {
  Surface surface;
  surface.parts.push_back(
      {.material = {.name = name, .color = srgb(albedo), .two_sided = two_sided}, .triangles = {}});
  return surface;
}

inline std::uint32_t add_vertex(Surface& surface, const Eigen::Vector3f& position,
                                const Eigen::Vector3f& normal) {
  surface.position.push_back(position);
  surface.normal.push_back(normal.normalized());
  surface.texture.push_back(Eigen::Vector2f::Zero());
  surface.branch.push_back(0);
  surface.along.push_back(0);
  return static_cast<std::uint32_t>(surface.position.size() - 1);
}

inline void add_triangle(Surface& surface, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  for (const std::uint32_t corner : {a, b, c}) surface.parts[0].triangles.push_back(corner);
}

inline void add_quad(Surface& surface, const Eigen::Vector3f& corner, const Eigen::Vector3f& across,
                     const Eigen::Vector3f& up) {
  const Eigen::Vector3f normal = across.cross(up);
  const std::uint32_t a = add_vertex(surface, corner, normal),
                      b = add_vertex(surface, corner + across, normal),
                      c = add_vertex(surface, corner + across + up, normal),
                      d = add_vertex(surface, corner + up, normal);
  add_triangle(surface, a, b, c);
  add_triangle(surface, a, c, d);
}

inline Surface sphere(const std::string& name, float albedo, float radius, int rows = 12) {
  Surface surface = surface_of(name, albedo, false);
  const int columns = 2 * rows;
  for (int i = 0; i <= rows; ++i) {
    for (int j = 0; j < columns; ++j) {
      const float a = std::numbers::pi_v<float> * static_cast<float>(i) / static_cast<float>(rows);
      const float b = 2 * std::numbers::pi_v<float> * static_cast<float>(j) / static_cast<float>(columns);
      const Eigen::Vector3f out(std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a));
      add_vertex(surface, radius * out, out);
    }
  }
  const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(i * columns + j % columns); };
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < columns; ++j) {
      add_triangle(surface, at(i, j), at(i + 1, j), at(i + 1, j + 1));
      add_triangle(surface, at(i, j), at(i + 1, j + 1), at(i, j + 1));
    }
  }
  return surface;
}

// Small squares, all ways, within a ball of radius 1.
inline Surface cloud(const std::string& name, float albedo, int count) {
  Surface surface = surface_of(name, albedo, true);
  const auto random = [&](int i, int of) {
    return static_cast<float>(uniform(
               {.seed = 5, .bin = static_cast<std::uint32_t>(of), .place = static_cast<std::uint64_t>(i)})) *
               2 -
           1;
  };
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3f middle(random(i, 0), random(i, 1), random(i, 2));
    if (middle.norm() > 1) continue;
    const Eigen::Vector3f across = Eigen::Vector3f(random(i, 3), random(i, 4), random(i, 5)).normalized();
    const Eigen::Vector3f up =
        across.cross(Eigen::Vector3f(random(i, 6), random(i, 7), random(i, 8))).normalized();
    add_quad(surface, middle, 0.2F * across, 0.2F * up);
  }
  return surface;
}

// `moved(time)`: by how much all of it is moved.
inline std::shared_ptr<Loop> loop_of(Surface surface,
                                     std::function<Eigen::Vector3f(double)> moved = nullptr) {
  auto loop = std::make_shared<Loop>();
  loop->facts.name = "simple";
  loop->period = 2;
  loop->coordinates = Eigen::MatrixXd::Zero(64, 1);
  const std::size_t vertices = surface.vertex_count();
  loop->rest = std::make_shared<const Surface>(std::move(surface));
  loop->skin_at = [vertices, moved = std::move(moved)](double time) {
    const Eigen::Vector3f by = moved ? moved(time) : Eigen::Vector3f(0, 0, 0);
    return SurfaceDelta{std::vector<Eigen::Vector3f>(vertices, by),
                        std::vector<Eigen::Vector3f>(vertices, Eigen::Vector3f::Zero())};
  };
  return loop;
}

inline Camera look(const Vec3& eye, const Vec3& at, double half_height = 0.25, double aspect = 1) {
  Camera camera;
  camera.eye = eye;
  camera.forward = (at - eye).normalized();
  const Vec3 side = std::abs(camera.forward.z()) > 0.99 ? Vec3::UnitX() : Vec3::UnitZ();
  camera.right = camera.forward.cross(side).normalized();
  camera.up = camera.right.cross(camera.forward);
  camera.half_height = half_height;
  camera.aspect = aspect;
  return camera;
}

inline TraceScene in_uniform_sky(std::vector<std::shared_ptr<const Loop>> loops, float radiance = 1) {
  TraceScene scene;
  scene.loops = std::move(loops);
  scene.ground.kind = GroundKind::none;
  scene.uniform_sky = Eigen::Vector3f::Constant(radiance);
  return scene;
}

inline TracedImage picture(const TraceScene& scene, const Camera& camera, const TraceOptions& options,
                           double time = 0) {
  return Tracer(scene).trace([&](double) { return camera; }, time, options);
}

inline Eigen::Vector3d mean_of(const LinearImage& image) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < image.rgb.size(); ++i)
    sum[static_cast<Eigen::Index>(i % 3)] += static_cast<double>(image.rgb[i]);
  return sum * 3 / static_cast<double>(image.rgb.size());
}

inline double difference(const LinearImage& a, const LinearImage& b) {  // mean of its size
  double sum = 0;
  for (std::size_t i = 0; i < a.rgb.size(); ++i) sum += static_cast<double>(std::abs(a.rgb[i] - b.rgb[i]));
  return sum / static_cast<double>(a.rgb.size());
}

}  // namespace tremula::simple
