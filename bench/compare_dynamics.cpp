// The three ways from wind to motion on one plant in one wind: spectra of the tips as a plot, and a table.
//
//   bench_compare_dynamics [PLANT [SPEED]] [--plot FILE.svg]      by default bamboo-2942 at 6 m/s
//
// Compared are the modes of the whole plant, synthesised bin by bin and integrated in time, and the branches
// of F section 6.1 as oscillators: as printed, with the mass that they carry, and with three modes each. All
// meet the same gusts. Where a tip goes is told by its displacement about the lean; `apart` is the root mean
// square of the way between all nodes and where the modes take them, in per cent of that of the modes, which
// 100 would be for a plant that stands still. The last line is what F times: a frame of all branches, in
// time.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <string>
#include <vector>

#include "plants.hpp"
#include "seconds.hpp"
#include "tremula/base/error.hpp"
#include "tremula/io/atomic_file.hpp"
#include "tremula/io/svg.hpp"
#include "tremula/numerics/fft.hpp"
#include "tremula/pipeline.hpp"

namespace {

using namespace tremula;

struct Way {
  const char* name;
  const char* color;
  Dynamics dynamics;
  BranchOscillatorOptions oscillators = {};
};

const std::vector<Way> ways = {
    {"modal", "#0b6e99", Dynamics::modal},
    {"time", "#8e5ba6", Dynamics::time},
    {"as F", "#d9730d", Dynamics::oscillators},
    {"+ mass", "#4d7c38", Dynamics::oscillators, {.carried_mass = true}},
    {"+ 3 modes", "#b03a2e", Dynamics::oscillators, {.modes = 3, .carried_mass = true}},
};

struct Tip {
  const char* name;
  int branch;
};

// The end of the culm, and that of a branch amid the crown.
std::vector<Tip> tips_of(const Skeleton& skeleton) {
  int highest = 0, farthest = 0;
  for (int k = 0; k < skeleton.branch_count(); ++k) {
    const Vec3 &end = skeleton.branches[index_of(k)].end, &top = skeleton.branches[index_of(highest)].end;
    if (end.z() > top.z()) highest = k;
  }
  const double middle = 0.6 * skeleton.branches[index_of(highest)].end.z();
  double most = 0;
  for (int k = 0; k < skeleton.branch_count(); ++k) {
    const Vec3& end = skeleton.branches[index_of(k)].end;
    const double reach = std::hypot(end.x(), end.y()) - std::abs(end.z() - middle);
    if (reach > most) {
      most = reach;
      farthest = k;
    }
  }
  return {{"top", highest}, {"side", farthest}};
}

// Along the wind, about the mean of the loop. (M)
Eigen::VectorXd sway(const Motion& motion, int branch) {
  Eigen::VectorXd moved(motion.sample_count());
  const Eigen::Index row = Eigen::Index{6} * branch;
  moved = motion.coordinates.rightCols(motion.basis.count() - 1) *
          motion.basis.columns.row(row).tail(motion.basis.count() - 1).transpose();
  return moved.array() - moved.mean();
}

// The same of all nodes along all axes, a column each: (M x 3N).
Eigen::MatrixXd sway_of_all(const Motion& motion) {
  const Eigen::Index nodes = motion.basis.columns.rows() / 6, moving = motion.basis.count() - 1;
  Eigen::MatrixXd shapes(3 * nodes, moving);
  for (Eigen::Index n = 0; n < nodes; ++n)
    shapes.middleRows<3>(3 * n) = motion.basis.columns.block(6 * n, 1, 3, moving);
  const Eigen::MatrixXd coordinates = motion.coordinates.rightCols(moving);
  return (coordinates.rowwise() - coordinates.colwise().mean()) * shapes.transpose();
}

// Of a frame of F's model, forces and step [s].
void time_a_frame(const Structure& structure) {
  const Sites sites = structure.find_sites();
  const Loads loads = linearise_loads(sites, Vec3(5, 1, 0).replicate(1, sites.point_count()));
  const BranchOscillators branches = branch_oscillators(structure, sites, loads, {});
  const OscillatorIntegrator integrator(branches.network, 1.0 / 30);
  OscillatorState state = at_rest(branches.network);
  const Eigen::VectorXd gust = Eigen::VectorXd::Ones(branches.participation.cols());
  Eigen::VectorXd before = Eigen::VectorXd::Zero(branches.network.size()), after = before;
  const double seconds = bench::seconds_a_call([&] {
    before.swap(after);
    after.noalias() = branches.participation * gust;
    integrator.advance(state, before, after);
  });
  std::printf("a frame of %zu axes in time takes %.1e seconds", branches.axes.size(), seconds);
  constexpr double of_f = 0.64;  // CPU seconds on a Personal IRIS 4D/25, for 2942 branches (F section 6.1)
  if (structure.members.size() == 2942)
    std::printf(", F's took %g seconds, %.0f times as long", of_f, of_f / seconds);
  std::printf("\n");
}

// One-sided [m^2/Hz], means over bands of a tenth of an octave.
Series spectrum(const Eigen::VectorXd& samples, double period, const Way& way) {
  Series series{.name = way.name, .color = way.color, .x = {}, .y = {}};
  const auto count = samples.size();
  double low = 1 / period;
  while (low < 0.5 * static_cast<double>(count) / period) {
    const double high = std::max(low * std::exp2(0.1), low + 1 / period);
    double sum = 0;
    int bins = 0;
    for (auto bin = static_cast<Eigen::Index>(std::ceil(low * period - 1e-9)); bin < high * period - 1e-9;
         ++bin) {
      if (2 * bin > count) break;
      std::complex<double> of_bin = 0;
      for (Eigen::Index p = 0; p < count; ++p)
        of_bin += samples[p] * std::polar(1.0, -2 * std::numbers::pi * static_cast<double>(bin * p % count) /
                                                   static_cast<double>(count));
      sum += 2 * std::norm(of_bin) / static_cast<double>(count * count) * period;
      ++bins;
    }
    if (bins > 0) {
      series.x.push_back(std::sqrt(low * high));
      series.y.push_back(sum / bins);
    }
    low = high;
  }
  return series;
}

int run(int argc, char** argv) {
  std::string plant = "bamboo-2942", plot;
  double speed = 6;
  for (int i = 1, place = 0; i < argc; ++i) {
    if (std::string(argv[i]) == "--plot" && i + 1 < argc) {
      plot = argv[++i];
    } else if (place++ == 0) {
      plant = argv[i];
    } else {
      speed = std::atof(argv[i]);
    }
  }
  const Skeleton skeleton = grow(parse_lsystem(find_preset(plant).text, plant), {}).skeleton;
  const Subject subject = bake(skeleton, {.modes = {.count = 40}});
  Weather weather;
  weather.wind = turbulent_wind({.speed = speed}, 0.2);
  weather.loop = {.period = 40, .sample_count = 800};
  weather.transfer = Transfer::sampled;  // one realisation for all
  const std::vector<Tip> tips = tips_of(skeleton);
  std::vector<Plot> plots;
  for (const Tip& tip : tips) plots.push_back({.title = tip.name, .x = {}, .y = {}, .series = {}});
  std::printf("%s at %g m/s: %d branches, first mode %.3f Hz at rest\n", plant.c_str(), speed,
              skeleton.branch_count(), subject.modes.frequency[0]);
  std::printf("%-10s %8s %11s %10s %10s %8s %8s %8s\n", "dynamics", "seconds", "a_frame_ms", "top_rms_m",
              "side_rms_m", "top/mod", "side/mod", "apart_%");
  std::vector<double> of_modal;
  Eigen::MatrixXd all_of_modal;
  for (const Way& way : ways) {
    weather.dynamics = way.dynamics;
    weather.oscillators = way.oscillators;
    Motion motion;
    const double seconds = bench::seconds_of([&] { motion = set_in_motion(subject, weather); });
    std::vector<double> rms;
    for (std::size_t t = 0; t < tips.size(); ++t) {
      const Eigen::VectorXd moved = sway(motion, tips[t].branch);
      rms.push_back(std::sqrt(moved.squaredNorm() / static_cast<double>(moved.size())));
      plots[t].series.push_back(spectrum(moved, motion.period, way));
      plots[t].series.back().dashed = way.dynamics == Dynamics::time;
    }
    const Eigen::MatrixXd all = sway_of_all(motion);
    if (of_modal.empty()) {
      of_modal = rms;
      all_of_modal = all;
    }
    std::printf("%-10s %8.2f %11.2f %10.4f %10.4f %8.3f %8.3f %8.1f\n", way.name, seconds,
                1e3 * seconds / motion.sample_count(), rms[0], rms[1], rms[0] / of_modal[0],
                rms[1] / of_modal[1], 100 * (all - all_of_modal).norm() / all_of_modal.norm());
  }
  time_a_frame(subject.structure);
  if (plot.empty()) return 0;
  std::string body = svg_text(20, 28, plant + ": sway along the wind", {.size = 16, .bold = true});
  for (std::size_t t = 0; t < plots.size(); ++t) {
    std::vector<double> x, y;
    for (const Series& series : plots[t].series) {
      x.insert(x.end(), series.x.begin(), series.x.end());
      y.insert(y.end(), series.y.begin(), series.y.end());
    }
    plots[t].x = axis_around("frequency [Hz]", x, true);
    plots[t].y = axis_around("spectrum [m\u00b2/Hz]", y, true);
    plots[t].y.low = std::max(plots[t].y.low, plots[t].y.high * 1e-10);
    body += svg_plot(plots[t], {84.0 + 520 * static_cast<double>(t), 84, 410, 300});
  }
  write_file_atomically(plot, svg_document(1060, 450, plant + ": three dynamics", body));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "compare_dynamics: %s\n", error.what());
    return 1;
  }
}
