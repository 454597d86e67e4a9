// How far superposed displacements (S eq. 1) stretch branches, and poses by strains do not.
//
//   bench_linear_poses [--plot FILE.svg]
//
// Three poses of the same plant in the same wind: linear from rest, as S has it, lean and all; linear about
// the bent lean, as morph targets play it; by strains. Stretch is how much longer the straight line between
// the ends of a branch is than the branch: the most over all branches and 100 instants. `apart` is the root
// mean square of the way between nodes of the first pose and of the last, beside that from rest to the last.
// A frame is the whole skin.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "seconds.hpp"
#include "tremula/deformation/bent_pose.hpp"
#include "tremula/deformation/loop.hpp"
#include "tremula/geometry/grow.hpp"
#include "tremula/geometry/plants.hpp"
#include "tremula/io/atomic_file.hpp"
#include "tremula/io/svg.hpp"
#include "tremula/pipeline.hpp"

namespace {

using namespace tremula;

constexpr int instants = 100;

double time_of(const Motion& motion, int instant) { return motion.period * instant / instants; }

double stretch(const Vec3& chord, const Member& member) { return chord.norm() / member.beam.length - 1; }

double stretch_of_strains(const Structure& structure, const Motion& motion) {
  const BentLean lean = bend_lean(structure, motion);
  double most = 0;
  for (int i = 0; i < instants; ++i) {
    const std::vector<BentBranch> bent = bent_at(lean, motion, time_of(motion, i));
    for (std::size_t k = 0; k < bent.size(); ++k)
      most = std::max(most, stretch(bent[k].end - bent[k].start, structure.members[k]));
  }
  return most;
}

// Of the nodes of two poses of one plant.
double apart(const Loop& linear, const Loop& bent) {
  double between = 0, way = 0;
  for (int i = 0; i < instants; ++i) {
    const double time = bent.period * i / instants;
    const NodePoses a = linear.nodes_at(time), b = bent.nodes_at(time);
    between += (a - b).topRows<3>().squaredNorm();
    way += b.topRows<3>().squaredNorm();
  }
  return std::sqrt(between / way);
}

double seconds_a_frame(const Loop& loop) {
  double time = 0;
  return bench::seconds_a_call([&] { loop.skin_at(time += 0.7); });
}

// Prints the row of one wind. Gives the stretch [%] of a linear pose from rest and about the lean.
std::pair<double, double> compare(const std::string& name, const Skeleton& skeleton, const Subject& subject,
                                  double speed) {
  Weather weather;
  weather.wind = turbulent_wind({.speed = speed}, 0.2);
  Motion bent = set_in_motion(subject, weather);
  weather.lean.rotations = Rotations::small;
  Motion linear = set_in_motion(subject, weather);
  const double from_rest = 100 * motion_statistics(subject.structure, linear).largest_stretch;
  const double about_lean = 100 * motion_statistics(subject.structure, bent).largest_stretch;
  const double by_strains = 100 * stretch_of_strains(subject.structure, bent);
  const Loop superposed = make_loop(subject.structure, mesh_surface(skeleton), std::move(linear), {});
  const Loop by_strain = make_loop(subject.structure, mesh_surface(skeleton), std::move(bent), {});
  std::printf("%8s %8g %13.2f %13.2f %13.4f %9.1f %11.2f %11.2f\n", name.c_str(), speed, from_rest,
              about_lean, by_strains, 100 * apart(superposed, by_strain), 1e3 * seconds_a_frame(superposed),
              1e3 * seconds_a_frame(by_strain));
  std::fflush(stdout);
  return {from_rest, about_lean};
}

}  // namespace

int main(int argc, char** argv) {
  std::printf("%8s %8s %13s %13s %13s %9s %11s %11s\n", "plant", "wind_m/s", "from_rest_%", "about_lean_%",
              "by_strains_%", "apart_%", "linear_ms", "strains_ms");
  std::vector<Series> from_rest, about_lean;
  const std::vector<std::pair<std::string, std::string>> plants = {
      {"sapling", "#4d7c38"}, {"birch", "#0b6e99"}, {"oak", "#d9730d"}};
  for (const auto& [name, color] : plants) {
    const Skeleton skeleton = grow(parse_lsystem(find_preset(name).text, name)).skeleton;
    const Subject subject = bake(skeleton, {.modes = {.count = 20}});
    from_rest.push_back({.name = name, .color = color, .x = {}, .y = {}});
    about_lean.push_back({.name = "", .color = color, .x = {}, .y = {}, .dashed = true});
    for (const double speed : {4.0, 8.0, 12.0, 16.0}) {
      const auto [rest, lean] = compare(name, skeleton, subject, speed);
      for (auto [series, value] : {std::pair{&from_rest.back(), rest}, {&about_lean.back(), lean}}) {
        series->x.push_back(speed);
        series->y.push_back(value);
      }
    }
  }
  if (argc < 3 || std::string(argv[1]) != "--plot") return 0;
  Plot plot{.title = "", .x = {"wind [m/s]", 4, 16}, .y = {}, .series = from_rest};
  plot.series.insert(plot.series.end(), about_lean.begin(), about_lean.end());
  plot.series.back().name = "dashed: about the lean";
  std::vector<double> values;
  for (const Series& series : plot.series) values.insert(values.end(), series.y.begin(), series.y.end());
  plot.y = axis_around("stretch [%]", values, true);
  const std::string title = "What linear poses stretch most";
  write_file_atomically(argv[2], svg_document(760, 450, title,
                                              svg_text(20, 28, title, {.size = 16, .bold = true}) +
                                                  svg_plot(plot, {84, 84, 620, 300})));
}
