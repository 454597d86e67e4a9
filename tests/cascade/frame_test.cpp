// A frame goes the way of a tree, from end to end.
#include <gtest/gtest.h>

#include <cmath>

#include "frames.hpp"
#include "in_wind.hpp"
#include "trees.hpp"
#include "tremula/deformation/loop.hpp"
#include "tremula/geometry/surface.hpp"
#include "tremula/io/loop_writers.hpp"
#include "tremula/pipeline.hpp"

namespace tremula {
namespace {

const Material wood = find_material("oak");

Weather breeze() {
  Weather weather;
  weather.wind = turbulent_wind({.speed = 6, .heading = 20}, 0.25);
  weather.loop = {.period = 8, .sample_count = 160};
  return weather;
}

// A tree and the same as a frame: sweeps against Cholesky factors, all along the cascade.
TEST(FrameInTheWind, MovesAsTheSameTreeDoes) {
  const Skeleton skeleton = test::random_tree(14, 6);
  const Subject tree =
      bake(skeleton, {.structure = test::weightless({.material = wood}), .modes = {.count = 10}});
  const Subject frame = bake(test::frame_of(skeleton, wood), {.modes = {.count = 10}});
  Weather weather = breeze();
  weather.lean.rotations = Rotations::small;
  const Motion as_tree = set_in_motion(tree, weather), as_frame = set_in_motion(frame, weather);
  EXPECT_LT((as_frame.basis.frequency - as_tree.basis.frequency).norm(),
            1e-8 * as_tree.basis.frequency.norm());
  for (const double time : {0.0, 1.7, 5.3}) {
    const Eigen::VectorXd one = displacement_at(as_tree, time), other = displacement_at(as_frame, time);
    EXPECT_LT((one - other).norm(), 1e-6 * one.norm()) << time;
  }
  EXPECT_GT(displacement_at(as_tree, 1.7).norm(), 0);
}

TEST(FrameInTheWind, WithALoopIsWrittenInEveryForm) {
  const Frame table = test::table(4, wood);
  const Subject subject = bake(table, {.modes = {.count = 8}});
  const Loop loop = make_loop(subject.structure, mesh_surface(outline_of(table)),
                              set_in_motion(subject, breeze()), {.name = "table"});
  const int frames[] = {0, 80};
  for (const LoopWriter& writer : loop_writers()) {
    if (writer.extension == "html") continue;  // wants Node.js
    EXPECT_GT(writer.encode(loop, {.frames = frames}).size(), 1000U) << writer.extension;
  }
  // It moves, its feet stand still.
  const NodePoses poses = loop.nodes_at(3.1);
  for (Eigen::Index node = 0; node < poses.cols(); ++node) {
    if (loop.nodes(2, node) == 0)
      EXPECT_EQ(poses.col(node).norm(), 0);
    else
      EXPECT_GT(poses.col(node).norm(), 0);
  }
}

TEST(FrameInTheWind, StandsUnderTheMeanWindWhereItsStiffnessSays) {
  // A portal of two posts and a beam, wind across its plane: the lean is K^-1 of the drag.
  const Frame table = test::table(6, wood);
  Weather weather = breeze();
  weather.lean = test::small_and_free;
  weather.loads.model = LoadModel::linearised;
  const Subject subject = bake(table, {.modes = {.count = 6}});
  const Motion motion = set_in_motion(subject, weather);
  const Sites sites = subject.structure.find_sites();
  const PointWind wind = wind_at_points(weather.wind, weather.loop, sites.points);
  const Eigen::VectorXd force = mean_force(sites, linearise_loads(sites, wind.mean, weather.loads));
  const FrameMatrices matrices = assemble_frame(table);
  const Eigen::VectorXd left = matrices.stiffness * lean_of(motion.basis) - force;
  EXPECT_LT(left.norm(), 1e-6 * force.norm());
}

TEST(OutlineOf, AFrameHasABranchForEveryElementInTheirOrder) {
  const Frame table = test::table(4, wood);
  const Skeleton outline = outline_of(table);
  ASSERT_EQ(outline.branches.size(), table.elements.size());
  EXPECT_EQ(outline.root_count(), 8) << "an axis for each leg and each rail";
  for (std::size_t i = 0; i < table.elements.size(); ++i) {
    EXPECT_EQ(outline.branches[i].start, table.nodes[static_cast<std::size_t>(table.elements[i].start_node)]);
    EXPECT_EQ(outline.branches[i].end, table.nodes[static_cast<std::size_t>(table.elements[i].end_node)]);
  }
  EXPECT_NO_THROW(check_skeleton(outline, "outline"));
}

}  // namespace
}  // namespace tremula
