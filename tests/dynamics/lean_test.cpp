#include "tremula/dynamics/lean.hpp"

#include "complaint.hpp"
#include "in_wind.hpp"
#include "trees.hpp"
#include "tremula/base/error.hpp"
#include "tremula/dynamics/damping.hpp"
#include "tremula/numerics/rotation.hpp"

#include <atomic>
#include <cmath>
#include <memory>
#include <string>

#include <gtest/gtest.h>

namespace tremula {
namespace {

WindAt steady(const Vec3& velocity) {
  return [velocity](Eigen::Index, const Vec3&) { return GustStatistics{velocity}; };
}

const LeanOptions unsheltered{.shelter = {.on = false}};

Structure leafy() {
  Skeleton skeleton = test::random_tree(40, 6);
  for (int k = 10; k < 40; ++k) {
    Leaf leaf;
    leaf.branch = k;
    leaf.position = 0.8;
    leaf.axis = Vec3(1, 0, 0);
    leaf.normal = Vec3(0, 0.3, 1).normalized();
    leaf.area = 0.05;
    leaf.mass = 0.01;
    skeleton.leaves.push_back(leaf);
  }
  return assemble(skeleton, {});
}

// A bare limp stem across the wind.
Structure limp_stem() { return assemble(test::straight_stem(40, 2, 0.004, 0.004), {}); }

Vec3 ground_force(const Structure& structure, double speed) {
  return find_lean(structure, steady({speed, 0, 0}), {}, unsheltered).wrenches.ground_force;
}

TEST(FindLean, WithoutWindIsTheStructureAtRest) {
  const Structure structure = leafy();
  const Lean lean = find_lean(structure, steady(Vec3::Zero()), {});
  EXPECT_EQ(lean.displacement.norm(), 0);
  EXPECT_TRUE(lean.strains.isZero(0));
}

TEST(FindLean, InALittleWindIsTheStaticDeflectionUnderTheDrag) {
  const Structure structure = leafy();
  const WindAt breeze = steady({0.5, 0.1, 0});
  const Eigen::VectorXd bent = find_lean(structure, breeze, {}, unsheltered).displacement;
  const Eigen::VectorXd linear = find_lean(structure, breeze, {}, test::small_and_free).displacement;
  EXPECT_LT((bent - linear).norm(), 1e-3 * linear.norm());
}

TEST(FindLean, OfSmallRotationsIsTheDeflectionUnderTheMeanDragToTheBit) {
  const Structure structure = leafy();
  const Vec3 wind(7, 2, 0);
  const Lean lean = find_lean(structure, steady(wind), {}, test::small_and_free);
  const Sites sites = structure.find_sites();
  const Loads loads = linearise_loads(sites, wind.replicate(1, sites.point_count()));
  EXPECT_EQ(lean.displacement, structure.flexibility(mean_force(sites, loads)));
}

TEST(FindLean, StandsWhereElasticForcesBalanceTheDragOnTheShapeItHasThere) {
  const Structure structure = leafy();
  const Lean lean = find_lean(structure, steady({15, 3, 0}), {}, unsheltered);
  // What the ground bears is the whole drag that the sites have where they then are.
  Vec3 drag = Vec3::Zero();
  for (const SiteLoad& load : lean.loads.sites) drag += load.mean;
  EXPECT_LT((lean.wrenches.ground_force - drag).head<2>().norm(), 0.01 * drag.norm());
}

TEST(FindLean, OfALimpStemShedsDragByBendingAlone) {
  const Structure structure = limp_stem();
  const double slow = ground_force(structure, 2).x(), faster = ground_force(structure, 2.2).x();
  EXPECT_NEAR(std::log(faster / slow) / std::log(1.1), 2, 0.05);
  const double fast = ground_force(structure, 60).x(), fastest = ground_force(structure, 66).x();
  EXPECT_NEAR(std::log(fastest / fast) / std::log(1.1), 4.0 / 3, 0.05);
}

TEST(FindLean, TurnsWithTheWind) {
  const Structure structure = limp_stem();
  const Lean east = find_lean(structure, steady({9, 0, 0}), {}),
             north = find_lean(structure, steady({0, 9, 0}), {});
  const Eigen::Index tip = structure.size() - 6;
  EXPECT_NEAR(east.displacement[tip], north.displacement[tip + 1], 1e-7);
  EXPECT_NEAR(east.displacement[tip + 2], north.displacement[tip + 2], 1e-7);
}

TEST(FindLean, FeelsTheWindOfTheHeightToWhichItBends) {
  const Structure structure = limp_stem();
  const WindAt sheared = [](Eigen::Index, const Vec3& place) {
    return GustStatistics{Vec3(20 * place.z(), 0, 0)};
  };
  const WindAt as_at_rest = [&structure](Eigen::Index point, const Vec3&) {
    return GustStatistics{Vec3(20 * structure.members[index_of(point)].point(0.5).z(), 0, 0)};
  };
  const auto sinks = [&](const WindAt& wind) {
    return -find_lean(structure, wind, {}).displacement[structure.size() - 4];
  };
  EXPECT_LT(sinks(sheared), 0.95 * sinks(as_at_rest));
}

TEST(FindLean, OfALeafyCrownIsLessWhereItShelters) {
  const Structure structure = leafy();
  const WindAt wind = steady({10, 0, 0});
  const double sheltered = find_lean(structure, wind, {}).wrenches.ground_force.x();
  const double free = find_lean(structure, wind, {}, unsheltered).wrenches.ground_force.x();
  EXPECT_LT(sheltered, 0.98 * free);
  EXPECT_GT(sheltered, 0.4 * free);
}

TEST(FindLean, StandsInTheWindThatItsOwnShelterLeavesThere) {
  const Structure structure = leafy();
  const Vec3 wind(12, 0, 0);
  const Lean lean = find_lean(structure, steady(wind), {});
  // Once more what shelters what, of the lean: by the sites of straight branches, between whose ends its own
  // are bent.
  const LoadLaw law = load_law({});
  Eigen::Matrix3Xd places(3, static_cast<Eigen::Index>(lean.sites.sites.size()));
  Eigen::VectorXd areas(places.cols()), shares(places.cols());
  for (Eigen::Index s = 0; s < places.cols(); ++s) {
    const Site& site = lean.sites.sites[index_of(s)];
    shares[s] = lean.loads.sites[index_of(s)].gust_share;
    places.col(s) = lean.structure.members[index_of(site.point)].point(site.place);
    areas[s] = drag_area(site, shares[s] * wind, law);
  }
  EXPECT_LT((find_shelter(places, areas, wind.normalized()) - shares).cwiseAbs().maxCoeff(), 0.01);
  EXPECT_LT(shares.minCoeff(), 0.9);
}

TEST(FindLean, RefusesAWindThatIsAnotherWheneverItIsAsked) {
  const Structure structure = leafy();
  const auto asked = std::make_shared<std::atomic<int>>(0);
  const int points = static_cast<int>(structure.members.size());
  const WindAt restless = [=](Eigen::Index, const Vec3&) {
    return GustStatistics{Vec3((*asked)++ / points % 2 == 0 ? 0.5 : 1.5, 0, 0)};
  };
  const std::string complaint = test::complaint_of<Error>([&] { find_lean(structure, restless, {}); });
  EXPECT_TRUE(complaint.starts_with("lean: wind and crown do not settle")) << complaint;
}

// d(modal force)/d(coordinate) by bending the structure a little and asking the loads again.
TEST(AerodynamicStiffness, IsHowTheDragOnTheShapesGrowsWithThem) {
  const Structure structure = assemble(test::random_tree(10, 3), {});
  const Sites sites = structure.find_sites();
  const Vec3 wind(9, 2, 1);
  const Eigen::MatrixXd shapes = Eigen::MatrixXd::Random(structure.size(), 3);
  const Eigen::MatrixXd motion = sites.motion(0, sites.sites.size(), shapes);
  const Eigen::MatrixXd turning = sites.turning(0, sites.sites.size(), shapes);
  const LoadLaw law = load_law({});
  Eigen::MatrixXd wanted(3, 3);
  const double h = 1e-6;
  for (Eigen::Index c = 0; c < 3; ++c) {
    Eigen::VectorXd growth = Eigen::VectorXd::Zero(3);
    for (std::size_t s = 0; s < sites.sites.size(); ++s) {
      const auto row = static_cast<Eigen::Index>(3 * s);
      const auto force = [&](double sign) {
        Site site = sites.sites[s];
        site.axis = rotation_matrix(sign * h * turning.block<3, 1>(row, c)) * site.axis;
        return load_on(site, {wind}, 1, law).mean;
      };
      growth += motion.middleRows<3>(row).transpose() * (force(1) - force(-1)) / (2 * h);
    }
    wanted.col(c) = -growth;
  }
  const Loads loads = linearise_loads(sites, wind.replicate(1, sites.point_count()));
  EXPECT_LT((aerodynamic_stiffness(sites, loads, shapes) - wanted).norm(), 1e-6 * wanted.norm());
}

}  // namespace
}  // namespace tremula
