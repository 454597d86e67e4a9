#include "tremula/raytrace/scattering.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include <Eigen/Geometry>

namespace tremula {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

// What a spot sends on in all, and the sum of the density: over a grid on the sphere of directions, which
// knows nothing of how directions are drawn.
struct Sums {
  Eigen::Vector3d sent = Eigen::Vector3d::Zero();
  double density = 0;
};

Sums over_sphere(const Scattering& spot, const Vector3f& to_eye) {
  constexpr int rows = 400, columns = 800;
  Sums sums;
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < columns; ++j) {
      const Vector3f direction =
          to_sphere({(static_cast<float>(i) + 0.5F) / rows, (static_cast<float>(j) + 0.5F) / columns});
      float density = 0;
      sums.sent += scattered(spot, to_eye, direction, density).cast<double>();
      sums.density += static_cast<double>(density);
    }
  }
  const double cell = 4 * std::numbers::pi / (rows * columns);
  return {cell * sums.sent, cell * sums.density};
}

Vector3f at_angle(float degrees) {
  const float angle = degrees * std::numbers::pi_v<float> / 180;
  return {std::sin(angle), 0, std::cos(angle)};
}

Scattering leaf(const Gloss* gloss = nullptr) {
  Scattering spot;
  spot.plane = spot.normal = Vector3f::UnitZ();
  spot.reflected = {0.10F, 0.22F, 0.05F};
  spot.transmitted = {0.08F, 0.20F, 0.02F};
  spot.gloss = gloss;
  return spot;
}

TEST(Scattering, OfADullLeafSendsOnWhatItReflectsAndTransmits) {
  const Scattering spot = leaf();
  for (const float angle : {0.0F, 40.0F, 75.0F}) {
    const Sums sums = over_sphere(spot, at_angle(angle));
    EXPECT_LT((sums.sent - (spot.reflected + spot.transmitted).cast<double>()).norm(), 1e-3) << angle;
    EXPECT_NEAR(sums.density, 1, 2e-3);
  }
}

TEST(Scattering, UnderGlossSendsOnTheShareOfTheCoatAndOfTheRestWhatTheLeafDoes) {
  for (const float roughness : {0.35F, 0.6F, 1.0F}) {
    const Gloss gloss(roughness);
    const Scattering spot = leaf(&gloss);
    for (const float angle : {5.0F, 45.0F, 70.0F, 83.0F}) {
      const Vector3f to_eye = at_angle(angle);
      const double coat = static_cast<double>(gloss.share(to_eye.z()));
      const Eigen::Vector3d wanted =
          Eigen::Vector3d::Constant(coat) + (1 - coat) * (spot.reflected + spot.transmitted).cast<double>();
      EXPECT_LT((over_sphere(spot, to_eye).sent - wanted).cwiseAbs().maxCoeff(), 0.006)
          << "roughness " << roughness << ", " << angle << " degrees";
    }
  }
}

TEST(Scattering, OfWhatSwallowsNothingKeepsAllLightWhateverTheSmoothNormal) {
  const Gloss gloss(0.5F);
  for (const Gloss* coat : {static_cast<const Gloss*>(nullptr), &gloss}) {
    for (const float tilt : {0.0F, 25.0F, 60.0F}) {
      for (const float angle : {-60.0F, 10.0F, 80.0F}) {
        Scattering spot;
        spot.plane = Vector3f::UnitZ();
        spot.normal = facing(at_angle(tilt), at_angle(angle));
        spot.reflected = Rgb::Constant(0.6F);
        spot.transmitted = Rgb::Constant(0.4F);
        spot.gloss = coat;
        EXPECT_NEAR(over_sphere(spot, at_angle(angle)).sent[0], 1, 0.015) << tilt << ", seen from " << angle;
      }
    }
  }
}

TEST(Scattering, IsReciprocal) {
  const Gloss gloss(0.4F);
  const Scattering spot = leaf(&gloss);
  const Vector3f a = Vector3f(0.3F, 0.4F, 0.6F).normalized();
  for (const Vector3f& b : {Vector3f(-0.5F, 0.2F, 0.3F), Vector3f(0.9F, 0, 0.1F)}) {
    float density = 0;
    const Vector3f unit = b.normalized();
    const Rgb there = scattered(spot, a, unit, density) / unit.z(),
              back = scattered(spot, unit, a, density) / a.z();
    EXPECT_LT((there - back).norm(), 1e-5F * there.norm());
  }
}

TEST(Scattering, DrawsDirectionsWithTheDensityItSays) {
  const Gloss gloss(0.5F);
  Scattering spot = leaf(&gloss);
  spot.normal = at_angle(20);
  const Vector3f to_eye = at_angle(-50);
  const int count = 1 << 16;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (std::uint32_t s = 0; s < count; ++s) {
    Sampler sampler(1, 2, s);
    const float choice = sampler.one();
    const Vector3f direction = scatter(spot, to_eye, choice, sampler.pair());
    float density = 0;
    const Rgb value = scattered(spot, to_eye, direction, density);
    if (density > 0) mean += (value / density).cast<double>() / count;
  }
  const Eigen::Vector3d wanted = over_sphere(spot, to_eye).sent;
  EXPECT_LT((mean - wanted).norm(), 0.005 * wanted.norm());
}

TEST(Facing, LeavesNormalsThatTheEyeSeesAndTurnsOthersOntoItsSide) {
  EXPECT_EQ(facing(Vector3f::UnitZ(), at_angle(80)), Vector3f(Vector3f::UnitZ()));
  const Vector3f to_eye = at_angle(120);
  const Vector3f turned = facing(Vector3f::UnitZ(), to_eye);
  EXPECT_GT(turned.dot(to_eye), 0);
  EXPECT_NEAR(turned.norm(), 1, 1e-5);
}

}  // namespace
}  // namespace tremula
