#include "tremula/dynamics/damping.hpp"

#include "tremula/base/error.hpp"
#include "tremula/modes/solve_modes.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>
#include <Eigen/Eigenvalues>

#include "trees.hpp"

namespace tremula {
namespace {

using std::numbers::pi;

Eigen::Matrix3Xd steady(const Vec3& wind, int branches) { return wind.replicate(1, branches); }

TEST(AerodynamicDamping, OfARowOfCylindersIsTheClosedForm) {
  // A uniform stem across a uniform wind: along the wind rho C D U a metre, across it half of that. With
  // modes of unit mass (rotatory inertia apart) that is rho C D U / (rho_w A) on the diagonal, nothing
  // beside.
  const double radius = 0.02, speed = 7, density = 1.2, drag = 1.1;
  const Skeleton stem = test::straight_stem(24, 3, radius, radius);
  const Material wood = find_material("birch");
  const Structure structure = assemble(stem, test::weightless({.material = wood, .rotatory_inertia = false}));
  const Sites sites = structure.find_sites();
  const Loads loads = linearise_loads(sites, steady({speed, 0, 0}, 24),
                                      {.fluid_density = density, .branch_drag_coefficient = drag});
  const Modes modes = solve_modes(structure, {.count = 6});
  const Eigen::MatrixXd damping = aerodynamic_damping(sites, loads, modes.shapes);
  const double along = density * drag * 2 * radius * speed / (wood.density * pi * radius * radius);
  // Pairs of equal frequency are turned as they come: the sum of a pair is 3/2 of the rate along the wind.
  for (const int r : {0, 2, 4}) {
    EXPECT_NEAR(damping.diagonal().segment(r, 2).sum(), 1.5 * along, 1e-9 * along) << r;
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> pair(damping.block(r, r, 2, 2));
    EXPECT_NEAR(pair.eigenvalues()[0], 0.5 * along, 1e-9 * along);
    EXPECT_NEAR(pair.eigenvalues()[1], along, 1e-9 * along);
  }
  EXPECT_LT((damping.block(0, 2, 2, 4)).cwiseAbs().maxCoeff(), 1e-6 * along);
}

TEST(AerodynamicDamping, TakesEnergyFromEveryMotion) {
  const Skeleton skeleton = test::awkward_tree();
  const Structure structure = assemble(skeleton, test::weightless());
  const Sites sites = structure.find_sites();
  const Loads loads = linearise_loads(sites, steady({5, 1, 0}, skeleton.branch_count()));
  const Modes modes = solve_modes(structure, {.count = 8});
  const Eigen::MatrixXd damping = aerodynamic_damping(sites, loads, modes.shapes);
  EXPECT_LT((damping - damping.transpose()).norm(), 1e-12 * damping.norm());
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(damping);
  EXPECT_GT(solver.eigenvalues().minCoeff(), 0);
}

TEST(AerodynamicDamping, OfALeafIsItsDragAtItsPlace) {
  // A stem whose own drag is switched off, with one leaf: D = phi(leaf)^T J phi(leaf).
  Skeleton skeleton = test::straight_stem(2, 1, 0.02, 0.01);
  Leaf leaf;
  leaf.branch = 1;
  leaf.position = 1;
  leaf.base = Vec3(0, 0, 1);
  leaf.length = leaf.width = 0.1;
  leaf.area = 0.01;
  leaf.mass = 0.002;
  skeleton.leaves.push_back(leaf);
  const Structure structure = assemble(skeleton, test::weightless());
  const Sites sites = structure.find_sites();
  const LoadOptions options{
      .branch_drag_coefficient = 0, .leaf_drag_coefficient = 0.4, .foliage = {.vogel_exponent = 0}};
  const Loads loads = linearise_loads(sites, steady({8, 0, 0}, 2), options);
  const Modes modes = solve_modes(structure, {.count = 4});
  const Eigen::MatrixXd damping = aerodynamic_damping(sites, loads, modes.shapes);
  const double rate = 0.5 * 1.2 * 0.4 * 0.01 * 8;
  const Mat3 drag = rate * Vec3(2, 1, 1).asDiagonal();
  const Eigen::MatrixXd tip = modes.shapes.middleRows<3>(6);
  EXPECT_LT((damping - tip.transpose() * drag * tip).norm(), 1e-12 * damping.norm());
}

TEST(AerodynamicDamping, IsNoneWithoutWindAndForLoadsAsPrinted) {
  const Skeleton skeleton = test::random_tree(12, 2);
  const Structure structure = assemble(skeleton, test::weightless());
  const Sites sites = structure.find_sites();
  const Modes modes = solve_modes(structure, {.count = 3});
  const Loads calm = linearise_loads(sites, steady(Vec3::Zero(), 12));
  EXPECT_EQ(aerodynamic_damping(sites, calm, modes.shapes).norm(), 0);
  const Loads printed = linearise_loads(sites, steady({5, 0, 0}, 12), {.model = LoadModel::paper});
  EXPECT_EQ(aerodynamic_damping(sites, printed, modes.shapes).norm(), 0);
}

TEST(StructuralDamping, IsByRatioByMassOrByStiffness) {
  const Eigen::Vector2d omega(3, 10);
  EXPECT_EQ(structural_damping({.ratio = 0.02}, omega), Eigen::Vector2d(2 * 0.02 * 3, 2 * 0.02 * 10));
  EXPECT_EQ(structural_damping({.mass_proportional = 0.3}, omega), Eigen::Vector2d(0.3, 0.3));
  // F eq. 9 and section 6.1 with errata F8: tau_0 = 1 s at 2 Hz is c = 2/(tau_0 (2 pi f)^2), and the motion
  // of that mode has fallen to 1/e after tau_0: exp(-c omega^2 t/2).
  const double c = 2 / std::pow(2 * pi * 2, 2);
  EXPECT_NEAR(c, 1.267e-2, 5e-6);
  const Eigen::VectorXd rate =
      structural_damping({.stiffness_proportional = c}, Eigen::VectorXd::Constant(1, 2 * pi * 2));
  EXPECT_NEAR(std::exp(-0.5 * rate[0] * 1.0), std::exp(-1.0), 1e-12);
}

TEST(StructuralDamping, OfADecayTimeLetsTheFirstModeFallToOneEthAndOthersByStiffness) {
  const Eigen::Vector3d omega(3, 10, 40);
  const Eigen::VectorXd rate = structural_damping({.decay_time = 4}, omega);
  EXPECT_NEAR(std::exp(-0.5 * rate[0] * 4), std::exp(-1.0), 1e-14);
  const double c = rate[0] / (omega[0] * omega[0]);
  EXPECT_LT((rate - structural_damping({.stiffness_proportional = c}, omega)).norm(), 1e-13 * rate.norm());
}

TEST(StructuralDamping, ModeByModeGoesOnWithTheLastRatio) {
  const Eigen::Vector4d omega(3, 5, 10, 20);
  EXPECT_EQ(structural_damping({.ratios = Eigen::Vector2d(0.1, 0.02)}, omega),
            Eigen::VectorXd(2 * Eigen::Vector4d(0.1, 0.02, 0.02, 0.02).cwiseProduct(omega)));
  EXPECT_DOUBLE_EQ(structural_damping({.ratios = Eigen::Vector2d(0.1, 0.02)}, omega.head(1))[0], 0.6);
  EXPECT_EQ(structural_damping({.ratios = Eigen::VectorXd::Constant(1, 0.03)}, omega),
            structural_damping({.ratio = 0.03}, omega));
}

TEST(StructuralDamping, RefusesWhatIsNotAboveZeroAndTwoAtOnce) {
  const Eigen::Vector2d omega(3, 10);
  for (const double bad : {0.0, -1.0, static_cast<double>(NAN)}) {
    EXPECT_THROW(structural_damping({.ratio = bad}, omega), InputError);
    EXPECT_THROW(structural_damping({.mass_proportional = bad}, omega), InputError);
    EXPECT_THROW(structural_damping({.stiffness_proportional = bad}, omega), InputError);
    EXPECT_THROW(structural_damping({.decay_time = bad}, omega), InputError);
    EXPECT_THROW(structural_damping({.ratios = Eigen::Vector3d(0.1, 0.1, bad)}, omega), InputError);
  }
  EXPECT_THROW(structural_damping({.ratios = Eigen::VectorXd::Constant(1, 0.1), .decay_time = 1}, omega),
               InputError);
  EXPECT_THROW(structural_damping({.mass_proportional = 1, .stiffness_proportional = 1}, omega), InputError);
}

}  // namespace
}  // namespace tremula
