#include "tremula/render/daylight.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "tremula/base/error.hpp"
#include "tremula/render/atmosphere.hpp"

namespace tremula {
namespace {

constexpr double pi = std::numbers::pi;

DaylightSettings at(double degrees, double turbidity = 3) {
  DaylightSettings settings;
  settings.sun_elevation = degrees * pi / 180;
  settings.sun_azimuth = 0.7;
  settings.turbidity = turbidity;
  return settings;
}

Eigen::Vector3f towards(double elevation, double azimuth) {
  return Eigen::Vector3d(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                         std::sin(elevation))
      .cast<float>();
}

// Sums over elevations and azimuths, each a midpoint of its own solid angle.
template <class Function>
auto over_directions(double low, int rows, int turns, const Function& function) {
  decltype(function(Eigen::Vector3f())) sum = 0 * function(Eigen::Vector3f::UnitZ());
  for (int i = 0; i < rows; ++i) {
    const double sine = low + (1 - low) * (i + 0.5) / rows;
    for (int j = 0; j < turns; ++j) {
      const float angle = static_cast<float>((1 - low) / rows * 2 * pi / turns);
      sum += angle * function(towards(std::asin(sine), 2 * pi * (j + 0.5) / turns));
    }
  }
  return sum;
}

// Points that fill the square evenly (Hammersley).
Eigen::Vector2f point_of(int i, int count) {
  double reversed = 0, digit = 0.5;
  for (int rest = i; rest > 0; rest /= 2, digit /= 2) reversed += digit * (rest % 2);
  return {static_cast<float>((i + 0.5) / count), static_cast<float>(reversed)};
}

TEST(Daylight, SkyIrradianceIsTheSameByQuadratureAndBySamplingWithItsDensity) {
  for (const double degrees : {2.0, 20.0, 50.0, 90.0}) {
    const Daylight light(at(degrees));
    const auto level = [&](const Eigen::Vector3f& d) -> Eigen::Vector3f {
      return light.sky(d) * std::max(d.z(), 0.0F);
    };
    const Eigen::Vector3f by_quadrature = over_directions(0, 400, 400, level);
    Eigen::Vector3f by_samples = Eigen::Vector3f::Zero();
    constexpr int count = 1 << 15;
    for (int i = 0; i < count; ++i) {
      float density = 0;
      const Eigen::Vector3f direction = light.sample_sky(point_of(i, count), density);
      ASSERT_GT(density, 0);
      by_samples += level(direction) / (density * count);
    }
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(by_samples[c] / by_quadrature[c], 1, 0.005) << degrees;
      EXPECT_NEAR(light.sky_irradiance()[c] / by_quadrature[c], 1, 0.01) << degrees;
    }
  }
}

TEST(Daylight, LightFromBelowIsTheSameByQuadratureAndBySampling) {
  const Daylight light(at(30));
  const auto below = [&](const Eigen::Vector3f& d) {
    return luminance(light.sky(d)) * std::max(-d.z(), 0.0F);
  };
  float by_samples = 0;
  constexpr int count = 1 << 15;
  for (int i = 0; i < count; ++i) {
    float density = 0;
    const Eigen::Vector3f direction = light.sample_sky(point_of(i, count), density);
    by_samples += below(direction) / (density * count);
  }
  EXPECT_NEAR(by_samples / over_directions(-1, 800, 400, below), 1, 0.01);
}

TEST(Daylight, DensityOfSamplesIntegratesToOneAndIsThatOfTheSamplesDrawn) {
  for (const double degrees : {0.0, 10.0, 90.0}) {
    const Daylight light(at(degrees));
    EXPECT_NEAR(over_directions(-1, 2000, 512, [&](const auto& d) { return double{light.sky_density(d)}; }),
                1, 0.003);
    int same = 0;
    for (int i = 0; i < 1000; ++i) {
      float density = 0;
      const Eigen::Vector3f direction = light.sample_sky(point_of(i, 1000), density);
      EXPECT_NEAR(direction.norm(), 1, 1e-5);
      same += std::abs(light.sky_density(direction) - density) < 1e-3F * density ? 1 : 0;
    }
    EXPECT_GE(same, 995);  // a direction on an edge may round into the next cell
  }
}

TEST(Daylight, SamplesFollowTheSkyCloserThanEvenOnesDo) {
  const Daylight light(at(15));
  const auto spread = [&](bool even) {
    double sum = 0, squares = 0;
    constexpr int count = 1 << 13;
    for (int i = 0; i < count; ++i) {
      float density = static_cast<float>(1 / (2 * pi));
      const Eigen::Vector2f p = point_of(i, count);
      Eigen::Vector3f d = towards(std::asin(p.x()), 2 * pi * p.y());
      if (!even) d = light.sample_sky(p, density);
      const double value = d.z() > 0 ? luminance(light.sky(d)) / density : 0;
      sum += value / count;
      squares += value * value / count;
    }
    return squares / (sum * sum) - 1;
  };
  EXPECT_LT(spread(false), 0.25 * spread(true));
}

TEST(Daylight, IsFiniteAndNotNegativeInEveryDirectionForEverySun) {
  for (const double degrees : {0.0, 0.2, 2.0, 45.0, 89.9, 90.0}) {
    for (const double turbidity : {1.0, 10.0}) {
      const Daylight light(at(degrees, turbidity));
      EXPECT_TRUE(light.sun_irradiance().allFinite() && light.sun_irradiance().minCoeff() >= 0);
      for (int i = -90; i <= 90; ++i) {
        for (int j = 0; j < 36; ++j) {
          const Eigen::Vector3f d = towards((i + 0.01 * j) * pi / 180, j * pi / 18);
          const Eigen::Vector3f radiance = light.sky(d);
          ASSERT_TRUE(radiance.allFinite() && radiance.minCoeff() >= 0 && radiance.maxCoeff() > 0)
              << i << ' ' << j;
          ASSERT_TRUE(light.sky_density(d) > 0 && std::isfinite(light.sky_density(d)));
        }
      }
      for (const Eigen::Vector3f& axis :
           {Eigen::Vector3f(0, 0, 1), Eigen::Vector3f(0, 0, -1), Eigen::Vector3f(1, 0, 0),
            Eigen::Vector3f(-1, 0, 0), Eigen::Vector3f(0, 0, 1.0001F)}) {
        EXPECT_TRUE(light.sky(axis).allFinite());
        EXPECT_GT(light.sky_density(axis), 0);
      }
      for (const float u : {0.0F, 0.1F, 0.5F, 0.99999994F}) {
        for (const float v : {0.0F, 0.99999994F}) {
          float density = 0;
          EXPECT_TRUE(light.sample_sky({u, v}, density).allFinite());
          EXPECT_GT(density, 0);
        }
      }
    }
  }
}

TEST(Daylight, SkyIsBlueOverheadPaleAtTheHorizonAndWarmAtSunset) {
  const Daylight noon(at(50));
  const Eigen::Vector3f away = towards(80 * pi / 180, 0.7 + pi), level = towards(2 * pi / 180, 0.7 + pi);
  EXPECT_GT(noon.sky(away).z(), 1.8F * noon.sky(away).x());
  EXPECT_LT(noon.sky(level).z() / noon.sky(level).x(), 0.7F * noon.sky(away).z() / noon.sky(away).x());
  EXPECT_GT(luminance(noon.sky(level)), 2 * luminance(noon.sky(away)));

  const Daylight evening(at(2));
  EXPECT_GT(evening.sun_irradiance().x(), 3 * evening.sun_irradiance().z());
  const Eigen::Vector3f glow = evening.sky(towards(6 * pi / 180, 0.7));
  EXPECT_GT(glow.x(), 1.5F * glow.z());
  EXPECT_GT(luminance(glow), 5 * luminance(evening.sky(towards(pi / 2, 0))));
}

// Clear days: 100 klx on the level at 60 degrees within a quarter, a tenth to a quarter of it from the sky;
// the zenith has a few thousand cd/m^2.
TEST(Daylight, AtNoonIsAsBrightAsDaysAre) {
  const Daylight noon(at(60, 2));
  const double all = 683 * luminance(noon.level_irradiance()), sky = 683 * luminance(noon.sky_irradiance());
  EXPECT_NEAR(all, 100'000, 25'000);
  EXPECT_GT(sky, 9'000);
  EXPECT_LT(sky, 25'000);
  const double zenith = 683 * luminance(noon.sky({0, 0, 1}));
  EXPECT_GT(zenith, 1500);
  EXPECT_LT(zenith, 12'000);
  // What falls on the ground is white: between D65 and D50, which is (1.18, 0.98, 0.76) in sRGB.
  const Eigen::Vector3f white = noon.level_irradiance() / noon.level_irradiance().y();
  EXPECT_GT(white.x(), 1);
  EXPECT_LT(white.x(), 1.18F / 0.98F);
  EXPECT_LT(white.z(), 1);
  EXPECT_GT(white.z(), 0.76F / 0.98F);
}

TEST(Daylight, TurnsWithTheSun) {
  DaylightSettings one = at(20), other = at(20);
  other.sun_azimuth += 2;
  const Daylight a(one), b(other);
  for (const double elevation : {-0.5, 0.1, 1.0}) {
    for (const double azimuth : {0.0, 2.5, 4.0}) {
      const Eigen::Vector3f x = a.sky(towards(elevation, azimuth)),
                            y = b.sky(towards(elevation, azimuth + 2));
      EXPECT_LT((x - y).norm(), 1e-4F * x.norm());
      const Eigen::Vector3f mirror = a.sky(towards(elevation, 2 * one.sun_azimuth - azimuth));
      EXPECT_LT((x - mirror).norm(), 1e-4F * x.norm());
    }
  }
}

TEST(Daylight, GroundSendsUpWhatItsAlbedoLeavesOfTheLightOnIt) {
  DaylightSettings settings = at(40, 1);
  settings.ground_albedo = {0.5F, 0.5F, 0.5F};
  const Daylight light(settings);
  const Eigen::Vector3f down = light.sky({0, 0, -1});
  const Eigen::Vector3f lambert = 0.5F / static_cast<float>(pi) * light.level_irradiance();
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(down[c] / lambert[c], 1, 0.01);  // 10 m of air
}

TEST(Daylight, SunIrradianceIsThatAboveTheAirThroughTheAir) {
  for (const double degrees : {30.0, 90.0}) {
    const Daylight light(at(degrees, 1));
    const Air air = air_of(1);
    const auto slant = static_cast<float>(1 / std::sin(degrees * pi / 180));
    const Spectrum through = (-(air.molecules * 8000 + air.ozone * 15'000) * slant).exp();
    const Eigen::Vector3f wanted = linear_srgb(solar_irradiance() * through);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(light.sun_irradiance()[c] / wanted[c], 1, 0.01);
    EXPECT_NEAR(light.to_sun().z(), std::sin(degrees * pi / 180), 1e-6);
  }
}

TEST(Daylight, RefusesASunUnderTheGroundAndNumbersOutOfRange) {
  EXPECT_THROW(Daylight(at(-1)), InputError);
  EXPECT_THROW(Daylight(at(91)), InputError);
  EXPECT_THROW(Daylight(at(30, 0.5)), InputError);
  EXPECT_THROW(Daylight(at(30, 11)), InputError);
  DaylightSettings settings = at(30);
  settings.sun_azimuth = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(Daylight{settings}, InputError);
  settings = at(30);
  settings.ground_albedo.x() = 1.5F;
  EXPECT_THROW(Daylight{settings}, InputError);
}

}  // namespace
}  // namespace tremula
