// A change of the motion that nobody meant: the numbers of two small loops, rounded far above what compilers
// and processors differ by, as one number each. Where a change is meant, the test prints the new one.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

#include "frames.hpp"
#include "tremula/geometry/grow.hpp"
#include "tremula/geometry/lsystem.hpp"
#include "tremula/geometry/plants.hpp"
#include "tremula/pipeline.hpp"

namespace tremula {
namespace {

// FNV-1a of all displacements at all samples, in steps of 1e-7 m and rad.
std::uint64_t fingerprint(const Motion& motion) {
  std::uint64_t hash = 0xcbf29ce484222325U;
  for (int p = 0; p < motion.sample_count(); ++p) {
    for (const double value : displacement_at(motion, p * motion.period / motion.sample_count())) {
      const auto steps = static_cast<std::uint64_t>(std::llround(value * 1e7));
      for (int byte = 0; byte < 8; ++byte) hash = (hash ^ (steps >> (8 * byte) & 255U)) * 0x100000001b3U;
    }
  }
  return hash;
}

Weather weather() {
  Weather weather;
  TurbulentWind wind = turbulent_wind({.speed = 5, .heading = 35}, 0.2);
  wind.seed = 9;
  weather.wind = wind;
  weather.loop = {.period = 4, .sample_count = 16};
  return weather;
}

TEST(PinnedMotion, OfATreeWithoutWeightIsWhatItWas) {
  const Skeleton tree = grow(parse_lsystem(find_preset("stam-17").text, "stam-17")).skeleton;
  EXPECT_EQ(
      fingerprint(set_in_motion(bake(tree, {.structure = {.gravity = 0}, .modes = {.count = 6}}), weather())),
      6927711064542651903U);
}

TEST(PinnedMotion, OfATreeUnderItsWeightIsWhatItWas) {
  const Skeleton tree = grow(parse_lsystem(find_preset("stam-17").text, "stam-17")).skeleton;
  EXPECT_EQ(fingerprint(set_in_motion(bake(tree, {.modes = {.count = 6}}), weather())),
            17206913007087735552U);
}

TEST(PinnedMotion, OfAFrameIsWhatItWas) {
  const Frame table = test::table(2, find_material("oak"));
  EXPECT_EQ(fingerprint(set_in_motion(bake(table, {.modes = {.count = 6}}), weather())),
            15243781796407330877U);
}

TEST(PinnedMotion, KnowsAChangeOfAMillionthOfAMetre) {
  const Skeleton tree = grow(parse_lsystem(find_preset("stam-17").text, "stam-17")).skeleton;
  Motion motion = set_in_motion(bake(tree, {.structure = {.gravity = 0}, .modes = {.count = 6}}), weather());
  const std::uint64_t before = fingerprint(motion);
  motion.basis.columns(7, 0) += 1e-6;
  EXPECT_NE(fingerprint(motion), before);
}

}  // namespace
}  // namespace tremula
