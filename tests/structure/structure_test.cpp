#include "tremula/structure/structure.hpp"

#include "tremula/base/error.hpp"
#include "tremula/structure/mode_count.hpp"

#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>
#include "frames.hpp"
#include "structure/random_vector.hpp"
#include "trees.hpp"

namespace tremula {
namespace {

const Material wood{"wood", 9e9, 7e8, 950, ""};

// Tapered elements, two clamps at two heights, a node below them, and masses on a free and on a held node.
Frame loaded_arch() {
  Frame frame;
  frame.nodes = {{0, 0, 0.2}, {0.3, 0.1, 1}, {1.1, -0.2, 1.2}, {1.5, 0, 0.1}, {0.8, 0.5, -0.3}};
  frame.clamped = {3, 0};
  const Material heavy{"heavy", 1.1e10, 8e8, 1100, ""};
  frame.elements = {test::make_element(0, 1, 0.03, 0.02, wood), test::make_element(2, 1, 0.015, 0.02, heavy),
                    test::make_element(2, 3, 0.02, 0.025, wood), test::make_element(1, 4, 0.02, 0.01, heavy)};
  frame.masses = {{2, 0.7}, {0, 0.4}};
  return frame;
}

TEST(StructureOfAFrame, HasTheMassAndTheFlexibilityOfTheAssembledMatrices) {
  for (const FrameOptions& options :
       {FrameOptions{}, FrameOptions{.section = Section::paper, .rotatory_inertia = false}}) {
    const FrameMatrices matrices = assemble_frame(loaded_arch(), options);
    const Structure structure = assemble(loaded_arch(), options);
    ASSERT_EQ(structure.size(), matrices.size());
    const Eigen::VectorXd u = test::random_vector(structure.size(), 1),
                          f = test::random_vector(structure.size(), 2);
    const Eigen::VectorXd inertia = Eigen::MatrixXd(matrices.mass) * u;
    EXPECT_LT((structure.mass(u) - inertia).norm(), 1e-14 * inertia.norm());
    const Eigen::VectorXd bent = Eigen::MatrixXd(matrices.stiffness).ldlt().solve(f);
    EXPECT_LT((structure.flexibility(f) - bent).norm(), 1e-10 * bent.norm());
    EXPECT_LT((matrices.stiffness * structure.flexibility(f) - f).norm(), 1e-10 * f.norm());
  }
}

TEST(StructureOfATree, HasTheMassAndTheFlexibilityOfTheSweeps) {
  for (const RootSpring& root : {RootSpring{}, RootSpring{.translation = 1e5, .rotation = 2e3}}) {
    const StructureOptions options{.material = wood, .root = root};
    const BeamTree tree = assemble_tree(test::awkward_tree(), options);
    const Structure structure = assemble(test::awkward_tree(), test::weightless(options));
    ASSERT_EQ(structure.size(), tree.size());
    const Eigen::VectorXd u = test::random_vector(structure.size(), 3);
    EXPECT_EQ(structure.mass(u), apply_mass(tree, u));
    EXPECT_EQ(structure.flexibility(u), solve_static(tree, u));
  }
}

TEST(Structure, OfATreeSaidAsAFrameDoesTheSame) {
  const Skeleton skeleton = test::random_tree(30, 11);
  const Structure tree = assemble(skeleton, test::weightless({.material = wood}));
  const Structure frame = assemble(test::frame_of(skeleton, wood));
  ASSERT_EQ(frame.size(), tree.size());
  const Eigen::VectorXd u = test::random_vector(tree.size(), 4);
  const Eigen::VectorXd inertia = tree.mass(u), bent = tree.flexibility(u);
  EXPECT_LT((frame.mass(u) - inertia).norm(), 1e-13 * inertia.norm());
  EXPECT_LT((frame.flexibility(u) - bent).norm(), 1e-8 * bent.norm());
  const GroundInertia of_tree = tree.find_ground_inertia(), of_frame = frame.find_ground_inertia();
  EXPECT_NEAR(of_frame.total_mass / of_tree.total_mass, 1, 1e-13);
  EXPECT_LT((of_frame.forces - of_tree.forces).norm(), 1e-13 * of_tree.forces.norm());
  ASSERT_EQ(frame.nodes.size(), tree.nodes.size());
  for (std::size_t i = 0; i < tree.nodes.size(); ++i) {
    EXPECT_EQ(frame.nodes[i].position, tree.nodes[i].position) << i;
    EXPECT_EQ(frame.nodes[i].row, tree.nodes[i].row) << i;
  }
}

TEST(Structure, KeepsInACopyWhatItsFunctionsWorkOn) {
  const auto forget = [](Structure structure) { return structure; };
  for (const Structure& copy : {forget(assemble(test::awkward_tree(), test::weightless({.material = wood}))),
                                forget(assemble(loaded_arch()))}) {
    EXPECT_TRUE(copy.mass(copy.flexibility(test::random_vector(copy.size(), 5))).allFinite());
    for (const Member& member : copy.members) EXPECT_NEAR(member.direction.norm(), 1, 1e-14);
    EXPECT_EQ(copy.find_ground_inertia().forces.rows(), copy.size());
    EXPECT_EQ(copy.find_sites().point_count(), static_cast<Eigen::Index>(copy.members.size()));
  }
}

TEST(Structure, RefusesVectorsOfAnotherSize) {
  for (const Structure& structure :
       {assemble(test::awkward_tree(), test::weightless({.material = wood})), assemble(loaded_arch())}) {
    for (const Eigen::Index size : {Eigen::Index{0}, structure.size() - 6, structure.size() + 1}) {
      EXPECT_THROW(structure.mass(Eigen::VectorXd::Ones(size)), InputError) << size;
      EXPECT_THROW(structure.flexibility(Eigen::VectorXd::Ones(size)), InputError) << size;
    }
  }
}

TEST(Assemble, RefusesWhatIsNoTreeAndNoFrame) {
  EXPECT_THROW(assemble(test::straight_stem(1, 1, 0.1, 0.1), test::weightless({.root = {.rotation = -1}})),
               InputError);
  EXPECT_THROW(assemble(test::straight_stem(1, 1, 0.1, -0.1), test::weightless()), InputError);
  Frame loose = loaded_arch();
  loose.clamped.clear();
  EXPECT_THROW(assemble(loose), InputError);
}

TEST(GroundInertia, OfAFrameWeighsItsWoodAndItsMassesHeldOrNot) {
  const Frame frame = loaded_arch();
  double mass = 0.7 + 0.4;
  for (const FrameElement& element : frame.elements) {
    const double a = element.start_radius, b = element.end_radius;
    const double length = (frame.nodes[static_cast<std::size_t>(element.end_node)] -
                           frame.nodes[static_cast<std::size_t>(element.start_node)])
                              .norm();
    mass += element.material.density * std::numbers::pi / 3 * (a * a + a * b + b * b) * length;
  }
  EXPECT_NEAR(assemble(frame).find_ground_inertia().total_mass / mass, 1, 1e-13);
}

// M over all nodes, held ones too: what held them hangs on one more node, which adds nothing to the rows of
// the others.
TEST(GroundInertia, OfAFrameIsTheMassMatrixOfAllItsNodesMovedAsOne) {
  const Frame frame = loaded_arch();
  Frame freed = frame;
  freed.nodes.emplace_back(0.7, 0.3, -1);
  const int anchor = static_cast<int>(frame.nodes.size());
  for (const int node : frame.clamped)
    freed.elements.push_back(test::make_element(anchor, node, 0.01, 0.01, wood));
  freed.clamped = {anchor};
  for (const bool rotatory : {false, true}) {
    const FrameOptions options{.rotatory_inertia = rotatory};
    const FrameMatrices all = assemble_frame(freed, options);
    const Structure structure = assemble(frame, options);
    const GroundInertia found = structure.find_ground_inertia();
    ASSERT_EQ(found.forces.rows(), structure.size());
    for (int axis = 0; axis < 3; ++axis) {
      Eigen::VectorXd moved = Eigen::VectorXd::Zero(all.size());
      for (Eigen::Index row = axis; row < moved.size(); row += 6) moved[row] = 1;
      const Eigen::VectorXd forces = all.mass * moved;
      for (std::size_t node = 0; node < structure.nodes.size(); ++node) {
        const Eigen::Index row = structure.nodes[node].row;
        if (row < 0) continue;
        const Vec6 wanted = forces.segment<6>(all.row[node]);
        EXPECT_LT((found.forces.col(axis).segment<6>(row) - wanted).norm(), 1e-13 * forces.norm())
            << "node " << node << ", axis " << axis;
      }
    }
  }
}

TEST(NodeDisplacement, IsThatOfTheRowsOfTheNodeAndZeroWhereTheGroundHoldsIt) {
  const Frame frame = loaded_arch();
  const FrameMatrices matrices = assemble_frame(frame);
  const Structure structure = assemble(frame);
  ASSERT_EQ(structure.nodes.size(), frame.nodes.size());
  const Eigen::VectorXd u = test::random_vector(structure.size(), 6);
  for (std::size_t node = 0; node < frame.nodes.size(); ++node) {
    EXPECT_EQ(structure.nodes[node].position, frame.nodes[node]);
    EXPECT_EQ(structure.nodes[node].row, matrices.row[node]);
    const Vec6 wanted = matrices.row[node] < 0 ? Vec6(Vec6::Zero()) : Vec6(u.segment<6>(matrices.row[node]));
    EXPECT_EQ(node_displacement(structure, u, node), wanted) << node;
  }
}

TEST(NodeDisplacement, OfARootIsThatOfTheFootOfTheFirstBranchOnIt) {
  Skeleton skeleton = test::awkward_tree();
  skeleton.branches.push_back(test::make_branch(0, Vec3::Zero(), Vec3(-0.3, 0.2, 0.6), 0.02, 0.01));
  skeleton.roots.emplace_back(4, 4, 0);  // nothing stands here
  for (Branch& branch : skeleton.branches) {
    if (branch.start_node > 1) ++branch.start_node;
  }
  for (const RootSpring& root : {RootSpring{}, RootSpring{.translation = 1e5, .rotation = 2e3}}) {
    const Structure structure = assemble(skeleton, test::weightless({.material = wood, .root = root}));
    ASSERT_EQ(static_cast<int>(structure.nodes.size()), skeleton.node_count());
    const Eigen::VectorXd u = test::random_vector(structure.size(), 7);
    for (int node = 0; node < skeleton.node_count(); ++node) {
      const auto index = static_cast<std::size_t>(node);
      EXPECT_EQ(structure.nodes[index].position, skeleton.node_position(node));
      Vec6 wanted = Vec6::Zero();
      if (node >= skeleton.root_count()) {
        wanted = u.segment<6>(6 * (node - skeleton.root_count()));
      } else {
        for (int k = skeleton.branch_count() - 1; k >= 0; --k) {
          if (skeleton.branches[static_cast<std::size_t>(k)].start_node == node)
            wanted = foot_displacement(structure.members[static_cast<std::size_t>(k)], u);
        }
      }
      EXPECT_EQ(node_displacement(structure, u, index), wanted) << node;
    }
    EXPECT_EQ(node_displacement(structure, u, 0).norm() > 0, std::isfinite(root.rotation));
    EXPECT_EQ(node_displacement(structure, u, 2), Vec6(Vec6::Zero()));
  }
}

TEST(GroundHeight, IsThatOfTheLowestHeldNodeHoweverLowTheOthersHang) {
  EXPECT_EQ(ground_height(assemble(loaded_arch())), 0.1);
  Skeleton skeleton = test::awkward_tree();
  for (Vec3* point : {&skeleton.roots[1], &skeleton.branches[12].start}) point->z() = -0.4;
  skeleton.branches[12].end.z() = -2;
  EXPECT_EQ(ground_height(assemble(skeleton, test::weightless())), -0.4);
}

// A member is the element between its two nodes, whichever of them are held.
TEST(Member, BeginsAndEndsWhereItsNodesAreAndMovesWithThem) {
  const Frame frame = loaded_arch();
  const Structure structure = assemble(frame);
  ASSERT_EQ(structure.members.size(), frame.elements.size());
  const Eigen::VectorXd u = test::random_vector(structure.size(), 8);
  for (std::size_t k = 0; k < frame.elements.size(); ++k) {
    const Member& member = structure.members[k];
    const auto start = static_cast<std::size_t>(frame.elements[k].start_node),
               end = static_cast<std::size_t>(frame.elements[k].end_node);
    EXPECT_LT((member.point(0) - frame.nodes[start]).norm(), 1e-15);
    EXPECT_LT((member.point(1) - frame.nodes[end]).norm(), 1e-15);
    const EndDisplacements ends = end_displacements(member, u);
    Vec6 at_start, at_end;
    at_start << ends.start_translation, ends.start_rotation;
    at_end << ends.end_translation, ends.end_rotation;
    EXPECT_EQ(at_start, node_displacement(structure, u, start)) << k;
    EXPECT_EQ(at_end, node_displacement(structure, u, end)) << k;
  }
}

// A branch may start beside the node that carries it: its start then moves as the end of a rigid arm does.
TEST(Member, OfATreeStartsAtTheEndOfItsArm) {
  const Skeleton skeleton = test::awkward_tree();
  const Structure structure = assemble(skeleton, test::weightless({.material = wood}));
  const Eigen::VectorXd u = test::random_vector(structure.size(), 9);
  int beside = 0;
  for (int k = 0; k < skeleton.branch_count(); ++k) {
    const auto index = static_cast<std::size_t>(k);
    const Branch& branch = skeleton.branches[index];
    const Member& member = structure.members[index];
    EXPECT_LT((member.point(0) - branch.start).norm() + (member.point(1) - branch.end).norm(), 1e-14) << k;
    const auto node = static_cast<std::size_t>(branch.start_node);
    const Vec6 carrier = node_displacement(structure, u, node);
    const Vec3 arm = branch.start - structure.nodes[node].position;
    beside += arm.norm() > 0.01 ? 1 : 0;
    const EndDisplacements ends = end_displacements(member, u);
    EXPECT_LT((ends.start_translation - carrier.head<3>() - carrier.tail<3>().cross(arm)).norm(), 1e-14) << k;
    EXPECT_EQ(ends.start_rotation, Vec3(carrier.tail<3>())) << k;
  }
  EXPECT_GT(beside, 0);
}

}  // namespace
}  // namespace tremula
