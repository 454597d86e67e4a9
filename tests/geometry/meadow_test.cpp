#include "tremula/geometry/meadow.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <set>
#include <string>
#include <utility>

#include "complaint.hpp"
#include "tremula/base/error.hpp"

namespace tremula {
namespace {

BladeKind thrown(double lean, double droop) {
  BladeKind kind;
  kind.lean = {lean, lean};
  kind.droop = {droop, droop};
  return kind;
}

TEST(Trajectory, IsThePathOfAParticleThatFalls) {
  // From the foot after a time t [v0/g]: (sin phi t, cos phi t - t^2/2), of length droop [v0^2/g].
  const double lean = 0.7, droop = 1.6;
  constexpr int pieces = 400;
  const Eigen::Matrix3Xd path = trajectory(thrown(lean, droop), 3, pieces);
  Vec3 place = Vec3::Zero();
  for (int i = 0; i < pieces; ++i) {
    place += droop / pieces * path.col(i);
    const double t = place.x() / std::sin(lean);
    EXPECT_NEAR(place.z(), std::cos(lean) * t - t * t / 2, 1e-5);
    EXPECT_EQ(place.y(), 0);
  }
}

TEST(Trajectory, LeavesItsFootAtItsLeanAndIsStraightWithoutDroop) {
  const Eigen::Matrix3Xd fine = trajectory(thrown(0.5, 1), 0, 1000);
  EXPECT_NEAR(std::atan2(fine(0, 0), fine(2, 0)), 0.5, 1e-3);
  const Eigen::Matrix3Xd straight = trajectory(thrown(0.5, 0), 0, 10);
  for (int i = 0; i < 10; ++i) EXPECT_NEAR(std::atan2(straight(0, i), straight(2, i)), 0.5, 1e-12);
}

TEST(Trajectory, GoesUpAndDownWhereTheParticleLeavesUpright) {
  const Eigen::Matrix3Xd path = trajectory(thrown(0, 2), 0, 8);
  EXPECT_NEAR(path(2, 0), 1, 1e-12);
  EXPECT_NEAR(path(2, 7), -1, 1e-12);
}

using Place = std::array<float, 4>;
std::set<Place> places_of(const Meadow& meadow) {
  std::set<Place> places;
  for (std::size_t i = 0; i < meadow.size(); ++i)
    places.insert({meadow.x[i], meadow.y[i], meadow.length[i], meadow.azimuth[i]});
  return places;
}

TEST(Sow, OfMoreGroundLeavesWhatIsThereAsItIs) {
  const GrassSpecies& species = grass_species_named("wheat");
  const std::set<Place> small = places_of(sow(species, {.low = {-1, -1}, .high = {1.3, 1}})),
                        large = places_of(sow(species, {.low = {-3, -2}, .high = {2, 4}}));
  EXPECT_GT(large.size(), 2 * small.size());
  for (const Place& place : small) EXPECT_TRUE(large.contains(place));
}

TEST(Sow, HasAsManyPlantsAsItsDensitySays) {
  for (const GrassSpecies& species : grass_species()) {
    const Meadow meadow = sow(species, {.low = {-5, -3}, .high = {5, 3}, .density = 200});
    std::set<std::pair<float, float>> plants;
    for (std::size_t i = 0; i < meadow.size(); ++i) plants.insert({meadow.x[i], meadow.y[i]});
    EXPECT_NEAR(static_cast<double>(plants.size()), 60 * 200, 4 * std::sqrt(60 * 200)) << species.name;
  }
}

TEST(Sow, KeepsToItsMasks) {
  SowOptions options{.low = {-2, -2}, .high = {2, 2}};
  options.density_at = [](const Eigen::Vector2d& p) { return p.norm() < 1 ? 0.0 : p.x() > 0 ? 1.0 : 0.25; };
  options.height_at = [](const Eigen::Vector2d& p) { return p.y() > 0 ? 1.0 : 0.5; };
  GrassSpecies lawn = grass_species_named("lawn");
  lawn.tufts = 0;
  const Meadow meadow = sow(lawn, options);
  double left = 0, right = 0, low = 0, high = 0, lows = 0, highs = 0;
  for (std::size_t i = 0; i < meadow.size(); ++i) {
    EXPECT_GE(std::hypot(meadow.x[i], meadow.y[i]), 1 - 1e-6);
    ++(meadow.x[i] > 0 ? right : left);
    (meadow.y[i] > 0 ? high : low) += static_cast<double>(meadow.length[i]);
    ++(meadow.y[i] > 0 ? highs : lows);
  }
  EXPECT_NEAR(left / right, 0.25, 0.01);
  EXPECT_NEAR(low / lows / (high / highs), 0.5, 0.01);
}

TEST(Sow, ThinsBladesWithTheDistanceFromTheEyesAndMakesThemWider) {
  SowOptions options{.low = {-30, -1}, .high = {30, 1}};
  options.thinning = Thinning{.eyes = {{-30, 0}, {30, 0}}, .full_until = 5, .widest = 3};
  const GrassSpecies& species = grass_species_named("lawn");
  const Meadow meadow = sow(species, options);
  double near = 0, far = 0, wide_near = 0, wide_far = 0;
  for (std::size_t i = 0; i < meadow.size(); ++i) {
    const double x = std::abs(static_cast<double>(meadow.x[i])), width = static_cast<double>(meadow.width[i]);
    if (x > 26) ++near, wide_near += width;
    if (x < 2) ++far, wide_far += width;
  }
  EXPECT_NEAR(far / (0.5 * near), 5.0 / 29, 0.01);  // 4 m of the field against 8
  EXPECT_NEAR(wide_far / far / (wide_near / near), 3, 0.05);
}

TEST(Sow, PutsLeavesAndEarsBehindTheStemThatCarriesThem) {
  for (const char* name : {"meadow", "wheat", "rice", "reed"}) {
    const Meadow meadow = sow(grass_species_named(name), {});
    bool stem = false;
    std::size_t carried = 0;
    for (std::size_t i = 0; i < meadow.size(); ++i) {
      const bool on_ground = meadow.attached[i] < 0;
      if (on_ground) stem = meadow.species.kinds[meadow.kind[i]].form == BladeForm::stem;
      EXPECT_TRUE(on_ground || stem);
      carried += on_ground ? 0 : 1;
    }
    EXPECT_GT(carried, 100U) << name;
  }
}

TEST(Sow, RefusesInOneLineWhatMakesNoMeadow) {
  const GrassSpecies& lawn = grass_species_named("lawn");
  SowOptions bare;
  bare.density_at = [](const Eigen::Vector2d&) { return 0.0; };
  EXPECT_EQ(test::complaint_of([&] { sow(lawn, bare); }),
            "field of grass: no blade in it, wanted ground that the masks leave, and a density for it");
  EXPECT_EQ(test::complaint_of([&] {
              sow(lawn, {.low = {1, 0}, .high = {0, 1}});
            }),
            "the field of grass: it ends before it begins, wanted low below high, along x and y");
  const std::string large = test::complaint_of([&] { sow(lawn, {.low = {-9e5, -9e5}, .high = {9e5, 9e5}}); });
  EXPECT_EQ(large.find("field of grass: 2.268e+16 blades"), 0U) << large;
  EXPECT_EQ(large.find('\n'), std::string::npos);
  EXPECT_EQ(test::complaint_of([&] { grass_species_named("weat"); }),
            "species of grass: 'weat'; did you mean wheat?, wanted one of lawn, meadow, wheat, rice, reed");
}

TEST(GrassSpecies, AreAllInRange) {
  for (const GrassSpecies& species : grass_species()) EXPECT_NO_THROW(check_species(species)) << species.name;
}

}  // namespace
}  // namespace tremula
