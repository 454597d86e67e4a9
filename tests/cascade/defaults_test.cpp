// The numbers that stand where nobody gives one. Whoever changes one of them changes everybody's result: it
// is meant to be done here, too, with the reason.
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include "tremula/dynamics/foliage.hpp"
#include "tremula/dynamics/motion_statistics.hpp"
#include "tremula/dynamics/shelter.hpp"
#include "tremula/geometry/grow.hpp"
#include "tremula/geometry/plants.hpp"
#include "tremula/geometry/turtle.hpp"
#include "tremula/pipeline.hpp"

#ifdef TREMULA_PROGRAM
#include <nlohmann/json.hpp>

#include "cli/program.hpp"
#endif

namespace tremula {
namespace {

TEST(Defaults, OfTheWoodAreGreenStems) {
  const StructureOptions options;
  // The mean of ForestGALES' birch, beech and oak (Hale et al. 2015).
  EXPECT_EQ(options.material.name, "green-wood");
  EXPECT_DOUBLE_EQ(options.material.youngs_modulus, (9.9e9 + 9.8e9 + 8.3e9) / 3);
  EXPECT_DOUBLE_EQ(options.material.density, (900.0 + 1158 + 1158) / 3);
  // Amid the ratios 0.05 … 0.1 of G_LR to E_L of the Wood Handbook.
  EXPECT_DOUBLE_EQ(options.material.shear_modulus, 0.075 * options.material.youngs_modulus);
  EXPECT_EQ(options.section, Section::exact);
  EXPECT_TRUE(options.rotatory_inertia);
  EXPECT_EQ(options.root.translation, std::numeric_limits<double>::infinity());  // clamped, S section 3
  EXPECT_EQ(options.root.rotation, std::numeric_limits<double>::infinity());
  EXPECT_EQ(options.added_mass_density, 0);  // air
}

TEST(Defaults, OfGrownPlantsAreTheirs) {
  // Broadleaves: some 80 g/m^2 dry, a third of what they weigh fresh.
  EXPECT_EQ(TurtleOptions{}.leaf_mass_per_area, 0.25);
  EXPECT_EQ(PipeModel{}.exponent, 2.3);  // within 1.8 … 2.5 that trees have; 2 is Leonardo's
}

TEST(Defaults, OfTheSearchForModes) {
  EXPECT_EQ(ModeOptions{}.count, 40);
  EXPECT_EQ(BakeOptions{}.modes.count, 20);  // a choice: static shapes stand for the others
}

// What Weather{}.wind is made from; it shows only what it does.
TurbulentWind default_wind() { return turbulent_wind({}, 0.2); }

TEST(Defaults, OfTheWindAreGrassAndABreeze) {
  const MeanWind mean;
  EXPECT_EQ(mean.speed, 6);                // Beaufort 4, leaves and twigs move: a choice
  EXPECT_EQ(mean.reference_height, 10);    // where weather stations measure (WMO)
  EXPECT_EQ(mean.roughness_length, 0.03);  // "open" of Davenport's classes (Wieringa 1992)
  EXPECT_EQ(mean.profile, ProfileKind::logarithmic);
  EXPECT_EQ(mean.power_exponent, 0.2);  // IEC 61400-1
  EXPECT_EQ(mean.displacement, 0);
  EXPECT_EQ(mean.canopy_height, 0);

  const TurbulentWind wind = default_wind();
  // 0.2 at the reference height: sigma_u = 1.2 m/s, of which Simiu & Scanlan's spectrum makes u* =
  // sigma_u/sqrt(6).
  EXPECT_EQ(wind.spectrum.kind, SpectrumKind::simiu_scanlan);
  EXPECT_NEAR(wind.spectrum.friction_velocity, 1.2 / std::sqrt(6.0), 1e-12);
  EXPECT_EQ(wind.coherence.kind, CoherenceKind::shinya_fournier);
  EXPECT_EQ(wind.coherence.decay_y, (std::array<double, 3>{3.6, 2.4, 8}));  // F section 3.2
  EXPECT_EQ(wind.coherence.decay_z, (std::array<double, 3>{6, 4, 8}));      // F section 3.2; w: as across
  EXPECT_EQ(wind.amplitudes, Amplitudes::gaussian);
  EXPECT_EQ(wind.seed, 1U);

  EXPECT_EQ(StamWind{}.turbulence_intensity, 0.2);
  EXPECT_EQ(StamWind{}.correlation_time, 1);    // [s] a choice, S prints none
  EXPECT_EQ(StamWind{}.correlation_length, 4);  // [m] likewise, the size of a crown
}

TEST(Defaults, OfTheWeatherAreThatWindToTheLastBit) {
  const Weather weather;
  const Wind wanted = default_wind();
  EXPECT_EQ(weather.wind.reference.speed, 6);
  EXPECT_EQ(weather.wind.reference.height, 10);
  EXPECT_EQ(weather.wind.reference.heading, wanted.reference.heading);
  EXPECT_EQ(weather.wind.reference.intensity, wanted.reference.intensity);
  EXPECT_NEAR(weather.wind.reference.intensity.value(), 0.2, 1e-12);
  for (const double height : {0.5, 3.0, 10.0, 25.0}) {
    for (const double frequency : {0.01, 0.3, 4.0})
      EXPECT_EQ(weather.wind.spectrum(height, frequency), wanted.spectrum(height, frequency));
  }
  Eigen::Matrix3Xd points(3, 3);
  points << 0, 1, 0.5, 0, 0.4, 3, 2, 9, 5;
  const PointWind found = wind_at_points(weather.wind, weather.loop, points),
                  expected = wind_at_points(wanted, weather.loop, points);
  EXPECT_EQ(found.mean, expected.mean);
  for (int bin = 0; bin < weather.loop.bin_count(); ++bin) {
    for (const int draw : {0, 1}) EXPECT_EQ(found.velocity(bin, draw), expected.velocity(bin, draw)) << bin;
  }
}

TEST(Defaults, OfTheLoadsAreAirOnCylindersAndFoldedLeaves) {
  const LoadOptions loads = Weather{}.loads;
  EXPECT_EQ(loads.model, LoadModel::stochastic);
  EXPECT_EQ(loads.fluid_density, 1.2);            // air (S section 2)
  EXPECT_EQ(loads.branch_drag_coefficient, 1.2);  // a cylinder across the flow below the drag crisis
  EXPECT_EQ(loads.leaf_drag_coefficient, 0.25);   // a choice: leaves that fold, plates have some 1.2
  EXPECT_EQ(loads.leaf_lift_coefficient, 0);      // leaves that flutter have none on the average
  EXPECT_EQ(Weather{}.lean.rotations, Rotations::large);
}

TEST(Defaults, OfACrownAreLeavesThatFoldInEachOthersShelter) {
  EXPECT_EQ(Weather{}.loads.foliage.vogel_exponent,
            -1);                             // of a cherry tree's leaves (de Langre, Tadrist et al. 2015)
  EXPECT_EQ(FoliageLaw{}.folding_speed, 3);  // [m/s] a choice: docs/theory/dynamics.md
  const ShelterOptions shelter = Weather{}.lean.shelter;
  EXPECT_TRUE(shelter.on);
  EXPECT_TRUE(shelter.induction);
  EXPECT_EQ(shelter.cell, 0.5);  // [m] a choice: 0.25 and 1 change the load by a tenth at most
}

TEST(Defaults, OfTheResponse) {
  const Weather weather;
  EXPECT_EQ(weather.damping.ratio, 0.05);  // wood and its joints without the air: a choice amid 0.01 … 0.1
  EXPECT_FALSE(weather.damping.mass_proportional);
  EXPECT_FALSE(weather.damping.stiffness_proportional);
  EXPECT_TRUE(weather.damping.aerodynamic);
  EXPECT_EQ(weather.transfer, Transfer::bin_averaged);
  EXPECT_TRUE(weather.static_correction);
  EXPECT_EQ(weather.loop.period, 20);
  EXPECT_EQ(weather.loop.sample_count, 600);  // 30 a second
}

#ifdef TREMULA_PROGRAM
// What the program takes where no flag is given is what the library takes.
TEST(Defaults, AreWhatTheReportOfTheProgramShows) {
  const test::TemporaryFolder folder;
  const test::Outcome outcome = test::run(folder, "animate sapling --report report.json");
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  const auto report = nlohmann::json::parse(test::contents(folder / "report.json"));

  const StructureOptions structure;
  EXPECT_EQ(report["structure"]["material"], structure.material.name);
  EXPECT_EQ(report["structure"]["youngs_modulus_pa"], structure.material.youngs_modulus);
  EXPECT_EQ(report["structure"]["shear_modulus_pa"], structure.material.shear_modulus);
  EXPECT_EQ(report["structure"]["density_kg_m3"], structure.material.density);
  EXPECT_EQ(report["structure"]["section"], "exact");
  EXPECT_EQ(report["structure"]["rotatory_inertia"], structure.rotatory_inertia);
  EXPECT_EQ(report["structure"]["added_mass_density_kg_m3"], structure.added_mass_density);
  EXPECT_EQ(report["structure"]["gravity_m_s2"], structure.gravity);
  EXPECT_GT(report["structure"]["load_margin"], 1);
  EXPECT_TRUE(report["structure"]["root_rotation_stiffness_n_m_rad"].is_null());
  EXPECT_TRUE(report["structure"]["root_translation_stiffness_n_m"].is_null());

  const Weather weather;
  const TurbulentWind wind = default_wind();
  const auto& settings = report["settings"];
  EXPECT_EQ(settings["wind"], "turbulent");
  EXPECT_EQ(settings["wind_settings"]["spectrum"], "simiu-scanlan");
  EXPECT_EQ(settings["wind_settings"]["coherence"], "shinya-fournier");
  EXPECT_EQ(settings["wind_settings"]["profile"], "log");
  EXPECT_EQ(settings["wind_settings"]["wind_speed_m_s"], wind.mean.speed);
  EXPECT_EQ(settings["wind_settings"]["reference_height_m"], wind.mean.reference_height);
  EXPECT_EQ(settings["wind_settings"]["roughness_length_m"], wind.mean.roughness_length);
  EXPECT_NEAR(settings["wind_settings"]["turbulence_intensity"].get<double>(), 0.2, 1e-12);
  EXPECT_EQ(settings["loads"], "stochastic");
  EXPECT_EQ(settings["leaf_drag_coefficient"], weather.loads.leaf_drag_coefficient);
  EXPECT_EQ(settings["leaf_lift_coefficient"], weather.loads.leaf_lift_coefficient);
  EXPECT_EQ(settings["damping_ratio"], weather.damping.ratio);
  EXPECT_EQ(settings["aerodynamic_damping"], weather.damping.aerodynamic);
  EXPECT_EQ(settings["transfer"], "bin-averaged");
  EXPECT_EQ(settings["period_s"], weather.loop.period);
  EXPECT_EQ(settings["frames_per_second"], 30);
  EXPECT_EQ(settings["samples"], weather.loop.sample_count);
  EXPECT_EQ(settings["seed"], wind.seed);
  EXPECT_EQ(report["mode_count"], BakeOptions{}.modes.count);
}

// The library's own defaults and the program's give one motion, so that none of those that the report does
// not show differs either.
TEST(Defaults, GiveTheSameFrequenciesAndLeanFromTheLibraryAndFromTheProgram) {
  const test::TemporaryFolder folder;
  const test::Outcome outcome = test::run(folder, "animate sapling --report report.json");
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  const auto report = nlohmann::json::parse(test::contents(folder / "report.json"));
  const Subject subject = bake(grow(parse_lsystem(find_preset("sapling").text, "sapling")).skeleton, {});
  const Motion motion = set_in_motion(subject, {});
  const MotionStatistics statistics = motion_statistics(subject.structure, motion);
  for (int r = 0; r < subject.modes.count(); ++r) {
    EXPECT_EQ(report["frequencies_hz"][static_cast<std::size_t>(r)], subject.modes.frequency[r]);
  }
  EXPECT_EQ(report["motion"]["largest_lean_m"], statistics.largest_lean);
  for (int r = 0; r < subject.modes.count(); ++r) {
    const auto& damping = report["damping"][static_cast<std::size_t>(r)];
    EXPECT_NEAR(damping["of_structure"].get<double>(), 0.05, 1e-12);
    const double critical = 4 * std::numbers::pi * motion.basis.frequency[r + 1];
    EXPECT_NEAR(damping["of_medium"].get<double>(), motion.damping.medium[r] / critical, 1e-9);
    EXPECT_NEAR(damping["damping_ratio"].get<double>(),
                damping["of_structure"].get<double>() + damping["of_medium"].get<double>(), 1e-12);
  }
}
#endif

}  // namespace
}  // namespace tremula
