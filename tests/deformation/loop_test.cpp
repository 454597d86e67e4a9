#include "tremula/deformation/loop.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <functional>

#include "trees.hpp"
#include "tremula/base/error.hpp"

namespace tremula {
namespace {

// A plant with two stems, and a motion without any order in it, of every kind of shape.
struct Case {
  Skeleton skeleton = test::awkward_tree();
  Structure structure;
  Surface surface = mesh_surface(skeleton);
  Motion motion{.period = 3, .basis = {}, .coordinates = Eigen::MatrixXd::Random(10, 5)};
  LoopFacts facts{.name = "plant", .frames_per_second = 10, .wind_speed = 7, .heading = 40, .seed = 3};

  explicit Case(const RootSpring& root = {})
      : structure(assemble(skeleton, test::weightless({.root = root}))) {
    const Eigen::Index rows = structure.size();
    Modes modes;
    modes.frequency = Eigen::Vector3d(1, 2, 3);
    modes.shapes = 0.02 * Eigen::MatrixXd::Random(rows, 3);
    motion.basis = join(0.02 * Eigen::VectorXd::Random(rows), modes,
                        {Eigen::VectorXd::Constant(1, 9), 0.02 * Eigen::MatrixXd::Random(rows, 1)});
    motion.coordinates.col(0).setOnes();
  }

  Loop loop() const { return make_loop(structure, surface, motion, facts); }
};

constexpr RootSpring soft{.translation = 1e5, .rotation = 1e4};
constexpr double times[] = {0, 0.9, 1.234, 2.95, 3, -4.5, 30.1};
// Of a vertex, and of what it moves by [m].
constexpr double float_error = 1e-7;

TEST(MakeLoop, SaysWhatTheMotionAndTheSurfaceAreAndOutlivesThem) {
  const Case c;
  const Loop loop = Case(c).loop();
  EXPECT_EQ(loop.facts.name, "plant");
  EXPECT_EQ(loop.facts.frames_per_second, 10);
  EXPECT_EQ(loop.facts.wind_speed, 7);
  EXPECT_EQ(loop.facts.heading, 40);
  EXPECT_EQ(loop.facts.seed, 3U);
  EXPECT_EQ(loop.period, 3);
  EXPECT_EQ(loop.sample_count(), 10);
  EXPECT_EQ(loop.kind, c.motion.basis.kind);
  EXPECT_EQ(loop.frequency, c.motion.basis.frequency);
  EXPECT_EQ(loop.coordinates, c.motion.coordinates);
  EXPECT_EQ(loop.rest->position, c.surface.position);
  ASSERT_EQ(loop.rest->parts.size(), c.surface.parts.size());
  EXPECT_EQ(loop.rest->parts[0].triangles, c.surface.parts[0].triangles);
  ASSERT_EQ(loop.nodes.cols(), c.skeleton.node_count());
  for (int node = 0; node < c.skeleton.node_count(); ++node)
    EXPECT_EQ(Vec3(loop.nodes.col(node)), c.skeleton.node_position(node));
}

TEST(SkinAt, IsTheSumOfTheShapesOfTheSkinTimesTheCoordinatesOfASample) {
  for (const RootSpring& root : {RootSpring{}, soft}) {
    const Loop loop = Case(root).loop();
    for (int p = 0; p < loop.sample_count(); ++p) {
      const SurfaceDelta found = loop.skin_at(p * loop.period / loop.sample_count());
      ASSERT_EQ(found.position.size(), loop.rest->vertex_count());
      std::vector<Vec3> position(found.position.size(), Vec3::Zero()), normal = position;
      double largest = 0;
      for (Eigen::Index c = 0; c < loop.coordinates.cols(); ++c) {
        const double weight = loop.coordinates(p, c);
        const SurfaceDelta one = loop.shape_of_skin(c, 1), weighted = loop.shape_of_skin(c, weight);
        for (std::size_t v = 0; v < position.size(); ++v) {
          position[v] += weight * one.position[v].cast<double>();
          normal[v] += weight * one.normal[v].cast<double>();
          EXPECT_LT((weight * one.position[v].cast<double>() - weighted.position[v].cast<double>()).norm(),
                    float_error);
        }
      }
      for (std::size_t v = 0; v < position.size(); ++v) {
        EXPECT_LT((position[v] - found.position[v].cast<double>()).norm(), float_error);
        EXPECT_LT((normal[v] - found.normal[v].cast<double>()).norm(), float_error);
        largest = std::max(largest, position[v].norm());
      }
      EXPECT_GT(largest, 0.01);
    }
  }
}

TEST(SkinAt, IsTheDeformedSurfaceAtAnyTimeAndClosesBitForBit) {
  const Case c(soft);
  const Loop loop = c.loop();
  for (const double time : times) {
    const SurfaceDelta wanted = deform_surface(c.structure, c.surface, displacement_at(c.motion, time));
    EXPECT_EQ(loop.skin_at(time).position, wanted.position) << time;
    EXPECT_EQ(loop.skin_at(time).normal, wanted.normal) << time;
  }
  EXPECT_EQ(loop.skin_at(0).position, loop.skin_at(loop.period).position);
}

TEST(NodesAt, AreTheNodesOfTheDisplacementAtAnyTime) {
  for (const RootSpring& root : {RootSpring{}, soft}) {
    const Case c(root);
    const Loop loop = c.loop();
    for (const double time : times) {
      const Eigen::VectorXd displacement = displacement_at(c.motion, time);
      const NodePoses poses = loop.nodes_at(time);
      ASSERT_EQ(poses.cols(), loop.nodes.cols());
      for (Eigen::Index node = 0; node < poses.cols(); ++node) {
        EXPECT_EQ(Vec6(poses.col(node)),
                  node_displacement(c.structure, displacement, static_cast<std::size_t>(node)));
      }
    }
    EXPECT_EQ(loop.nodes_at(0), loop.nodes_at(loop.period));
  }
}

// How far the lowest ring of every stem is from where its root takes it.
double farthest_from_the_feet(const Case& c, double time) {
  const Loop loop = c.loop();
  const SurfaceDelta skin = loop.skin_at(time);
  const NodePoses poses = loop.nodes_at(time);
  double farthest = 0;
  for (int root = 0; root < c.skeleton.root_count(); ++root) {
    int seen = 0;
    for (std::size_t v = 0; v < c.surface.vertex_count(); ++v) {
      const auto branch = static_cast<std::size_t>(c.surface.branch[v]);
      if (c.skeleton.branches[branch].start_node != root || c.surface.along[v] != 0) continue;
      const Vec3 arm =
          c.surface.position[v].cast<double>() - c.skeleton.roots[static_cast<std::size_t>(root)];
      const Vec3 translation = poses.col(root).head<3>(), rotation = poses.col(root).tail<3>();
      const Vec3 moved = translation + rotation.cross(arm);
      farthest = std::max(farthest, (skin.position[v].cast<double>() - moved).norm());
      ++seen;
    }
    EXPECT_GT(seen, 2) << "root " << root;
  }
  return farthest;
}

TEST(NodesAt, TakeTheFootOfASoftRootAlongAsTheSkinDoes) {
  const Case on_springs(soft), clamped;
  for (const double time : times) {
    const NodePoses moved = on_springs.loop().nodes_at(time), still = clamped.loop().nodes_at(time);
    for (int root = 0; root < 2; ++root) {
      EXPECT_GT(moved.col(root).head<3>().norm(), 1e-4) << time;
      EXPECT_GT(moved.col(root).tail<3>().norm(), 1e-4) << time;
      EXPECT_EQ(still.col(root).norm(), 0) << time;
    }
    EXPECT_LT(farthest_from_the_feet(on_springs, time), float_error);
    EXPECT_EQ(farthest_from_the_feet(clamped, time), 0);
  }
}

TEST(MakeLoop, RefusesTheSurfaceAndTheMotionOfAnotherStructure) {
  const auto make = [](const std::function<void(Case&)>& spoil) {
    Case c;
    spoil(c);
    return c.loop();
  };
  EXPECT_NO_THROW(make([](Case&) {}));
  EXPECT_NO_THROW(make([](Case& c) { c.surface = {}; }));
  const Skeleton larger = test::random_tree(20, 2), smaller = test::random_tree(4, 2);
  EXPECT_THROW(make([&](Case& c) { c.surface = mesh_surface(larger); }), InputError);
  EXPECT_THROW(make([](Case& c) { c.surface.branch.front() = -1; }), InputError);
  for (const Skeleton* other : {&larger, &smaller})
    EXPECT_THROW(make([&](Case& c) { c.structure = assemble(*other, test::weightless()); }), InputError);
  EXPECT_THROW(make([](Case& c) { c.motion.basis.columns.conservativeResize(6, 5); }), InputError);
  EXPECT_THROW(make([](Case& c) { c.motion.coordinates.conservativeResize(10, 4); }), InputError);
  EXPECT_THROW(make([](Case& c) { c.motion.coordinates.resize(0, 5); }), InputError);
  EXPECT_THROW(make([](Case& c) { c.motion.basis.kind.pop_back(); }), InputError);
  EXPECT_THROW(make([](Case& c) { c.motion = {}; }), InputError);
}

}  // namespace
}  // namespace tremula
