#include "tremula/structure/heavy_rod.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "complaint.hpp"
#include "rods.hpp"
#include "support.hpp"

namespace tremula {
namespace {

HeavyRod unit_rod(double weight, int pieces = 40) {
  return {.length = 1, .bending_stiffness = 1, .mass = 1, .tip_mass = 0, .gravity = weight, .pieces = pieces};
}

Eigen::Matrix3Xd straight(int pieces, const Vec3& direction = Vec3::UnitZ()) {
  return direction.normalized().replicate(1, pieces);
}

TEST(HeavyRod, HasTheFrequenciesThatItsWeightLeavesIt) {
  TREMULA_NEED_DATA("rods.json");
  const nlohmann::json rods = test::rods();
  for (const auto& [weight, wanted] : rods.at("heavy.standing.omega2").items()) {
    const HeavyRod rod = unit_rod(std::stod(weight));
    const double omega_squared = std::pow(2 * std::numbers::pi * first_frequency(rod), 2);
    EXPECT_NEAR(omega_squared, wanted[0].get<double>(), 0.02) << weight;
    const double frequency = std::sqrt(wanted[0].get<double>()) / (2 * std::numbers::pi);
    EXPECT_NEAR(stiffness_of_frequency(rod, frequency), 1, 2e-3) << weight;
  }
}

TEST(HeavyRod, IsRefusedWhereItsWeightWouldBuckleIt) {
  TREMULA_NEED_DATA("rods.json");
  const double greenhill = test::rods().at("heavy.greenhill.uniform_qL3/EI").get<double>();
  EXPECT_NO_THROW(check_rod(unit_rod(0.995 * greenhill)));
  EXPECT_THROW(check_rod(unit_rod(1.005 * greenhill)), InputError);
}

TEST(HeavyRod, LeansInLinearTheoryAsTheClosedFormsSay) {
  const HeavyRod rod = unit_rod(0);
  EXPECT_NEAR(linear_tip_angle(rod, {.along = 1}), 1.0 / 6, 2e-4);
  EXPECT_NEAR(linear_tip_angle(rod, {.tip = 1}), 1.0 / 2, 2e-4);
  // int (1-s)-weighted load exp(-2a(1-s)): tip angle int_0^1 p(x) x^2/2 dx.
  const double a = 1.3;
  double wanted = 0;
  for (int i = 0; i < 20000; ++i) {
    const double x = (i + 0.5) / 20000;
    wanted += std::exp(-2 * a * (1 - x)) * x * x / 2 / 20000;
  }
  EXPECT_NEAR(linear_tip_angle(rod, {.along = 1, .decay = a}), wanted, 2e-4);
}

TEST(HeavyRod, IsDampedByUniformDragAtTheRateOfTheDragOverTheMass) {
  HeavyRod rod = unit_rod(2);
  rod.mass = 0.25;
  EXPECT_NEAR(damping_rate(rod, {.along = 3}), 12, 1e-3 * 12);
}

TEST(BendRod, IsTheFibreInAFlowThatShedsItsDrag) {
  TREMULA_NEED_DATA("rods.json");
  const nlohmann::json rods = test::rods();
  for (const auto& [cauchy, wanted] : rods.at("fibre.reconfiguration_number").items()) {
    const double load = std::stod(cauchy);
    if (load > 101) continue;
    constexpr int pieces = 80;
    const Eigen::Matrix3Xd bent =
        bend_rod(unit_rod(0, pieces), straight(pieces), {.along = load}, Vec3::UnitX());
    double drag = 0;
    for (Eigen::Index i = 0; i < pieces; ++i) {
      const Vec3 across = Vec3::UnitX() - bent(0, i) * bent.col(i);
      drag += across.norm() * across.x() / pieces;
    }
    EXPECT_NEAR(drag, wanted.get<double>(), 3e-3) << load;
  }
}

TEST(BendRod, BendsAsItLinearlyWouldUnderSmallDragWithWeightToo) {
  for (const double weight : {0.0, 3.0, 6.0}) {
    const HeavyRod rod = unit_rod(weight, 20);
    const RodDrag drag{.along = 1e-4, .tip = 2e-4, .decay = 0.7};
    const Eigen::Matrix3Xd bent = bend_rod(rod, straight(20), drag, Vec3::UnitY());
    EXPECT_NEAR(std::atan2(bent(1, 19), bent(2, 19)), linear_tip_angle(rod, drag), 1e-7);
    EXPECT_LT(bent.row(0).cwiseAbs().maxCoeff(), 1e-12);
  }
}

// A leaning heavy rod with the wind from its side, by the library's other solver.
TEST(BendRod, StandsInAWindFromTheSideWhereTheEquilibriumOfABeamTreeDoes) {
  const int pieces = 40;
  const double weight = 2.5, load = 6;
  const Vec3 lean = Vec3(std::sin(0.6), 0, std::cos(0.6));
  const BeamTree tree = test::rod(pieces, lean);
  const auto loads = [&](double drag) {
    return [&tree, weight, drag, pieces](int k, const BentBranch& branch) {
      const auto force = [&](const Vec3& direction) -> Vec3 {
        const Vec3 across = Vec3::UnitY() - direction.y() * direction;
        return (drag * across.norm() * across - weight * Vec3::UnitZ()) / pieces;
      };
      const Vec3 direction = (branch.end - branch.start).normalized();
      Mat3 turning;
      for (int axis = 0; axis < 3; ++axis) {
        const Vec3 turn = 1e-6 * Vec3::Unit(axis);
        turning.col(axis) =
            (force(direction + turn.cross(direction)) - force(direction - turn.cross(direction))) / 2e-6;
      }
      EndLoads ends;
      add_force(shape_at(tree.members[index_of(k)].beam, 0.5), direction, force(direction), turning, ends);
      return ends;
    };
  };
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(6 * pieces);
  const std::vector<BentBranch> still = bend(tree, none);
  EquilibriumOptions options;
  options.at_rest = forces_on_strains(tree, none, still, sum_wrenches(tree, still, loads(0)).at_end);
  const Equilibrium wanted = find_equilibrium(tree, loads(load), options);
  const Eigen::Matrix3Xd bent =
      bend_rod(unit_rod(weight, pieces), straight(pieces, lean), {.along = load}, Vec3::UnitY());
  const Vec3 tip = bent.rowwise().sum() / pieces;
  EXPECT_LT((tip - wanted.bent.back().end).norm(), 0.01);
  EXPECT_GT((tip - lean).norm(), 0.3);
}

TEST(BendRod, KeepsADrawnCurveWhereNoWindBlows) {
  constexpr int pieces = 20;
  Eigen::Matrix3Xd rest(3, pieces);
  for (int i = 0; i < pieces; ++i) rest.col(i) = Vec3(std::sin(0.1 * i), 0, std::cos(0.1 * i));
  EXPECT_LT((bend_rod(unit_rod(4, pieces), rest, {}, Vec3::UnitX()) - rest).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(BendRod, RefusesWhatIsNoRod) {
  EXPECT_THROW(bend_rod(unit_rod(1, 20), straight(19), {}, Vec3::UnitX()), InputError);
  HeavyRod rod = unit_rod(1);
  rod.length = 0;
  EXPECT_EQ(test::complaint_of([&] { check_rod(rod); }),
            "length of the rod: 0 m, wanted a finite number above 0");
}

}  // namespace
}  // namespace tremula
