#include "tremula/reference/modal_load_spectrum.hpp"

#include "tremula/base/error.hpp"
#include "tremula/dynamics/damping.hpp"
#include "tremula/dynamics/response.hpp"
#include "tremula/modes/solve_modes.hpp"
#include "tremula/wind/point_wind.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "trees.hpp"

namespace tremula {
namespace {

using std::numbers::pi;

// A tree of twenty branches in the wind of Shinya & Fournier, with all that the response asks for.
struct WindyTree {
  Structure structure = assemble(test::random_tree(20, 12), test::weightless());
  Modes modes = solve_modes(structure, {.count = 6});
  Sites sites = structure.find_sites();
  TurbulentWind wind = turbulent_wind({.speed = 6, .heading = 30}, 0.2);
  Loads loads = linearise_loads(sites, wind_at_points(wind, {10, 10}, sites.points).mean);
  Eigen::MatrixXd participation = modal_participation(sites, loads, modes.shapes);

  ModalSystem system(double damping_ratio) const {
    ModalSystem result{modes.omega(),
                       structural_damping({.ratio = damping_ratio}, modes.omega()).asDiagonal()};
    result.damping += aerodynamic_damping(sites, loads, modes.shapes);
    return result;
  }
};

const WindyTree& windy_tree() {
  static const WindyTree tree;
  return tree;
}

TEST(ModalLoadSpectrum, IsWhatTheWindAtThePointsGivesTheModes) {
  const WindyTree& tree = windy_tree();
  const TimeAxis axis{20, 400};
  constexpr int seeds = 400;
  for (const int bin : {2, 12, 40}) {
    const Eigen::MatrixXcd wanted =
        modal_load_spectrum(tree.wind, tree.sites.points, tree.participation, axis.frequency(bin)) /
        (2 * axis.period);
    Eigen::MatrixXcd by_wind = Eigen::MatrixXcd::Zero(6, 6), direct = by_wind;
    for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
      TurbulentWind wind = tree.wind;
      wind.seed = seed;
      const Eigen::Matrix3Xcd velocity = wind_at_points(wind, axis, tree.sites.points).velocity(bin, 0);
      const Eigen::VectorXcd force = tree.participation.transpose() * Eigen::VectorXcd(velocity.reshaped());
      by_wind += force * force.adjoint() / seeds;
      const Eigen::VectorXcd drawn = draw_modal_forces(wanted * (2 * axis.period), axis.period, seed, bin);
      direct += drawn * drawn.adjoint() / seeds;
    }
    // Each entry of a sample covariance has a deviation of sqrt(C_aa C_bb / seeds).
    for (int a = 0; a < 6; ++a) {
      for (int b = 0; b < 6; ++b) {
        const double deviation = std::sqrt(wanted(a, a).real() * wanted(b, b).real() / seeds);
        EXPECT_LT(std::abs(direct(a, b) - wanted(a, b)), 4 * deviation) << bin << ": " << a << ", " << b;
        // The wind at points is interpolated: 0.04 of coherence beside the statistics.
        EXPECT_LT(std::abs(by_wind(a, b) - wanted(a, b)),
                  4 * deviation + 0.06 * std::sqrt(wanted(a, a).real() * wanted(b, b).real()))
            << bin << ": " << a << ", " << b;
      }
    }
  }
}

// The integral over all frequencies of H S_f(f) H^H, the diagonal.
Eigen::VectorXd variance_of_the_tree(const WindyTree& tree, const ModalSystem& system) {
  Eigen::VectorXd variance = Eigen::VectorXd::Zero(6);
  const double ratio = 1.002;  // a fortieth of the width of a resonance of 4 %
  for (double f = 1e-5; f < 8; f *= ratio) {
    const double middle = f * std::sqrt(ratio);
    const Eigen::MatrixXcd transfer = transfer_function(system, 2 * pi * middle);
    const Eigen::MatrixXcd spectrum =
        modal_load_spectrum(tree.wind, tree.sites.points, tree.participation, middle);
    variance += f * (ratio - 1) * (transfer * spectrum * transfer.adjoint()).diagonal().real();
  }
  return variance;
}

TEST(Response, OfAWholeTreeHasTheVarianceOfTheIntegralForAnyPeriod) {
  const WindyTree& tree = windy_tree();
  const ModalSystem system = tree.system(0.02);
  const Eigen::VectorXd wanted = variance_of_the_tree(tree, system);
  constexpr int seeds = 200;
  for (const double period : {10.0, 20.0}) {
    const TimeAxis axis{period, static_cast<int>(16 * period)};
    std::vector<std::vector<double>> variances(6);
    for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
      TurbulentWind wind = tree.wind;
      wind.seed = seed;
      const PointWind at_points = wind_at_points(wind, axis, tree.sites.points);
      const BinTransfer transfer(system, axis, Transfer::bin_averaged, at_points.power);
      const Eigen::MatrixXcd y = respond(transfer, tree.participation, axis, at_points);
      for (Eigen::Index r = 0; r < 6; ++r) {
        variances[static_cast<std::size_t>(r)].push_back(std::norm(y(0, r)) +
                                                         2 * y.col(r).tail(y.rows() - 1).squaredNorm());
      }
    }
    for (Eigen::Index r = 0; r < 6; ++r) {
      const auto& values = variances[static_cast<std::size_t>(r)];
      double mean = 0, square = 0;
      for (const double value : values) mean += value / seeds, square += value * value / seeds;
      const double standard_error = std::sqrt((square - mean * mean) / (seeds - 1));
      // Beside the statistics, 3 % for the coherence of the wind between the nodes of its plane.
      EXPECT_NEAR(mean, wanted[r], 3 * standard_error + 0.03 * wanted[r]) << period << " s, mode " << r;
      EXPECT_LT(standard_error, 0.15 * wanted[r]);
    }
  }
}

TEST(DrawModalForces, RefuseALoopWithoutLength) {
  EXPECT_THROW(draw_modal_forces(Eigen::MatrixXcd::Identity(2, 2), 0, 1, 1), InputError);
}

}  // namespace
}  // namespace tremula
