#include "tremula/geometry/quadric_mesh.hpp"

#include "tremula/base/error.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

namespace tremula {
namespace {

std::vector<Quadric> some_quadrics() {
  const Mat3 turn =
      (Eigen::AngleAxisd(0.6, Vec3(1, 2, 0.5).normalized()) * Eigen::AngleAxisd(1, Vec3::UnitZ()))
          .toRotationMatrix();
  const Quadric askew{.centre = {1, -2, 5},
                      .form = turn * Vec3(1, 1 / 4.0, 1 / 9.0).asDiagonal() * turn.transpose()};
  Quadric cut = ellipsoid({0, 1, 2}, {2, 3, 1});
  cut.high = 2.4;
  return {askew, cut, upright_cone({0, 0, 7}, 3, 2), tapered_column(6, 0.5, 0.2)};
}

Vec3 corner(const QuadricMesh& mesh, std::size_t i) {
  return mesh.positions[mesh.triangles[i]].cast<double>();
}

TEST(QuadricMesh, HasAllItsCornersOnTheQuadricAndNormalsAlongItsGradient) {
  for (const Quadric& quadric : some_quadrics()) {
    const QuadricMesh mesh = mesh_of(quadric, 9, 12);
    ASSERT_EQ(mesh.positions.size(), 9U * 12U);
    const Eigen::AlignedBox3d box = bounds_of(quadric);
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
      const Vec3 at = mesh.positions[i].cast<double>() - quadric.centre;
      EXPECT_NEAR(at.dot(quadric.form * at), quadric.level, 2e-5);
      EXPECT_GE(mesh.positions[i].z(), box.min().z() - 1e-5);
      EXPECT_LE(mesh.positions[i].z(), box.max().z() + 1e-5);
      const Vec3 gradient = quadric.form * at;
      if (gradient.norm() > 1e-3) {
        EXPECT_NEAR(mesh.normals[i].cast<double>().dot(gradient.normalized()), 1, 1e-5);
      }
      EXPECT_NEAR(mesh.normals[i].norm(), 1, 1e-6F);
    }
  }
}

TEST(QuadricMesh, LooksOutwardsWithEveryTriangle) {
  for (const Quadric& quadric : some_quadrics()) {
    const QuadricMesh mesh = mesh_of(quadric, 9, 12);
    for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) {
      const Vec3 a = corner(mesh, i), b = corner(mesh, i + 1), c = corner(mesh, i + 2);
      const Vec3 facing = (b - a).cross(c - a), middle = (a + b + c) / 3;
      if (facing.norm() < 1e-9) continue;  // at a pole
      EXPECT_GT(facing.dot(quadric.form * (middle - quadric.centre)), 0);
    }
  }
}

// A closed one holds what its tetrahedra hold (Gauss), which comes to the volume of the formula.
TEST(QuadricMesh, EnclosesTheVolumeOfTheQuadricAsItGetsFiner) {
  const Quadric quadric = some_quadrics()[0];
  double off = 1;
  for (const int fineness : {8, 16, 32, 64}) {
    const QuadricMesh mesh = mesh_of(quadric, fineness, 2 * fineness);
    double volume = 0;
    for (std::size_t i = 0; i < mesh.triangles.size(); i += 3)
      volume += corner(mesh, i).dot(corner(mesh, i + 1).cross(corner(mesh, i + 2))) / 6;
    const double now = 1 - volume / volume_of(quadric);
    EXPECT_GT(now, 0);
    EXPECT_LT(now, off / 3);  // second order
    off = now;
  }
  EXPECT_LT(off, 3e-3);
}

TEST(QuadricMesh, IsRefusedForWhatHasNoVolumeAndForTooFewRings) {
  Quadric flat = ellipsoid({0, 0, 1}, {1, 1, 1});
  flat.low = flat.high = 1;
  EXPECT_THROW(mesh_of(flat, 9, 12), InputError);
  EXPECT_THROW(mesh_of(some_quadrics()[0], 1, 12), InputError);
  EXPECT_THROW(mesh_of(some_quadrics()[0], 9, 2), InputError);
}

}  // namespace
}  // namespace tremula
