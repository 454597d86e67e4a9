#include "tremula/deformation/fit_rig.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <tbb/global_control.h>

#include "structure/random_vector.hpp"
#include "trees.hpp"
#include "tremula/base/error.hpp"
#include "tremula/deformation/bent_pose.hpp"
#include "tremula/numerics/rotation.hpp"

namespace tremula {
namespace {

// A tree that sways about a bent lean by a random shape or two.
struct Case {
  Skeleton skeleton;
  Structure structure;
  Surface surface;
  Motion motion{.period = 3, .basis = {}, .coordinates = 0.5 * test::random_vector(60, 9).reshaped(20, 3)};

  explicit Case(Skeleton of, double lean, double sway, const RootSpring& root = {})
      : skeleton(std::move(of)) {
    surface = mesh_surface(skeleton, {.leaves = false});
    structure = assemble(skeleton, test::weightless({.root = root}));
    motion.lean_strains = lean * test::random_vector(structure.size(), 8);
    for (const Member& member : structure.members) {
      const Vec3 d = member.direction, v = motion.lean_strains.segment<3>(member.end_row);
      motion.lean_strains.segment<3>(member.end_row) = member.beam.length * (v - v.dot(d) * d);
    }
    const std::vector<BentBranch> bent = bend(*structure.tree, motion.lean_strains);
    const BeamTree standing = tree_at(*structure.tree, bent);
    Modes shapes;
    shapes.frequency = Eigen::Vector2d(1, 2);
    shapes.shapes.resize(structure.size(), 2);
    for (Eigen::Index r = 0; r < 2; ++r) {
      const Eigen::VectorXd shape =
          solve_static(standing, test::random_vector(structure.size(), static_cast<std::uint64_t>(40 + r)));
      const double turned = shape.reshaped(6, shape.size() / 6).bottomRows(3).colwise().norm().maxCoeff();
      shapes.shapes.col(r) = sway / turned * shape;
    }
    motion.basis = join(displacement_of(*structure.tree, bent), shapes, {});
    motion.coordinates.col(0).setOnes();
  }

  Rig rig(const RigOptions& options) const {
    const ClipSource clip{"wind loop", &motion};
    return fit_rig(structure, surface, {&clip, 1}, options);
  }

  double error_at(const Rig& rig, double time) const {
    const SurfaceDelta delta = bend_surface(structure, surface, bent_at(structure, motion, time));
    const std::vector<Eigen::Vector3f> skin = skin_on_rig(rig, rig.clips[0], surface, time);
    double error = 0;
    for (std::size_t i = 0; i < skin.size(); ++i)
      error =
          std::max(error, static_cast<double>((surface.position[i] + delta.position[i] - skin[i]).norm()));
    return error;
  }
};

std::string complaint(const Case& c, const RigOptions& options) {
  try {
    c.rig(options);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(FitRig, KeepsTheSkinWithinTheToleranceAtAnyTime) {
  for (const double tolerance : {0.05, 0.02}) {
    const Case c(test::awkward_tree(), 0.1, 0.5);
    const Rig rig = c.rig({.tolerance = tolerance});
    EXPECT_LE(rig.largest_error, tolerance);
    for (const double time : {0.0, 0.123, 1.0, 2.2222, 2.99})
      EXPECT_LE(c.error_at(rig, time), 1.1 * tolerance);
  }
}

TEST(FitRig, FollowsAStemBentToOneSideOnFewJoints) {
  const Case c(test::straight_stem(20, 4, 0.05, 0.02), 0, 0.8);
  const Rig rig = c.rig({.tolerance = 0.02});
  EXPECT_LE(rig.joints.size(), 7U);
  EXPECT_LE(rig.largest_error, 0.02);
}

TEST(FitRig, OfWhatStandsStillIsItsRootAlone) {
  const Case c(test::straight_stem(5, 4, 0.05, 0.02), 0, 1e-6);
  EXPECT_EQ(c.rig({.tolerance = 0.01}).joints.size(), 1U);
}

TEST(FitRig, OfASlightSwayDoesNotStandStill) {
  const Case slight(test::straight_stem(20, 4, 0.05, 0.02), 0, 0.02),
      still(test::straight_stem(20, 4, 0.05, 0.02), 0, 1e-6);
  const Rig rig = slight.rig({.tolerance = 0.1});
  EXPECT_GT(rig.joints.size(), 1U);
  EXPECT_LE(rig.largest_error, 0.02);
  EXPECT_EQ(still.rig({.tolerance = 0.1}).joints.size(), 1U);
}

TEST(FitRig, OnGroundThatGivesWayMovesTheFoot) {
  const Case c(test::straight_stem(5, 2, 0.05, 0.02), 0.05, 0.3, {.translation = 1e3, .rotation = 1e2});
  const Rig rig = c.rig({.tolerance = 0.005});
  ASSERT_GE(rig.joints.size(), 2U);
  EXPECT_EQ(rig.joints[1].name, "foot 0");
  EXPECT_TRUE(rig.joints[1].travels);
  EXPECT_LE(c.error_at(rig, 1.111), 0.0055);
}

TEST(FitRig, GivesSharesThatAddUpAndParentsBeforeChildren) {
  const Case c(test::awkward_tree(), 0.1, 0.5);
  const Rig rig = c.rig({.tolerance = 0.01});
  for (const JointShares& shares : rig.shares) {
    int sum = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      sum += shares.share[i];
      EXPECT_LT(shares.joint[i], rig.joints.size());
    }
    EXPECT_EQ(sum, 255);
  }
  for (std::size_t j = 0; j < rig.joints.size(); ++j) EXPECT_LT(rig.joints[j].parent, static_cast<int>(j));
}

TEST(FitRig, IsTheSameOnAnyNumberOfThreads) {
  const Case c(test::awkward_tree(), 0.1, 0.5);
  const Rig many = c.rig({.tolerance = 0.01, .shapes_of = 0});
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const Rig alone = c.rig({.tolerance = 0.01, .shapes_of = 0});
  ASSERT_EQ(many.joints.size(), alone.joints.size());
  EXPECT_EQ(many.largest_error, alone.largest_error);
  EXPECT_EQ(many.shapes.turn, alone.shapes.turn);
  for (std::size_t j = 0; j < many.joints.size(); ++j) {
    EXPECT_EQ(many.joints[j].name, alone.joints[j].name);
    EXPECT_EQ(many.clips[0].tracks[j].turn, alone.clips[0].tracks[j].turn);
  }
  for (std::size_t i = 0; i < many.shares.size(); ++i) {
    EXPECT_EQ(many.shares[i].joint, alone.shares[i].joint);
    EXPECT_EQ(many.shares[i].share, alone.shares[i].share);
  }
}

// The joints of one sample, put together from the shapes and from the keys.
TEST(FitRig, TellsShapesThatAddUpToTheClipToFirstOrder) {
  const auto largest_difference = [](double sway) {
    const Case c(test::awkward_tree(), 0.1, sway, {.translation = 1e3, .rotation = 1e2});
    const Rig rig = c.rig({.tolerance = 1e-3, .shapes_of = 0});
    const RigShapes& shapes = rig.shapes;
    EXPECT_EQ(shapes.clip, 0);
    EXPECT_EQ(shapes.kind, c.motion.basis.kind);
    EXPECT_EQ(shapes.coordinates, c.motion.coordinates);
    double difference = 0, turned = 0, travelled = 0;
    for (const int sample : {0, 7, 13}) {
      const double time = c.motion.period * sample / c.motion.sample_count();
      const std::vector<JointFrame> frames = joint_frames(rig, rig.clips[0], time);
      for (std::size_t j = 1; j < rig.joints.size(); ++j) {
        const JointFrame& below = frames[index_of(rig.joints[j].parent)];
        const auto row = static_cast<Eigen::Index>(3 * j);
        const Eigen::VectorXf y = shapes.coordinates.row(sample).transpose().cast<float>();
        const auto moving = [&](const Eigen::MatrixXf& of_joints) -> Vec3 {
          return (of_joints.middleRows<3>(row).rightCols(y.size() - 1) * y.tail(y.size() - 1)).cast<double>();
        };
        const Vec3 lean = shapes.turn.col(0).segment<3>(row).cast<double>(), turn = moving(shapes.turn);
        const Mat3 put_together = rotation_matrix(lean) * rotation_matrix(turn);
        difference = std::max(difference, (below.turn.transpose() * frames[j].turn - put_together).norm());
        turned = std::max(turned, turn.norm());
        if (!rig.joints[j].travels) continue;
        const Vec3 rest = rig.joints[j].position - rig.joints[index_of(rig.joints[j].parent)].position;
        const Vec3 travel = moving(shapes.travel);
        const Vec3 place = rest + shapes.travel.col(0).segment<3>(row).cast<double>() + travel;
        difference = std::max(
            difference, (below.turn.transpose() * (frames[j].position - below.position) - place).norm());
        travelled = std::max(travelled, travel.norm());
      }
    }
    EXPECT_GT(turned, 0.05 * sway);
    EXPECT_GT(travelled, 0);
    return difference;
  };
  const double small = largest_difference(0.1), large = largest_difference(0.4);
  EXPECT_LT(small, 0.01);
  EXPECT_GT(large, 4 * small);
}

TEST(FitRig, TellsNoShapesUnlessAsked) {
  const Case c(test::awkward_tree(), 0.1, 0.5);
  EXPECT_EQ(c.rig({.tolerance = 0.05}).shapes.clip, -1);
  EXPECT_EQ(complaint(c, {.tolerance = 0.05, .shapes_of = 1}),
            "clip whose shapes the rig tells: 1, wanted -1 (none) to 0");
}

TEST(FitRig, RefusesWhatItCannotFit) {
  Case c(test::awkward_tree(), 0.1, 0.5);
  EXPECT_EQ(complaint(c, {.tolerance = 0}), "tolerance of the rig: 0.000000, wanted metres above 0");
  EXPECT_NE(complaint(c, {.tolerance = std::numeric_limits<double>::quiet_NaN()}), "");
  EXPECT_EQ(complaint(c, {.tolerance = 0.1, .max_joints = 1}),
            "most joints of the rig: 1, wanted 2 or more (0: as many as it takes)");
  c.motion.lean_strains.resize(0);
  EXPECT_EQ(complaint(c, {.tolerance = 0.1}),
            "motion of clip 'wind loop': displacements that superpose, wanted one that bends "
            "(Motion::lean_strains)");
}

TEST(LinearPoseError, GrowsWithTheSquareOfTheSway) {
  const Case little(test::awkward_tree(), 0.1, 0.05), more(test::awkward_tree(), 0.1, 0.1);
  const double a = linear_pose_error(little.structure, little.surface, little.motion),
               b = linear_pose_error(more.structure, more.surface, more.motion);
  EXPECT_NEAR(b / a, 4, 0.4);
}

}  // namespace
}  // namespace tremula
