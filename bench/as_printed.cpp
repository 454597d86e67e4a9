// What the misprints of both papers (docs/theory/errata.md) do, in per cent.
//
// First a tree of 62 branches in a wind of 6 m/s, with one formula at a time as it is printed: its lean, and
// the root mean square of its sway about the mean of the loop, of the branch end that goes farthest, over 8
// seeds; with the seconds of its modes and one loop. Then numbers by themselves: as printed, right, and how
// far off.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>
#include <utility>
#include <vector>

#include "plants.hpp"
#include "seconds.hpp"
#include "tremula/pipeline.hpp"
#include "tremula/structure/uniform_beam.hpp"

namespace {

using namespace tremula;
using std::numbers::pi;

struct Setting {
  StructureOptions structure{.gravity = 0};  // S has no weight
  Weather weather = {};
};
using Change = std::function<void(Setting&)>;

void section(Setting& setting) { setting.structure.section = Section::paper; }
void load(Setting& setting) { setting.weather.loads.model = LoadModel::paper; }
void bins(Setting& setting) { setting.weather.transfer = Transfer::sampled; }
void left_out(Setting& setting) { setting.weather.static_correction = false; }

struct Moved {
  double lean, sway, seconds;
};

Moved move(const Skeleton& skeleton, const std::vector<Change>& changes) {
  Setting setting;
  for (const Change& change : changes) change(setting);
  const auto baked = [&] { return bake(skeleton, {.structure = setting.structure, .modes = {.count = 20}}); };
  const Subject subject = baked();
  Moved moved{0, 0, bench::seconds_a_call([&] { set_in_motion(baked(), setting.weather); })};
  constexpr int seeds = 8;
  for (int seed = 1; seed <= seeds; ++seed) {
    TurbulentWind wind = turbulent_wind({.speed = 6}, 0.2);
    wind.seed = static_cast<std::uint64_t>(seed);
    setting.weather.wind = wind;
    const MotionStatistics found =
        motion_statistics(subject.structure, set_in_motion(subject, setting.weather));
    moved.lean = found.largest_lean;
    moved.sway += std::pow(found.about_mean.displacement, 2) / seeds;
  }
  moved.sway = std::sqrt(moved.sway);
  return moved;
}

void print_motions(const Skeleton& skeleton) {
  const std::vector<std::pair<const char*, std::vector<Change>>> ways = {
      {"nothing", {}},
      {"S1 section", {section}},
      {"S6 load", {load}},
      {"S11 bins", {bins}},
      {"S11 modes left out", {left_out}},
      {"all of these", {section, load, bins, left_out}}};
  std::printf("%-20s %8s %8s %8s %8s %9s\n", "as_printed", "lean_m", "off_%", "sway_m", "off_%", "seconds");
  const Moved right = move(skeleton, {});
  for (const auto& [name, changes] : ways) {
    const Moved moved = move(skeleton, changes);
    std::printf("%-20s %8.4f %8.1f %8.4f %8.1f %9.4f\n", name, moved.lean,
                100 * (moved.lean / right.lean - 1), moved.sway, 100 * (moved.sway / right.sway - 1),
                moved.seconds);
  }
}

void print(const char* erratum, const char* what, double printed, double right) {
  if (std::abs(printed) < 1e-12) printed = 0;  // but for rounding
  std::printf("%-8s %-62s %10.4g %10.4g %8.1f\n", erratum, what, printed, right, 100 * (printed / right - 1));
}

double first_frequency(const Skeleton& skeleton, Section section) {
  const Structure structure = assemble(skeleton, {.section = section, .gravity = 0});
  return solve_modes(structure, {.count = 1}).frequency[0];
}

// S eq. 8: the sum of squared weights, the mean over all branches.
double variance_of_rows(const Skeleton& skeleton, const StamWind& wind, double omega) {
  const Eigen::Matrix3Xd points = assemble(skeleton, {}).find_sites().points;
  double sum = 0;
  for (Eigen::Index k = 0; k < points.cols(); ++k) {
    const Eigen::VectorXd distance = (points.colwise() - points.col(k)).colwise().norm();
    sum += (-2 * wind.correlation_time * omega / wind.correlation_length * distance).array().exp().sum();
  }
  return sum / static_cast<double>(points.cols());
}

// Of an oscillator of this damping ratio in a white wind: the sum over the bins of a loop, in units of the
// integral, which is pi/(4 zeta omega^3).
double sampled_variance(double omega, double ratio, double period) {
  const double spacing = 2 * pi / period;
  double sum = 0;
  for (double w = spacing; w < 100 * omega; w += spacing)
    sum += spacing / (std::pow(omega * omega - w * w, 2) + std::pow(2 * ratio * omega * w, 2));
  return sum * 4 * ratio * std::pow(omega, 3) / pi;
}

void print_numbers_of_stam(const Skeleton& skeleton) {
  const double right = first_frequency(skeleton, Section::exact);
  print("S1", "first frequency of the tree [Hz]", first_frequency(skeleton, Section::paper), right);
  print("S2", "bin of that frequency in a loop of 256 s", 2 * pi * right * 256, right * 256);
  print("S7", "variance of the wind in bin 1 of it, of a lone branch 1",
        variance_of_rows(skeleton, {}, 2 * pi / 256), 1);
  const Eigen::VectorXd omega = solve_modes(assemble(skeleton, {.gravity = 0}), {.count = 20}).omega();
  Eigen::VectorXd variance(omega.size());
  for (Eigen::Index r = 0; r < omega.size(); ++r) variance[r] = sampled_variance(omega[r], 0.005, 10);
  print("S11", "variance of a mode, 0.5 % damped, in a loop of 10 s: least of 20", variance.minCoeff(), 1);
  print("S11", "most of 20", variance.maxCoeff(), 1);
}

// F section 6.1: a branch of l = 1 m, r = 5 mm, 800 kg/m^3, that shall swing with 2 Hz for 1 s, for which it
// prints E = 3.89e8 and c = 3.0e-4.
void print_numbers_of_shinya_and_fournier() {
  constexpr double length = 1, radius = 0.005, density = 800, frequency = 2;
  constexpr double printed_modulus = 3.89e8, printed_damping = 3.0e-4;
  const RoundSection disc = round_section(radius);
  const double modulus = youngs_modulus_of(frequency, length, density, disc);
  const auto beam = [&](double of_modulus) {
    return UniformBeam{length, of_modulus * disc.second_moment, density * disc.area};
  };
  print("F4", "correlation of gusts where eq. 2 has 0.5, in one dimension", (1 + std::log(2)) / 2, 0.5);
  const double root = clamped_free_root(1),
               celerity = std::sqrt(beam(modulus).bending_stiffness / beam(modulus).mass_per_length);
  print("F5", "first frequency of F's branch by eq. 6 [Hz]", root * std::sqrt(celerity) / (2 * pi),
        natural_omega(beam(modulus), 1) / (2 * pi));
  const double eta = (std::cosh(root) - std::cos(root)) / (std::sinh(root) - std::sin(root));
  print("F6", "first shape at the free end",
        std::cosh(root) - std::cos(root) - eta * (std::sinh(root) - std::sin(root)),
        clamped_free_shape(1, 1).value);
  print("F8", "damping time of F's branch [s]", 2 / (printed_damping * std::pow(2 * pi * frequency, 2)),
        2 / (stiffness_damping_of(1, frequency) * std::pow(2 * pi * frequency, 2)));
  print("F9", "frequency of F's branch with the printed E [Hz]",
        natural_omega(beam(printed_modulus), 1) / (2 * pi), frequency);
  double error = 0;
  for (int i = 0; i <= 1000; ++i) {
    const double place = i / 1000.0;
    error = std::max(
        error, 100 * std::abs(fundamental_polynomial(place).value - clamped_free_shape(1, place).value / 2));
  }
  print("F10", "largest error of the polynomial [% of the tip]", 1.3, error);
}

}  // namespace

int main() {
  const Skeleton skeleton = bench::stam_tree(62);
  print_motions(skeleton);
  std::printf("\n%-8s %-62s %10s %10s %8s\n", "erratum", "number", "printed", "right", "off_%");
  print_numbers_of_stam(skeleton);
  print_numbers_of_shinya_and_fournier();
}
