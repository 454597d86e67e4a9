#include "tremula/dynamics/grass_response.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

#include "tremula/base/error.hpp"
#include "tremula/wind/point_wind.hpp"

namespace tremula {
namespace {

GustStatistics steady(double speed) { return {.mean = {speed, 0, 0}}; }

// Blades of a meadow without weight to speak of, so that closed forms hold.
GrassSpecies light_grass() {
  GrassSpecies species = grass_species_named("lawn");
  species.canopy_decay = 0;
  species.mean_share = species.gust_share = 1;
  species.kinds[0].length_spread = 0;
  species.kinds[0].frequency = 50;
  return species;
}

TEST(BladeResponse, OfALightUprightBladeIsThatOfACantileverUnderUniformDrag) {
  const GrassSpecies species = light_grass();
  const BladeKind& kind = species.kinds[0];
  const double height = 0.05, speed = 3, density = 1.2;
  const BladeResponse blade = blade_response(species, 0, 1, height, steady(speed), density);
  // omega = 3.516 sqrt(EI/m)/L^2; tip angle p L^3/(6 EI), p = 1/2 rho C_D w U^2.
  const double omega = 2 * std::numbers::pi * kind.frequency;
  const double stiffness = kind.mass * std::pow(height, 4) * std::pow(omega / 3.5160, 2);
  const double load = 0.5 * density * kind.drag_coefficient * kind.width * speed * speed;
  EXPECT_NEAR(blade.rod.bending_stiffness, stiffness, 0.01 * stiffness);
  EXPECT_NEAR(blade.lean, load * std::pow(height, 3) / (6 * stiffness), 0.01 * blade.lean);
  // Drag goes with U^2 along the wind, and turns with it across.
  EXPECT_NEAR(blade.along, 2 * blade.lean / speed, 1e-9);
  EXPECT_NEAR(blade.across, blade.lean / speed, 1e-9);
  // On a blade that moves: rho C_D w U/m along, half of it across.
  const double rate = density * kind.drag_coefficient * kind.width * speed / kind.mass;
  EXPECT_NEAR(blade.damping_along, kind.damping_ratio + rate / (2 * omega), 1e-3);
  EXPECT_NEAR(blade.damping_across, kind.damping_ratio + rate / (4 * omega), 1e-3);
}

TEST(BladeResponse, HasTheFrequenciesOfTheSpeciesAndLongerBladesLowerOnes) {
  for (const GrassSpecies& species : grass_species()) {
    for (std::size_t k = 0; k < species.kinds.size(); ++k) {
      const BladeKind& kind = species.kinds[k];
      if (kind.frequency == 0) continue;
      double before = 1e9;
      for (int number = 0; number < frequency_classes; ++number) {
        const BladeResponse blade =
            blade_response(species, static_cast<int>(k), number, species.height, steady(2));
        EXPECT_NEAR(first_frequency(blade.rod), blade.frequency, 1e-6 * blade.frequency);
        EXPECT_LT(blade.frequency, before);
        if (number == 1) {
          EXPECT_NEAR(blade.frequency, kind.frequency, 1e-12);
        }
        before = blade.frequency;
      }
    }
  }
}

TEST(BladeResponse, OfWheatHasAStiffnessThatStrawWasMeasuredToHave) {
  // EI of a green or dry straw: 0.01 to 0.05 N m^2 (O'Dogherty et al. 1995).
  const BladeResponse stem = blade_response(grass_species_named("wheat"), 0, 1, 0.75, steady(2));
  EXPECT_GT(stem.rod.bending_stiffness, 0.01);
  EXPECT_LT(stem.rod.bending_stiffness, 0.06);
}

TravellingField gusts_over(double width, int samples = 512) {
  const Wind wind(turbulent_wind({.speed = 5, .heading = 30}, 0.3));
  const TimeAxis loop{20, samples};
  std::vector<Vec3> points = {Vec3(-width, -width, 0), Vec3(width, width, 0)};
  return gust_field(wind, loop, plane_across(points, 30, 0.5, {0.5}));
}

TEST(SwayInTime, OfABladeIsTheResponseFieldAtItsFoot) {
  const TravellingField gusts = gusts_over(3);
  const GrassSpecies& species = grass_species_named("meadow");
  const BladeResponse blade = blade_response(species, 0, 1, 0.5, statistics_at(gusts, 0.5));
  const TravellingField field = respond(gusts, field_response(blade));
  for (const Vec3& place : {Vec3(0, 0, 0.5), Vec3(1.7, -2.2, 0.5)}) {
    const Eigen::Matrix2Xd in_time = sway_in_time(blade, gusts, place);
    double off = 0, size = 0;
    for (int p = 0; p < gusts.loop.sample_count; ++p) {
      const Eigen::Vector3d looked_up =
          local_value_at(field, place, gusts.loop.period * p / gusts.loop.sample_count).cast<double>();
      off += (looked_up.head<2>() - in_time.col(p)).squaredNorm();
      size += in_time.col(p).squaredNorm();
    }
    EXPECT_LT(std::sqrt(off / size), 0.03);
  }
}

TEST(SwayInTime, HasTheSpectrumOfTheResponseFieldWithinFivePercent) {
  const TravellingField gusts = gusts_over(10);
  const BladeResponse blade =
      blade_response(grass_species_named("wheat"), 0, 1, 0.75, statistics_at(gusts, 0.75));
  const TravellingField field = respond(gusts, field_response(blade));
  const int samples = gusts.loop.sample_count;
  // Power in octaves, over blades at 12 feet; up to an eighth of the rate of samples, between which the force
  // in time is straight.
  Eigen::ArrayXd in_time = Eigen::ArrayXd::Zero(6), looked_up = in_time;
  for (int i = 0; i < 12; ++i) {
    const Vec3 place(1.3 * i - 7, 0.9 * i - 5, 0.75);
    const Eigen::Matrix2Xd sway = sway_in_time(blade, gusts, place);
    for (int octave = 0; octave < 6; ++octave) {
      for (int bin = 1 << octave; bin < 2 << octave; ++bin) {
        std::complex<double> a = 0, b = 0;
        for (int p = 0; p < samples; ++p) {
          const auto turn = std::polar(1.0, -2 * std::numbers::pi * bin * p / samples);
          a += sway(0, p) * turn;
          b += static_cast<double>(local_value_at(field, place, gusts.loop.period * p / samples).x()) * turn;
        }
        in_time[octave] += std::norm(a);
        looked_up[octave] += std::norm(b);
      }
    }
  }
  for (int octave = 0; octave < 6; ++octave)
    EXPECT_NEAR(looked_up[octave] / in_time[octave], 1, 0.05) << "octave " << octave;
}

TEST(InAxesOfBlade, AreTheProjectionsOfShinyaAndFournier) {
  const Eigen::Vector2d force(0.3, -0.8);
  const double theta = 1.1;
  const Eigen::Vector2d of_blade = in_axes_of_blade(theta, force);
  EXPECT_NEAR(of_blade[0], force.x() * std::cos(theta) + force.y() * std::sin(theta), 1e-15);
  EXPECT_NEAR(of_blade[1], -force.x() * std::sin(theta) + force.y() * std::cos(theta), 1e-15);
}

TEST(BladeResponse, RefusesStiffKindsAndNumbersThatAreNone) {
  const GrassSpecies& wheat = grass_species_named("wheat");
  EXPECT_THROW(blade_response(wheat, 1, 0, 0.7, steady(1)), InputError);
  EXPECT_THROW(blade_response(wheat, 3, 0, 0.7, steady(1)), InputError);
  EXPECT_THROW(blade_response(wheat, 0, 3, 0.7, steady(1)), InputError);
  EXPECT_THROW(blade_response(wheat, 0, 0, 0, steady(1)), InputError);
  EXPECT_THROW(blade_response(wheat, 0, 0, 0.7, steady(NAN)), InputError);
}

}  // namespace
}  // namespace tremula
