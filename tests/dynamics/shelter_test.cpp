#include "tremula/dynamics/shelter.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "tremula/base/error.hpp"
#include "tremula/dynamics/foliage.hpp"
#include "tremula/geometry/grow.hpp"
#include "tremula/geometry/plants.hpp"

namespace tremula {
namespace {

struct Places {
  Eigen::Matrix3Xd places;
  Eigen::VectorXd drag_area;
};

// Drag in a free wind of speed 1, over rho/2.
double drag(const Places& sites, const Vec3& direction, const ShelterOptions& options = {}) {
  return sites.drag_area.dot(find_shelter(sites.places, sites.drag_area, direction, options).cwiseAbs2());
}

Places stacked(const std::vector<Vec3>& places, double drag_area) {
  Places sites{Eigen::Matrix3Xd(3, static_cast<Eigen::Index>(places.size())), {}};
  for (std::size_t s = 0; s < places.size(); ++s) sites.places.col(static_cast<Eigen::Index>(s)) = places[s];
  sites.drag_area = Eigen::VectorXd::Constant(sites.places.cols(), drag_area);
  return sites;
}

// C a per volume [1/m], 3 m deep, 4 m by 4 m across, from the origin on; ten sites a metre.
Places slab(double density) {
  constexpr double step = 0.1;
  std::vector<Vec3> places;
  for (int i = 0; i < 30; ++i)
    for (int j = 0; j < 40; ++j)
      for (int k = 0; k < 40; ++k) places.push_back(step * Vec3(i + 0.5, j + 0.5, k + 0.5));
  return stacked(places, density * step * step * step);
}

// The grown plant as sites: four pieces a branch, and its leaves.
Places crown(const Skeleton& plant, bool in_leaf, const Vec3& direction) {
  std::vector<Vec3> places;
  std::vector<double> areas;
  for (const Branch& branch : plant.branches) {
    const Vec3 span = branch.end - branch.start;
    for (int i = 0; i < 4; ++i) {
      const double s = (i + 0.5) / 4;
      places.push_back(branch.start + s * span);
      const double radius = branch.start_radius + s * (branch.end_radius - branch.start_radius);
      areas.push_back(1.2 * 2 * radius * span.cross(direction).norm() / 4);
    }
  }
  for (const Leaf& leaf : plant.leaves) {
    if (!in_leaf) break;
    places.push_back(leaf.base + 0.5 * leaf.length * leaf.axis);
    areas.push_back(0.25 * leaf.area);
  }
  Places sites = stacked(places, 0);
  sites.drag_area = Eigen::Map<const Eigen::VectorXd>(areas.data(), sites.drag_area.size());
  return sites;
}

Skeleton preset(const char* name) { return grow(parse_lsystem(find_preset(name).text, name)).skeleton; }

// Leaves folded in the wind that reaches them.
double drag_of_folding_leaves(Places sites, Eigen::Index wood_count, const FoliageLaw& law, double speed) {
  const Eigen::VectorXd unfolded = sites.drag_area;
  for (int iteration = 0; iteration < 20; ++iteration) {
    const Eigen::VectorXd shelter = find_shelter(sites.places, sites.drag_area, Vec3::UnitX());
    for (Eigen::Index s = wood_count; s < unfolded.size(); ++s) {
      const double folded = unfolded[s] * folding_factor(law, speed * shelter[s]);
      sites.drag_area[s] = 0.5 * (sites.drag_area[s] + folded);
    }
  }
  return drag(sites, Vec3::UnitX());
}

TEST(FindShelter, LeavesTheWholeWindToASingleSiteAndToSitesThatStandApart) {
  EXPECT_DOUBLE_EQ(drag(stacked({Vec3(3, 1, 7)}, 0.2), Vec3::UnitX()), 0.2);
  // Beside each other and far off, whatever they take themselves.
  const Places apart = stacked({Vec3(0, 0, 0), Vec3(5, 2, 0), Vec3(-7, 0, 2), Vec3(1, -3, 4)}, 0.2);
  EXPECT_NEAR(drag(apart, Vec3::UnitX()), 4 * 0.2, 1e-12);
}

TEST(FindShelter, LeavesTheWindToALoneTwigAndToALoneTrunk) {
  // A twig half a metre long that the wind meets at an angle, and an upright trunk that fills half a column.
  std::vector<Vec3> places;
  for (int i = 0; i < 20; ++i) places.push_back(Vec3(0, 0, 0.025 * i));
  for (const double angle : {1.57, 1.0, 0.6, 0.2}) {
    const Vec3 direction(std::sin(angle), 0, std::cos(angle));
    const Places twig = stacked(places, 1.2 * 0.01 * 0.025 * std::sin(angle));
    const Eigen::VectorXd shelter = find_shelter(twig.places, twig.drag_area, direction);
    EXPECT_GT(shelter.minCoeff(), 0.99) << angle;
    EXPECT_LE(shelter.maxCoeff(), 1);
  }
  const Places trunk = stacked(places, 1.2 * 0.3 * 0.025);
  EXPECT_GT(find_shelter(trunk.places, trunk.drag_area, Vec3::UnitX()).minCoeff(), 1 - 1e-12);
}

TEST(FindShelter, InAUniformSlabFallsExponentiallyWithDepth) {
  const double density = 0.8;
  const Places sites = slab(density);
  const Eigen::VectorXd shelter =
      find_shelter(sites.places, sites.drag_area, Vec3::UnitX(), {.induction = false});
  int compared = 0;
  for (Eigen::Index s = 0; s < shelter.size(); ++s) {
    const Vec3& place = sites.places.col(s);
    // A cell from the sides, where columns are half empty.
    if (place.x() < 0.0625 || std::abs(place.y() - 2) > 1.4 || std::abs(place.z() - 2) > 1.4) continue;
    // The sites stand in planes 0.1 m apart: the wind before a plane has passed half of such a step less.
    const double wanted = std::exp(-0.5 * density * (place.x() - 0.05));
    EXPECT_NEAR(shelter[s] / wanted, 1, 1e-10) << place.transpose();
    ++compared;
  }
  EXPECT_GT(compared, 10'000);
}

TEST(FindShelter, TakesFromTheWindWhatTheSitesGetOfIt) {
  // Drag is what the momentum loses, u_in^2 - u_out^2 with u_out/u_in = exp(-c a d/2), and the speed that
  // enters an actuator disc of that thrust solves (1 - i)^2 (1 - exp(-c a d)) = 4 i (1 - i).
  const double density = 0.8, depth = 3;
  const Places sites = slab(density);
  const double lost = 1 - std::exp(-density * depth), entering = 1 / (1 + lost / 4);
  for (const bool induction : {false, true}) {
    const Eigen::VectorXd shelter =
        find_shelter(sites.places, sites.drag_area, Vec3::UnitX(), {.induction = induction});
    double thrust = 0;
    for (Eigen::Index s = 0; s < shelter.size(); ++s) {
      const Vec3& place = sites.places.col(s);
      if (std::abs(place.y() - 2) < 1 && std::abs(place.z() - 2) < 1)
        thrust += sites.drag_area[s] * shelter[s] * shelter[s] / 4;  // of a square metre
    }
    // Of the first order in the steps of 0.1 m: each plane has the wind before it and not that within.
    const double before_it = std::exp(0.05 * density);
    EXPECT_NEAR(thrust / (lost * before_it * (induction ? entering * entering : 1)), 1, 0.005);
  }
}

TEST(FindShelter, OfColumnsSideBySideIsThatOfEachAlone) {
  std::vector<Vec3> left, right, both;
  for (int i = 0; i < 20; ++i) {
    left.push_back(Vec3(0.2 * i, 0, 0));
    right.push_back(Vec3(0.2 * i, 8, 0));
  }
  both = left;
  both.insert(both.end(), right.begin(), right.end());
  const double alone = drag(stacked(left, 0.05), Vec3::UnitX());
  EXPECT_LT(alone, 0.8 * 20 * 0.05);
  EXPECT_NEAR(drag(stacked(both, 0.05), Vec3::UnitX()), 2 * alone, 1e-12);
}

TEST(FindShelter, TurnsWithTheWindAndMovesWithThePlant) {
  const Places sites = crown(preset("sapling"), true, Vec3::UnitX());
  const Eigen::VectorXd wanted = find_shelter(sites.places, sites.drag_area, Vec3::UnitX());
  const Mat3 turn = Eigen::AngleAxisd(2.1, Vec3::UnitZ()).toRotationMatrix();
  const Eigen::Matrix3Xd turned = (turn * sites.places).colwise() + Vec3(31.7, -4.3, 2.2);
  const Eigen::VectorXd found = find_shelter(turned, sites.drag_area, turn * Vec3::UnitX());
  EXPECT_LT((found - wanted).cwiseAbs().maxCoeff(), 1e-10);
}

TEST(FindShelter, HardlyDependsOnWhereTheColumnsLie) {
  // A site without drag, far off, moves the mean of the places and with it the columns.
  Places sites = crown(preset("oak"), true, Vec3::UnitX());
  const double before = drag(sites, Vec3::UnitX());
  const Eigen::Index count = sites.places.cols();
  sites.places.conservativeResize(3, count + 1);
  sites.drag_area.conservativeResize(count + 1);
  sites.drag_area[count] = 0;
  for (const double shift : {0.1, 0.25, 0.4}) {
    sites.places.col(count) = sites.places.leftCols(count).rowwise().mean() +
                              shift * static_cast<double>(count + 1) * Vec3(0, 0.7, 1);
    EXPECT_NEAR(drag(sites, Vec3::UnitX()) / before, 1, 0.01) << shift;
  }
}

TEST(FindShelter, ChangesContinuouslyWithThePlaces) {
  // A plant that leans: no step, however it lies in the columns.
  const Places upright = crown(preset("sapling"), true, Vec3::UnitX());
  const auto shelter_at = [&](double slope) {
    Eigen::Matrix3Xd places = upright.places;
    places.row(0) += slope * places.row(2);
    places.row(1) -= 0.3 * slope * places.row(2);
    return find_shelter(places, upright.drag_area, Vec3::UnitX());
  };
  for (double slope = 0; slope < 0.5; slope += 0.02)
    EXPECT_LT((shelter_at(slope + 1e-7) - shelter_at(slope)).cwiseAbs().maxCoeff(), 1e-5) << slope;
}

TEST(FindShelter, MakesTheLeavesOfACrownTwoToThreeTimesTheLoad) {
  // An open-grown oak in leaf had 2 to 3 times the load that it had without leaves (Angelou, Dellwik & Mann
  // 2019, Forestry 92); without shelter this one would have 5.6 times as much.
  for (const char* name : {"oak", "birch"}) {
    const Skeleton plant = preset(name);
    const Places leafed = crown(plant, true, Vec3::UnitX()), bare = crown(plant, false, Vec3::UnitX());
    const double ratio = drag(leafed, Vec3::UnitX()) / drag(bare, Vec3::UnitX());
    EXPECT_GT(ratio, 2) << name;
    EXPECT_LT(ratio, name == std::string("oak") ? 3 : 3.6) << name;
    for (const double cell : {0.25, 1.0}) {
      const ShelterOptions options{.cell = cell};
      EXPECT_NEAR(drag(leafed, Vec3::UnitX(), options) / drag(bare, Vec3::UnitX(), options) / ratio, 1, 0.06)
          << name << ' ' << cell;
    }
  }
}

TEST(FindShelter, WithLeavesThatFoldGivesTheExponentsOfTreesInLeaf) {
  // Branches are rigid here; alone they lower the exponent by up to 0.1 (Angelou, Dellwik & Mann 2019: 1.90
  // to 2.01 without leaves, 1.60 to 1.68 in leaf).
  const Skeleton plant = preset("oak");
  const Places sites = crown(plant, true, Vec3::UnitX());
  const Eigen::Index wood_count = 4 * plant.branch_count();
  const auto drag_at = [&](double speed) { return drag_of_folding_leaves(sites, wood_count, {}, speed); };
  const double exponent = 2 + std::log(drag_at(20) / drag_at(6)) / std::log(20.0 / 6);
  EXPECT_GT(exponent, 1.6);
  EXPECT_LT(exponent, 1.8);
}

TEST(FindShelter, OffIsTheFreeWind) {
  const Places sites = slab(2);
  EXPECT_EQ(find_shelter(sites.places, sites.drag_area, Vec3::UnitX(), {.on = false}),
            Eigen::VectorXd::Ones(sites.drag_area.size()));
}

TEST(FindShelter, TakesNoMoreMemoryForAPlantOfAKilometreInCellsOfAMillimetre) {
  const Places sites = stacked({Vec3(0, 0, 0), Vec3(1000, 0, 0), Vec3(3, 1000, 1000)}, 1e-6);
  const Eigen::VectorXd shelter =
      find_shelter(sites.places, sites.drag_area, Vec3::UnitX(), {.cell = 1e-3, .induction = false});
  EXPECT_EQ(shelter[0], 1);
  EXPECT_NEAR(shelter[1], std::exp(-0.5), 0.4);  // the two may share four columns
  EXPECT_EQ(shelter[2], 1);
}

TEST(FindShelter, RefusesWhatItCannotPlace) {
  const Places sites = stacked({Vec3(0, 0, 0), Vec3(1, 0, 0)}, 0.1);
  const auto refuses = [](const Eigen::Matrix3Xd& places, const Eigen::VectorXd& area, const Vec3& direction,
                          double cell) {
    EXPECT_THROW(find_shelter(places, area, direction, {.cell = cell}), InputError);
  };
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const Vec3 x = Vec3::UnitX();
  refuses(sites.places, Eigen::VectorXd::Ones(3), x, 0.5);
  refuses(sites.places, Eigen::Vector2d(0.1, -0.1), x, 0.5);
  refuses(sites.places, Eigen::Vector2d(0.1, nan), x, 0.5);
  refuses(nan * sites.places, sites.drag_area, x, 0.5);
  for (const Vec3& direction : {Vec3(0, 0, 0), Vec3(2, 0, 0), Vec3(nan, 0, 0)})
    refuses(sites.places, sites.drag_area, direction, 0.5);
  for (const double cell : {0.0, -1.0, nan, 1e-12}) refuses(sites.places, sites.drag_area, x, cell);
  EXPECT_EQ(find_shelter(Eigen::Matrix3Xd(3, 0), Eigen::VectorXd(0), x).size(), 0);
}

}  // namespace
}  // namespace tremula
