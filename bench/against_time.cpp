// The loop against the whole nonlinear tree integrated in time, in the same realisation of the wind:
//   bench_against_time PLANT SPEED…
// Prints, for every mean wind speed [m/s], the displacement of the tip along the wind and the moment at the
// base along it: mean, root mean square and largest value, and the root mean squares of the tip below, around
// and above its lowest mode (half to twice its frequency); by the loop with linear and with quadratic drag
// and by time integration. The moment is that of the thickest stem and of all the ground: of plants with one
// stem the same.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <string>

#include "tremula/deformation/bent_pose.hpp"
#include "tremula/dynamics/gauge.hpp"
#include "tremula/geometry/grow.hpp"
#include "tremula/geometry/lsystem.hpp"
#include "tremula/geometry/plants.hpp"
#include "tremula/numerics/fft.hpp"
#include "tremula/pipeline.hpp"
#include "tremula/reference/large_motion.hpp"

namespace {

using namespace tremula;

constexpr double intensity = 0.2, steps_a_second = 100;
const TimeAxis loop{.period = 20, .sample_count = 600};

struct Moments {
  double mean = 0, rms = 0, largest = 0;
};

Moments moments_of(const Eigen::VectorXd& series) {
  const double mean = series.mean();
  return {mean, std::sqrt((series.array() - mean).square().mean()), series.maxCoeff()};
}

// Root mean square of what a series over one loop has between two frequencies [Hz].
double rms_between(const Eigen::VectorXd& series, double low, double high) {
  const Eigen::VectorXcd spectrum = half_spectra_from_samples(series).col(0);
  double variance = 0;
  for (Eigen::Index bin = 1; bin < spectrum.size(); ++bin) {
    const double frequency = static_cast<double>(bin) / loop.period;
    if (frequency >= low && frequency < high) variance += 2 * std::norm(spectrum[bin]);
  }
  return std::sqrt(variance);
}

struct Answer {
  Eigen::VectorXd tip, moment;  // along the wind: from rest [m], at the ground about the foot [N m]
};

// The fluctuation of every point at the samples of the loop (M x 3P).
Eigen::MatrixXd gusts_of(const PointWind& wind) {
  Eigen::MatrixXcd spectra = Eigen::MatrixXcd::Zero(loop.bin_count(), 3 * wind.mean.cols());
  for (int bin = 1; bin < loop.bin_count(); ++bin)
    spectra.row(bin) = wind.velocity(bin, 0).reshaped().transpose();
  return samples_from_half_spectra(spectra, loop.sample_count);
}

Eigen::Index tip_of(const BeamTree& tree) {
  int tip = 0;
  for (int k = 0; k < tree.branch_count(); ++k) {
    if (tree.members[index_of(k)].point(1).z() > tree.members[index_of(tip)].point(1).z()) tip = k;
  }
  return tip;
}

Answer by_loop(const Subject& subject, const Weather& weather, const Skeleton& skeleton) {
  Weather gauged = weather;
  gauged.gauges = {place_gauge(skeleton, "base")};
  const Motion motion = set_in_motion(subject, gauged);
  const BentLean lean = bend_lean(subject.structure, motion);
  const Eigen::Index tip = tip_of(*subject.structure.tree);
  Answer answer{Eigen::VectorXd(loop.sample_count),
                gauge_series(motion.readings.front(), motion, 0).along_wind};
  for (int p = 0; p < loop.sample_count; ++p) {
    const std::vector<BentBranch> bent = bent_at(lean, motion, p * loop.period / loop.sample_count);
    answer.tip[p] = bent[index_of(tip)].end.x() - subject.structure.tree->members[index_of(tip)].point(1).x();
  }
  return answer;
}

// The second of two periods, the first of which begins at the lean.
Answer by_time(const Subject& subject, const Weather& weather) {
  const BeamTree& tree = *subject.structure.tree;
  const WindAt mean_wind = [&](Eigen::Index, const Vec3& place) { return weather.wind.statistics(place); };
  const Lean lean = find_lean(subject.structure, mean_wind, weather.loads, weather.lean);
  const Eigen::MatrixXd gusts = gusts_of(wind_at_points(weather.wind, loop, lean.sites.points));
  const auto gust = [&](int point, double time) -> Vec3 {
    const double at = std::fmod(time / loop.period, 1.0) * loop.sample_count;
    const int first = static_cast<int>(at) % loop.sample_count, second = (first + 1) % loop.sample_count;
    const double part = at - std::floor(at);
    return ((1 - part) * gusts.block<1, 3>(first, 3 * point) + part * gusts.block<1, 3>(second, 3 * point))
        .transpose();
  };
  const WeightAndDrag outside{
      .leaves = tree.blades,
      .leaf_drag_coefficient =
          [&](double speed) {
            return weather.loads.leaf_drag_coefficient * folding_factor(weather.loads.foliage, speed);
          },
      .wind = [&](std::size_t site, double time, const Vec3& place) -> Vec3 {
        return lean.loads.sites[site].gust_share *
               (weather.wind.statistics(place).mean + gust(lean.sites.sites[site].point, time));
      }};
  const Eigen::VectorXd straight = Eigen::VectorXd::Zero(tree.size());
  WeightAndDrag weight = outside;
  weight.fluid_density = 0;
  const std::vector<BentBranch> given = bend(tree, straight);
  const double frequency = subject.modes.frequency[0];
  const LargeMotionSettings settings{
      .step = 1 / steps_a_second,
      .step_count = static_cast<int>(std::lround(2 * loop.period * steps_a_second)),
      .high_frequency_radius = 0.8,
      .damping = rayleigh_damping(weather.damping.ratio, frequency, 4 * frequency),
      .at_rest = forces_on_strains(tree, straight, given,
                                   sum_wrenches(tree, given, loads_at_rest(tree, weight)).at_end),
      .strains = lean.strains,
      .tolerance = 1e-7};
  const int kept = settings.step_count / 2;
  const Eigen::Index tip = tip_of(tree);
  const Vec3 foot = tree.members.front().start;
  Answer answer{Eigen::VectorXd(kept), Eigen::VectorXd(kept)};
  integrate_large_motion(tree, outside, settings, [&](int step, const LargeMotionState& state) {
    if (step <= kept) return;
    answer.tip[step - kept - 1] =
        state.bent[index_of(tip)].end.x() - tree.members[index_of(tip)].point(1).x();
    answer.moment[step - kept - 1] =
        (state.wrenches.ground_moment - foot.cross(state.wrenches.ground_force)).y();
  });
  return answer;
}

}  // namespace

int main(int count, char** arguments) {
  if (count < 3) {
    std::fprintf(stderr, "usage: bench_against_time PLANT SPEED...\n");
    return 2;
  }
  const Skeleton skeleton = grow(parse_lsystem(find_preset(arguments[1]).text, arguments[1])).skeleton;
  const Subject subject = bake(skeleton, {.modes = {.count = 40}});
  std::printf("%s\n", arguments[1]);
  for (int i = 2; i < count; ++i) {
    const double speed = std::atof(arguments[i]), frequency = subject.modes.frequency[0];
    Weather weather;
    weather.wind = turbulent_wind({.speed = speed, .profile = ProfileKind::constant}, intensity);
    weather.transfer = Transfer::sampled;
    weather.loop = loop;
    const Answer linear = by_loop(subject, weather, skeleton), time = by_time(subject, weather);
    weather.drag = Drag::quadratic;
    const Answer quadratic = by_loop(subject, weather, skeleton);
    std::printf("%g m/s %22s %10s %10s\n", speed, "linear", "quadratic", "in time");
    const auto print = [&](const char* what, auto&& value) {
      std::printf("  %-18s %10.4g %10.4g %10.4g\n", what, value(linear), value(quadratic), value(time));
    };
    print("tip mean [m]", [](const Answer& of) { return moments_of(of.tip).mean; });
    print("tip rms [m]", [](const Answer& of) { return moments_of(of.tip).rms; });
    print("tip largest [m]", [](const Answer& of) { return moments_of(of.tip).largest; });
    print("  rms below mode 1", [&](const Answer& of) { return rms_between(of.tip, 0, frequency / 2); });
    print("  around", [&](const Answer& of) { return rms_between(of.tip, frequency / 2, 2 * frequency); });
    print("  above", [&](const Answer& of) { return rms_between(of.tip, 2 * frequency, 1e9); });
    print("moment mean [N m]", [](const Answer& of) { return moments_of(of.moment).mean; });
    print("moment rms [N m]", [](const Answer& of) { return moments_of(of.moment).rms; });
    print("moment max [N m]", [](const Answer& of) { return moments_of(of.moment).largest; });
    std::fflush(stdout);
  }
  return 0;
}
