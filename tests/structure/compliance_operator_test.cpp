#include "tremula/structure/compliance_operator.hpp"

#include "tremula/numerics/random.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "trees.hpp"

namespace tremula {
namespace {

Eigen::VectorXd random_vector(Eigen::Index size) {
  Eigen::VectorXd vector(size);
  for (Eigen::Index i = 0; i < size; ++i) {
    vector[i] = uniform({8, RandomStream::test, 0, static_cast<std::uint64_t>(i)}) - 0.5;
  }
  return vector;
}

// The plain form, branch after branch, is the second method.
void expect_the_plain_form(const BeamTree& tree) {
  ComplianceOperator packed_operator(tree);
  ASSERT_GE(packed_operator.size(), tree.size());
  const Eigen::VectorXd s = random_vector(tree.size());
  const Eigen::VectorXd wanted = apply_compliance_form(tree, s);
  Eigen::VectorXd out(packed_operator.size());
  for (int time = 0; time < 2; ++time) {  // nothing is left over from the time before
    const double product = packed_operator.apply(packed_operator.packed(s), out);
    EXPECT_LT((packed_operator.unpacked(out) - wanted).norm(), 1e-13 * wanted.norm());
    EXPECT_NEAR(product, s.dot(wanted), 1e-13 * s.norm() * wanted.norm());
  }
  EXPECT_NEAR(out.norm() / wanted.norm(), 1, 1e-13);  // lanes without a branch stay 0
}

TEST(ComplianceOperator, IsThePlainFormOnTreesOfManySizes) {
  for (const int branches : {1, 2, 7, 8, 9, 62, 700, 3000}) {
    SCOPED_TRACE(branches);
    expect_the_plain_form(assemble_tree(test::random_tree(branches, 4), {}));
  }
}

TEST(ComplianceOperator, IsThePlainFormWhereTheTreeIsCutIntoBlocks) {
  expect_the_plain_form(assemble_tree(test::random_tree(20000, 9), {}));
}

TEST(ComplianceOperator, IsThePlainFormOnAStraightStemWhereNoTwoBranchesHaveOneDepth) {
  const Skeleton stem = test::straight_stem(6000, 60, 0.3, 0.2);
  const BeamTree tree = assemble_tree(stem, {});
  EXPECT_EQ(ComplianceOperator(tree).size(), tree.size());
  expect_the_plain_form(tree);
}

TEST(ComplianceOperator, IsThePlainFormOnAThicketOfManyRoots) {
  Skeleton thicket;
  for (int i = 0; i < 5000; ++i) thicket.roots.emplace_back(1.0 * i, 0, 0);
  for (int i = 0; i < 5000; ++i) {
    thicket.branches.push_back(test::make_branch(i, Vec3(1.0 * i, 0, 0), Vec3(1.0 * i, 0.1, 1), 0.02, 0.01));
  }
  expect_the_plain_form(assemble_tree(thicket, {}));
}

TEST(ComplianceOperator, GivesTheSameBitsOnAnyNumberOfThreads) {
  const BeamTree tree = assemble_tree(test::random_tree(20000, 9), {});
  const auto apply = [&](std::size_t threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    ComplianceOperator packed_operator(tree);
    Eigen::VectorXd out(packed_operator.size());
    packed_operator.apply(packed_operator.packed(random_vector(tree.size())), out);
    return out;
  };
  EXPECT_EQ(apply(1), apply(4));
}

}  // namespace
}  // namespace tremula
