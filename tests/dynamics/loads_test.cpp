#include "tremula/dynamics/loads.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "in_wind.hpp"
#include "trees.hpp"
#include "tremula/base/error.hpp"

namespace tremula {
namespace {

const Material wood{"wood", 9e9, 7e8, 950, ""};

// Uniform wind over one branch, at an angle to it; a short branch without wind carries it, so that both ends
// are free.
struct OneBranch {
  Skeleton skeleton;
  Structure structure;
  Vec3 wind{3, 1, -2};

  explicit OneBranch(double end_radius, const Vec3& end = Vec3(0.4, 0.3, 1.1)) {
    skeleton.roots.push_back(-Vec3::UnitZ());
    skeleton.branches.push_back(test::make_branch(0, -Vec3::UnitZ(), Vec3::Zero(), 0.03, 0.03));
    skeleton.branches.push_back(test::make_branch(1, Vec3::Zero(), end, 0.03, end_radius));
    structure = assemble(skeleton, test::weightless({.material = wood}));
  }
  const Member& branch() const { return structure.members[1]; }
  Loads loads(const LoadOptions& options = {}) const {
    Eigen::Matrix3Xd winds = Eigen::Matrix3Xd::Zero(3, 2);
    winds.col(1) = wind;
    return linearise_loads(structure.find_sites(), winds, options);
  }
  Eigen::Matrix<double, 12, 1> mean(const LoadOptions& options = {}) const {
    return test::mean_end_forces(structure, structure.find_sites(), loads(options), 1);
  }
  Eigen::Matrix<double, 12, 3> per_velocity(const LoadOptions& options = {}) const {
    return test::gust_end_forces(structure, structure.find_sites(), loads(options), 1);
  }
  Vec3 normal_wind() const { return wind - branch().direction * branch().direction.dot(wind); }
};

TEST(Loads, OfAUniformBranchAreStamsPrintedMatrix) {
  const OneBranch one(0.03);
  const double l = one.branch().beam.length, r = 0.03;
  const LoadOptions options{.model = LoadModel::paper};
  // S appendix A, each block of B = (B1 B2 B1 -B2)^T transposed, turned to world axes; S eq. 5.
  const Vec3 d = one.branch().direction, y = d.unitOrthogonal(), z = d.cross(y);
  Mat3 r_k, b1 = Mat3::Zero(), b2 = Mat3::Zero();
  r_k << d, y, z;
  b1(1, 1) = b1(2, 2) = l / 2;
  b2(1, 2) = l * l / 12;
  b2(2, 1) = -l * l / 12;
  Eigen::Matrix<double, 12, 3> b;
  b << r_k * b1.transpose() * r_k.transpose(), r_k * b2.transpose() * r_k.transpose(),
      r_k * b1.transpose() * r_k.transpose(), -r_k * b2.transpose() * r_k.transpose();
  const Mat3 projection = Mat3::Identity() - d * d.transpose();
  const Eigen::Matrix<double, 12, 3> wanted =
      options.fluid_density * options.branch_drag_coefficient * r * b * projection;
  EXPECT_LT((one.per_velocity(options) - wanted).norm(), 1e-13 * wanted.norm());
  EXPECT_EQ(one.mean(options).norm(), 0) << "the paper's load has no mean wind";
}

TEST(Loads, AddUpToTheDragOnTheArea) {
  for (const double tip : {0.03, 0.01}) {
    const OneBranch one(tip);
    const double area = 2 * 0.5 * (0.03 + tip) * one.branch().beam.length;
    const Vec3 n = one.normal_wind();
    const Vec3 drag = 0.5 * 1.2 * 1.2 * area * n.norm() * n;
    const auto mean = one.mean();
    EXPECT_LT((mean.segment<3>(0) + mean.segment<3>(6) - drag).norm(), 1e-12 * drag.norm()) << tip;
  }
}

TEST(Loads, HaveTheMomentAboutTheStartThatHandIntegrationGives) {
  const double tip = 0.012;
  const OneBranch one(tip);
  const auto mean = one.mean();
  const double L = one.branch().beam.length;
  const Vec3 n = one.normal_wind(), d = one.branch().direction;
  // int_0^L x 2 r(x) dx, r linear from 0.03
  const double first_moment = 2 * (0.03 * L * L / 2 + (tip - 0.03) * L * L / 3);
  const Vec3 moment = 0.5 * 1.2 * 1.2 * first_moment * n.norm() * d.cross(n);
  const Vec3 found = mean.segment<3>(3) + mean.segment<3>(9) + (L * d).cross(Vec3(mean.segment<3>(6)));
  EXPECT_LT((found - moment).norm(), 1e-12 * moment.norm());
}

TEST(Loads, AreTheDerivativeOfTheDrag) {
  OneBranch one(0.02);
  Leaf leaf;
  leaf.branch = 1;
  leaf.position = 0.7;
  leaf.area = 0.01;
  one.skeleton.leaves.push_back(leaf);
  one.structure = assemble(one.skeleton, test::weightless({.material = wood}));
  for (int axis = 0; axis < 3; ++axis) {
    const double h = 1e-6;
    OneBranch more = one, less = one;
    more.wind[axis] += h;
    less.wind[axis] -= h;
    const Eigen::VectorXd difference = (more.mean() - less.mean()) / (2 * h);
    EXPECT_LT((one.per_velocity().col(axis) - difference).norm(), 1e-8 * difference.norm());
  }
}

TEST(Loads, BendATipAsTheClosedFormOfAUniformLoadSays) {
  // Wind across an upright stem, the same at all heights: q L^4 / (8 E I), in one piece or ten.
  const double L = 2, r = 0.02, speed = 5, I = 3.14159265358979 * std::pow(r, 4) / 4;
  const double q = 0.5 * 1.2 * 1.2 * 2 * r * speed * speed;
  for (const int pieces : {1, 10}) {
    const Skeleton stem = test::straight_stem(pieces, L, r, r);
    const Structure structure = assemble(stem, test::weightless({.material = wood}));
    Eigen::Matrix3Xd wind = Eigen::Matrix3Xd::Zero(3, pieces);
    wind.row(0).setConstant(speed);
    const Sites sites = structure.find_sites();
    const Eigen::VectorXd u = structure.flexibility(mean_force(sites, linearise_loads(sites, wind)));
    EXPECT_NEAR(u[6 * (pieces - 1)] * 8 * wood.youngs_modulus * I / (q * std::pow(L, 4)), 1, 1e-12) << pieces;
  }
}

TEST(Loads, OnASpringBendATipByWhatTheFootGivesWayToo) {
  const double L = 2, r = 0.02, speed = 5, EI = wood.youngs_modulus * 3.14159265358979 * std::pow(r, 4) / 4;
  const double q = 0.5 * 1.2 * 1.2 * 2 * r * speed * speed;
  const RootSpring spring{.translation = 700, .rotation = 900};
  for (const int pieces : {1, 10}) {
    const Skeleton stem = test::straight_stem(pieces, L, r, r);
    const Structure structure = assemble(stem, test::weightless({.material = wood, .root = spring}));
    Eigen::Matrix3Xd wind = Eigen::Matrix3Xd::Zero(3, pieces);
    wind.row(0).setConstant(speed);
    const Sites sites = structure.find_sites();
    const Eigen::VectorXd u = structure.flexibility(mean_force(sites, linearise_loads(sites, wind)));
    const double wanted =
        q * L * (std::pow(L, 3) / (8 * EI) + 1 / spring.translation + L * L / (2 * spring.rotation));
    EXPECT_NEAR(u[6 * (pieces - 1)] / wanted, 1, 1e-12) << pieces;
  }
}

TEST(Loads, VanishForWindAlongABranchAndForNoWind) {
  OneBranch one(0.02);
  one.wind = 4 * one.branch().direction;
  EXPECT_LT(one.mean().norm(), 1e-25);
  one.wind.setZero();
  EXPECT_EQ(one.per_velocity().norm(), 0);
}

TEST(ModalParticipation, IsTheWorkOfTheNodalForces) {
  const Skeleton skeleton = test::random_tree(14, 3);
  for (const RootSpring& root : {RootSpring{}, RootSpring{.translation = 1e3, .rotation = 1e3}}) {
    const Structure structure = assemble(skeleton, test::weightless({.material = wood, .root = root}));
    const Eigen::Matrix3Xd mean = Eigen::Matrix3Xd::Random(3, 14);
    const Sites sites = structure.find_sites();
    const Loads loads = linearise_loads(sites, mean);
    const Eigen::MatrixXd shapes = Eigen::MatrixXd::Random(structure.size(), 5);
    const Eigen::Matrix3Xd velocity = Eigen::Matrix3Xd::Random(3, 14);
    const Eigen::VectorXd wanted = shapes.transpose() * fluctuating_force(sites, loads, velocity);
    const Eigen::VectorXd found =
        modal_participation(sites, loads, shapes).transpose() * Eigen::VectorXd(velocity.reshaped());
    EXPECT_LT((found - wanted).norm(), 1e-13 * wanted.norm());
  }
}

TEST(Loads, RefuseNegativeCoefficients) {
  const OneBranch one(0.02);
  EXPECT_THROW(one.loads({.fluid_density = -1}), InputError);
  EXPECT_THROW(one.loads({.branch_drag_coefficient = -1}), InputError);
  EXPECT_THROW(one.loads({.leaf_drag_coefficient = -1}), InputError);
}

TEST(Loads, OfAFlatBladeHaveALiftAcrossTheWindAndTheSlopeOfTheirOwnMean) {
  // Normal force C_L rho/2 A |u| (u . n) n: at 45 degrees half of it is lift, and central differences of the
  // mean load give the load per velocity.
  Skeleton skeleton = test::straight_stem(1, 1, 0.01, 0.01);
  Leaf leaf;
  leaf.branch = 0;
  leaf.position = 1;
  leaf.base = Vec3(0, 0, 1);
  leaf.normal = Vec3(1, 0, 1).normalized();
  leaf.axis = Vec3::UnitY();
  leaf.length = leaf.width = 0.2;
  leaf.area = 0.03;
  leaf.mass = 0.001;
  skeleton.leaves.push_back(leaf);
  const Structure structure = assemble(skeleton, test::weightless({.material = wood}));
  const LoadOptions options{
      .branch_drag_coefficient = 0, .leaf_drag_coefficient = 0, .leaf_lift_coefficient = 0.7};
  const Sites sites = structure.find_sites();
  const auto loads_in = [&](const Vec3& wind) { return linearise_loads(sites, wind, options); };
  const auto force_in = [&](const Vec3& wind) -> Vec3 {
    return mean_force(sites, loads_in(wind)).head<3>();  // the blade hangs on the tip
  };
  const Vec3 wind(5, 0, 0);
  const double size = 0.5 * 1.2 * 0.7 * 0.03 * 5 * (5 * std::sqrt(0.5));
  const Vec3 at_tip = force_in(wind);
  EXPECT_LT((at_tip - size * leaf.normal).norm(), 1e-12);
  EXPECT_NEAR(at_tip.z(), size * std::sqrt(0.5), 1e-12);  // lift
  const double step = 1e-5;
  for (int c = 0; c < 3; ++c) {
    const Vec3 change = step * Vec3::Unit(c);
    const Vec3 slope = (force_in(wind + change) - force_in(wind - change)) / (2 * step);
    const Vec3 found = fluctuating_force(sites, loads_in(wind), Vec3::Unit(c)).head<3>();
    EXPECT_LT((slope - found).norm(), 1e-8) << c;
  }
}

}  // namespace
}  // namespace tremula
