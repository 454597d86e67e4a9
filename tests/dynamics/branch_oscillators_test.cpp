#include "tremula/dynamics/branch_oscillators.hpp"

#include "tremula/base/error.hpp"
#include "tremula/dynamics/lean.hpp"
#include "tremula/modes/solve_modes.hpp"
#include "tremula/structure/uniform_beam.hpp"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include "complaint.hpp"
#include "trees.hpp"

namespace tremula {
namespace {

using std::numbers::pi;

struct Case {
  Structure structure;
  Sites sites;
  Loads loads;
  BranchOscillators oscillators;
};

Case oscillators_of(const Skeleton& skeleton, const BranchOscillatorOptions& options = {},
                    const Vec3& wind = {5, 0, 0}, const Damping& damping = {.ratio = 0.03}) {
  Case c{assemble(skeleton, test::weightless()), {}, {}, {}};
  c.sites = c.structure.find_sites();
  c.loads = linearise_loads(c.sites, wind.replicate(1, skeleton.branch_count()));
  c.oscillators = branch_oscillators(c.structure, c.sites, c.loads, damping, options);
  return c;
}

UniformBeam beam_of(double length, double radius) {
  const Material wood = StructureOptions{}.material;
  const RoundSection disc = round_section(radius);
  return {length, wood.youngs_modulus * disc.second_moment, wood.density * disc.area};
}

// A stem up the z axis in six pieces, and a branch along y at a third of its height.
Skeleton tee() {
  Skeleton skeleton = test::straight_stem(6, 3, 0.03, 0.03);
  const Vec3 fork(0, 0, 1);
  for (int i = 0; i < 3; ++i) {
    skeleton.branches.push_back(test::make_branch(i == 0 ? 2 : 6 + i, fork + 0.3 * i * Vec3::UnitY(),
                                                  fork + 0.3 * (i + 1) * Vec3::UnitY(), 0.01, 0.01));
  }
  return skeleton;
}

TEST(BranchOscillators, OfAUniformStemAreTheBeamOfFHoweverItIsCut) {
  const UniformBeam beam = beam_of(2, 0.02);
  for (const int pieces : {1, 3, 20}) {
    const Case c = oscillators_of(test::straight_stem(pieces, 2, 0.02, 0.02), {.modes = 3});
    ASSERT_EQ(c.oscillators.axes.size(), 1U);
    const OscillatorAxis& axis = c.oscillators.axes[0];
    for (int r = 1; r <= 3; ++r) {
      EXPECT_NEAR(axis.omega[r - 1] / natural_omega(beam, r), 1, 1e-8) << pieces << ", " << r;
      // The shear force at the foot, of a coordinate in m sqrt(kg): V has B = 1/sqrt(rho A l).
      const double unit = 1 / std::sqrt(beam.mass_per_length * beam.length);
      EXPECT_NEAR(std::pow(axis.omega[r - 1], 2) * axis.momentum[r - 1] / (-clamp_shear(beam, r) * unit), 1,
                  1e-7)
          << pieces << ", " << r;
    }
  }
}

TEST(BranchOscillators, OfATaperedStemWithLeavesHaveTheFrequenciesOfItsModes) {
  Skeleton skeleton = test::straight_stem(12, 2, 0.02, 0.006);
  for (const double place : {0.2, 0.9}) {
    Leaf leaf;
    leaf.branch = 10;
    leaf.position = place;
    leaf.base = Vec3(0, 0, 1.9);
    leaf.length = leaf.width = 0.1;
    leaf.area = 0.01;
    leaf.mass = 0.02;
    skeleton.leaves.push_back(leaf);
  }
  const Case c = oscillators_of(skeleton, {.modes = 2});
  const Modes modes = solve_modes(c.structure, {.count = 4});
  for (int r = 0; r < 2; ++r)
    EXPECT_NEAR(c.oscillators.axes[0].omega[r] / (2 * pi * modes.frequency[2 * r]), 1, 0.005) << r;
}

TEST(BranchOscillators, HandTheirShearForceToTheParentWhereTheyStandOnIt) {
  const Case c = oscillators_of(tee());
  const BranchOscillators& o = c.oscillators;
  ASSERT_EQ(o.axes.size(), 2U);
  const OscillatorAxis &stem = o.axes[0], &branch = o.axes[1];
  EXPECT_EQ(branch.parent, 0);
  EXPECT_NEAR(branch.attachment, 1.0 / 3, 1e-12);
  ASSERT_TRUE(is_one_way(o.network));
  const double shape = stem.shape.col(0).dot(
      Eigen::Vector4d(clamped_free_shape(1, 1.0 / 3).value, clamped_free_shape(2, 1.0 / 3).value,
                      clamped_free_shape(3, 1.0 / 3).value, clamped_free_shape(4, 1.0 / 3).value));
  for (int i = 0; i < 2; ++i) {
    const double shear = branch.omega[0] * branch.omega[0] * branch.momentum[0];
    for (int j = 0; j < 2; ++j) {
      const double wanted = -shape * shear * stem.across[std::size_t(j)].dot(branch.across[std::size_t(i)]);
      EXPECT_NEAR(o.network.coupling.coeff(o.index(0, 0, j), o.index(1, 0, i)), wanted,
                  1e-9 * std::abs(shear));
    }
  }
}

// A steady gust along y: nothing across the branch, so all of it goes straight on to the stem.
TEST(BranchOscillators, HandOnTheWindThatBlowsAlongThem) {
  Case c = oscillators_of(tee(), {}, {3, 4, 0});
  for (SiteLoad& load : c.loads.sites) load.per_velocity = Mat3::Identity();  // drag along too
  const BranchOscillators o = branch_oscillators(c.structure, c.sites, c.loads, {.ratio = 0.03});
  Eigen::VectorXd gust = Eigen::VectorXd::Zero(3 * c.sites.point_count());
  for (const int point : {6, 7, 8}) gust[3 * point + 1] = 1;  // on the pieces of the branch
  const Eigen::VectorXd force = o.participation * gust;
  EXPECT_NEAR(force.segment<2>(o.index(1, 0, 0)).norm(), 0, 1e-12);
  const double shape = displacement_of(o, c.structure, Eigen::VectorXd::Unit(4, o.index(0, 0, 0)))
                           .segment<3>(6 * 1)
                           .norm();  // of the stem at the fork
  const Vec3 on_stem = force[0] * o.axes[0].across[0] + force[1] * o.axes[0].across[1];
  EXPECT_NEAR((on_stem - 12 * shape * Vec3::UnitY()).norm(), 0, 1e-9);  // four sites on each of three pieces
}

// One mode carries 61 % of an even load, (2 eta/lambda)^2, and all modes all of it.
TEST(BranchOscillators, OfOneModeHandOn61PercentOfASteadyLoadAndMoreModesMore) {
  double before = 0;
  for (const int modes : {1, 2, 5}) {
    const Case c = oscillators_of(test::straight_stem(1, 1, 0.01, 0.01), {.modes = modes});
    const OscillatorAxis& axis = c.oscillators.axes[0];
    const double share = axis.momentum.squaredNorm() / (beam_of(1, 0.01).mass_per_length);
    double wanted = 0;
    for (int r = 1; r <= modes; ++r) wanted += std::pow(clamped_free_mean(r), 2);
    EXPECT_NEAR(share, wanted, 1e-6);
    EXPECT_GT(share, before);
    before = share;
  }
  EXPECT_NEAR(std::pow(clamped_free_mean(1), 2), 0.613, 5e-4);
  EXPECT_GT(before, 0.9);
}

TEST(BranchOscillators, UnderAnEvenSteadyWindBendAsTheBeamDoes) {
  const double length = 2, radius = 0.02;
  const Case c = oscillators_of(test::straight_stem(8, length, radius, radius), {.modes = 4});
  Eigen::VectorXd gust(3 * c.sites.point_count());
  for (Eigen::Index p = 0; p < c.sites.point_count(); ++p) gust.segment<3>(3 * p) = Vec3::UnitX();
  const Eigen::VectorXd force = c.oscillators.participation * gust;
  const Eigen::VectorXd held = force.cwiseQuotient(c.oscillators.network.coupling.diagonal());
  const Eigen::VectorXd u = displacement_of(c.oscillators, c.structure, held);
  const double per_length = (c.loads.sites[0].per_velocity(0, 0)) / (c.sites.sites[0].area / (2 * radius));
  const double tip = per_length * std::pow(length, 4) / (8 * beam_of(length, radius).bending_stiffness);
  EXPECT_NEAR(u[6 * 7] / tip, 1, 1e-3);
  EXPECT_NEAR(u[6 * 7 + 4] / (tip * 4 / (3 * length)), 1, 5e-3);  // turns about y
}

TEST(BranchOscillators, CarryTheirChildrenWithThem) {
  const Case c = oscillators_of(tee());
  const Eigen::VectorXd u =
      displacement_of(c.oscillators, c.structure, Eigen::VectorXd::Unit(4, c.oscillators.index(0, 0, 0)));
  const Vec6 fork = u.segment<6>(6);
  for (int i = 0; i < 3; ++i) {
    const Vec3 arm = 0.3 * (i + 1) * Vec3::UnitY(), turned = fork.tail<3>();
    EXPECT_LT((u.segment<3>(6 * (6 + i)) - (fork.head<3>() + turned.cross(arm))).norm(), 1e-12);
    EXPECT_LT((u.segment<3>(6 * (6 + i) + 3) - turned).norm(), 1e-12);
  }
}

TEST(BranchOscillators, LoseToTheWindWhatTheRowOfCylindersDoes) {
  // As AerodynamicDamping.OfARowOfCylindersIsTheClosedForm: rho C D U/(rho_w A) along the wind, half across.
  const double radius = 0.02, speed = 7;
  const Case c =
      oscillators_of(test::straight_stem(10, 3, radius, radius), {}, {speed, 0, 0}, {.ratio = 0.01});
  const OscillatorAxis& axis = c.oscillators.axes[0];
  const double along =
      1.2 * 1.2 * 2 * radius * speed / (StructureOptions{}.material.density * pi * radius * radius);
  const double wood = 2 * 0.01 * axis.omega[0];
  EXPECT_NEAR(std::abs(axis.across[0].x()), 1, 1e-9);
  EXPECT_NEAR(c.oscillators.network.damping.coeff(0, 0), wood + along, 2e-3 * along);
  EXPECT_NEAR(c.oscillators.network.damping.coeff(1, 1), wood + along / 2, 2e-3 * along);
}

TEST(BranchOscillators, SwingSlowerWithWhatTheyCarry) {
  const double free = oscillators_of(tee()).oscillators.axes[0].omega[0];
  const double laden = oscillators_of(tee(), {.carried_mass = true}).oscillators.axes[0].omega[0];
  EXPECT_LT(laden, free);
  // Rayleigh: the mass of the branch at a third of the stem, with the shape of the stem alone.
  const UniformBeam stem = beam_of(3, 0.03), branch = beam_of(0.9, 0.01);
  const double V = clamped_free_shape(1, 1.0 / 3).value;
  const double more = branch.mass_per_length * branch.length / (stem.mass_per_length * stem.length) * V * V;
  EXPECT_NEAR(std::pow(free / laden, 2), 1 + more, 5e-3 * more);
}

TEST(BranchOscillators, RefuseFramesAndTooManyModes) {
  const Case c = oscillators_of(tee());
  EXPECT_EQ(test::complaint_of([&] { branch_oscillators(c.structure, c.sites, c.loads, {}, {.modes = 9}); }),
            "modes of every branch: 9, wanted 1 to 8");
  Structure frame = c.structure;
  frame.tree = nullptr;
  EXPECT_EQ(test::complaint_of([&] { branch_oscillators(frame, c.sites, c.loads, {}); }),
            "oscillators: a frame, wanted a tree");
  EXPECT_THROW(displacement_of(c.oscillators, c.structure, Eigen::VectorXd::Zero(1)), InputError);
}

}  // namespace
}  // namespace tremula
