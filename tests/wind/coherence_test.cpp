#include "tremula/wind/coherence.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tremula/base/error.hpp"

namespace tremula {
namespace {

const MeanWind breeze{.speed = 8, .reference_height = 20};

TEST(RootCoherence, OfShinyaAndFournierIsTheirEquation2) {
  const Coherence coherence = coherence_model(CoherenceKind::shinya_fournier, breeze);
  const double f = 0.3, dy = 2, dz = -1.5;
  EXPECT_NEAR(-std::log(root_coherence(coherence, 0, f, dy, dz)),
              f * std::sqrt(36 * dz * dz + 3.6 * 3.6 * dy * dy) / 8, 1e-14);
  EXPECT_NEAR(-std::log(root_coherence(coherence, 1, f, dy, dz)),
              f * std::sqrt(16 * dz * dz + 2.4 * 2.4 * dy * dy) / 8, 1e-14);
  EXPECT_NEAR(-std::log(root_coherence(coherence, 2, f, dy, 0)), 8 * f * dy / 8, 1e-14);
}

TEST(RootCoherence, OfTheStandardDependsOnTheDistanceAloneAndFallsWithItEvenAtZeroFrequency) {
  const Coherence coherence = coherence_model(CoherenceKind::iec, breeze);
  const double length = 8.1 * 0.7 * 20;
  EXPECT_NEAR(root_coherence(coherence, 0, 0, 3, 4), std::exp(-12 * 0.12 * 5 / length), 1e-14);
  EXPECT_NEAR(root_coherence(coherence, 0, 0.4, 3, 4),
              std::exp(-12 * std::hypot(0.4 * 5 / 8, 0.12 * 5 / length)), 1e-14);
  EXPECT_NEAR(root_coherence(coherence, 0, 0.4, 3, 4), root_coherence(coherence, 2, 0.4, 5, 0), 1e-14);
}

TEST(RootCoherence, OfTheStandardToTheLetterLeavesTheOtherComponentsIncoherent) {
  Coherence coherence = coherence_model(CoherenceKind::iec, breeze);
  coherence.iec_for_u_only = true;
  EXPECT_GT(root_coherence(coherence, 0, 0.1, 1, 0), 0.5);
  EXPECT_EQ(root_coherence(coherence, 1, 0.1, 1, 0), 0);
  EXPECT_EQ(root_coherence(coherence, 1, 0.1, 0, 0), 1);
}

TEST(RootCoherence, OfDavenportDecaysFasterAcrossTheWindThanUp) {
  const Coherence coherence = coherence_model(CoherenceKind::davenport, breeze);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(
        std::log(root_coherence(coherence, c, 0.2, 1, 0)) / std::log(root_coherence(coherence, c, 0.2, 0, 1)),
        1.6, 1e-12);
  }
}

TEST(RootCoherence, IsOneOfAPointWithItselfInEveryModelAndOfNothingElseWithoutCoherence) {
  for (const CoherenceKind kind :
       {CoherenceKind::shinya_fournier, CoherenceKind::davenport, CoherenceKind::iec, CoherenceKind::none}) {
    EXPECT_EQ(root_coherence(coherence_model(kind, breeze), 0, 1, 0, 0), 1);
    EXPECT_EQ(coherence_named(name_of(kind)), kind);
  }
  EXPECT_EQ(root_coherence(coherence_model(CoherenceKind::none, breeze), 0, 1e-9, 1e-6, 0), 0);
  EXPECT_THROW(coherence_named("exponential"), InputError);
}

TEST(CheckCoherence, RefusesWhatWouldGrowWithDistance) {
  EXPECT_THROW(check_coherence({.decay_y = {-1, 1, 1}}), InputError);
  EXPECT_THROW(check_coherence({.decay_z = {1, std::nan(""), 1}}), InputError);
  EXPECT_THROW(check_coherence({.iec_length = 0}), InputError);
  EXPECT_THROW(check_coherence({.speed = -1}), InputError);
}

}  // namespace
}  // namespace tremula
