#include "tremula/structure/structure.hpp"

#include "tremula/base/error.hpp"
#include "tremula/structure/sparse_matrices.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>
#include "assembled.hpp"
#include "trees.hpp"

namespace tremula {
namespace {

using std::numbers::pi;

const Material wood{"wood", 9e9, 7e8, 950, ""};

Eigen::VectorXd random_vector(Eigen::Index size, std::uint64_t seed) {
  Eigen::VectorXd vector(size);
  for (Eigen::Index i = 0; i < size; ++i) {
    vector[i] = complex_gaussian({seed, RandomStream::test, 1, static_cast<std::uint64_t>(i)}).real();
  }
  return vector;
}

TEST(SolveStatic, GivesTheClosedFormsOfACantilever) {
  const double L = 2, r = 0.03, EI = wood.youngs_modulus * pi * std::pow(r, 4) / 4;
  for (const int pieces : {1, 7}) {
    const Structure structure = assemble(test::straight_stem(pieces, L, r, r), {.material = wood});
    Eigen::VectorXd force = Eigen::VectorXd::Zero(structure.size());
    force[6 * (pieces - 1)] = 10;  // across, at the tip
    const Eigen::VectorXd u = solve_static(structure, force);
    EXPECT_NEAR(u[6 * (pieces - 1)] * 3 * EI / (10 * L * L * L), 1, 1e-12);
    EXPECT_NEAR(u[6 * (pieces - 1) + 4] * 2 * EI / (10 * L * L), 1, 1e-12);
  }
}

TEST(SolveStatic, OfACutUpConeIsThatOfTheWholeCone) {
  const Structure whole = assemble(test::straight_stem(1, 3, 0.06, 0.01), {.material = wood});
  const Structure pieces = assemble(test::straight_stem(16, 3, 0.06, 0.01), {.material = wood});
  for (int row = 0; row < 6; ++row) {
    Eigen::VectorXd on_whole = Eigen::VectorXd::Zero(6), on_pieces = Eigen::VectorXd::Zero(96);
    on_whole[row] = on_pieces[90 + row] = 1;
    const Eigen::VectorXd wanted = solve_static(whole, on_whole);
    EXPECT_LT((solve_static(pieces, on_pieces).tail<6>() - wanted).norm(), 1e-11 * wanted.norm());
  }
}

TEST(Structure, OperatorsAgreeWithAssembledMatrices) {
  const Skeleton skeleton = test::awkward_tree();
  for (const Section section : {Section::exact, Section::paper}) {
    const Structure structure = assemble(skeleton, {.material = wood, .section = section});
    const test::Assembled dense = test::assemble_dense(skeleton, structure);
    const Eigen::VectorXd u = random_vector(structure.size(), 9);
    const Eigen::VectorXd inertia = dense.mass * u, elastic = dense.stiffness * u;
    EXPECT_LT((apply_mass(structure, u) - inertia).norm(), 1e-13 * inertia.norm());
    EXPECT_LT((apply_stiffness(structure, u) - elastic).norm(), 1e-12 * elastic.norm());
    const Eigen::VectorXd solved = dense.stiffness.ldlt().solve(u);
    EXPECT_LT((solve_static(structure, u) - solved).norm(), 1e-8 * solved.norm());
  }
}

TEST(AssembleSparse, GivesTheMatricesOfTheOperators) {
  const Structure structure = assemble(test::awkward_tree(), {.material = wood});
  const SparseMatrices matrices = assemble_sparse(structure);
  const Eigen::VectorXd u = random_vector(structure.size(), 17);
  const Eigen::VectorXd inertia = apply_mass(structure, u), elastic = apply_stiffness(structure, u);
  EXPECT_LT((matrices.mass * u - inertia).norm(), 1e-13 * inertia.norm());
  EXPECT_LT((matrices.stiffness * u - elastic).norm(), 1e-12 * elastic.norm());
}

TEST(Structure, StiffnessUndoesTheStaticSolve) {
  const Structure structure = assemble(test::awkward_tree(), {.material = wood});
  const Eigen::VectorXd force = random_vector(structure.size(), 4);
  EXPECT_LT((apply_stiffness(structure, solve_static(structure, force)) - force).norm(), 1e-8 * force.norm());
}

TEST(Structure, ComplianceFormIsSymmetricAndCarriesTheKineticEnergy) {
  const Structure structure = assemble(test::awkward_tree(), {.material = wood});
  const Eigen::VectorXd a = random_vector(structure.size(), 1), b = random_vector(structure.size(), 2);
  const double ab = a.dot(apply_compliance_form(structure, b)),
               ba = b.dot(apply_compliance_form(structure, a));
  EXPECT_NEAR(ab / ba, 1, 1e-12);
  const Eigen::VectorXd q = displacement_from_compliance_form(structure, a);
  EXPECT_NEAR(a.dot(apply_compliance_form(structure, a)) / q.dot(apply_mass(structure, q)), 1, 1e-12);
  EXPECT_NEAR(a.squaredNorm() / q.dot(apply_stiffness(structure, q)), 1, 1e-9);
}

TEST(Structure, MovedAsOneWeighsWhatItsWoodAndLeavesWeigh) {
  const Skeleton skeleton = test::awkward_tree();
  const Structure structure = assemble(skeleton, {.material = wood});
  double mass = 0;
  for (int k = 0; k < skeleton.branch_count(); ++k) {
    if (skeleton.parent(k) < 0) continue;  // the start of these does not move with the rest
    const Branch& branch = skeleton.branches[static_cast<std::size_t>(k)];
    const double a = branch.start_radius, b = branch.end_radius;
    mass += wood.density * pi * branch.length() / 3 * (a * a + a * b + b * b);
  }
  for (const Leaf& leaf : skeleton.leaves) mass += leaf.mass;
  Eigen::VectorXd translation = Eigen::VectorXd::Zero(structure.size());
  for (int k = 0; k < skeleton.branch_count(); ++k) translation[6 * k + 1] = 1;
  double of_root_branches = 0;
  for (int k = 0; k < skeleton.branch_count(); ++k) {
    if (skeleton.parent(k) >= 0) continue;
    const Vec3& d = structure.direction[static_cast<std::size_t>(k)];
    const ElementMass& m = structure.masses[static_cast<std::size_t>(k)];
    of_root_branches += d[1] * d[1] * m.axial(1, 1) + (1 - d[1] * d[1]) * m.bending(2, 2);
  }
  EXPECT_NEAR(translation.dot(apply_mass(structure, translation)) / (mass + of_root_branches), 1, 1e-12);
}

TEST(Assemble, RefusesAMaterialThatIsNone) {
  EXPECT_THROW(assemble(test::straight_stem(1, 1, 0.1, 0.1), {.material = {"m", -1, 1, 1, ""}}), InputError);
}

}  // namespace
}  // namespace tremula
