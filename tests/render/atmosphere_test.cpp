#include "tremula/render/atmosphere.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <random>

namespace tremula {
namespace {

constexpr double pi = std::numbers::pi;

template <class Function>
double over_the_sphere(const Function& of_cosine) {
  constexpr int steps = 20000;
  double sum = 0;
  for (int i = 0; i < steps; ++i) sum += of_cosine(-1 + 2 * (i + 0.5) / steps) * 2 * pi * 2 / steps;
  return sum;
}

TEST(Phase, OfMoleculesAndAerosolIntegratesToOne) {
  EXPECT_NEAR(over_the_sphere([](double c) { return molecular_phase(static_cast<float>(c)); }), 1, 1e-5);
  EXPECT_NEAR(over_the_sphere([](double c) { return aerosol_phase(static_cast<float>(c)); }), 1, 1e-4);
}

TEST(Phase, OfMoleculesIsEvenAndThatOfAerosolGoesForward) {
  EXPECT_EQ(molecular_phase(0.3F), molecular_phase(-0.3F));
  EXPECT_GT(aerosol_phase(1), 50 * aerosol_phase(-1));
}

TEST(LinearSrgb, OfTheSunAboveTheAirIsAlmostWhiteAndAbout130000Lux) {
  const Eigen::Vector3f sun = linear_srgb(solar_irradiance());
  EXPECT_NEAR(683 * luminance(sun), 133'000,
              4000);  // CIE 1931: 133.1 klx at the mean distance (Darula et al. 2005)
  EXPECT_NEAR(sun.x() / sun.y(), 1, 0.12);
  EXPECT_NEAR(sun.z() / sun.y(), 1, 0.12);
}

TEST(LinearSrgb, OfColoursItDoesNotHaveKeepsTheirLuminance) {
  for (int b = 0; b < band_count; ++b) {
    Spectrum line = Spectrum::Zero();
    line[b] = 1;
    const Eigen::Vector3f color = linear_srgb(line);
    EXPECT_GE(color.minCoeff(), 0);
    // In front of enough white it has a colour of sRGB.
    const Spectrum white = Spectrum::Constant(10);
    const float before = luminance(linear_srgb(white));
    EXPECT_NEAR(luminance(linear_srgb(white + line)) - before, luminance(color), 1e-5F * before);
  }
}

TEST(SolarIrradiance, IsThatOfABlackBodyOf5900KelvinWithinAnEighth) {
  const Spectrum sun = solar_irradiance();
  for (int b = 2; b < band_count; ++b) {  // below 420 nm, iron and calcium take much
    const double w = band_centre(b) * 1e-9;
    const double planck = 2 * 6.62607e-34 * 2.99792e8 * 2.99792e8 / std::pow(w, 5) /
                          (std::exp(6.62607e-34 * 2.99792e8 / (w * 1.380649e-23 * 5900)) - 1);
    const double irradiance = planck * 1e-9 * pi * std::pow(6.957e8 / 1.496e11, 2);
    EXPECT_NEAR(sun[b] / irradiance, 1, 0.125) << band_centre(b);
  }
}

TEST(AirOf, MoleculesHasTheCoefficientsOfBrunetonAndNeyretAtTheirThreeWavelengths) {
  const Air air = air_of(1);
  for (const auto& [wavelength, coefficient] :
       {std::pair{680.0, 5.8e-6}, {550.0, 13.5e-6}, {440.0, 33.1e-6}}) {
    int nearest = 0;
    for (int b = 0; b < band_count; ++b)
      if (std::abs(band_centre(b) - wavelength) < std::abs(band_centre(nearest) - wavelength)) nearest = b;
    const double there = coefficient * std::pow(band_centre(nearest) / wavelength, -4);
    EXPECT_NEAR(air.molecules[nearest] / there, 1, 0.01);
  }
  EXPECT_TRUE((air.aerosol == 0).all());
}

TEST(AirOf, TurbidityIsTheRatioOfThicknessesAt550Nanometres) {
  for (const double turbidity : {1.5, 3.0, 8.0}) {
    const Air air = air_of(turbidity);
    const Column up = column_above(0, 0);
    for (int b = 7; b <= 8; ++b) {  // 550 nm lies where these meet
      const double ratio = 1 + air.aerosol[b] * up.y() / (air.molecules[b] * up.x());
      EXPECT_NEAR(ratio, turbidity, 0.06 * (turbidity - 1));
    }
  }
}

TEST(ColumnAbove, StraightUpIsTheClosedFormOfItsProfiles) {
  for (const double height : {0.0, 500.0, 9000.0}) {
    const Column up = column_above(height, 0);
    const auto layer = [&](double scale) {
      return scale * (std::exp(-height / scale) - std::exp(-air_height / scale));
    };
    EXPECT_NEAR(up.x() / layer(8000), 1, 1e-3);
    EXPECT_NEAR(up.y() / layer(1200), 1, 3e-3);
    EXPECT_NEAR(up.z() / 15'000, 1, 3e-3);  // the tent's area: 300 Dobson units
  }
}

TEST(ColumnAbove, OfASlantIsThatOfAFlatEarthWhileTheSunIsHigh) {
  const Column up = column_above(0, 0);
  for (const double degrees : {20.0, 40.0, 60.0}) {
    const double angle = degrees * pi / 180;
    const Column slant = column_above(0, angle);
    EXPECT_NEAR(slant.x() * std::cos(angle) / up.x(), 1, 0.005);
    EXPECT_NEAR(slant.y() * std::cos(angle) / up.y(), 1, 0.005);
  }
}

// Chapman's function at 90 degrees: sqrt(pi r / 2 h), to the first order in h / r.
TEST(ColumnAbove, AlongTheHorizonIsChapmansFunction) {
  const Column level = column_above(0, pi / 2);
  for (const auto& [found, scale] : {std::pair{level.x(), 8000.0}, {level.y(), 1200.0}}) {
    const double chapman = std::sqrt(pi * earth_radius / (2 * scale)) * (1 + 3 * scale / (8 * earth_radius));
    EXPECT_NEAR(found / (scale * chapman), 1, 0.005);
  }
}

TEST(ColumnTable, IsWhatItTabulates) {
  const ColumnTable table;
  for (const double height : {0.0, 37.0, 1000.0, 7000.0, 21'000.0}) {
    for (const double share : {0.0, 0.3, 0.9, 0.97, 0.999}) {
      const double angle = horizon_angle(height) * share;
      const Column found = table(height, angle), wanted = column_above(height, angle);
      EXPECT_NEAR(found.x() / wanted.x(), 1, 0.01) << height << ' ' << share;
      // Aerosol matters where there is some; over 7 km there is a third of a per cent of it.
      EXPECT_NEAR((found.y() - wanted.y()) / (wanted.y() + 100), 0, 0.03) << height << ' ' << share;
      EXPECT_NEAR(found.z() / wanted.z(), 1, 0.02) << height << ' ' << share;
    }
  }
}

double sun_angle_of(double degrees_above) { return pi / 2 - degrees_above * pi / 180; }

// Beer and Lambert through layers of exponential density on a flat earth; the tent of ozone has its area.
TEST(SunTransmittance, IsTheClosedFormOfAFlatEarthWhileTheSunIsHigh) {
  for (const double turbidity : {1.0, 3.0, 6.0}) {
    const Air air = air_of(turbidity);
    for (const double degrees : {30.0, 60.0, 90.0}) {
      const Atmosphere atmosphere(air, sun_angle_of(degrees), Spectrum::Zero());
      const Spectrum found = atmosphere.sun_transmittance(0, sun_angle_of(degrees));
      const auto slant = static_cast<float>(1 / std::sin(degrees * pi / 180));
      const Spectrum wanted =
          (-(air.molecules * 8000 + air.aerosol * 1200 + air.ozone * 15'000) * slant).exp();
      EXPECT_LT(((found - wanted) / wanted).abs().maxCoeff(), 0.02F) << turbidity << ' ' << degrees;
    }
  }
}

TEST(SunTransmittance, GoesToNothingWhileTheDiscSets) {
  const Atmosphere atmosphere(air_of(1), sun_angle_of(0), Spectrum::Zero());
  const Spectrum whole = atmosphere.sun_transmittance(0, sun_angle_of(0.3));
  const Spectrum half = atmosphere.sun_transmittance(0, sun_angle_of(0));
  EXPECT_TRUE((half < whole).all());
  EXPECT_TRUE((half > 0).all());
  EXPECT_TRUE((atmosphere.sun_transmittance(0, sun_angle_of(-0.3)) == 0).all());
}

// Another way to the light scattered once: in double precision, the depths to the eye and to the sun each
// summed anew by even steps, no table.
std::array<double, band_count> single_scattering(const Air& air, double height, const Vec3& way,
                                                 const Vec3& to_sun) {
  const Vec3 eye(0, 0, earth_radius + height);
  const auto distance = [](const Vec3& from, const Vec3& direction) {
    const double b = from.dot(direction);
    const double top = earth_radius + air_height;
    const double ground = b * b - from.squaredNorm() + earth_radius * earth_radius;
    if (b < 0 && ground > 0) return std::pair{-b - std::sqrt(ground), true};
    return std::pair{-b + std::sqrt(b * b - from.squaredNorm() + top * top), false};
  };
  const auto depth = [&](const Vec3& from, const Vec3& direction, double length, int steps) {
    Column sum = Column::Zero();
    for (int i = 0; i < steps; ++i)
      sum += density_at((from + direction * (length * (i + 0.5) / steps)).norm() - earth_radius) *
             (length / steps);
    return sum;
  };
  const double length = distance(eye, way).first;
  constexpr int steps = 1500;
  Column before = Column::Zero();
  std::array<double, band_count> light{};
  const double cosine = way.dot(to_sun);
  for (int i = 0; i < steps; ++i) {
    const Vec3 point = eye + way * (length * (i + 0.5) / steps);
    const Column density = density_at(point.norm() - earth_radius);
    const auto [far, hits] = distance(point, to_sun);
    if (!hits) {
      const Column path = before + density * (length / steps / 2) + depth(point, to_sun, far, 400);
      for (int b = 0; b < band_count; ++b) {
        const double optical =
            air.molecules[b] * path.x() + air.aerosol[b] * path.y() + air.ozone[b] * path.z();
        const double scattering =
            air.molecules[b] * density.x() * 3 / (16 * pi) * (1 + cosine * cosine) +
            air.aerosol[b] * 0.9 * density.y() * aerosol_phase(static_cast<float>(cosine));
        light[static_cast<std::size_t>(b)] += std::exp(-optical) * scattering * length / steps;
      }
    }
    before += density * (length / steps);
  }
  return light;
}

TEST(Atmosphere, SinglyScatteredLightIsThatOfABruteForceIntegration) {
  for (const double turbidity : {1.0, 3.0}) {
    const Air air = air_of(turbidity);
    for (const double sun : {3.0, 35.0, 90.0}) {
      const Atmosphere atmosphere(air, sun_angle_of(sun), Spectrum::Zero());
      const Vec3 to_sun(std::cos(sun * pi / 180), 0, std::sin(sun * pi / 180));
      for (const double elevation : {0.5, 5.0, 40.0, 90.0}) {
        for (const double azimuth : {0.2, 2.0}) {
          const double e = elevation * pi / 180;
          const Vec3 way(std::cos(e) * std::cos(azimuth), std::cos(e) * std::sin(azimuth), std::sin(e));
          const SkyLight found = atmosphere.along(10, e, azimuth);
          const auto wanted = single_scattering(air, 10, way, to_sun);
          double difference = 0, sum = 0;
          for (int b = 0; b < band_count; ++b) {
            difference += std::abs(found.single[b] - wanted[static_cast<std::size_t>(b)]);
            sum += wanted[static_cast<std::size_t>(b)];
          }
          EXPECT_LT(difference / sum, 0.015) << turbidity << ' ' << sun << ' ' << elevation << ' ' << azimuth;
        }
      }
    }
  }
}

// Light followed one way at a time (Woodcock tracking) through flat layers of the same air, with all
// scatterings and the ground's. Irradiance of the ground by the sky, per irradiance above the air on a plane
// that faces the sun.
double traced_sky_irradiance(const Air& air, int band, double sun_elevation, double albedo) {
  std::mt19937 random(3);
  const auto uniform = [&] { return (random() + 0.5) * 0x1p-32; };
  const auto around = [&](const Vec3& way, double cosine) -> Vec3 {
    const Vec3 side = way.unitOrthogonal(), other = way.cross(side);
    const double turn = 2 * pi * uniform(), sine = std::sqrt(1 - cosine * cosine);
    return cosine * way + sine * (std::cos(turn) * side + std::sin(turn) * other);
  };
  const auto scattered = [&](const Vec3& way, bool molecule) {
    for (;;) {
      const double cosine = 2 * uniform() - 1;
      const double most = molecule ? molecular_phase(1) : aerosol_phase(1);
      const double phase =
          molecule ? molecular_phase(static_cast<float>(cosine)) : aerosol_phase(static_cast<float>(cosine));
      if (uniform() * most < phase) return around(way, cosine);
    }
  };
  const double densest = air.molecules[band] + air.aerosol[band] + air.ozone[band];
  double sum = 0;
  constexpr int count = 30'000;
  for (int i = 0; i < count; ++i) {
    Vec3 way(std::cos(sun_elevation), 0, -std::sin(sun_elevation));
    double height = air_height, weight = 1;
    bool of_the_sky = false;
    while (weight > 1e-3) {
      height -= std::log(uniform()) / densest * way.z();
      if (height > air_height) break;
      if (height <= 0) {
        if (of_the_sky) sum += weight;
        weight *= albedo;
        height = 0;
        of_the_sky = true;
        way = around(Vec3::UnitZ(), std::sqrt(uniform()));
        continue;
      }
      const Column density = density_at(height);
      const double molecules = air.molecules[band] * density.x(), aerosol = air.aerosol[band] * density.y();
      double event = uniform() * densest - molecules;
      if (event < 0) {
        way = scattered(way, true);
        of_the_sky = true;
      } else if ((event -= aerosol) < 0) {
        weight *= 0.9;
        way = scattered(way, false);
        of_the_sky = true;
      } else if (event - air.ozone[band] * density.z() < 0) {
        break;
      }
    }
  }
  return sum / count * std::sin(sun_elevation);
}

TEST(Atmosphere, AllItsScatteringsMakeTheSkyOfLightTracedOneWayAtATimeToASixth) {
  for (const double turbidity : {1.0, 3.0}) {
    const Air air = air_of(turbidity);
    for (const double degrees : {20.0, 60.0}) {
      const Atmosphere atmosphere(air, sun_angle_of(degrees), Spectrum::Constant(0.3F));
      Spectrum found = Spectrum::Zero();
      constexpr int rings = 12, spokes = 24;
      for (int ring = 0; ring < rings; ++ring) {
        for (int spoke = 0; spoke < spokes; ++spoke) {  // of one half
          const SkyLight light =
              atmosphere.along(0, std::asin(std::sqrt((ring + 0.5) / rings)), pi * (spoke + 0.5) / spokes);
          found += (light.single + light.multiple) * static_cast<float>(pi / (rings * spokes));
        }
      }
      for (const int band : {2, 7, 13}) {  // blue, green, red
        const double wanted = traced_sky_irradiance(air, band, degrees * pi / 180, 0.3);
        EXPECT_NEAR(found[band] / wanted, 1, 1.0 / 6) << turbidity << ' ' << degrees << ' ' << band;
      }
    }
  }
}

TEST(Atmosphere, OverAWhiteGroundIsBrighterThanOverABlackOne) {
  const Atmosphere black(air_of(3), sun_angle_of(40), Spectrum::Zero());
  const Atmosphere white(air_of(3), sun_angle_of(40), Spectrum::Ones());
  for (const double elevation : {0.1, 0.8, 1.5}) {
    const SkyLight a = black.along(10, elevation, 1), b = white.along(10, elevation, 1);
    EXPECT_TRUE((a.single == b.single).all());
    EXPECT_TRUE((a.multiple < b.multiple).all());
    EXPECT_TRUE((a.multiple > 0).all());
  }
}

}  // namespace
}  // namespace tremula
