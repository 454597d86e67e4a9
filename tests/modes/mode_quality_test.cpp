#include "tremula/modes/mode_quality.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "frames.hpp"
#include "trees.hpp"
#include "tremula/modes/solve_modes.hpp"
#include "tremula/reference/sparse_matrices.hpp"

namespace tremula {
namespace {

const Material wood{"wood", 9e9, 7e8, 950, ""};

struct Assessed {
  Structure structure;
  Modes modes;
  ModeQuality quality;
};

Assessed assess(const Skeleton& skeleton, const StructureOptions& options, int count) {
  Assessed result{assemble(skeleton, test::weightless(options)), {}, {}};
  result.modes = solve_modes(result.structure, {.count = count});
  result.quality = assess_modes(result.structure, result.modes, trunk_branches(skeleton));
  return result;
}

// M (1_x 1_y 1_z) in the rows of the free nodes by apply_mass alone: massless branches below the roots make
// the clamped nodes free ones that can be moved.
Eigen::MatrixX3d forces_of_moved_ground(const Skeleton& skeleton, const StructureOptions& options) {
  const int roots = skeleton.root_count();
  Skeleton lifted;
  for (int root = 0; root < roots; ++root) {
    const Vec3 foot = skeleton.roots[std::size_t(root)] - Vec3::UnitZ();
    lifted.roots.push_back(foot);
    lifted.branches.push_back(test::make_branch(root, foot, foot + Vec3::UnitZ(), 0.01, 0.01));
  }
  for (Branch branch : skeleton.branches) {
    branch.start_node += roots;
    lifted.branches.push_back(branch);
  }
  for (Leaf leaf : skeleton.leaves) {
    leaf.branch += roots;
    lifted.leaves.push_back(leaf);
  }
  BeamTree tree = assemble_tree(lifted, options);
  std::fill_n(tree.masses.begin(), roots, ElementMass{});
  Eigen::MatrixX3d forces(6 * skeleton.branch_count(), 3);
  for (int d = 0; d < 3; ++d) {
    Eigen::VectorXd moved = Eigen::VectorXd::Zero(tree.size());
    for (Eigen::Index row = d; row < moved.size(); row += 6) moved[row] = 1;
    forces.col(d) = apply_mass(tree, moved).tail(forces.rows());
  }
  return forces;
}

TEST(ModeQuality, EffectiveMassesOfAllModesAddUpToWhatTheGroundCanMove) {
  const Skeleton skeleton = test::awkward_tree();
  const StructureOptions options{.material = wood};
  const Assessed all = assess(skeleton, options, all_modes);
  const Eigen::MatrixXd mass = assemble_sparse(assemble_tree(skeleton, options)).mass;
  const Eigen::MatrixX3d forces = forces_of_moved_ground(skeleton, options);
  const Mat3 movable = forces.transpose() * mass.llt().solve(forces);
  // Completeness holds between directions too.
  const Mat3 found = all.quality.participation.transpose() * all.quality.participation;
  EXPECT_LT((found - movable).norm(), 1e-10 * movable.norm());
  for (int d = 0; d < 3; ++d) {
    EXPECT_NEAR(all.quality.effective_mass().col(d).sum(), movable(d, d), 1e-10 * movable(d, d));
    EXPECT_LT(movable(d, d), all.quality.total_mass);
  }
}

TEST(ModeQuality, TotalMassIsThatOfWoodAndLeaves) {
  const Skeleton skeleton = test::awkward_tree();
  double mass = 0;
  for (const Branch& branch : skeleton.branches) {
    const double a = branch.start_radius, b = branch.end_radius;
    mass += wood.density * std::numbers::pi / 3 * (a * a + a * b + b * b) * branch.length();
  }
  for (const Leaf& leaf : skeleton.leaves) mass += leaf.mass;
  const Assessed found = assess(skeleton, {.material = wood}, 3);
  EXPECT_NEAR(found.quality.total_mass / mass, 1, 1e-12);
}

TEST(ModeQuality, EffectiveMassesOfAFineStemAddUpToItsMass) {
  for (const int pieces : {10, 20, 40}) {
    const Assessed all = assess(test::straight_stem(pieces, 2, 0.02, 0.02), {.material = wood}, all_modes);
    const Eigen::Vector3d missing =
        Eigen::Vector3d::Ones() - all.quality.effective_mass_share().colwise().sum().transpose();
    // Along the stem the elements are linear. Eliminating them from the tip leaves on the clamped node
    // 1/3 - (1/6)^2/y of a piece's mass, with y = 2/3 - (1/6)^2/y: 1/sqrt(12).
    EXPECT_NEAR(missing[2] * pieces, 1 / std::sqrt(12.0), 1e-9);
    EXPECT_GT(missing.head<2>().minCoeff(), 0);
    EXPECT_LT(missing.head<2>().maxCoeff() * pieces, 0.5);
  }
}

TEST(ModeQuality, BendingOfAUniformCantileverHasTheEffectiveMassOfTheClosedForm) {
  const Assessed found =
      assess(test::straight_stem(40, 2, 0.01, 0.01), {.material = wood, .rotatory_inertia = false}, 8);
  for (int n = 1; n <= 4; ++n) {
    // 1 + cos b cosh b = 0; of cosh - cos - s (sinh - sin) the mean is 2 s/b and the mean square 1.
    double low = (n - 1) * std::numbers::pi, high = n * std::numbers::pi;
    const auto equation = [](double b) { return std::cos(b) + 1 / std::cosh(b); };
    for (int step = 0; step < 100; ++step) {
      const double middle = 0.5 * (low + high);
      (equation(middle) * equation(low) > 0 ? low : high) = middle;
    }
    const double s = (std::cosh(low) + std::cos(low)) / (std::sinh(low) + std::sin(low));
    const double wanted = 4 * s * s / (low * low);
    const Eigen::MatrixX3d share = found.quality.effective_mass_share().middleRows(2 * n - 2, 2);
    // The two modes of a pair may stand at any angle to x and y.
    EXPECT_NEAR(share.col(0).sum(), wanted, 1e-5) << "mode " << n;
    EXPECT_NEAR(share.col(1).sum(), wanted, 1e-5) << "mode " << n;
    EXPECT_NEAR(share.col(2).sum(), 0, 1e-12) << "mode " << n;
  }
}

// ln omega^2 of the lowest modes, by all eigenvalues of the compliance form.
Eigen::ArrayXd log_omega_squares(const BeamTree& tree, int count) {
  Eigen::MatrixXd form(tree.size(), tree.size());
  for (Eigen::Index i = 0; i < tree.size(); ++i)
    form.col(i) = apply_compliance_form(tree, Eigen::VectorXd::Unit(tree.size(), i));
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(form, Eigen::EigenvaluesOnly);
  return -solver.eigenvalues().tail(count).reverse().array().log();
}

// d ln omega^2 of every mode where some of the stiffnesses grow by a relative amount.
using Scale = std::function<void(std::size_t branch, Compliance&, double factor)>;
Eigen::ArrayXd sensitivity(const BeamTree& tree, int count, const Scale& scale) {
  const double step = 1e-4;
  const auto log_omega_square = [&](double change) {
    BeamTree changed = tree;
    for (std::size_t k = 0; k < changed.compliances.size(); ++k) {
      scale(k, changed.compliances[k], std::exp(-change));
    }
    return log_omega_squares(changed, count);
  };
  return (log_omega_square(step) - log_omega_square(-step)) / (2 * step);
}

TEST(ModeQuality, EnergySharesAreTheSensitivitiesOfTheFrequencies) {
  const Skeleton skeleton = test::awkward_tree();
  const std::vector<bool> trunk = trunk_branches(skeleton);
  const int count = 20;
  const Assessed found = assess(skeleton, {.material = wood}, count);
  const BeamTree tree = assemble_tree(skeleton, {.material = wood});
  const auto bending_of = [&](bool of_trunk) {
    return [&trunk, of_trunk](std::size_t k, Compliance& c, double factor) {
      if (trunk[k] != of_trunk) return;
      for (double* value : {&c.deflection, &c.deflection_slope, &c.slope, &c.slope_held}) *value *= factor;
    };
  };
  const auto of_trunk = sensitivity(tree, count, bending_of(true));
  const auto of_branches = sensitivity(tree, count, bending_of(false));
  const auto of_twist =
      sensitivity(tree, count, [](std::size_t, Compliance& c, double factor) { c.torsion *= factor; });
  const auto of_stretch =
      sensitivity(tree, count, [](std::size_t, Compliance& c, double factor) { c.axial *= factor; });
  for (int r = 0; r < count; ++r) {
    const EnergyShares& energy = found.quality.energy[std::size_t(r)];
    EXPECT_NEAR(energy.trunk, of_trunk[r], 1e-6) << "mode " << r + 1;
    EXPECT_NEAR(energy.branch, of_branches[r], 1e-6) << "mode " << r + 1;
    EXPECT_NEAR(energy.torsion, of_twist[r], 1e-6) << "mode " << r + 1;
    EXPECT_NEAR(energy.axial, of_stretch[r], 1e-6) << "mode " << r + 1;
  }
}

TEST(ModeQuality, TheTrunkIsTheAxisOfEveryRoot) {
  Skeleton skeleton = test::straight_stem(3, 3, 0.1, 0.05);
  // A thin branch at the first fork, listed before the stem goes on; a second stem with a twig.
  skeleton.branches.insert(skeleton.branches.begin() + 1,
                           test::make_branch(1, Vec3(0, 0, 1), Vec3(1, 0, 1), 0.02, 0.01));
  skeleton.branches[2].start_node = 1;
  skeleton.branches[3].start_node = 3;
  skeleton.roots.emplace_back(5, 0, 0);
  for (Branch& branch : skeleton.branches) {
    if (branch.start_node > 0) ++branch.start_node;
  }
  skeleton.branches.push_back(test::make_branch(1, Vec3(5, 0, 0), Vec3(5, 0, 1), 0.05, 0.04));
  EXPECT_EQ(trunk_branches(skeleton), (std::vector<bool>{true, false, true, true, true}));
}

TEST(ModeQuality, AStemBendsAsATrunkTwistsAndStretchesAtTheFrequenciesOfARod) {
  const double length = 2;
  const Assessed found = assess(test::straight_stem(20, length, 0.02, 0.02), {.material = wood}, 60);
  for (int r = 0; r < found.modes.count(); ++r) {
    const double frequency = found.modes.frequency[r], across_rod = 4 * length * frequency;
    // Odd multiples of c/4L, up to what twenty linear elements are off.
    const auto is_of_rod = [&](double modulus) {
      const double order = across_rod / std::sqrt(modulus / wood.density);
      const double odd = 2 * std::round((order - 1) / 2) + 1;
      return std::abs(order / odd - 1) < 3e-4 * odd * odd;
    };
    switch (found.quality.kind[std::size_t(r)]) {
      case ModeKind::trunk:
        EXPECT_GT(found.quality.energy[std::size_t(r)].trunk, 1 - 1e-9);
        break;
      case ModeKind::torsion:
        EXPECT_TRUE(is_of_rod(wood.shear_modulus)) << frequency;
        break;
      case ModeKind::axial:
        EXPECT_TRUE(is_of_rod(wood.youngs_modulus)) << frequency;
        break;
      case ModeKind::branch:
        ADD_FAILURE() << "a stem has no branches";
        break;
      case ModeKind::bending:
        ADD_FAILURE() << "a stem has a trunk";
        break;
    }
  }
  const auto count = [&](ModeKind kind) {
    return std::count(found.quality.kind.begin(), found.quality.kind.end(), kind);
  };
  EXPECT_EQ(found.quality.kind.front(), ModeKind::trunk);
  EXPECT_GE(count(ModeKind::torsion), 3);
  EXPECT_GE(count(ModeKind::axial), 1);
}

TEST(ModeQuality, TheLowestModesOfWoodWithoutShearStiffnessAreTorsion) {
  Material soft = wood;
  soft.shear_modulus = 1e5;
  const Assessed found = assess(test::random_tree(40, 3), {.material = soft}, 10);
  for (int r = 0; r < 10; ++r) {
    EXPECT_EQ(found.quality.kind[std::size_t(r)], ModeKind::torsion) << "mode " << r + 1;
  }
}

TEST(ModeQuality, AThinBranchOnAHeavyTrunkMovesAlone) {
  Skeleton skeleton = test::straight_stem(10, 2, 0.1, 0.1);
  const Vec3 start = skeleton.node_position(5);
  skeleton.branches.push_back(test::make_branch(5, start, start + Vec3(1, 0, 0.5), 0.005, 0.003));
  const Assessed found = assess(skeleton, {.material = wood}, 2);
  for (std::size_t r = 0; r < 2; ++r) {
    EXPECT_EQ(found.quality.kind[r], ModeKind::branch);
    EXPECT_LT(found.quality.effective_mass_share().row(Eigen::Index(r)).maxCoeff(), 1e-3);
  }
}

TEST(ModeQuality, OfATreeSaidAsAFrameIsThatOfTheTree) {
  const Skeleton skeleton = test::random_tree(30, 4);
  const int count = 12;
  const Assessed tree = assess(skeleton, {.material = wood}, count);
  const Structure frame = assemble(test::frame_of(skeleton, wood));
  const Modes modes = solve_modes(frame, {.count = count});
  const ModeQuality found = assess_modes(frame, modes, trunk_branches(skeleton));
  EXPECT_NEAR(found.total_mass / tree.quality.total_mass, 1, 1e-12);
  EXPECT_LT((found.participation - tree.quality.participation).norm(),
            1e-5 * tree.quality.participation.norm());
  for (std::size_t r = 0; r < std::size_t{count}; ++r) {
    EXPECT_EQ(found.kind[r], tree.quality.kind[r]) << "mode " << r + 1;
    const EnergyShares &energy = found.energy[r], &wanted = tree.quality.energy[r];
    EXPECT_NEAR(energy.trunk, wanted.trunk, 1e-5) << "mode " << r + 1;
    EXPECT_NEAR(energy.branch, wanted.branch, 1e-5) << "mode " << r + 1;
    EXPECT_NEAR(energy.torsion, wanted.torsion, 1e-5) << "mode " << r + 1;
    EXPECT_NEAR(energy.axial, wanted.axial, 1e-5) << "mode " << r + 1;
  }
}

TEST(ModeQuality, AFrameHasNoTrunkAndBends) {
  const Structure structure = assemble(test::table(4, wood));
  const Modes modes = solve_modes(structure, {.count = 30});
  const ModeQuality found = assess_modes(structure, modes, std::vector<bool>(structure.members.size()));
  EXPECT_EQ(found.kind.front(), ModeKind::bending);
  for (std::size_t r = 0; r < 30; ++r) {
    EXPECT_EQ(found.energy[r].trunk, 0) << "mode " << r + 1;
    EXPECT_NE(found.kind[r], ModeKind::trunk) << "mode " << r + 1;
    EXPECT_NE(found.kind[r], ModeKind::branch) << "mode " << r + 1;
  }
}

// All modes together: 1_d^T M_af M_ff^-1 M_fa 1_d, less than the mass by what hangs on the clamped feet.
TEST(ModeQuality, EffectiveMassesOfAFrameAddUpToWhatTheGroundCanMove) {
  const Structure structure = assemble(test::table(2, wood));
  const Modes modes = solve_modes(structure, {.count = all_modes});
  const ModeQuality found = assess_modes(structure, modes, std::vector<bool>(structure.members.size()));
  const GroundInertia inertia = structure.find_ground_inertia();
  const Eigen::MatrixXd mass = assemble_frame(test::table(2, wood)).mass;
  const Mat3 movable = inertia.forces.transpose() * mass.llt().solve(inertia.forces);
  const Mat3 sum = found.participation.transpose() * found.participation;
  EXPECT_LT((sum - movable).norm(), 1e-9 * movable.norm());
  for (int d = 0; d < 3; ++d) EXPECT_LT(movable(d, d), found.total_mass);
}

}  // namespace
}  // namespace tremula
