// Modal forces drawn directly instead of from a wind at all branches (S section 7: "effective only for small
// trees. For larger trees, unnatural displacements along the tree's length occurred").
//
//   bench_direct_forces [--plot FILE.svg]
//
// Drawn alone, each mode has its own spectrum and knows nothing of the others; drawn together they have their
// cross spectra too (modal_load_spectrum). Material, loads and damping are Stam's, the wind is F's, whose
// cross spectra are known. So what a loop has on the average over all seeds can be worked out: the covariance
// of the modal coordinates is the sum over bins of H S_f H^H / T, with the diagonal of S_f for modes alone.
// Beside that stand loops that were synthesised, 64 seeds of each kind.

#include <cstdio>
#include <string>
#include <vector>

#include <tbb/parallel_for.h>

#include "paper.hpp"
#include "plants.hpp"
#include "seconds.hpp"
#include "tremula/dynamics/response.hpp"
#include "tremula/dynamics/wind_forces.hpp"
#include "tremula/io/atomic_file.hpp"
#include "tremula/io/svg.hpp"
#include "tremula/reference/modal_load_spectrum.hpp"

namespace {

using namespace tremula;

const TimeAxis loop{32, 256};  // to 4 Hz

struct Tree {
  Skeleton skeleton;
  Structure structure = assemble(skeleton, bench::paper_structure());
  Modes modes = solve_modes(structure, {.count = 20});
  Sites sites = structure.find_sites();
  TurbulentWind wind = turbulent_wind({.speed = 6}, 0.2);
  Loads loads =
      linearise_loads(sites, wind_at_points(wind, loop, sites.points).mean, bench::paper_weather().loads);
  Eigen::MatrixXd participation = modal_participation(sites, loads, modes.shapes);
  ModalSystem system{modes.omega(),
                     structural_damping(bench::paper_weather().damping, modes.omega()).asDiagonal()};
};

using Spectra = std::vector<Eigen::MatrixXcd>;  // of the bins from 1 on

Spectra cross_spectra(const Tree& tree) {
  Spectra spectra(index_of(loop.bin_count()));
  tbb::parallel_for(1, loop.bin_count(), [&](int bin) {
    spectra[index_of(bin)] =
        modal_load_spectrum(tree.wind, tree.sites.points, tree.participation, loop.frequency(bin));
  });
  return spectra;
}

// Of the modal coordinates over all seeds. (m x m)
Eigen::MatrixXd covariance(const Tree& tree, const Spectra& spectra, bool alone) {
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(tree.modes.count(), tree.modes.count());
  for (int bin = 1; bin < loop.bin_count(); ++bin) {
    const Eigen::MatrixXcd transfer = transfer_function(tree.system, loop.omega(bin));
    sum += (transfer * spectra[index_of(bin)] * transfer.adjoint()).real() / loop.period;
  }
  if (alone) sum = Eigen::MatrixXd(sum.diagonal().asDiagonal());
  return sum;
}

// One loop of modal forces (M/2+1 x m): from the wind at all branches, or drawn.
Eigen::MatrixXcd forces_by_wind(const Tree& tree, std::uint64_t seed) {
  TurbulentWind wind = tree.wind;
  wind.seed = seed;
  return wind_forces(tree.participation, loop, wind_at_points(wind, loop, tree.sites.points));
}
Eigen::MatrixXcd forces_drawn(const Tree& tree, const Spectra& spectra, std::uint64_t seed) {
  Eigen::MatrixXcd forces = Eigen::MatrixXcd::Zero(loop.bin_count(), tree.modes.count());
  for (int bin = 1; bin < loop.bin_count(); ++bin)
    forces.row(bin) = draw_modal_forces(spectra[index_of(bin)], loop.period, seed, bin).transpose();
  return forces;
}

// The covariance that a number of such loops has. (m x m)
template <typename Forces>
Eigen::MatrixXd covariance_of_loops(const Tree& tree, const Forces& forces_of) {
  constexpr int seeds = 64;
  const BinTransfer transfer(tree.system, loop, Transfer::sampled);
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(tree.modes.count(), tree.modes.count());
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    Eigen::MatrixXcd forces = forces_of(seed);
    forces.row(0).setZero();
    const Eigen::MatrixXcd found = respond(transfer, loop, {forces});
    sum += 2 * (found.adjoint() * found).real() / seeds;
  }
  return sum;
}

int highest_tip(const Skeleton& skeleton) {
  int top = 0;
  for (int k = 0; k < skeleton.branch_count(); ++k) {
    if (skeleton.branches[index_of(k)].end.z() > skeleton.branches[index_of(top)].end.z()) top = k;
  }
  return top;
}

// How the ends of branches move along the wind.
struct Sway {
  Eigen::VectorXd rms;       // (N) [m]
  Eigen::VectorXd with_top;  // (N) correlation with the highest tip
};
Sway sway(const Tree& tree, const Eigen::MatrixXd& of_coordinates) {
  Eigen::MatrixXd shapes(tree.structure.members.size(), tree.modes.count());
  for (Eigen::Index k = 0; k < shapes.rows(); ++k)
    shapes.row(k) = tree.modes.shapes.row(tree.structure.members[index_of(k)].end_row);
  const Eigen::VectorXd rms =
      (shapes * of_coordinates).cwiseProduct(shapes).rowwise().sum().cwiseMax(0).cwiseSqrt();
  const int top = highest_tip(tree.skeleton);
  const Eigen::VectorXd shared = shapes * of_coordinates * shapes.row(top).transpose();
  return {rms, shared.array() / (rms.array() * rms[top])};
}

double difference(const Sway& found, const Sway& wanted) {
  return 100 * (found.rms - wanted.rms).norm() / wanted.rms.norm();
}

// How every branch moves with the highest tip, against how it should.
Plot scatter(int branches, const Sway& wanted, const Sway& by_wind, const Sway& alone) {
  const PlotAxis x{"correlation that the wind gives it", -1, 1}, y{"correlation found", -1, 1};
  Plot plot{.title = std::to_string(branches) + " branches", .x = x, .y = y, .series = {}};
  const auto add = [&](const char* name, const char* color, const Sway& found) {
    plot.series.push_back({.name = name, .color = color, .x = {}, .y = {}, .mark = Mark::points});
    for (Eigen::Index k = 0; k < found.with_top.size(); ++k) {
      plot.series.back().x.push_back(wanted.with_top[k]);
      plot.series.back().y.push_back(found.with_top[k]);
    }
  };
  add("from the wind", "#0b6e99", by_wind);
  add("each mode alone", "#d9730d", alone);
  return plot;
}

// Prints the row of one tree.
Plot compare(int branches) {
  const Tree tree{bench::stam_tree(branches)};
  Spectra spectra;
  const double finding = bench::seconds_of([&] { spectra = cross_spectra(tree); });
  const Sway together = sway(tree, covariance(tree, spectra, false));
  const Sway alone = sway(tree, covariance(tree, spectra, true));
  const auto by_wind = [&](std::uint64_t seed) { return forces_by_wind(tree, seed); };
  const auto drawn = [&](std::uint64_t seed) { return forces_drawn(tree, spectra, seed); };
  const Sway loops_by_wind = sway(tree, covariance_of_loops(tree, by_wind));
  const Sway loops_drawn = sway(tree, covariance_of_loops(tree, drawn));
  std::printf("%8d %8.1f %10.1f %8.1f %10.2f %8.2f %10.4f %10.4f %9.4f\n", branches,
              difference(loops_by_wind, together), difference(loops_drawn, together),
              difference(alone, together), together.with_top.mean(), alone.with_top.mean(),
              bench::seconds_a_call([&] { by_wind(1); }), finding, bench::seconds_a_call([&] { drawn(1); }));
  std::fflush(stdout);
  return scatter(branches, together, loops_by_wind, alone);
}

}  // namespace

int main(int argc, char** argv) {
  std::printf("%8s %8s %10s %8s %10s %8s %10s %10s %9s\n", "branches", "wind_%", "together_%", "alone_%",
              "with_top", "alone", "wind_s", "spectra_s", "drawn_s");
  std::vector<Plot> plots;
  for (const int branches : {17, 62, 212, 692}) plots.push_back(compare(branches));
  if (argc < 3 || std::string(argv[1]) != "--plot") return 0;
  const std::string title = "How branches move with the highest tip";
  write_file_atomically(argv[2], svg_document(1060, 470, title,
                                              svg_text(20, 28, title, {.size = 16, .bold = true}) +
                                                  svg_plot(plots.front(), {84, 84, 410, 320}) +
                                                  svg_plot(plots.back(), {604, 84, 410, 320})));
}
