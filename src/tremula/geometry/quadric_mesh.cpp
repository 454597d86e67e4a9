#include "tremula/geometry/quadric_mesh.hpp"

#include "tremula/base/error.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include <Eigen/Cholesky>

namespace tremula {
namespace {

// Where the level section has its middle, and what makes it of a circle (impression.cpp: Sections).
struct Ring {
  Eigen::Vector2d middle{0, 0};
  Eigen::Matrix2d of_circle = Eigen::Matrix2d::Zero();
};

Ring ring_at(const Quadric& quadric, double height) {
  const Eigen::Matrix2d flat = quadric.form.topLeftCorner<2, 2>();
  const Eigen::Vector2d across = quadric.form.topRightCorner<2, 1>();
  const Eigen::LLT<Eigen::Matrix2d> root(flat);
  const Eigen::Vector2d lean = root.solve(across);
  const double z = height - quadric.centre.z();
  const double left = quadric.level - (quadric.form(2, 2) - across.dot(lean)) * z * z;
  Ring ring;
  ring.middle = quadric.centre.head<2>() - z * lean;
  ring.of_circle = root.matrixU().solve(Eigen::Matrix2d::Identity());
  ring.of_circle *= std::sqrt(std::max(left, 0.0));
  return ring;
}

// Straight up the rings at the apex of a cone, where the quadric has no normal.
Vec3 normal_at(const Quadric& quadric, const Vec3& place, double height, double low, double high) {
  const Vec3 gradient = quadric.form * (place - quadric.centre);
  const double size = gradient.norm();
  const double tiny = 1e-9 * std::sqrt(quadric.form.norm());
  if (size > tiny) return gradient / size;
  return (height - low > high - height ? 1 : -1) * Vec3::UnitZ();
}

}  // namespace

QuadricMesh mesh_of(const Quadric& quadric, int rings, int sides) {
  check_quadric(quadric, "a quadric");
  if (rings < 2 || sides < 3)
    throw InputError("mesh of a quadric", std::to_string(rings) + " rings of " + std::to_string(sides),
                     "at least 2 of 3");
  const Eigen::AlignedBox3d box = bounds_of(quadric);
  const double low = box.min().z(), high = box.max().z();
  QuadricMesh mesh;
  for (int i = 0; i < rings; ++i) {
    const double share = (1 - std::cos(std::numbers::pi * i / (rings - 1))) / 2;
    const double height = low + share * (high - low);
    const Ring ring = ring_at(quadric, height);
    for (int k = 0; k < sides; ++k) {
      const double angle = 2 * std::numbers::pi * k / sides;
      Vec3 place;
      place << ring.middle + ring.of_circle * Eigen::Vector2d(std::cos(angle), std::sin(angle)), height;
      mesh.positions.push_back(place.cast<float>());
      mesh.normals.push_back(normal_at(quadric, place, height, low, high).cast<float>());
    }
  }
  for (int i = 0; i + 1 < rings; ++i) {
    for (int k = 0; k < sides; ++k) {
      const auto at = [&](int ring, int side) {
        return static_cast<std::uint32_t>(ring * sides + side % sides);
      };
      const std::uint32_t a = at(i, k), b = at(i, k + 1), c = at(i + 1, k), d = at(i + 1, k + 1);
      for (const std::uint32_t corner : {a, b, d, a, d, c}) mesh.triangles.push_back(corner);
    }
  }
  return mesh;
}

}  // namespace tremula
