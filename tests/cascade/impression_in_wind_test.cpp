// An impressionist tree by the field of its fundamental mode, and the same trunk through the whole cascade,
// in the same wind at the same place.
#include "tremula/dynamics/trunk_sway.hpp"
#include "tremula/geometry/impression.hpp"
#include "tremula/pipeline.hpp"
#include "tremula/wind/travelling_field.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace tremula {
namespace {

TEST(ImpressionInTheWind, SwaysAsItsTrunkDoesThroughTheWholeCascade) {
  const ImpressionistTree tree = impressionist_tree("round", 10);
  const Skeleton skeleton = trunk_skeleton(tree);
  const Material& material = find_material(tree.material);
  double worst = 1, power = 0, of_field = 0;
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    Weather weather;
    TurbulentWind wind = turbulent_wind({.speed = 8}, 0.2);
    wind.seed = seed;
    weather.wind = wind;
    weather.loop = {.period = 60, .sample_count = 900};
    weather.lean.shelter.on = false;
    weather.damping.ratio = 0.05;
    const Subject subject = bake(skeleton, {.structure = {.material = material}, .modes = {.count = 12}});
    const Motion motion = set_in_motion(subject, weather);
    const TrunkSway sway = trunk_sway(subject.structure, weather.wind, weather.loop,
                                      {.loads = weather.loads, .damping = weather.damping});
    const FieldPlane plane{.heights = {sway.gust_height}};
    const TravellingField top = respond(gust_field(weather.wind, weather.loop, plane), sway.response);
    const Eigen::Index row = subject.structure.nodes.back().row;
    const double stands = lean_of(motion.basis)[row];
    EXPECT_NEAR(sway.lean.back().x(), stands, 1e-6 * stands);
    double both = 0, one = 0, two = 0;
    for (int p = 0; p < weather.loop.sample_count; ++p) {
      const double time = weather.loop.period * p / weather.loop.sample_count;
      const double cascade = displacement_at(motion, time)[row] - stands;
      const double field = static_cast<double>(local_value_at(top, Vec3::Zero(), time).x());
      both += cascade * field;
      one += cascade * cascade;
      two += field * field;
    }
    worst = std::min(worst, both / std::sqrt(one * two));
    power += one;
    of_field += two;
  }
  EXPECT_GT(worst, 0.8);
  EXPECT_NEAR(std::sqrt(of_field / power), 1, 0.2);
}

}  // namespace
}  // namespace tremula
