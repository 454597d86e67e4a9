// How much of the motion of all modes a few have (S section 7: ten do for trees of less than 50 branches),
// and what they cost.
//
// Root mean square over all nodes and instants of what is missing, in per cent of that of the motion by all
// modes: in Stam's wind as he prints it and with rows of unit variance, and in the latter with the static
// shapes that the cascade puts behind the modes. Seconds for modes and loop.

#include <cstdio>
#include <initializer_list>

#include "paper.hpp"
#include "plants.hpp"
#include "seconds.hpp"

namespace {

using namespace tremula;

// Where the nodes go from the lean: (3N x M) [m].
Eigen::MatrixXd translations(const Motion& motion) {
  const Eigen::Index nodes = motion.basis.columns.rows() / 6, moving = motion.basis.count() - 1;
  Eigen::MatrixXd rows(3 * nodes, moving);
  for (Eigen::Index n = 0; n < nodes; ++n)
    rows.middleRows<3>(3 * n) = motion.basis.columns.block(6 * n, 1, 3, moving);
  return rows * motion.coordinates.rightCols(moving).transpose();
}

struct Way {
  Weather weather;
  Eigen::MatrixXd of_all = {};  // the motion by all modes
};

void compare(int branches, const TimeAxis& loop) {
  const Skeleton skeleton = bench::stam_tree(branches);
  const auto bake_with = [&](int count) {
    return bake(skeleton, {.structure = bench::paper_structure(), .modes = {.count = count}});
  };
  std::vector<Way> ways(3, Way{bench::paper_weather(loop)});
  ways[0].weather.wind = StamWind{.rows = StamRows::as_printed, .cutoff = 0};
  for (const std::size_t w : {1, 2}) ways[w].weather.wind = StamWind{.cutoff = 0};
  ways[2].weather.static_correction = true;
  for (const int count : {all_modes, 5, 10, 20, 40}) {
    Subject subject;
    Motion motion;
    const double seconds = bench::seconds_of([&] {
      subject = bake_with(count);
      motion = set_in_motion(subject, ways[1].weather);
    });
    std::printf("%8d %8.4g %6d %12.2f", branches, loop.sample_count / loop.period / 2, subject.modes.count(),
                subject.modes.frequency[subject.modes.count() - 1]);
    for (Way& way : ways) {
      Weather weather = way.weather;
      if (count == all_modes) weather.static_correction = false;  // nothing is left out
      const Eigen::MatrixXd found = translations(set_in_motion(subject, weather));
      if (count == all_modes) way.of_all = found;
      std::printf(" %12.2f", 100 * (found - way.of_all).norm() / way.of_all.norm());
    }
    std::printf(" %9.4f\n", seconds);
    std::fflush(stdout);
  }
}

}  // namespace

int main() {
  std::printf("%8s %8s %6s %12s %12s %12s %12s %9s\n", "branches", "to_Hz", "m", "highest_Hz", "as_printed_%",
              "unit_rows_%", "with_static_%", "seconds");
  const TimeAxis of_stam{256, 256}, fine{32, 1024};
  for (const int branches : {17, 49}) {
    for (const TimeAxis& loop : {of_stam, fine}) compare(branches, loop);
  }
  compare(212, of_stam);
}
