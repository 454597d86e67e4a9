// The whole cascade in the frequency domain against the whole structure in time, under the same wind.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "in_wind.hpp"
#include "trees.hpp"
#include "tremula/modes/solve_modes.hpp"
#include "tremula/pipeline.hpp"
#include "tremula/reference/newmark.hpp"
#include "tremula/reference/sparse_matrices.hpp"
#include "tremula/structure/prestress.hpp"
#include "tremula/wind/stam_wind.hpp"

namespace tremula {
namespace {

const TimeAxis loop{4, 64};  // bins up to 8 Hz, above the modes that move most

// Thin enough that the slowest modes swing with the gusts; the axes of the branches stay where they are.
Skeleton thinned(Skeleton skeleton, double factor) {
  for (Branch& branch : skeleton.branches) {
    branch.start_radius *= factor;
    branch.end_radius *= factor;
  }
  return skeleton;
}

Skeleton bare_tree() { return thinned(test::random_tree(10, 2), 0.12); }

// Two roots, branches that start beside their nodes, and leaves that the wind catches.
Skeleton leafy_tree() {
  Skeleton skeleton = thinned(test::awkward_tree(), 0.25);
  for (Leaf& leaf : skeleton.leaves) leaf.area = 0.02;
  return skeleton;
}

struct Tree {
  Structure structure;
  Sites sites;
  SparseMatrices matrices;
  Loads loads;
  Modes modes;  // all 6N
  Eigen::Matrix3Xd mean_wind;
  Eigen::MatrixXcd winds;  // (3N x M/2+1) Fourier coefficients of one realisation, none slower than the loop
  Eigen::VectorXd mean;    // (6N) force of the mean wind
};

Tree in_the_wind(const Skeleton& skeleton) {
  Tree tree;
  tree.structure = assemble(skeleton, {});
  tree.sites = tree.structure.find_sites();
  tree.matrices = assemble_sparse(under_load(assemble_tree(skeleton, {}), weight(skeleton, {})));
  tree.modes = solve_modes(tree.structure, {.count = all_modes});
  const StamWind wind{.mean = {.speed = 7, .heading = 30}, .turbulence_intensity = 0.25, .seed = 11};
  const Eigen::Matrix3Xd& points = tree.sites.points;
  tree.mean_wind.resize(3, points.cols());
  for (Eigen::Index k = 0; k < points.cols(); ++k) {
    tree.mean_wind.col(k) = mean_speed(wind.mean, points(2, k)) * heading_direction(wind.mean);
  }
  tree.loads = linearise_loads(tree.sites, tree.mean_wind);
  tree.mean = mean_force(tree.sites, tree.loads);
  const StamWindAtPoints gusts(wind, loop, points);
  tree.winds.resize(3 * points.cols(), loop.bin_count());
  tree.winds.col(0).setZero();
  for (int bin = 1; bin < loop.bin_count(); ++bin) tree.winds.col(bin) = gusts.velocity(bin).reshaped();
  return tree;
}

// What blows through the tree, as a wind of its own.
Wind wind_of(const Tree& tree) {
  Wind wind;
  wind.at_points = [mean = tree.mean_wind, winds = tree.winds](const TimeAxis&, const Eigen::Matrix3Xd&) {
    return PointWind{
        .mean = mean,
        .velocity = [winds](int bin,
                            int) { return Eigen::Matrix3Xcd(winds.col(bin).reshaped(3, winds.rows() / 3)); },
        .has_draws = false,
        .has_slow_gusts = false};
  };
  return wind;
}

// Displacement (6N x M) over the loop by the cascade, with the lowest modes alone.
Eigen::MatrixXd synthesised(const Tree& tree, const Damping& damping, Eigen::Index mode_count) {
  Subject subject{tree.structure, tree.modes};
  subject.modes.frequency.conservativeResize(mode_count);
  subject.modes.shapes.conservativeResize(Eigen::NoChange, mode_count);
  const Motion motion = set_in_motion(subject, {.wind = wind_of(tree),
                                                .loads = {.model = LoadModel::linearised},
                                                .lean = test::small_and_free,
                                                .damping = damping,
                                                .transfer = Transfer::sampled,
                                                .static_correction = false,
                                                .loop = loop});
  return motion.basis.columns * motion.coordinates.transpose();
}

// The same in time: no modes, no FFT; the nodal force between the samples is that of the trigonometric sum.
PeriodicResponse integrated(const Tree& tree, const Eigen::SparseMatrix<double>& damping,
                            const PeriodicIntegration& settings) {
  const int bins = loop.bin_count();
  Eigen::MatrixXd coefficients(tree.structure.size(), 2 * bins);  // of the cosine and minus the sine
  for (int bin = 0; bin < bins; ++bin) {
    const Eigen::Matrix3Xcd wind = tree.winds.col(bin).reshaped(3, tree.winds.rows() / 3);
    // Bins -p and p together; bin 0 and the one at the Nyquist frequency stand for themselves.
    const double both = bin == 0 || 2 * bin == loop.sample_count ? 1 : 2;
    coefficients.col(2 * bin) = both * fluctuating_force(tree.sites, tree.loads, wind.real());
    coefficients.col(2 * bin + 1) = -both * fluctuating_force(tree.sites, tree.loads, wind.imag());
  }
  Eigen::VectorXd waves(2 * bins);
  const auto force = [&](double time) -> Eigen::VectorXd {
    for (int bin = 0; bin < bins; ++bin) {
      waves[2 * bin] = std::cos(loop.omega(bin) * time);
      waves[2 * bin + 1] = std::sin(loop.omega(bin) * time);
    }
    return tree.mean + coefficients * waves;
  };
  return periodic_response(tree.matrices, damping, force, loop, settings);
}

// Every mode damped by its own rate: C = M Q diag(c) Q^T M, since Q^T M Q = I.
Eigen::SparseMatrix<double> modal_damping(const Tree& tree, const Eigen::VectorXd& rates) {
  const Eigen::MatrixXd momenta = tree.matrices.mass * tree.modes.shapes;
  return Eigen::MatrixXd(momenta * rates.asDiagonal() * momenta.transpose()).sparseView();
}

// Root mean square of the difference over that of the motion about its mean, of all the ends of the branches
// and all samples.
struct Disagreement {
  double translation, rotation;
};
Disagreement disagreement(const Eigen::MatrixXd& first, const Eigen::MatrixXd& truth) {
  const Eigen::MatrixXd motion = truth.colwise() - truth.rowwise().mean(), difference = first - truth;
  double of_motion[2] = {}, of_difference[2] = {};
  for (Eigen::Index i = 0; i < truth.rows(); ++i) {
    of_motion[i % 6 / 3] += motion.row(i).squaredNorm();
    of_difference[i % 6 / 3] += difference.row(i).squaredNorm();
  }
  return {std::sqrt(of_difference[0] / of_motion[0]), std::sqrt(of_difference[1] / of_motion[1])};
}

TEST(AgainstTime, TheSynthesisedLoopIsTheOneThatTimeIntegrationSettlesInto) {
  const double ratio = 0.05, alpha = 1.5;
  for (const bool leafy : {false, true}) {
    const Tree tree = in_the_wind(leafy ? leafy_tree() : bare_tree());
    for (const bool by_ratio : {true, false}) {
      const std::string name =
          std::string(leafy ? "leafy" : "bare") + " tree, damping by " + (by_ratio ? "ratio" : "mass");
      const Damping damping = by_ratio ? Damping{.ratio = ratio, .aerodynamic = false}
                                       : Damping{.mass_proportional = alpha, .aerodynamic = false};
      const PeriodicResponse truth =
          integrated(tree,
                     by_ratio ? modal_damping(tree, 2 * ratio * tree.modes.omega())
                              : Eigen::SparseMatrix<double>(alpha * tree.matrices.mass),
                     {.steps_per_sample = 64});
      const Eigen::MatrixXd loop_of_all = synthesised(tree, damping, tree.structure.size());
      const auto [translation, rotation] = disagreement(loop_of_all, truth.displacement);
      EXPECT_LT(translation, 0.01) << name;
      EXPECT_LT(rotation, 0.01) << name;
      std::printf("%s, %d modes, %.2f to %.0f Hz, %d loops: %.3f %% of translations, %.3f %% of rotations\n",
                  name.c_str(), tree.modes.count(), tree.modes.frequency[0],
                  tree.modes.frequency[tree.modes.count() - 1], truth.loop_count, 100 * translation,
                  100 * rotation);
    }
  }
}

TEST(AgainstTime, DampedByTheWindToo) {
  for (const bool leafy : {false, true}) {
    const Tree tree = in_the_wind(leafy ? leafy_tree() : bare_tree());
    const Eigen::Index size = tree.structure.size();
    // Between the nodes: no modes in it.
    const Eigen::SparseMatrix<double> wind_damping =
        aerodynamic_damping(tree.sites, tree.loads, Eigen::MatrixXd::Identity(size, size)).sparseView();
    const double alpha = 1.5;
    const Eigen::MatrixXd truth =
        integrated(tree, alpha * tree.matrices.mass + wind_damping, {.steps_per_sample = 64}).displacement;
    const Eigen::MatrixXd of_all_modes = synthesised(tree, {.mass_proportional = alpha}, size);
    const auto [translation, rotation] = disagreement(of_all_modes, truth);
    EXPECT_LT(translation, 0.01);
    EXPECT_LT(rotation, 0.01);
    const Disagreement without =
        disagreement(synthesised(tree, {.mass_proportional = alpha, .aerodynamic = false}, size), truth);
    EXPECT_GT(without.translation, 0.05);
    std::printf(
        "%s tree, damping by mass and wind: %.3f %% of translations, %.3f %% of rotations; "
        "without the wind's damping %.1f %%, %.1f %%\n",
        leafy ? "leafy" : "bare", 100 * translation, 100 * rotation, 100 * without.translation,
        100 * without.rotation);
  }
}

TEST(AgainstTime, ModesLeftOutAreMissed) {
  const Tree tree = in_the_wind(bare_tree());
  const Eigen::MatrixXd truth = integrated(tree, 1.5 * tree.matrices.mass, {}).displacement;
  double last = 1;
  for (const int modes : {1, 2, 4}) {
    const auto [translation, rotation] =
        disagreement(synthesised(tree, {.mass_proportional = 1.5, .aerodynamic = false}, modes), truth);
    EXPECT_GT(std::min(translation, rotation), 0.02) << modes << " modes";
    EXPECT_LT(translation, last) << modes << " modes";
    last = translation;
  }
}

TEST(AgainstTime, TheDifferenceIsThatOfTheStepAndNothingElse) {
  const Tree tree = in_the_wind(bare_tree());
  const Eigen::MatrixXd loop_of_all =
      synthesised(tree, {.mass_proportional = 1.5, .aerodynamic = false}, tree.structure.size());
  const Eigen::SparseMatrix<double> damping = 1.5 * tree.matrices.mass;
  const auto difference = [&](int steps_per_sample) {
    return disagreement(
        loop_of_all,
        integrated(tree, damping, {.steps_per_sample = steps_per_sample, .tolerance = 1e-5}).displacement);
  };
  Disagreement last = difference(8);
  for (const int steps : {16, 32}) {
    const Disagreement halved = difference(steps);
    EXPECT_NEAR(last.translation / halved.translation, 4, 0.4) << steps << " steps a sample";
    EXPECT_NEAR(last.rotation / halved.rotation, 4, 0.4) << steps << " steps a sample";
    last = halved;
  }
}

}  // namespace
}  // namespace tremula
