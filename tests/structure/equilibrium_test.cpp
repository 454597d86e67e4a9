#include "tremula/structure/equilibrium.hpp"

#include "random_vector.hpp"
#include "rods.hpp"
#include "support.hpp"
#include "tremula/base/error.hpp"
#include "tremula/numerics/quadrature.hpp"
#include "tremula/numerics/rotation.hpp"

#include <array>

#include <gtest/gtest.h>

namespace tremula {
namespace {

using test::rod;
using test::tip_of;

Vec3 row(const nlohmann::json& values) {
  return Vec3(values[0].get<double>(), values[1].get<double>(), values[2].get<double>());
}

// A load per length that knows the direction of the rod.
BranchLoads per_length(const BeamTree& tree, std::function<Vec3(const Vec3& direction)> load) {
  return [&tree, load = std::move(load)](int k, const BentBranch& branch) {
    static const std::vector<QuadraturePoint> points = gauss_legendre(4);
    const Member& member = tree.members[index_of(k)];
    EndLoads loads;
    for (const QuadraturePoint& point : points) {
      const Vec3 direction = point_on(member, branch, point.position).frame * member.direction;
      Mat3 turning;
      for (int axis = 0; axis < 3; ++axis) {
        const Vec3 turn = 1e-6 * Vec3::Unit(axis);
        turning.col(axis) =
            (load(rotation_matrix(turn) * direction) - load(rotation_matrix(-turn) * direction)) / 2e-6;
      }
      const double length = point.weight * member.beam.length;
      add_force(shape_at(member.beam, point.position), direction, length * load(direction), length * turning,
                loads);
    }
    return loads;
  };
}

BranchLoads at_tip(const BeamTree& tree, const Vec3& force, const Vec3& moment = Vec3::Zero()) {
  return [last = tree.branch_count() - 1, force, moment](int k, const BentBranch&) {
    EndLoads loads;
    if (k == last) loads.end_force = force, loads.end_moment = moment;
    return loads;
  };
}

TEST(FindEquilibrium, IsTheElasticaUnderAForceAtTheTip) {
  TREMULA_NEED_DATA("rods.json");
  const nlohmann::json rods = test::rods();
  for (const auto& [load, wanted] : rods.at("elastica.tip_force").items()) {
    const BeamTree tree = rod(40);
    const Vec3 tip = tip_of(find_equilibrium(tree, at_tip(tree, {std::stod(load), 0, 0})));
    EXPECT_LT((tip - row(wanted)).cwiseAbs().maxCoeff(), 1e-3 * row(wanted).maxCoeff()) << load;
  }
}

TEST(FindEquilibrium, ConvergesWithTheSquareOfTheLengthOfThePieces) {
  TREMULA_NEED_DATA("rods.json");
  const Vec3 wanted = row(test::rods().at("elastica.tip_force").at("5"));
  const auto error = [&](int pieces) {
    const BeamTree tree = rod(pieces);
    return (tip_of(find_equilibrium(tree, at_tip(tree, {5, 0, 0}))) - wanted).norm();
  };
  EXPECT_GT(error(8) / error(16), 3.5);
  EXPECT_GT(error(16) / error(32), 3.5);
}

TEST(FindEquilibrium, BendsUnderADeadLoadPerLengthAsTheBoundaryValueProblemDoes) {
  TREMULA_NEED_DATA("rods.json");
  const nlohmann::json rods = test::rods();
  for (const auto& [load, wanted] : rods.at("uniform.dead").items()) {
    const BeamTree tree = rod(40);
    const Vec3 force(std::stod(load), 0, 0);
    const Vec3 tip = tip_of(find_equilibrium(tree, per_length(tree, [&](const Vec3&) { return force; })));
    EXPECT_LT((tip - row(wanted)).cwiseAbs().maxCoeff(), 1e-3 * row(wanted).maxCoeff()) << load;
  }
}

TEST(FindEquilibrium, BendsUnderALoadThatStaysAcrossTheRod) {
  TREMULA_NEED_DATA("rods.json");
  const nlohmann::json rods = test::rods();
  for (const auto& [load, wanted] : rods.at("uniform.follower").items()) {
    const BeamTree tree = rod(40);
    const double size = std::stod(load);
    const auto across = [&](const Vec3& direction) -> Vec3 {
      return size * Vec3(direction.z(), 0, -direction.x());
    };
    const Vec3 tip = tip_of(find_equilibrium(tree, per_length(tree, across)));
    EXPECT_LT((tip - row(wanted)).cwiseAbs().maxCoeff(), 1e-3 * row(wanted).maxCoeff()) << load;
  }
}

// The drag along the flow of a fibre across it, over that of the straight one.
double reconfiguration_number(int pieces, double cauchy) {
  const BeamTree tree = rod(pieces);
  const auto drag = [&](const Vec3& direction) -> Vec3 {
    const Vec3 flow = Vec3::UnitX(), across = flow - flow.dot(direction) * direction;
    return cauchy * across.norm() * across;
  };
  return find_equilibrium(tree, per_length(tree, drag)).wrenches.ground_force.x() / cauchy;
}

TEST(FindEquilibrium, OfAFibreInAFlowShedsTheDragAsItWasWorkedOutElsewhere) {
  TREMULA_NEED_DATA("rods.json");
  const nlohmann::json rods = test::rods();
  for (const auto& [cauchy, wanted] : rods.at("fibre.reconfiguration_number").items()) {
    EXPECT_NEAR(reconfiguration_number(80, std::stod(cauchy)) / wanted.get<double>(), 1, 0.01) << cauchy;
  }
}

TEST(FindEquilibrium, OfAFibreInAStrongFlowHasVogelsExponentOfTwoThirds) {
  const double exponent =
      std::log(reconfiguration_number(160, 1.2e4) / reconfiguration_number(160, 0.8e4)) / std::log(1.5);
  EXPECT_NEAR(2 * exponent, -2.0 / 3, 0.01);  // c goes with the square of the speed
}

TEST(FindEquilibrium, MakesAQuarterOfACircleUnderAMomentAtTheTip) {
  const BeamTree tree = rod(40);
  const double angle = std::numbers::pi / 2;
  const Equilibrium rest = find_equilibrium(tree, at_tip(tree, Vec3::Zero(), {0, angle, 0}));
  EXPECT_NEAR(rest.bent.back().end.x(), 1 / angle, 2e-4);
  EXPECT_NEAR(rest.bent.back().end.z(), 1 / angle, 2e-4);
  EXPECT_NEAR(tip_of(rest)[2], angle, 1e-9);
}

// Bathe & Bolourchi 1979, Int. J. Num. Meth. Eng. 14: an eighth of a circle of radius 100 in the plane, a
// section of 1 x 1, E = 1e7, no Poisson effect, a force of 600 out of the plane at the tip.
TEST(FindEquilibrium, OfTheFortyFiveDegreeBendEndsWhereBatheAndBolourchiFoundIt) {
  const int pieces = 40;
  const double radius = std::pow(1.0 / 12 * 4 / std::numbers::pi, 0.25);  // I = 1/12
  Skeleton skeleton;
  skeleton.roots.push_back(Vec3::Zero());
  const auto at = [&](int i) {
    const double angle = std::numbers::pi / 4 * i / pieces;
    return Vec3(100 * (1 - std::cos(angle)), 100 * std::sin(angle), 0);
  };
  for (int i = 0; i < pieces; ++i)
    skeleton.branches.push_back(test::make_branch(i, at(i), at(i + 1), radius, radius));
  StructureOptions options;
  options.material.youngs_modulus = 1e7;
  options.material.shear_modulus = 5e6;  // J = 2 I of this section
  const BeamTree tree = assemble_tree(skeleton, options);
  const Vec3 moved = find_equilibrium(tree, at_tip(tree, {0, 0, 600})).bent.back().end - at(pieces);
  EXPECT_NEAR(moved.y(), -23.5, 0.3);
  EXPECT_NEAR(std::abs(moved.x()), 13.6, 0.3);
  EXPECT_NEAR(moved.z(), 53.4, 0.3);
}

TEST(FindEquilibrium, UnderSmallLoadsIsTheStaticDeflection) {
  const BeamTree tree = assemble_tree(test::awkward_tree(), {});
  const Eigen::VectorXd force = 1e-3 * test::random_vector(tree.size(), 4);
  const BranchLoads loads = [&](int k, const BentBranch&) {
    EndLoads load;
    load.end_force = force.segment<3>(6 * k);
    load.end_moment = force.segment<3>(6 * k + 3);
    return load;
  };
  const Eigen::VectorXd wanted = solve_static(tree, force);
  const Eigen::VectorXd found = displacement_of(tree, find_equilibrium(tree, loads).bent);
  EXPECT_LT((found - wanted).norm(), 1e-4 * wanted.norm());
}

TEST(FindEquilibrium, KeepsAGivenShapeUnderALoadThatItAlreadyBears) {
  const BeamTree tree = assemble_tree(test::random_tree(60, 2), {});
  const auto weight = per_length(tree, [](const Vec3&) { return Vec3(0, 0, -80); });
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(tree.size());
  const std::vector<BentBranch> given = bend(tree, none);
  const Equilibrium rest = find_equilibrium(
      tree, weight,
      {.at_rest = forces_on_strains(tree, none, given, sum_wrenches(tree, given, weight).at_end)});
  EXPECT_LT(displacement_of(tree, rest.bent).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(FindEquilibrium, HandsTheWholeLoadToTheGround) {
  const BeamTree tree = assemble_tree(test::awkward_tree(), {});
  const Eigen::VectorXd force = 50 * test::random_vector(tree.size(), 9);
  const BranchLoads loads = [&](int k, const BentBranch&) {
    EndLoads load;
    load.end_force = force.segment<3>(6 * k);
    return load;
  };
  const Equilibrium rest = find_equilibrium(tree, loads);
  Vec3 sum = Vec3::Zero(), moment = Vec3::Zero();
  for (int k = 0; k < tree.branch_count(); ++k) {
    sum += force.segment<3>(6 * k);
    moment += rest.bent[index_of(k)].end.cross(Vec3(force.segment<3>(6 * k)));
  }
  EXPECT_LT((rest.wrenches.ground_force - sum).norm(), 1e-12 * force.norm());
  EXPECT_LT((rest.wrenches.ground_moment - moment).norm(), 1e-12 * force.norm());
}

TEST(FindEquilibrium, OnASoftRootTurnsWholeUnderTheMomentThere) {
  StructureOptions options;
  options.root.rotation = 1e3;
  const BeamTree tree = assemble_tree(test::straight_stem(10, 2, 0.3, 0.3), options);
  const Equilibrium rest = find_equilibrium(tree, at_tip(tree, Vec3::Zero(), {0, 500, 0}));
  EXPECT_NEAR(tip_of(rest)[2], 0.5, 1e-3);
}

// Springs between both ends of every branch and the places where they stand at rest.
BranchLoads springs(const BeamTree& tree, const EndGrowth& stiffness, bool tell_growth) {
  return [=, &tree](int k, const BentBranch& branch) {
    const Member& member = tree.members[index_of(k)];
    Eigen::Matrix<double, 12, 1> moved;
    moved << branch.start - member.start, rotation_vector(branch.start_frame), branch.end - member.point(1),
        rotation_vector(branch.end_frame);
    const Eigen::Matrix<double, 12, 1> force = -stiffness * moved;
    EndLoads loads{force.head<3>(), force.segment<3>(3), force.segment<3>(6), force.tail<3>()};
    loads.end_force += Vec3(200, 100, 0);
    if (tell_growth) loads.growth = -stiffness;
    return loads;
  };
}

TEST(FindEquilibrium, TakesFewStepsWhereItIsToldHowSpringsAnswerAndComesToTheSamePlaceWithout) {
  const BeamTree tree = assemble_tree(test::awkward_tree(), {});
  EndGrowth root;
  for (int i = 0; i < 12; ++i) root.col(i) = test::random_vector(12, index_of(i));
  const EndGrowth stiffness = 0.5 * root * root.transpose();
  const Equilibrium told = find_equilibrium(tree, springs(tree, stiffness, true));
  const Equilibrium untold = find_equilibrium(tree, springs(tree, stiffness, false));
  EXPECT_LE(told.steps, 5);
  EXPECT_GT(untold.steps, told.steps);
  EXPECT_LT((told.strains - untold.strains).norm(), 1e-8 * told.strains.norm());
}

// A force at the tip that falls as the tip sinks.
TEST(FindEquilibrium, EndsWhereLoadsThatTheWholeShapeDecidesHaveSettledToo) {
  const BeamTree tree = rod(8);
  double told = 1;
  const auto force_at = [](const std::vector<BentBranch>& bent) { return 2 * bent.back().end.z(); };
  const BranchLoads loads = [&](int k, const BentBranch&) {
    EndLoads load;
    if (k == 7) load.end_force = Vec3(0, told, 0);
    return load;
  };
  EquilibriumOptions options;
  options.on_shape = [&](const std::vector<BentBranch>& bent) {
    const double before = told;
    told = force_at(bent);
    return std::abs(told - before) < 1e-9;
  };
  const Equilibrium rest = find_equilibrium(tree, loads, options);
  EXPECT_NEAR(rest.wrenches.ground_force.y(), force_at(rest.bent), 1e-8);
}

TEST(FindEquilibrium, RefusesLoadsAtRestOfAnotherTree) {
  const BeamTree tree = rod(4);
  EXPECT_THROW(find_equilibrium(tree, at_tip(tree, Vec3::Zero()), {.at_rest = Eigen::VectorXd::Zero(3)}),
               InputError);
}

}  // namespace
}  // namespace tremula
