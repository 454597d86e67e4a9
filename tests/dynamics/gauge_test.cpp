#include "tremula/dynamics/gauge.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "frames.hpp"
#include "structure/random_vector.hpp"
#include "trees.hpp"
#include "tremula/base/error.hpp"
#include "tremula/numerics/fft.hpp"
#include "tremula/structure/bent_tree.hpp"

namespace tremula {
namespace {

using std::numbers::pi;

Lean upright(const Structure& structure) {
  return {.displacement = Eigen::VectorXd::Zero(structure.size()),
          .structure = structure,
          .sites = {},
          .loads = {}};
}

// A lean without displacement, and one shape about it.
Basis basis_of(const Eigen::VectorXd& shape) {
  return {{ShapeKind::lean, ShapeKind::mode},
          Eigen::Vector2d(0, 1),
          (Eigen::MatrixXd(shape.size(), 2) << Eigen::VectorXd::Zero(shape.size()), shape).finished()};
}

Motion motion_of(const Basis& basis, const Eigen::VectorXd& coordinate) {
  Motion motion{10, basis, Eigen::MatrixXd::Ones(coordinate.size(), 2)};
  motion.coordinates.col(1) = coordinate;
  return motion;
}

TEST(ReadGauge, OfACantileverWithAForceAtItsTipIsForceTimesLever) {
  const double length = 4, force = 30;
  for (const RootSpring& root : {RootSpring{}, RootSpring{.translation = 1e4, .rotation = 2e3}}) {
    for (const double tip_radius : {0.05, 0.02}) {
      const Skeleton stem = test::straight_stem(5, length, 0.05, tip_radius);
      const Structure structure = assemble(stem, test::weightless({.root = root}));
      Eigen::VectorXd load = Eigen::VectorXd::Zero(structure.size());
      load[6 * 4] = force;  // along x
      const Basis basis = basis_of(structure.flexibility(load));
      const double youngs_modulus = structure.members[0].beam.material.youngs_modulus;
      for (const double at : {0.0, 0.3, 1.7, 4.0}) {
        const Gauge gauge = place_gauge(stem, "stem:" + std::to_string(at));
        const GaugeReading reading = read_gauge(upright(structure), basis, gauge);
        EXPECT_EQ(reading.lean.norm(), 0);
        const GaugeSeries series = gauge_series(reading, motion_of(basis, Eigen::Vector3d(1, -2, 0)), 0);
        const double moment = force * (length - at), r = 0.05 + at / length * (tip_radius - 0.05);
        EXPECT_NEAR(series.bending_moment[0], moment, 1e-9);
        EXPECT_NEAR(series.along_wind[0], moment, 1e-9);
        EXPECT_NEAR(series.along_wind[1], -2 * moment, 1e-9);
        EXPECT_NEAR(series.across_wind[0], 0, 1e-9);
        EXPECT_NEAR(series.shear[0], force, 1e-9);
        EXPECT_NEAR(series.axial[0], 0, 1e-9);
        EXPECT_NEAR(series.torsion[0], 0, 1e-9);
        EXPECT_NEAR(series.strain[1] * youngs_modulus * pi / 4 * r * r * r, 2 * moment, 1e-8);
        EXPECT_EQ(series.bending_moment[2], 0);
      }
    }
  }
}

TEST(ReadGauge, KnowsPullAndTwistAndBendingToTheLeftOfTheWind) {
  const Skeleton stem = test::straight_stem(3, 3, 0.05, 0.03);
  const Structure structure = assemble(stem, test::weightless());
  Eigen::VectorXd load = Eigen::VectorXd::Zero(structure.size());
  load.segment<6>(12) << 0, 7, 11, 0, 0, 5;
  const Basis basis = basis_of(structure.flexibility(load));
  const GaugeReading reading = read_gauge(upright(structure), basis, place_gauge(stem, "stem:1"));
  const Motion motion = motion_of(basis, Eigen::VectorXd::Ones(1));
  const GaugeSeries series = gauge_series(reading, motion, 0);
  EXPECT_NEAR(series.axial[0], 11, 1e-9);
  EXPECT_NEAR(series.torsion[0], 5, 1e-9);
  EXPECT_NEAR(series.across_wind[0], 14, 1e-9);
  EXPECT_NEAR(series.along_wind[0], 0, 1e-9);
  EXPECT_NEAR(gauge_series(reading, motion, 90).along_wind[0], 14, 1e-9);
  EXPECT_NEAR(gauge_series(reading, motion, 30).along_wind[0], 7, 1e-9);
  const double area = pi * reading.radius * reading.radius;
  EXPECT_NEAR(reading.axial_stiffness / area, structure.members[0].beam.material.youngs_modulus, 1);
  EXPECT_NEAR(series.strain[0],
              14 * reading.radius / reading.bending_stiffness + 11 / reading.axial_stiffness, 1e-15);
}

TEST(ReadGauge, OfABranchThatPointsIntoTheWindTellsBendingUpwards) {
  const Skeleton stem = test::straight_stem(2, 2, 0.05, 0.03, Vec3::UnitX());
  const Structure structure = assemble(stem, test::weightless());
  Eigen::VectorXd load = Eigen::VectorXd::Zero(structure.size());
  load.segment<3>(6) << 0, 3, 4;
  const Basis basis = basis_of(structure.flexibility(load));
  const GaugeReading reading = read_gauge(upright(structure), basis, place_gauge(stem, "base"));
  const GaugeSeries series = gauge_series(reading, motion_of(basis, Eigen::VectorXd::Ones(1)), 0);
  EXPECT_NEAR(series.along_wind[0], 8, 1e-9);
  EXPECT_NEAR(std::abs(series.across_wind[0]), 6, 1e-9);
}

TEST(ReadGauge, UnderAnEvenLoadMissesTheShareOfTheStartOfItsOwnBranch) {
  const double length = 3, load = 40;
  for (const int pieces : {1, 4, 20}) {
    const Skeleton stem = test::straight_stem(pieces, length, 0.05, 0.05);
    const Structure structure = assemble(stem, test::weightless());
    const double piece = length / pieces;
    Eigen::VectorXd force = Eigen::VectorXd::Zero(structure.size());
    for (int k = 0; k < pieces; ++k) force[6 * k] = load * piece;
    force[6 * pieces - 6] = load * piece / 2;
    force[6 * pieces - 2] = -load * piece * piece / 12;
    const Basis basis = basis_of(structure.flexibility(force));
    const GaugeReading reading = read_gauge(upright(structure), basis, place_gauge(stem, "base"));
    const GaugeSeries series = gauge_series(reading, motion_of(basis, Eigen::VectorXd::Ones(1)), 0);
    const double n = pieces;
    EXPECT_NEAR(series.shear[0] / (load * length), 1 - 1 / (2 * n), 1e-9);
    EXPECT_NEAR(series.along_wind[0] / (load * length * length / 2), 1 - 1 / (6 * n * n), 1e-9);
  }
}

TEST(ReadGauge, OnAFrameIsThatOnTheTreeItIs) {
  const Skeleton stem = test::straight_stem(4, 2, 0.04, 0.02, Vec3(0.3, 0.1, 1).normalized());
  const Structure tree = assemble(stem, test::weightless()),
                  frame = assemble(test::frame_of(stem, StructureOptions{}.material));
  const Eigen::VectorXd load = test::random_vector(tree.size(), 4);
  const Gauge gauge{"here", 2, 0.3};
  const GaugeReading of_tree = read_gauge(upright(tree), basis_of(tree.flexibility(load)), gauge),
                     of_frame = read_gauge(upright(frame), basis_of(frame.flexibility(load)), gauge);
  EXPECT_EQ(of_tree.axes, of_frame.axes);
  const double size = of_tree.per_coordinate.norm();
  EXPECT_LT((of_tree.per_coordinate - of_frame.per_coordinate).norm(), 1e-8 * size);
}

// A structure that has the members of a tree as it stands bent.
struct Standing {
  BeamTree tree;
  Structure structure;
};

TEST(ReadGauge, SumsUpWhatLoadsABentTreeBeyondTheSection) {
  const Skeleton skeleton = test::awkward_tree();
  for (const RootSpring& root : {RootSpring{}, RootSpring{.translation = 1e5, .rotation = 1e4}}) {
    Standing standing{{}, assemble(skeleton, test::weightless({.root = root}))};
    const BeamTree& rest = *standing.structure.tree;
    Eigen::VectorXd strains = 0.4 * test::random_vector(rest.size(), 2);
    for (int k = 0; k < rest.branch_count(); ++k)
      strains.segment<3>(6 * k) *= rest.members[index_of(k)].beam.length;
    const std::vector<BentBranch> bent = bend(rest, strains);
    standing.tree = tree_at(rest, bent);
    standing.structure.members = standing.tree.members;
    const Eigen::VectorXd load = test::random_vector(rest.size(), 3);
    const Basis basis = basis_of(solve_static(standing.tree, load));
    Lean lean = upright(standing.structure);
    lean.strains = strains;
    lean.wrenches.at_end = lean.wrenches.at_start = Eigen::VectorXd::Zero(rest.size());
    for (int k = 0; k < rest.branch_count(); ++k) {
      // By hand: forces and moments of all that hangs on branch k.
      std::vector<bool> beyond(index_of(rest.branch_count()));
      Vec6 at_end = Vec6::Zero();
      for (int j = k; j < rest.branch_count(); ++j) {
        const int parent = rest.parent[index_of(j)];
        beyond[index_of(j)] = j == k || (parent >= 0 && beyond[index_of(parent)]);
        if (!beyond[index_of(j)]) continue;
        const Vec3 arm = bent[index_of(j)].end - bent[index_of(k)].end;
        at_end.head<3>() += load.segment<3>(6 * j);
        at_end.tail<3>() += load.segment<3>(6 * j + 3) + arm.cross(load.segment<3>(6 * j));
      }
      const Vec3 reach = bent[index_of(k)].end - standing.tree.members[index_of(k)].start;
      Vec6 at_start = at_end;
      at_start.tail<3>() += reach.cross(Vec3(at_end.head<3>()));
      lean.wrenches.at_end.segment<6>(6 * k) = at_end;
      lean.wrenches.at_start.segment<6>(6 * k) = at_start;
      const Gauge gauge{"here", k, 0.25};
      const GaugeReading reading = read_gauge(lean, basis, gauge);
      const Member& member = standing.tree.members[index_of(k)];
      const Vec3 arm = member.point(1) - member.point(0.25), force = at_end.head<3>();
      const Vec3 moment = at_end.tail<3>() + arm.cross(force);
      EXPECT_LT((reading.axes * reading.per_coordinate.col(1).head<3>() - force).norm(), 1e-8) << k;
      EXPECT_LT((reading.axes * reading.per_coordinate.col(1).tail<3>() - moment).norm(), 1e-8) << k;
      EXPECT_LT((reading.axes * reading.lean.head<3>() - force).norm(), 1e-12) << k;
      EXPECT_LT((reading.axes * reading.lean.tail<3>() - moment).norm(), 1e-12) << k;
      EXPECT_LT((reading.axes.transpose() * reading.axes - Mat3::Identity()).norm(), 1e-14);
      EXPECT_GT(reading.axes.determinant(), 0);
      EXPECT_NEAR(reading.axes(2, 1), 0, 1e-15);
    }
  }
}

TEST(ReadGauge, AtTheFootOfATreeUnderLoadsAtItsEndsIsWhatTheGroundCarries) {
  const Skeleton stem = test::straight_stem(8, 4, 0.03, 0.01);
  Standing standing{{}, assemble(stem, test::weightless())};
  const BeamTree& rest = *standing.structure.tree;
  const Equilibrium found = find_equilibrium(rest, [&](int k, const BentBranch&) {
    EndLoads loads;
    if (k >= 2) loads.end_force = Vec3(60, 9, -15);
    if (k + 1 == rest.branch_count()) loads.end_moment = Vec3(1, 2, 3);
    return loads;
  });
  standing.tree = tree_at(rest, found.bent);
  standing.structure.members = standing.tree.members;
  Lean lean = upright(standing.structure);
  lean.strains = found.strains;
  lean.wrenches = found.wrenches;
  lean.displacement = displacement_of(rest, found.bent);
  const GaugeReading reading = read_gauge(lean, basis_of(lean.displacement), place_gauge(stem, "base"));
  EXPECT_GT(found.bent.back().end.x(), 1);  // it bends far
  EXPECT_LT((reading.axes * reading.lean.head<3>() - found.wrenches.ground_force).norm(), 1e-9);
  // Levers are those of beams of their length at rest: off by what they stretch, some 1e-6 of it.
  const Vec3 moment = found.wrenches.ground_moment;
  EXPECT_LT((reading.axes * reading.lean.tail<3>() - moment).norm(), 1e-6 * moment.norm());
}

TEST(ReadGauge, OfALeanWithoutWrenchesIsItsElasticAnswer) {
  const Skeleton stem = test::straight_stem(4, 2, 0.04, 0.02);
  const Structure structure = assemble(stem, test::weightless());
  Lean lean = upright(structure);
  lean.displacement = structure.flexibility(test::random_vector(structure.size(), 4));
  const Basis basis = basis_of(lean.displacement);
  const GaugeReading reading = read_gauge(lean, basis, place_gauge(stem, "stem:0.7"));
  EXPECT_EQ(reading.lean, Vec6(reading.per_coordinate.col(1)));
  EXPECT_EQ(reading.per_coordinate.col(0).norm(), 0);
}

TEST(PlaceGauge, FindsTheBaseAPlaceOnTheStemAndABranch) {
  Skeleton skeleton = test::straight_stem(5, 5, 0.05, 0.02);
  skeleton.roots.emplace_back(3, 0, 0);
  for (Branch& branch : skeleton.branches) branch.start_node += branch.start_node > 0 ? 1 : 0;
  skeleton.branches.push_back(test::make_branch(1, Vec3(3, 0, 0), Vec3(3, 0, 1), 0.04, 0.03));
  skeleton.branches.push_back(test::make_branch(3, Vec3(0, 0, 2), Vec3(1, 0, 2), 0.01, 0.01));
  EXPECT_EQ(place_gauge(skeleton, "base").branch, 0);
  EXPECT_EQ(place_gauge(skeleton, "base").place, 0);
  EXPECT_EQ(place_gauge(skeleton, "stem:2.25").branch, 2);
  EXPECT_NEAR(place_gauge(skeleton, "stem:2.25").place, 0.25, 1e-12);
  EXPECT_EQ(place_gauge(skeleton, "stem:0").branch, 0);
  EXPECT_EQ(place_gauge(skeleton, "stem:5").branch, 4);
  EXPECT_EQ(place_gauge(skeleton, "branch:6:0.5").branch, 6);
  EXPECT_EQ(place_gauge(skeleton, "branch:6:0.5").place, 0.5);
  EXPECT_EQ(place_gauge(skeleton, "branch:6:0.5").name, "branch:6:0.5");
  EXPECT_EQ(place_gauge(skeleton, "stem:5.00001").place, 1);  // as a message may round the length
  skeleton.branches[5].start_radius = 0.2;
  EXPECT_EQ(place_gauge(skeleton, "base").branch, 5);
}

std::string complaint(const std::string& text) {
  try {
    place_gauge(test::straight_stem(5, 5, 0.05, 0.02), text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(PlaceGauge, RefusesWhatIsNotOnThePlant) {
  EXPECT_EQ(complaint("stem:7"), "gauge: 'stem:7', wanted 0 to 5 m, the length of the main stem");
  for (const char* text : {"stem:-1", "stem:", "stem:1.3m", "stem:nan", "stem:inf"})
    EXPECT_NE(complaint(text), "") << text;
  for (const char* text : {"", "foot", "branch:", "branch:2", "branch:2:", "branch:2:0.5:1", "branch:x:0"})
    EXPECT_EQ(complaint(text),
              std::string("gauge: '") + text + "', wanted base, stem:METRES or branch:NUMBER:PLACE");
  for (const char* text : {"branch:5:0.5", "branch:-1:0.5", "branch:2:1.1"})
    EXPECT_EQ(complaint(text),
              std::string("gauge: '") + text + "', wanted a branch from 0 to 4 and a place from 0 to 1");
}

TEST(ReadGauge, RefusesGaugesAndShapesOfAnotherStructure) {
  const Structure structure = assemble(test::straight_stem(3, 3, 0.05, 0.03), test::weightless());
  const Basis basis = basis_of(Eigen::VectorXd::Zero(18));
  const Lean lean = upright(structure);
  EXPECT_NO_THROW(read_gauge(lean, basis, {"", 2, 1}));
  EXPECT_THROW(read_gauge(lean, basis, {"", 3, 0}), InputError);
  EXPECT_THROW(read_gauge(lean, basis, {"", -1, 0}), InputError);
  EXPECT_THROW(read_gauge(lean, basis, {"", 0, 1.01}), InputError);
  EXPECT_THROW(read_gauge(lean, basis, {"", 0, std::nan("")}), InputError);
  EXPECT_THROW(read_gauge(lean, basis_of(Eigen::VectorXd::Zero(24)), {"", 0, 0}), InputError);
  const GaugeReading reading = read_gauge(lean, basis, {"", 0, 0});
  Motion motion = motion_of(basis, Eigen::Vector2d(1, 2));
  EXPECT_THROW(gauge_series(reading, motion, std::nan("")), InputError);
  motion.coordinates.conservativeResize(2, 1);
  EXPECT_THROW(gauge_series(reading, motion, 0), InputError);
}

Eigen::VectorXd sine(int samples, int cycles, double mean, double amplitude) {
  Eigen::VectorXd series(samples);
  for (int p = 0; p < samples; ++p) series[p] = mean + amplitude * std::sin(2 * pi * cycles * p / samples);
  return series;
}

TEST(ExtremesOf, ASineCrossItsMeanAtItsFrequency) {
  const Extremes found = extremes_of(sine(400, 6, 3, 2), 12);
  EXPECT_NEAR(found.mean, 3, 1e-12);
  EXPECT_NEAR(found.rms, std::sqrt(2), 1e-12);
  EXPECT_NEAR(found.crossing_rate, 0.5, 1e-12);
  EXPECT_NEAR(found.peak, 5, 1e-3);
  const double root = std::sqrt(2 * std::log(0.5 * 600));
  EXPECT_NEAR(found.peak_factor, root + 0.5772 / root, 1e-5);
  EXPECT_NEAR(found.expected_peak, 3 + found.peak_factor * std::sqrt(2), 1e-12);
}

TEST(ExtremesOf, ASeriesBelowZeroAreOnItsOwnSide) {
  const Extremes up = extremes_of(sine(400, 6, 3, 2), 12, 60),
                 down = extremes_of(-sine(400, 6, 3, 2), 12, 60);
  EXPECT_NEAR(down.peak, -up.peak, 1e-12);
  EXPECT_NEAR(down.expected_peak, -up.expected_peak, 1e-12);
}

TEST(ExtremesOf, WhatStandsStillAndOfWhatIsSlowAreFinite) {
  const Extremes still = extremes_of(Eigen::VectorXd::Constant(7, 4), 2);
  EXPECT_EQ(still.rms, 0);
  EXPECT_EQ(still.crossing_rate, 0);
  EXPECT_EQ(still.expected_peak, 4);
  EXPECT_EQ(extremes_of(Eigen::VectorXd::Constant(1, 4), 2).peak, 4);
  // Fewer than one crossing in the time asked for: never less than the least of the formula.
  EXPECT_NEAR(extremes_of(sine(64, 1, 0, 1), 1000, 10).peak_factor, 1.5195, 1e-4);
  const double nyquist = extremes_of((Eigen::VectorXd(4) << 1, -1, 1, -1).finished(), 2).crossing_rate;
  EXPECT_NEAR(nyquist, 1, 1e-12);
}

// Ten minutes of noise that is white up to 0.8 Hz, many times over: its largest value on the average.
TEST(ExtremesOf, WhiteNoiseExpectTheMeanOfItsMaxima) {
  const double period = 600, band = 0.8;
  const int samples = 9600, bins = static_cast<int>(band * period), draws = 400;
  Eigen::MatrixXcd spectra = Eigen::MatrixXcd::Zero(samples / 2 + 1, draws);
  for (int draw = 0; draw < draws; ++draw) {
    for (int p = 1; p <= bins; ++p)
      spectra(p, draw) = complex_gaussian(
          {7, RandomStream::test, static_cast<std::uint32_t>(p), static_cast<std::uint64_t>(draw)});
  }
  const Eigen::MatrixXd noise = samples_from_half_spectra(spectra, samples);
  double largest = 0, expected = 0, rate = 0;
  for (int draw = 0; draw < draws; ++draw) {
    const Extremes found = extremes_of(noise.col(draw), period);
    largest += noise.col(draw).maxCoeff() / found.rms / draws;
    expected += found.peak_factor / draws;
    rate += found.crossing_rate / draws;
  }
  EXPECT_NEAR(rate, band / std::sqrt(3), 0.01);
  // Maxima scatter by about 0.38 rms; the mean of 400 of them by 0.02.
  EXPECT_NEAR(largest, expected, 0.06);
}

TEST(ExtremesOf, RefuseSeriesAndTimesThatAreNone) {
  EXPECT_THROW(extremes_of({}, 1), InputError);
  EXPECT_THROW(extremes_of(Eigen::Vector2d(1, std::nan("")), 1), InputError);
  EXPECT_THROW(extremes_of(Eigen::Vector2d(1, 2), 0), InputError);
  EXPECT_THROW(extremes_of(Eigen::Vector2d(1, 2), 1, -1), InputError);
  EXPECT_THROW(extremes_of(Eigen::Vector2d(1, 2), 1, std::numeric_limits<double>::infinity()), InputError);
}

// A load per length that the lean knows of is in the reading wherever the gauge sits.
TEST(ReadGauge, OfALeanUnderAnEvenLoadIsTheClosedFormAllAlongTheBranch) {
  const double length = 3, load = 40;
  const Skeleton stem = test::straight_stem(1, length, 0.2, 0.2);
  Lean lean = upright(assemble(stem, test::weightless()));
  const Vec3 force(load * length, 0, 0), half = 0.5 * force;
  const double fixed = load * length * length / 12;
  lean.wrenches.at_end = lean.wrenches.at_start = Eigen::VectorXd::Zero(6);
  lean.wrenches.at_end << half, Vec3(0, -fixed, 0);
  lean.wrenches.at_start << force, Vec3(0, load * length * length / 2, 0);
  const Basis basis = basis_of(Eigen::VectorXd::Zero(6));
  for (const double s : {0.0, 0.2, 0.5, 0.9, 1.0}) {
    const GaugeReading reading = read_gauge(lean, basis, {"here", 0, s});
    const Vec3 moment = reading.axes * reading.lean.tail<3>();
    const double beyond = (1 - s) * length;
    EXPECT_NEAR(moment.y(), load * beyond * beyond / 2, 1e-9) << s;
    EXPECT_NEAR((reading.axes * reading.lean.head<3>()).x(), load * beyond, 1e-9) << s;
  }
}

TEST(MostStrained, AreTheThinPiecesOfAStemInTheOrderOfTheirStress) {
  const double length = 5, force = 30;
  Skeleton stem = test::straight_stem(5, length, 0.05, 0.05);
  for (const auto& [piece, radius] : {std::pair{2, 0.02}, std::pair{4, 0.01}})
    stem.branches[index_of(piece)].start_radius = stem.branches[index_of(piece)].end_radius = radius;
  const Structure structure = assemble(stem, test::weightless());
  Eigen::VectorXd load = Eigen::VectorXd::Zero(structure.size());
  load[6 * 4 + 1] = force;
  const Basis basis = basis_of(structure.flexibility(load));
  const Motion motion = motion_of(basis, Eigen::Vector4d(1, -1, 1, -1));
  // M/r^3 at the feet: 3/0.02^3, 1/0.01^3, 5/0.05^3.
  const std::vector<Gauge> worst = most_strained(upright(structure), motion, 3);
  ASSERT_EQ(worst.size(), 3U);
  EXPECT_EQ(worst[0].branch, 4);
  EXPECT_EQ(worst[1].branch, 2);
  EXPECT_EQ(worst[2].branch, 0);
  EXPECT_EQ(most_strained(upright(structure), motion, 100).size(), 5U);
  EXPECT_TRUE(most_strained(upright(structure), motion, 0).empty());
}

TEST(ExtremesOf, ASeriesWithRarePeaksIsSkewed) {
  EXPECT_NEAR(extremes_of(Eigen::Vector4d(0, 0, 0, 1), 1).skewness, 2 / std::sqrt(3.0), 1e-12);
  EXPECT_NEAR(extremes_of(Eigen::Vector4d(0, 1, 0, 1), 1).skewness, 0, 1e-12);
  EXPECT_EQ(extremes_of(Eigen::Vector4d::Ones(), 1).skewness, 0);
}

}  // namespace
}  // namespace tremula
