#include "tremula/structure/bent_tree.hpp"

#include "random_vector.hpp"
#include "trees.hpp"
#include "tremula/base/error.hpp"
#include "tremula/numerics/rotation.hpp"

#include <numbers>

#include <gtest/gtest.h>

namespace tremula {
namespace {

BeamTree awkward() { return assemble_tree(test::awkward_tree(), {}); }

Eigen::VectorXd random_strains(const BeamTree& tree, double size, std::uint64_t seed) {
  Eigen::VectorXd strains = size * test::random_vector(tree.size(), seed);
  for (int k = 0; k < tree.branch_count(); ++k)
    strains.segment<3>(6 * k) *= tree.members[index_of(k)].beam.length;
  return strains;
}

TEST(Bend, WithoutStrainsLeavesEveryBranchWhereItIs) {
  const BeamTree tree = awkward();
  const Eigen::VectorXd moved = displacement_of(tree, bend(tree, Eigen::VectorXd::Zero(tree.size())));
  EXPECT_LT(moved.cwiseAbs().maxCoeff(), 1e-15);
}

TEST(Bend, IsSuperpositionToFirstOrder) {
  const BeamTree tree = awkward();
  const Eigen::VectorXd displacement = test::random_vector(tree.size(), 3);
  const auto error = [&](double size) {
    const Eigen::VectorXd small = size * displacement;
    return (displacement_of(tree, bend(tree, strains_of(tree, small))) - small).norm();
  };
  EXPECT_NEAR(error(1e-3) / error(1e-4), 100, 2);
  EXPECT_LT(error(1e-5), 1e-8);
}

TEST(Bend, KeepsTheLengthOfEveryChordAtAnyAngle) {
  const BeamTree tree = awkward();
  Eigen::VectorXd strains = random_strains(tree, 2.0, 8);
  for (int k = 0; k < tree.branch_count(); ++k) {
    const Vec3& d = tree.members[index_of(k)].direction;
    strains.segment<3>(6 * k) -= d * d.dot(strains.segment<3>(6 * k));
  }
  const std::vector<BentBranch> bent = bend(tree, strains);
  for (int k = 0; k < tree.branch_count(); ++k) {
    const double length = tree.members[index_of(k)].beam.length;
    EXPECT_NEAR((bent[index_of(k)].end - bent[index_of(k)].start).norm() / length, 1, 1e-13);
  }
}

TEST(Bend, MakesACircleOfAStemWithTheSameMomentEverywhere) {
  const int pieces = 64;
  const BeamTree tree = assemble_tree(test::straight_stem(pieces, 2, 0.02, 0.02), {});
  const double angle = std::numbers::pi / 2, piece = 2.0 / pieces;
  Eigen::VectorXd strains = Eigen::VectorXd::Zero(tree.size());
  for (int k = 0; k < pieces; ++k) {
    strains[6 * k] = 0.5 * piece * angle / pieces;  // the chord turns by half of what its end does
    strains[6 * k + 4] = angle / pieces;
  }
  const BentBranch tip = bend(tree, strains).back();
  const double radius = 2 / angle;
  EXPECT_NEAR(tip.end.x(), radius, 1e-4);
  EXPECT_NEAR(tip.end.z(), radius, 1e-4);
}

TEST(StrainsAbout, IsTheInverseOfTheDerivativeOfBend) {
  const BeamTree tree = awkward();
  const Eigen::VectorXd strains = random_strains(tree, 0.6, 1), more = random_strains(tree, 1, 2);
  const std::vector<BentBranch> bent = bend(tree, strains);
  const double h = 1e-6;
  const std::vector<BentBranch> plus = bend(tree, strains + h * more), minus = bend(tree, strains - h * more);
  Eigen::VectorXd displacement(tree.size());
  for (std::size_t k = 0; k < bent.size(); ++k) {
    displacement.segment<3>(6 * static_cast<Eigen::Index>(k)) = (plus[k].end - minus[k].end) / (2 * h);
    displacement.segment<3>(6 * static_cast<Eigen::Index>(k) + 3) =
        rotation_vector(plus[k].end_frame * minus[k].end_frame.transpose()) / (2 * h);
  }
  EXPECT_LT((strains_about(tree, strains, bent, displacement) - more).norm(), 1e-7 * more.norm());
}

TEST(StrainsAbout, AboutRestAreTheStrainsThemselves) {
  const BeamTree tree = awkward();
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(tree.size()),
                        displacement = test::random_vector(tree.size(), 6);
  const Eigen::VectorXd wanted = strains_of(tree, displacement);
  EXPECT_LT((strains_about(tree, none, bend(tree, none), displacement) - wanted).norm(),
            1e-13 * wanted.norm());
}

TEST(TreeAt, StandsWhereTheBentBranchesEnd) {
  const BeamTree tree = awkward();
  const std::vector<BentBranch> bent = bend(tree, random_strains(tree, 0.3, 4));
  const BeamTree standing = tree_at(tree, bent);
  for (int k = 0; k < tree.branch_count(); ++k) {
    const std::size_t i = index_of(k);
    EXPECT_LT((standing.members[i].point(1) - bent[i].end).norm(), 1e-13);
    const int parent = tree.parent[i];
    if (parent < 0) continue;
    EXPECT_LT((bent[index_of(parent)].end + standing.reach[i] - bent[i].end).norm(), 1e-13);
  }
}

TEST(PointOn, RunsFromTheStartToTheEndInTheirDirections) {
  const BeamTree tree = awkward();
  const std::vector<BentBranch> bent = bend(tree, random_strains(tree, 0.5, 5));
  for (int k = 0; k < tree.branch_count(); ++k) {
    const Member& member = tree.members[index_of(k)];
    const BentBranch& branch = bent[index_of(k)];
    const BentPoint first = point_on(member, branch, 0), last = point_on(member, branch, 1);
    EXPECT_LT((first.position - branch.start).norm(), 1e-14);
    EXPECT_LT((first.frame - branch.start_frame).norm(), 1e-7);
    EXPECT_LT((last.position - branch.end).norm(), 1e-14);
    EXPECT_LT((last.frame - branch.end_frame).norm(), 1e-7);
    const Vec3 along = point_on(member, branch, 0.41).position - point_on(member, branch, 0.39).position;
    EXPECT_GT(along.normalized().dot(point_on(member, branch, 0.4).frame * member.direction), 1 - 1e-4);
  }
}

TEST(BentTree, RefusesStrainsOfAnotherSize) {
  const BeamTree tree = awkward();
  EXPECT_THROW(bend(tree, Eigen::VectorXd::Zero(5)), InputError);
  EXPECT_THROW(strains_of(tree, Eigen::VectorXd::Zero(5)), InputError);
  EXPECT_THROW(displacement_of(tree, {}), InputError);
  EXPECT_THROW(tree_at(tree, {}), InputError);
}

}  // namespace
}  // namespace tremula
