// The whole cascade: grow a sapling, bake its modes, let a wind blow, ask for any instant.

#include <tremula/dynamics/motion_statistics.hpp>
#include <tremula/geometry/grow.hpp>
#include <tremula/geometry/plants.hpp>
#include <tremula/pipeline.hpp>

#include <cstdio>

int main() {
  using namespace tremula;

  // 1. What depends on the plant alone is baked once.
  const GrownPlant plant = grow(parse_lsystem(find_preset("sapling").text, "sapling"));
  const Subject subject = bake(plant.skeleton, {.modes = {.count = 20}});

  // 2. Wind and motion vary: every speed and seed makes a loop of its own from the same modes.
  for (const double speed : {2.0, 4.0, 8.0}) {
    Weather weather;
    weather.wind = turbulent_wind({.speed = speed}, 0.2);
    weather.loop = {.period = 20, .sample_count = 600};
    const Motion motion = set_in_motion(subject, weather);
    const MotionStatistics statistics = motion_statistics(subject.structure, motion);
    std::printf("wind %.0f m/s: lean %.3f m, sway %.3f m rms\n", speed, statistics.largest_lean,
                statistics.about_lean.displacement);

    // 3. The loop closes, and any instant can be had directly.
    const Eigen::VectorXd at_start = displacement_at(motion, 0);
    const Eigen::VectorXd at_end = displacement_at(motion, motion.period);
    if (at_start != at_end) return 1;
  }
  return 0;
}
