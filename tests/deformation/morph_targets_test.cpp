#include "tremula/deformation/morph_targets.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>

#include "trees.hpp"
#include "tremula/base/error.hpp"

namespace tremula {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

double random_number(int what, int i) {  // -1 … 1
  return 2 * uniform(
                 {7, RandomStream::test, static_cast<std::uint32_t>(what), static_cast<std::uint64_t>(i)}) -
         1;
}

Eigen::MatrixXd random_matrix(Eigen::Index rows, Eigen::Index columns, int what) {
  Eigen::MatrixXd matrix(rows, columns);
  for (Eigen::Index i = 0; i < matrix.size(); ++i)
    matrix.data()[i] = random_number(what, static_cast<int>(i));
  return matrix;
}

// A tree, a few points around its branches, and a motion without any order in it: y crosses zero everywhere.
struct Case {
  Skeleton skeleton = test::random_tree(12, 3);
  Surface surface;
  Structure structure = assemble(skeleton, test::weightless());
  Motion motion;

  explicit Case(int mode_count = 4, int sample_count = 30) {
    for (int branch = 0; branch < skeleton.branch_count(); ++branch) {
      for (const double s : {0.0, 0.4, 1.0}) {
        const Branch& b = skeleton.branches[static_cast<std::size_t>(branch)];
        const Vec3 side = (b.end - b.start).unitOrthogonal();
        surface.position.push_back((b.start + s * (b.end - b.start) + b.start_radius * side).cast<float>());
        surface.normal.push_back(side.cast<float>());
        surface.branch.push_back(branch);
        surface.along.push_back(static_cast<float>(s));
      }
    }
    const Eigen::Index rows = structure.size();
    Modes modes;
    modes.frequency = Eigen::VectorXd::LinSpaced(mode_count, 0.5716, 3);
    modes.shapes = 0.01 * random_matrix(rows, mode_count, 0);
    motion.period = 7.3;
    motion.basis = join(0.02 * random_matrix(rows, 1, 2), modes, {});
    motion.coordinates = Eigen::MatrixXd::Ones(sample_count, 1 + mode_count);
    motion.coordinates.rightCols(mode_count) = 3 * random_matrix(sample_count, mode_count, 1);
  }

  // The last mode turned into a static shape: the same motion by another name.
  Case& with_static_shape() {
    motion.basis.kind.back() = ShapeKind::static_shape;
    return *this;
  }

  int mode_count() const { return motion.basis.count(ShapeKind::mode); }
  auto mode(int r) { return motion.coordinates.col(1 + r); }
  auto mode(int r) const { return motion.coordinates.col(1 + r); }

  Loop loop() const { return make_loop(structure, surface, motion, {}); }
  MorphTargets morphs(MorphForm form) const { return make_morph_targets(loop(), form); }
};

constexpr std::array all_forms{MorphForm::signed_weights, MorphForm::biased, MorphForm::paired};

// What a player does that knows keys and weights only.
std::vector<double> play(const MorphTargets& morphs, double time) {
  const auto after = std::upper_bound(morphs.times.begin(), morphs.times.end() - 1, time);
  const auto k = static_cast<std::size_t>(std::max<std::ptrdiff_t>(after - morphs.times.begin(), 1));
  const double begin = morphs.times[k - 1], end = morphs.times[k];
  std::vector<double> weights;
  for (std::size_t i = 0; i < morphs.target_count(); ++i) {
    const double a = morphs.weight(k - 1, i), b = morphs.weight(k, i);
    weights.push_back(a + (b - a) * (time - begin) / (end - begin));
  }
  return weights;
}

// The largest difference between the surface as played and as displacement_at() has it, over many instants,
// as a part of the largest movement.
double worst_error(const Case& c, const MorphTargets& morphs) {
  double worst = 0, largest = 0;
  for (int i = 0; i < 400; ++i) {
    const double time = c.motion.period * (random_number(3, i) + 1) / 2;
    const SurfaceDelta wanted = deform_surface(c.structure, c.surface, displacement_at(c.motion, time));
    const std::vector<double> weights = play(morphs, time);
    for (std::size_t v = 0; v < c.surface.vertex_count(); ++v) {
      Vec3 moved = Vec3::Zero(), turned = Vec3::Zero();
      for (std::size_t t = 0; t < weights.size(); ++t) {
        const MorphTarget& target = morphs.targets[t];
        const SurfaceDelta& shape = morphs.shapes[static_cast<std::size_t>(target.shape)];
        const double weight = (weights[t] - target.rest) * target.sign;
        moved += weight * shape.position[v].cast<double>();
        turned += weight * shape.normal[v].cast<double>();
      }
      worst = std::max(worst, (moved - wanted.position[v].cast<double>()).norm());
      worst = std::max(worst, (turned - wanted.normal[v].cast<double>()).norm());
      largest = std::max<double>(largest, wanted.position[v].norm());
    }
  }
  return worst / largest;
}

// Weights, shapes and instants are floats; between samples y changes by several times its size per second.
constexpr double float_error = 2e-5;

TEST(MorphTargets, SignedWeightsGiveTheMotionAtAnyTime) {
  const Case c;
  EXPECT_LT(worst_error(c, c.morphs(MorphForm::signed_weights)), float_error);
}

TEST(MorphTargets, BiasedWeightsGiveTheMotionAtAnyTime) {
  const Case c;
  EXPECT_LT(worst_error(c, c.morphs(MorphForm::biased)), float_error);
}

TEST(MorphTargets, StaticShapesMoveLikeModesAndAreNamedForWhatTheyAre) {
  const Case c = Case(3).with_static_shape();
  for (const MorphForm form : all_forms) {
    const MorphTargets morphs = c.morphs(form);
    EXPECT_LT(worst_error(c, morphs), float_error);
    EXPECT_EQ(morphs.frequencies.size(), 2U);
    EXPECT_EQ(morphs.static_shape_count, 1);
    const MorphTarget& last = morphs.targets.back();
    EXPECT_EQ(last.name, form == MorphForm::paired ? "static 1 -" : "static 1");
    EXPECT_EQ(last.kind, ShapeKind::static_shape);
    EXPECT_EQ(last.number, 0);
  }
}

TEST(MorphTargets, PairedWeightsGiveTheMotionAtAnyTime) {
  const Case c;
  EXPECT_LT(worst_error(c, c.morphs(MorphForm::paired)), float_error);
}

TEST(MorphTargets, PairedWeightsNeedTheKeysAtTheZeroCrossings) {
  const Case c;
  MorphTargets morphs = c.morphs(MorphForm::paired);
  // Without them, a mode that changes its sign between two samples would move both ways at once.
  MorphTargets sampled = morphs;
  sampled.times.clear();
  sampled.weights.clear();
  const MorphTargets samples = c.morphs(MorphForm::signed_weights);
  for (std::size_t k = 0; k < morphs.key_count(); ++k) {
    if (!std::binary_search(samples.times.begin(), samples.times.end(), morphs.times[k])) continue;
    sampled.times.push_back(morphs.times[k]);
    for (std::size_t t = 0; t < morphs.target_count(); ++t) sampled.weights.push_back(morphs.weight(k, t));
  }
  ASSERT_EQ(sampled.key_count(), samples.key_count());
  // The sum of both halves is still right; what is wrong is that they overlap.
  double overlap = 0, overlap_without = 0;
  for (int i = 0; i < 400; ++i) {
    const double time = c.motion.period * (random_number(4, i) + 1) / 2;
    const std::vector<double> with = play(morphs, time), without = play(sampled, time);
    for (std::size_t t = 1; t + 1 < with.size(); t += 2) {
      ASSERT_EQ(morphs.targets[t].number, morphs.targets[t + 1].number);
      overlap = std::max(overlap, with[t] * with[t + 1]);
      overlap_without = std::max(overlap_without, without[t] * without[t + 1]);
    }
  }
  EXPECT_EQ(overlap, 0);
  EXPECT_GT(overlap_without, 0.01);
}

TEST(MorphTargets, WeightsOfAModeSpanOne) {
  const Case c;
  for (const MorphForm form : all_forms) {
    const MorphTargets morphs = c.morphs(form);
    const float least = form == MorphForm::signed_weights ? -1 : 0;
    for (const float weight : morphs.weights) {
      EXPECT_GE(weight, least);
      EXPECT_LE(weight, 1);
      EXPECT_FALSE(weight == 0 && std::signbit(weight));
    }
    for (int mode = 0; mode < c.mode_count(); ++mode) {
      float low = 1, high = -1;
      for (std::size_t k = 0; k < morphs.key_count(); ++k) {
        float sum = 0;
        for (std::size_t t = 0; t < morphs.target_count(); ++t) {
          const MorphTarget& target = morphs.targets[t];
          if (target.kind == ShapeKind::mode && target.number == mode)
            sum += target.sign * (morphs.weight(k, t) - target.rest);
        }
        low = std::min(low, sum);
        high = std::max(high, sum);
      }
      EXPECT_NEAR(high - low, 1, 1e-6);
    }
  }
}

TEST(MorphTargets, KeysIncreaseFromZeroToThePeriod) {
  const Case c;
  for (const MorphForm form : all_forms) {
    const MorphTargets morphs = c.morphs(form);
    ASSERT_GE(morphs.key_count(), 31U);
    EXPECT_EQ(morphs.times.front(), 0);
    EXPECT_EQ(morphs.times.back(), static_cast<float>(c.motion.period));
    EXPECT_EQ(std::adjacent_find(morphs.times.begin(), morphs.times.end(), std::greater_equal<>()),
              morphs.times.end());
  }
}

TEST(MorphTargets, TheLastKeyIsTheFirstBitForBit) {
  const Case c;
  for (const MorphForm form : all_forms) {
    const MorphTargets morphs = c.morphs(form);
    const std::size_t row = morphs.target_count(), last = (morphs.key_count() - 1) * row;
    ASSERT_EQ(morphs.weights.size(), last + row);
    EXPECT_EQ(std::memcmp(&morphs.weights[0], &morphs.weights[last], row * sizeof(float)), 0);
  }
}

TEST(MorphTargets, SampledKeysHoldTheSamples) {
  const Case c;
  const MorphTargets morphs = c.morphs(MorphForm::signed_weights);
  ASSERT_EQ(morphs.key_count(), 31U);
  for (int mode = 0; mode < c.mode_count(); ++mode) {
    const Eigen::VectorXd y = c.mode(mode);
    const double span = y.maxCoeff() - y.minCoeff();
    for (int p = 0; p < 30; ++p) {
      EXPECT_EQ(morphs.weight(static_cast<std::size_t>(p), static_cast<std::size_t>(mode) + 1),
                static_cast<float>(y[p] / span));
    }
  }
}

std::vector<std::string> names(const MorphTargets& morphs) {
  std::vector<std::string> result;
  for (const MorphTarget& target : morphs.targets) result.push_back(target.name);
  return result;
}

TEST(MorphTargets, BiasedWeightsSpanZeroToOneAroundTheirRest) {
  Case c(3);
  c.mode(1) = c.mode(1).cwiseAbs();   // rests at one end
  c.mode(2) = -c.mode(2).cwiseAbs();  // and at the other
  const MorphTargets morphs = c.morphs(MorphForm::biased);
  ASSERT_EQ(morphs.target_count(), 4U);
  EXPECT_EQ(morphs.targets[0].rest, 0);
  const double low = c.mode(0).minCoeff(), high = c.mode(0).maxCoeff();
  EXPECT_EQ(morphs.targets[1].rest, static_cast<float>(-low / (high - low)));
  EXPECT_EQ(morphs.targets[2].rest, 0);
  EXPECT_EQ(morphs.targets[3].rest, 1);
  float least = 1, most = 0;
  for (std::size_t k = 0; k < morphs.key_count(); ++k) {
    least = std::min(least, morphs.weight(k, 1));
    most = std::max(most, morphs.weight(k, 1));
  }
  EXPECT_EQ(least, 0);
  EXPECT_EQ(most, 1);
  EXPECT_LT(worst_error(c, morphs), float_error);
}

TEST(MorphTargets, TakeTheFootOfAStemOnASpringAlong) {
  Case c;
  EXPECT_EQ(c.morphs(MorphForm::paired).shapes[0].position[0].norm(), 0);
  c.structure = assemble(c.skeleton, test::weightless({.root = {.rotation = 1e4}}));
  const MorphTargets morphs = c.morphs(MorphForm::paired);
  const SurfaceDelta lean = deform_surface(c.structure, c.surface, lean_of(c.motion.basis));
  EXPECT_EQ(morphs.shapes[0].position, lean.position);
  EXPECT_GT(lean.position[0].norm(), 1e-5F);  // turned with the foot
}

TEST(MorphTargets, AreNamedByModeAndFrequency) {
  const Case c(2);
  EXPECT_THAT(names(c.morphs(MorphForm::signed_weights)),
              ElementsAre("mean lean", "mode 01 0.572 Hz", "mode 02 3.000 Hz"));
  EXPECT_THAT(names(c.morphs(MorphForm::biased)),
              ElementsAre("mean lean", "mode 01 0.572 Hz", "mode 02 3.000 Hz"));
  EXPECT_THAT(names(c.morphs(MorphForm::paired)),
              ElementsAre("mean lean", "mode 01 0.572 Hz +", "mode 01 0.572 Hz -", "mode 02 3.000 Hz +",
                          "mode 02 3.000 Hz -"));
}

TEST(MorphTargets, NamesSortInTheOrderOfTheModes) {
  const std::vector<std::string> all = names(Case(120, 3).morphs(MorphForm::paired));
  EXPECT_TRUE(std::is_sorted(all.begin() + 1, all.end(), [](const std::string& a, const std::string& b) {
    return a.substr(0, 8) < b.substr(0, 8);
  }));
  EXPECT_THAT(all.back(), HasSubstr("mode 120"));
}

TEST(MorphTargets, WhatDoesNotMoveGetsNone) {
  Case c(3);
  c.mode(1).setZero();
  c.motion.basis.columns.col(0).setZero();
  const MorphTargets morphs = c.morphs(MorphForm::signed_weights);
  ASSERT_EQ(morphs.target_count(), 2U);
  EXPECT_EQ(morphs.targets[0].kind, ShapeKind::mode);
  EXPECT_EQ(morphs.targets[0].number, 0);
  EXPECT_EQ(morphs.targets[1].number, 2);
  EXPECT_LT(worst_error(c, morphs), float_error);
  EXPECT_EQ(morphs.frequencies.size(), 3U);

  c.motion.coordinates.rightCols(3).setZero();
  EXPECT_EQ(c.morphs(MorphForm::paired).target_count(), 0U);
}

TEST(MorphTargets, AModeThatBendsOneWayOnlyGetsOneOfThePair) {
  Case c(2);
  c.mode(0) = c.mode(0).cwiseAbs();
  c.mode(1) = -c.mode(1).cwiseAbs();
  const MorphTargets morphs = c.morphs(MorphForm::paired);
  EXPECT_THAT(names(morphs), ElementsAre("mean lean", "mode 01 0.572 Hz +", "mode 02 3.000 Hz -"));
  EXPECT_LT(worst_error(c, morphs), float_error);
}

TEST(MorphTargets, CrossingsAtOneInstantShareAKey) {
  Case c(2, 4);
  c.mode(0) << 1, -1, -1, 1;
  c.mode(1) << -2, 2, 2, 3;
  const MorphTargets morphs = c.morphs(MorphForm::paired);
  // Samples 0 … 4, both modes half way to sample 1, the first half way to 3, the second on its way back to 0.
  EXPECT_EQ(morphs.key_count(), 5U + 3U);
  EXPECT_LT(worst_error(c, morphs), float_error);
}

std::string message_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const Error& error) {
    return error.what();
  }
  return "accepted";
}

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

TEST(MorphTargets, StagesThatDoNotFitAreRejected) {
  const auto message = [](const auto& spoil) {
    Case c;
    spoil(c);
    return message_of([&] { c.morphs(MorphForm::paired); });
  };
  EXPECT_EQ(message([](Case&) {}), "accepted");
  EXPECT_THAT(message([](Case& c) { c.motion.coordinates.conservativeResize(30, 4); }),
              HasSubstr("columns of the coordinates: 4, wanted 5"));
  EXPECT_THAT(message([](Case& c) { c.motion.basis.columns.conservativeResize(66, 5); }),
              HasSubstr("rows of the motion: 66, wanted 72"));
  EXPECT_THAT(message([](Case& c) { c.motion.basis.columns.conservativeResize(72, 4); }),
              HasSubstr("columns of the basis: 4, wanted 5"));
  EXPECT_THAT(message([](Case& c) { c.motion.basis.frequency.conservativeResize(4); }),
              HasSubstr("kinds of the shapes: 5, wanted 4"));
  EXPECT_THAT(message([](Case& c) { c.with_static_shape().motion.basis.kind.pop_back(); }),
              HasSubstr("kinds of the shapes: 4, wanted 5"));
  EXPECT_THAT(message([](Case& c) { c.motion.coordinates.resize(0, 5); }),
              HasSubstr("samples of the motion: 0"));
  EXPECT_THAT(message([](Case& c) { c.structure = assemble(test::random_tree(11, 3), test::weightless()); }),
              HasSubstr("rows of the motion: 72, wanted 66"));
  EXPECT_THAT(message([](Case& c) { c.surface.branch[5] = 12; }), HasSubstr("branch of a vertex: 12"));
  EXPECT_THAT(message([](Case& c) { c.motion.coordinates(3, 2) = nan; }), HasSubstr("not finite"));
  EXPECT_THAT(message([](Case& c) { c.motion.basis.columns(3, 0) = nan; }), HasSubstr("not finite"));
  EXPECT_THAT(message([](Case& c) { c.motion.basis.columns(3, 2) = nan; }), HasSubstr("not finite"));
  EXPECT_THAT(message([](Case& c) { c.motion.period = 0; }), HasSubstr("period"));
  EXPECT_THAT(message([](Case& c) { c.motion.period = nan; }), HasSubstr("period"));
}

TEST(MorphTargets, LoopsThatDoNotFitAreRejected) {
  const auto message = [](const auto& spoil) {
    Loop loop = Case().loop();
    spoil(loop);
    return message_of([&] { make_morph_targets(loop, MorphForm::paired); });
  };
  EXPECT_EQ(message([](Loop&) {}), "accepted");
  EXPECT_THAT(message([](Loop& loop) { loop.coordinates.conservativeResize(30, 4); }),
              HasSubstr("number of kinds is 5, wanted 4"));
  EXPECT_THAT(message([](Loop& loop) { loop.frequency.conservativeResize(4); }),
              HasSubstr("number of frequencies is 4, wanted 5"));
  EXPECT_THAT(message([](Loop& loop) { loop.coordinates.resize(0, 5); }), HasSubstr("no samples"));
  EXPECT_THAT(message([](Loop& loop) { loop.coordinates(3, 2) = nan; }), HasSubstr("not finite"));
  EXPECT_THAT(message([](Loop& loop) { loop.frequency[2] = nan; }), HasSubstr("not finite"));
  EXPECT_THAT(message([](Loop& loop) { loop.period = 0; }), HasSubstr("period"));
  EXPECT_THAT(message([](Loop& loop) { loop.period = nan; }), HasSubstr("period"));
}

TEST(MorphTargets, SamplesCloserThanFloatsAreRejected) {
  Loop loop;
  loop.period = 1.5;
  loop.coordinates.resize(1 << 10, 0);
  EXPECT_NO_THROW(make_morph_targets(loop, MorphForm::signed_weights));
  loop.coordinates.resize(1 << 24, 0);
  EXPECT_THROW(make_morph_targets(loop, MorphForm::signed_weights), Error);
}

std::vector<double> weights_at(const std::vector<float>& times, const std::vector<float>& weights,
                               double time) {
  const std::size_t count = weights.size() / times.size();
  std::size_t k = 1;
  while (k + 1 < times.size() && static_cast<double>(times[k]) < time) ++k;
  const auto begin = static_cast<double>(times[k - 1]), end = static_cast<double>(times[k]);
  const double part = (time - begin) / (end - begin);
  std::vector<double> result;
  for (std::size_t t = 0; t < count; ++t) {
    result.push_back((1 - part) * static_cast<double>(weights[(k - 1) * count + t]) +
                     part * static_cast<double>(weights[k * count + t]));
  }
  return result;
}

TEST(WeightsOf, AreThoseOfTheLoopAtAnotherTimeAndCloseAsItDoes) {
  const Case c;
  for (const MorphForm form : {MorphForm::signed_weights, MorphForm::biased, MorphForm::paired}) {
    const MorphTargets morphs = make_morph_targets(c.loop(), form);
    const double period = morphs.period, step = period / 50;
    const auto exact = static_cast<double>(morphs.times[3]);
    for (const double shift :
         {0.0, 0.3 * period, -0.4 * period, 7.77 * period, exact, period, period - 1e-9}) {
      const WeightTable table = weights_of(morphs, {.time_shift = shift});
      ASSERT_EQ(table.weights.size(), table.times.size() * morphs.target_count());
      EXPECT_EQ(table.times.front(), 0);
      EXPECT_EQ(table.times.back(), morphs.times.back());
      for (std::size_t k = 1; k < table.times.size(); ++k)
        ASSERT_LT(table.times[k - 1], table.times[k]) << shift;
      EXPECT_TRUE(std::equal(table.weights.begin(),
                             table.weights.begin() + static_cast<std::ptrdiff_t>(morphs.target_count()),
                             table.weights.end() - static_cast<std::ptrdiff_t>(morphs.target_count())));
      for (double time = 0; time < period; time += step) {
        const double there = time + shift - period * std::floor((time + shift) / period);
        const auto found = weights_at(table.times, table.weights, time);
        const auto wanted = weights_at(morphs.times, morphs.weights, there);
        for (std::size_t t = 0; t < found.size(); ++t)
          ASSERT_NEAR(found[t], wanted[t], 2e-5) << shift << ' ' << time;
      }
    }
  }
}

}  // namespace
}  // namespace tremula
