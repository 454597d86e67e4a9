#include "tremula/structure/beam_tree.hpp"

#include "tremula/base/error.hpp"
#include "tremula/reference/sparse_matrices.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>
#include "assembled.hpp"
#include "structure/random_vector.hpp"
#include "trees.hpp"

namespace tremula {
namespace {

using std::numbers::pi;

const Material wood{"wood", 9e9, 7e8, 950, ""};

TEST(SolveStatic, GivesTheClosedFormsOfACantilever) {
  const double L = 2, r = 0.03, EI = wood.youngs_modulus * pi * std::pow(r, 4) / 4;
  for (const int pieces : {1, 7}) {
    const BeamTree tree = assemble_tree(test::straight_stem(pieces, L, r, r), {.material = wood});
    Eigen::VectorXd force = Eigen::VectorXd::Zero(tree.size());
    force[6 * (pieces - 1)] = 10;  // across, at the tip
    const Eigen::VectorXd u = solve_static(tree, force);
    EXPECT_NEAR(u[6 * (pieces - 1)] * 3 * EI / (10 * L * L * L), 1, 1e-12);
    EXPECT_NEAR(u[6 * (pieces - 1) + 4] * 2 * EI / (10 * L * L), 1, 1e-12);
  }
}

TEST(SolveStatic, OnASpringAddsWhatTheFootGivesWay) {
  const double L = 2, r = 0.03, EI = wood.youngs_modulus * pi * std::pow(r, 4) / 4;
  const RootSpring spring{.translation = 4e4, .rotation = 3e3};
  for (const int pieces : {1, 7}) {
    const BeamTree tree =
        assemble_tree(test::straight_stem(pieces, L, r, r), {.material = wood, .root = spring});
    Eigen::VectorXd force = Eigen::VectorXd::Zero(tree.size());
    force[6 * (pieces - 1)] = 10;       // across, at the tip
    force[6 * (pieces - 1) + 5] = 0.7;  // twist
    const Eigen::VectorXd u = solve_static(tree, force);
    const double wanted = 10 * (L * L * L / (3 * EI) + 1 / spring.translation + L * L / spring.rotation);
    EXPECT_NEAR(u[6 * (pieces - 1)] / wanted, 1, 1e-12);
    const Vec6 foot = foot_displacement(tree.members[0], u);
    EXPECT_NEAR(foot[0] * spring.translation / 10, 1, 1e-11);
    EXPECT_NEAR(foot[4] * spring.rotation / (10 * L), 1, 1e-11);
    EXPECT_NEAR(foot[5] * spring.rotation / 0.7, 1, 1e-11);
    EXPECT_LT((apply_stiffness(tree, u) - force).norm(), 1e-9 * force.norm());
  }
}

TEST(FootDisplacement, IsZeroOnARigidRoot) {
  const BeamTree tree = assemble_tree(test::awkward_tree(), {.material = wood});
  const Eigen::VectorXd u = test::random_vector(tree.size(), 3);
  EXPECT_EQ(foot_displacement(tree.members[0], u), Vec6(Vec6::Zero()));
}

TEST(FootDisplacement, OfTwoStemsIsWhatTheirSpringsBearTogether) {
  const RootSpring spring{.translation = 2e5, .rotation = 5e3};
  const Skeleton skeleton = test::awkward_tree();
  const BeamTree tree = assemble_tree(skeleton, {.material = wood, .root = spring});
  const Eigen::VectorXd force = test::random_vector(tree.size(), 6);
  const Eigen::VectorXd u = solve_static(tree, force);
  Vec3 load = Vec3::Zero(), moment = Vec3::Zero(), borne = Vec3::Zero(), borne_moment = Vec3::Zero();
  int stems = 0;
  for (int k = 0; k < skeleton.branch_count(); ++k) {
    const Branch& branch = skeleton.branches[static_cast<std::size_t>(k)];
    const Vec3 at_node = force.segment<3>(6 * k);
    load += at_node;
    moment += force.segment<3>(6 * k + 3) + branch.end.cross(at_node);
    if (skeleton.parent(k) >= 0) continue;
    ++stems;
    const Vec6 foot = foot_displacement(tree.members[static_cast<std::size_t>(k)], u);
    const Vec3 on_ground = spring.translation * foot.head<3>();
    borne += on_ground;
    borne_moment += spring.rotation * foot.tail<3>() + branch.start.cross(on_ground);
  }
  EXPECT_GE(stems, 2);
  EXPECT_LT((borne - load).norm(), 1e-10 * load.norm());
  EXPECT_LT((borne_moment - moment).norm(), 1e-10 * moment.norm());
}

TEST(SolveStatic, OfACutUpConeIsThatOfTheWholeCone) {
  const BeamTree whole = assemble_tree(test::straight_stem(1, 3, 0.06, 0.01), {.material = wood});
  const BeamTree pieces = assemble_tree(test::straight_stem(16, 3, 0.06, 0.01), {.material = wood});
  for (int row = 0; row < 6; ++row) {
    Eigen::VectorXd on_whole = Eigen::VectorXd::Zero(6), on_pieces = Eigen::VectorXd::Zero(96);
    on_whole[row] = on_pieces[90 + row] = 1;
    const Eigen::VectorXd wanted = solve_static(whole, on_whole);
    EXPECT_LT((solve_static(pieces, on_pieces).tail<6>() - wanted).norm(), 1e-11 * wanted.norm());
  }
}

TEST(BeamTree, OperatorsAgreeWithAssembledMatrices) {
  const Skeleton skeleton = test::awkward_tree();
  for (const StructureOptions& options :
       {StructureOptions{.material = wood}, StructureOptions{.material = wood, .section = Section::paper},
        StructureOptions{.material = wood, .root = {.translation = 1e5, .rotation = 2e3}}}) {
    const BeamTree tree = assemble_tree(skeleton, options);
    const test::Assembled dense = test::assemble_dense(skeleton, tree);
    const Eigen::VectorXd u = test::random_vector(tree.size(), 9);
    const Eigen::VectorXd inertia = dense.mass * u, elastic = dense.stiffness * u;
    EXPECT_LT((apply_mass(tree, u) - inertia).norm(), 1e-13 * inertia.norm());
    EXPECT_LT((apply_stiffness(tree, u) - elastic).norm(), 1e-12 * elastic.norm());
    const Eigen::VectorXd solved = dense.stiffness.ldlt().solve(u);
    EXPECT_LT((solve_static(tree, u) - solved).norm(), 1e-8 * solved.norm());
  }
}

TEST(AssembleSparse, GivesTheMatricesOfTheOperators) {
  const BeamTree tree = assemble_tree(test::awkward_tree(), {.material = wood});
  const SparseMatrices matrices = assemble_sparse(tree);
  const Eigen::VectorXd u = test::random_vector(tree.size(), 17);
  const Eigen::VectorXd inertia = apply_mass(tree, u), elastic = apply_stiffness(tree, u);
  EXPECT_LT((matrices.mass * u - inertia).norm(), 1e-13 * inertia.norm());
  EXPECT_LT((matrices.stiffness * u - elastic).norm(), 1e-12 * elastic.norm());
}

TEST(BeamTree, StiffnessUndoesTheStaticSolve) {
  const BeamTree tree = assemble_tree(test::awkward_tree(), {.material = wood});
  const Eigen::VectorXd force = test::random_vector(tree.size(), 4);
  EXPECT_LT((apply_stiffness(tree, solve_static(tree, force)) - force).norm(), 1e-8 * force.norm());
}

TEST(BeamTree, ComplianceFormIsSymmetricAndCarriesTheKineticEnergy) {
  const BeamTree tree = assemble_tree(test::awkward_tree(), {.material = wood});
  const Eigen::VectorXd a = test::random_vector(tree.size(), 1), b = test::random_vector(tree.size(), 2);
  const double ab = a.dot(apply_compliance_form(tree, b)), ba = b.dot(apply_compliance_form(tree, a));
  EXPECT_NEAR(ab / ba, 1, 1e-12);
  const Eigen::VectorXd q = displacement_from_compliance_form(tree, a);
  EXPECT_NEAR(a.dot(apply_compliance_form(tree, a)) / q.dot(apply_mass(tree, q)), 1, 1e-12);
  EXPECT_NEAR(a.squaredNorm() / q.dot(apply_stiffness(tree, q)), 1, 1e-9);
}

TEST(BeamTree, MovedAsOneWeighsWhatItsWoodAndLeavesWeigh) {
  const Skeleton skeleton = test::awkward_tree();
  const BeamTree tree = assemble_tree(skeleton, {.material = wood});
  double mass = 0;
  for (int k = 0; k < skeleton.branch_count(); ++k) {
    if (skeleton.parent(k) < 0) continue;  // the start of these does not move with the rest
    const Branch& branch = skeleton.branches[static_cast<std::size_t>(k)];
    const double a = branch.start_radius, b = branch.end_radius;
    mass += wood.density * pi * branch.length() / 3 * (a * a + a * b + b * b);
  }
  for (const Leaf& leaf : skeleton.leaves) mass += leaf.mass;
  Eigen::VectorXd translation = Eigen::VectorXd::Zero(tree.size());
  for (int k = 0; k < skeleton.branch_count(); ++k) translation[6 * k + 1] = 1;
  double of_root_branches = 0;
  for (int k = 0; k < skeleton.branch_count(); ++k) {
    if (skeleton.parent(k) >= 0) continue;
    const Vec3& d = tree.members[static_cast<std::size_t>(k)].direction;
    const ElementMass& m = tree.masses[static_cast<std::size_t>(k)];
    of_root_branches += d[1] * d[1] * m.axial(1, 1) + (1 - d[1] * d[1]) * m.bending(2, 2);
  }
  EXPECT_NEAR(translation.dot(apply_mass(tree, translation)) / (mass + of_root_branches), 1, 1e-12);
}

TEST(AssembleTree, WithInfiniteRootStiffnessGivesTheBitsOfTheClampedTree) {
  const BeamTree clamped = assemble_tree(test::awkward_tree(), {.material = wood});
  const double infinity = std::numeric_limits<double>::infinity();
  const BeamTree held = assemble_tree(
      test::awkward_tree(), {.material = wood, .root = {.translation = infinity, .rotation = infinity}});
  const BeamTree loose = assemble_tree(test::awkward_tree(), {.material = wood, .root = {.rotation = 1e4}});
  const Eigen::VectorXd s = test::random_vector(clamped.size(), 5);
  EXPECT_EQ(apply_compliance_form(clamped, s), apply_compliance_form(held, s));
  EXPECT_EQ(solve_static(clamped, s), solve_static(held, s));
  EXPECT_NE(solve_static(clamped, s), solve_static(loose, s));
}

TEST(AssembleTree, RefusesRootStiffnessesThatAreNotAboveZero) {
  const Skeleton stem = test::straight_stem(1, 1, 0.1, 0.1);
  for (const double bad : {0.0, -1.0, std::nan(""), -std::numeric_limits<double>::infinity()}) {
    EXPECT_THROW(assemble_tree(stem, {.root = {.translation = bad}}), InputError) << bad;
    EXPECT_THROW(assemble_tree(stem, {.root = {.rotation = bad}}), InputError) << bad;
  }
}

TEST(AssembleTree, RefusesAMaterialThatIsNone) {
  EXPECT_THROW(assemble_tree(test::straight_stem(1, 1, 0.1, 0.1), {.material = {"m", -1, 1, 1, ""}}),
               InputError);
}

TEST(BeamTree, InAFluidBendingIsHeavierByTheFluidThatMovesAlongAndStretchingIsNot) {
  const Skeleton stem = test::straight_stem(6, 2, 0.02, 0.02);
  const StructureOptions dry{.material = wood, .rotatory_inertia = false};
  StructureOptions wet = dry;
  wet.added_mass_density = 1000;
  const BeamTree in_air = assemble_tree(stem, dry), in_water = assemble_tree(stem, wet);
  for (std::size_t k = 0; k < in_air.masses.size(); ++k) {
    const double ratio = (wood.density + 1000) / wood.density;
    EXPECT_LT((in_water.masses[k].bending - ratio * in_air.masses[k].bending).norm(),
              1e-12 * in_water.masses[k].bending.norm());
    EXPECT_EQ(in_water.masses[k].axial, in_air.masses[k].axial);
    EXPECT_EQ(in_water.masses[k].torsion, in_air.masses[k].torsion);
  }
  wet.added_mass_density = -1;
  EXPECT_THROW(assemble_tree(stem, wet), InputError);
}

// Of leaves long and short, on branches with arms: as a matrix, as a product, and by kinetic energy.
TEST(BladeWater, IsTheMassOfTheFluidAlongTheNormalsOfTheBlades) {
  Skeleton skeleton = test::awkward_tree();
  skeleton.leaves[2].branch = skeleton.branch_count() - 1;  // which starts beside its node
  for (Leaf& leaf : skeleton.leaves) {
    leaf.length = 0.5;
    leaf.width = 0.1;
    leaf.area = 0.04;
    leaf.normal = Vec3(1, 2, -0.5).normalized();
    leaf.axis = leaf.normal.unitOrthogonal();
  }
  skeleton.leaves[1].is_ribbon = true;
  skeleton.leaves[1].end_width = 0.3;
  const BeamTree dry = assemble_tree(skeleton, {.gravity = 0});
  const BeamTree wet = assemble_tree(skeleton, {.added_mass_density = 1000, .gravity = 0});
  BeamTree stems = wet;
  stems.blade_water.clear();
  EXPECT_TRUE(dry.blade_water.empty());
  const Eigen::VectorXd u = test::random_vector(wet.size(), 3), v = test::random_vector(wet.size(), 4);
  EXPECT_LT((assemble_sparse(wet).mass * u - apply_mass(wet, u)).norm(), 1e-12 * apply_mass(wet, u).norm());
  EXPECT_NEAR(v.dot(apply_mass(wet, u)), u.dot(apply_mass(wet, v)), 1e-9 * apply_mass(wet, u).norm());
  double energy = 0;
  for (const Leaf& leaf : skeleton.leaves) {
    const Member& member = wet.members[static_cast<std::size_t>(leaf.branch)];
    const EndDisplacements ends = end_displacements(member, u);
    Eigen::Matrix<double, 12, 1> stacked;
    stacked << ends.start_translation, ends.start_rotation, ends.end_translation, ends.end_rotation;
    const double speed = leaf.normal.dot(point_shape(member, leaf.position).transpose() * stacked);
    const double volume = leaf.is_ribbon ? std::numbers::pi / 12 * 0.5 * (0.01 + 0.03 + 0.09)
                                         : std::numbers::pi / 4 * 0.08 * 0.08 * 0.5;
    energy += 1000 * volume * speed * speed;
  }
  EXPECT_NEAR(u.dot(apply_mass(wet, u) - apply_mass(stems, u)), energy, 1e-9 * energy);
}

}  // namespace
}  // namespace tremula
