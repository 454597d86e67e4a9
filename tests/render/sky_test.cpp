#include "tremula/render/sky.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace tremula {
namespace {

using Eigen::Vector3f;
using Eigen::Vector3i;

constexpr float pi = std::numbers::pi_v<float>;

FogGrid cube_of_fog(float extinction) {
  FogGrid fog;
  fog.low = Vector3f(-1, -1, -1);
  fog.cell = 0.1F;
  fog.size = Vector3i(20, 20, 20);
  fog.extinction.assign(8000, extinction);
  return fog;
}

TEST(FogGrid, WeakensLightByTheLengthOfTheWayThroughIt) {
  const FogGrid fog = cube_of_fog(0.7F);
  const Vector3f along = Vector3f(1, 0, 0);
  EXPECT_NEAR(fog.transmittance({-5, 0.03F, 0.03F}, along), std::exp(-0.7F * 2), 1e-5F);
  EXPECT_NEAR(fog.transmittance({0.5F, 0.03F, 0.03F}, along), std::exp(-0.7F * 0.5F), 1e-5F);
  const Vector3f slant = Vector3f(1, 1, 1).normalized();
  EXPECT_NEAR(fog.transmittance({0, 0, 0}, slant), std::exp(-0.7F * std::sqrt(3.0F)), 0.03F);
  EXPECT_EQ(fog.transmittance({-5, 0, 0}, -along), 1);
  EXPECT_EQ(fog.transmittance({-5, 2, 0}, along), 1);
  EXPECT_EQ(fog.transmittance({0, 0, -1e6F}, {0, 0, -1}), 1);
}

TEST(MakeFog, HoldsTheProjectedAreaOfTheTriangles) {
  const std::vector<Vector3f> positions = {{0, 0, 0},          {3, 0, 0},           {0, 2, 1},
                                           {0.1F, 0.1F, 0.1F}, {0.1F, 0.12F, 0.1F}, {0.1F, 0.1F, 0.15F}};
  const std::vector<std::uint32_t> large = {0, 1, 2}, small = {3, 4, 5};
  const float large_area = 0.5F * Vector3f(3, 0, 0).cross(Vector3f(0, 2, 1)).norm();
  const float small_area = 0.5F * 0.02F * 0.05F;
  const auto total = [](const FogGrid& fog) {
    return std::accumulate(fog.extinction.begin(), fog.extinction.end(), 0.0F) * fog.cell * fog.cell *
           fog.cell;
  };
  const Vector3f low(0, 0, 0), high(3, 2, 1);
  const auto fog_of = [&](const std::vector<std::uint32_t>& triangles, bool thin, int cells) {
    FogGrid made = make_fog(low, high, cells);
    SurfacePart part;
    part.material.two_sided = thin;
    part.triangles = triangles;
    add_fog(made, positions, part);
    return made;
  };
  EXPECT_NEAR(total(fog_of(large, true, 30)), 0.5F * large_area, 1e-4F);
  EXPECT_NEAR(total(fog_of(large, false, 30)), 0.25F * large_area, 1e-4F);
  EXPECT_NEAR(total(fog_of(small, true, 30)), 0.5F * small_area, 1e-6F);
  // A large triangle is spread over the cells that it crosses: about area / cell^2 of them.
  const FogGrid fog = fog_of(large, true, 6);
  const auto cells =
      std::count_if(fog.extinction.begin(), fog.extinction.end(), [](float e) { return e > 0; });
  EXPECT_GT(cells, large_area / (fog.cell * fog.cell));
  // … evenly: its middle stays where it was.
  const FogGrid fine = fog_of(large, true, 60);
  Vector3f sum = Vector3f::Zero();
  float weight = 0;
  for (int z = 0; z < fine.size.z(); ++z) {
    for (int y = 0; y < fine.size.y(); ++y) {
      for (int x = 0; x < fine.size.x(); ++x) {
        const float e = fine.extinction[fine.index({x, y, z})];
        sum += e * (fine.low + fine.cell * (Vector3i(x, y, z).cast<float>() + Vector3f::Constant(0.5F)));
        weight += e;
      }
    }
  }
  EXPECT_LT((sum / weight - (positions[0] + positions[1] + positions[2]) / 3).norm(), 0.5F * fine.cell);
}

TEST(AmbientLight, InEvenLightEverySideGetsPiTimesTheRadiance) {
  const Rgb even(0.2F, 0.5F, 1);
  const AmbientLight light(cube_of_fog(0), {even, even, even, Rgb::Zero()});
  for (const Vector3f& normal : {Vector3f(0, 0, 1), Vector3f(1, 0, 0), Vector3f(0.6F, 0, -0.8F)}) {
    for (const Vector3f& point : {Vector3f(0, 0, 0), Vector3f(0.91F, -0.3F, 0.2F), Vector3f(9, 9, 9)}) {
      EXPECT_LT((light.irradiance(point, normal) - pi * even).norm(), 0.02F * pi * even.norm());
    }
  }
}

TEST(AmbientLight, UpperSidesGetSkyLowerSidesGetGround) {
  const AmbientLight light(cube_of_fog(0), {Rgb(0, 0, 1), Rgb(0, 0, 1), Rgb(1, 0, 0), Rgb::Zero()});
  // A half sphere of radiance 1 gives pi to the side that faces it; to first order the other side gets
  // nothing.
  const Rgb up = light.irradiance({0, 0, 0}, {0, 0, 1});
  const Rgb down = light.irradiance({0, 0, 0}, {0, 0, -1});
  EXPECT_NEAR(up.z(), pi, 0.03F);
  EXPECT_NEAR(up.x(), 0, 0.03F);
  EXPECT_NEAR(down.x(), pi, 0.03F);
  EXPECT_NEAR(down.z(), 0, 0.03F);
}

TEST(AmbientLight, DeepInDenseFogOnlyTheFogShines) {
  const Rgb sky(1, 1, 1), own(0.1F, 0.3F, 0.05F);
  const AmbientLight light(cube_of_fog(20), {sky, sky, sky, own});
  EXPECT_LT((light.irradiance({0, 0, 0}, {0, 0, 1}) - pi * own).norm(), 0.05F * pi * own.norm());
}

TEST(GroundLight, IsFullInTheOpenAndDimUnderACrown) {
  const GroundLight open(cube_of_fog(0), {0, 0}, -1.5F, 8);
  EXPECT_EQ(open.sky_share(0, 0), 1);
  EXPECT_EQ(open.sky_share(100, -100), 1);
  const GroundLight covered(cube_of_fog(10), {0, 0}, -1.5F, 8);
  // The cube fills the cone up to about 63 degrees from its foot half a metre above: cos-weighted, most of
  // the sky.
  EXPECT_LT(covered.sky_share(0, 0), 0.25F);
  EXPECT_GT(covered.sky_share(7.5F, 7.5F), 0.95F);
  EXPECT_LT(covered.sky_share(0, 0), covered.sky_share(1.5F, 0));
  EXPECT_LT(covered.sky_share(1.5F, 0), covered.sky_share(4, 0));
}

}  // namespace
}  // namespace tremula
