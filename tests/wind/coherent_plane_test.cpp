#include "tremula/wind/coherent_plane.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace tremula {
namespace {

struct Error {
  double coherence, clipped;
};

// For a window of points x points with neighbours 1 m apart.
Error error_of_window(int points, const CoherenceDecay& decay, double tolerance) {
  const int rows = fast_length(periodic_length(points, 1, decay.z, tolerance));
  const int columns = fast_length(periodic_length(points, 1, decay.y, tolerance));
  const CoherentPlane plane(rows, columns, points);
  CoherentPlaneWork work;
  plane.set_coherences({decay, decay}, 1, 1, work);
  const double clipped = work.clipped_share[0];
  return {plane.coherence_error({decay, decay}, 1, 1, points, points, work)[0], clipped};
}

TEST(CoherentPlane, HasTheCoherenceWantedWithinThreePercentHoweverFarGustsReach) {
  double worst = 0;
  for (double decay = 1e-4; decay < 8; decay *= 1.5) {
    for (const double ratio : {0.3, 0.6, 1.0, 1.67, 4.0}) {
      worst = std::max(worst, error_of_window(21, {decay, ratio * decay}, 0.005).coherence);
    }
  }
  EXPECT_LT(worst, 0.03);
  EXPECT_GT(worst, 0.01) << "then the theory chapter is too modest";
}

TEST(CoherentPlane, IsExactToTheToleranceWhereGustsAreSmallerThanTheWindow) {
  for (const double tolerance : {0.02, 0.001}) {
    for (const double decay : {0.35, 0.6, 1.0, 3.0}) {
      const Error error = error_of_window(31, {decay, decay}, tolerance);
      EXPECT_LT(error.coherence, 1.01 * tolerance) << decay;
      EXPECT_LT(error.clipped, 1e-3) << decay;
    }
  }
}

TEST(CoherentPlane, PadsNoFurtherThanTwiceTheWindowOrTheReachOfAGust) {
  EXPECT_EQ(periodic_length(1, 2, 0.1, 0.01), 1);
  EXPECT_EQ(periodic_length(50, 2, 1e-9, 0.01), 98);
  EXPECT_EQ(periodic_length(50, 2, 0, 0.01), 98);
  EXPECT_EQ(periodic_length(50, 2, 1, std::exp(-6)), 49 + 3);
  EXPECT_EQ(periodic_length(50, 2, 1e9, 0.01), 50);
}

TEST(CoherentPlane, GivesTwoCoherencesAtOnceAsItGivesEachAlone) {
  const CoherenceDecay slow{0.05, 0.1}, fast{0.7, 0.3};
  const CoherentPlane plane(24, 20, 12);
  CoherentPlaneWork together, alone;
  plane.set_coherences({slow, fast}, 1, 1, together);
  for (const int which : {0, 1}) {
    const auto k = static_cast<std::size_t>(which);
    const CoherenceDecay& decay = which == 0 ? slow : fast;
    plane.set_coherences({decay, decay}, 1, 1, alone);
    EXPECT_NEAR(static_cast<double>(together.scale[k] / alone.scale[0]), 1, 1e-5);
    EXPECT_NEAR(together.clipped_share[k], alone.clipped_share[0], 1e-5);
  }
}

TEST(CoherentPlane, CoversThePlaneWithUnitPowerWhateverThePhases) {
  const CoherentPlane plane(16, 24, 16);
  CoherentPlaneWork work;
  plane.set_coherences({CoherenceDecay{0.1, 0.2}, CoherenceDecay{0.5, 0.3}}, 1, 1, work);
  for (std::uint32_t bin = 0; bin < 5; ++bin) {
    for (const int which : {0, 1}) {
      plane.draw({.amplitudes = Amplitudes::phases_only, .seed = 3, .stream = RandomStream::test, .bin = bin},
                 which, work);
      double power = 0;
      for (int r = 0; r < 16; ++r) {
        for (int c = 0; c < 24; ++c) {
          power +=
              static_cast<double>(std::norm(work.plane[static_cast<std::size_t>(r * plane.pitch() + c)]));
        }
      }
      const auto scale = static_cast<double>(work.scale[static_cast<std::size_t>(which)]);
      EXPECT_NEAR(power * scale * scale / (16 * 24), 1, 1e-5);
    }
  }
}

TEST(CoherentPlane, OfOneNoiseGivesTwoFieldsAsCorrelatedAsItSays) {
  const CoherentPlane plane(24, 24, 24);
  const CoherenceDecay slow{0.2, 0.3}, fast{0.9, 1.4};
  CoherentPlaneWork work;
  plane.set_coherences({slow, slow}, 1, 1, work);
  EXPECT_NEAR(plane.likeness(work), 1, 1e-5);
  plane.set_coherences({slow, fast}, 1, 1, work);
  const double likeness = plane.likeness(work);
  EXPECT_LT(likeness, 0.9);
  constexpr double shared = 0.8;
  const Noise of_u{.seed = 3, .stream = RandomStream::wind_u};
  Noise of_w{.seed = 3, .stream = RandomStream::wind_w, .shared = shared, .other = RandomStream::wind_u};
  double cross = 0, power_u = 0, power_w = 0;
  for (std::uint32_t bin = 0; bin < 400; ++bin) {
    Noise first = of_u, second = of_w;
    first.bin = second.bin = bin;
    plane.draw(first, 0, work);
    const auto u = work.plane;
    plane.draw(second, 1, work);
    for (int r = 0; r < 24; ++r) {
      for (int c = 0; c < 24; ++c) {
        const auto at = static_cast<std::size_t>(r * plane.pitch() + c);
        const auto x = std::complex<double>(u[at]), y = std::complex<double>(work.plane[at]);
        cross += (x * std::conj(y)).real();
        power_u += std::norm(x);
        power_w += std::norm(y);
      }
    }
  }
  // 400 planes of some tens of independent places each: within a hundredth.
  EXPECT_NEAR(cross / std::sqrt(power_u * power_w), shared * likeness, 0.015);
}

}  // namespace
}  // namespace tremula
