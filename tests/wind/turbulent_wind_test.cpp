#include "tremula/wind/turbulent_wind.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tremula/base/error.hpp"

namespace tremula {
namespace {

TEST(TurbulentWind, TakesTheCoherenceThatGoesWithItsSpectrum) {
  EXPECT_EQ(turbulent_wind({}, 0.2).coherence.kind, CoherenceKind::shinya_fournier);
  EXPECT_EQ(turbulent_wind({}, 0.2, SpectrumKind::iec_kaimal).coherence.kind, CoherenceKind::iec);
  EXPECT_EQ(turbulent_wind({}, 0.2, SpectrumKind::iec_kaimal, CoherenceKind::davenport).coherence.kind,
            CoherenceKind::davenport);
  EXPECT_EQ(turbulent_wind({.speed = 9}, 0.2).coherence.speed, 9);
}

TEST(TurbulentWind, RefusesAnIntensityThatIsNone) {
  EXPECT_THROW(turbulent_wind({}, -0.1), InputError);
  EXPECT_THROW(turbulent_wind({}, std::nan("")), InputError);
}

TEST(TurbulentWind, RefusesACovarianceThatItsSpectraDoNotAllow) {
  TurbulentWind wind = turbulent_wind({.speed = 10}, 0.2, SpectrumKind::iec_kaimal);
  const Vec3 deviation = spectrum_variance(wind.spectrum).cwiseSqrt();
  const double most = largest_covariance_uw(wind.spectrum, 10, 10);
  for (const double covariance : {-0.99 * most, 0.99 * most}) {
    wind.covariance_uw = covariance;
    EXPECT_NO_THROW(check_turbulent_wind(wind));
    EXPECT_NEAR(coherency_uw(wind), covariance / most, 1e-12);
  }
  for (const double covariance : {-1.01 * most, 1.01 * deviation[0] * deviation[2], std::nan("")}) {
    wind.covariance_uw = covariance;
    EXPECT_THROW(check_turbulent_wind(wind), InputError) << covariance;
  }
  wind.covariance_uw = -0.1;
  wind.amplitudes = Amplitudes::phases_only;
  EXPECT_THROW(check_turbulent_wind(wind), InputError);
  wind.amplitudes = Amplitudes::gaussian;
  wind.coherence.iec_for_u_only = true;
  EXPECT_THROW(check_turbulent_wind(wind), InputError);
  wind.coherence.iec_for_u_only = false;
  wind.mean.speed = 0;
  EXPECT_THROW(check_turbulent_wind(wind), InputError) << "no turbulence, no covariance";
}

TEST(SpectrumAt, StaysWithTheLowestHeightBelowIt) {
  const TurbulentWind wind = turbulent_wind({}, 0.2);
  EXPECT_EQ(spectrum_at(wind, 0.01, 0.3), spectrum_at(wind, 0.5, 0.3));
  EXPECT_NE(spectrum_at(wind, 0.6, 0.3), spectrum_at(wind, 0.5, 0.3));
}

TEST(Terrain, MakesAWindThatRisesWithHeightAndIsGustierTheRougherItIs) {
  double gustiest = 0;
  for (const Terrain& terrain : terrains()) {
    const MeanWind mean = mean_wind_over(terrain, 6);
    EXPECT_NEAR(mean_speed(mean, 10), 6, 1e-12) << terrain.name;
    for (double z = 0.6; z < 60; z += 0.5) {
      EXPECT_GE(mean_speed(mean, z + 0.5), mean_speed(mean, z)) << terrain.name << ", " << z;
    }
    EXPECT_GT(turbulence_intensity_of(mean), gustiest) << terrain.name;
    gustiest = turbulence_intensity_of(mean);
    EXPECT_EQ(&terrain_named(terrain.name), &terrain);
  }
  EXPECT_THROW(terrain_named("desert"), InputError);
}

TEST(Terrain, WithACanopyHasTheRoughnessThatGoesWithItsHeight) {
  for (const char* name : {"grass", "crops"}) {
    const Terrain& terrain = terrain_named(name);
    EXPECT_NEAR(terrain.roughness_length / terrain.canopy_height, 0.123, 0.002) << name;
    EXPECT_NEAR(terrain.displacement / terrain.canopy_height, 2.0 / 3, 0.01) << name;
  }
}

TEST(TurbulenceIntensity, OfTheLogLawGivesTheFrictionVelocityOfTheProfileBack) {
  const MeanWind mean = mean_wind_over(terrain_named("parkland"), 7);
  const SpectrumModel model =
      spectrum_model(SpectrumKind::simiu_scanlan, mean, turbulence_intensity_of(mean));
  EXPECT_NEAR(model.friction_velocity, log_law_friction_velocity(mean), 1e-14);
}

}  // namespace
}  // namespace tremula
