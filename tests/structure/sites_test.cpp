#include "tremula/structure/sites.hpp"

#include "tremula/base/error.hpp"
#include "tremula/numerics/quadrature.hpp"
#include "tremula/numerics/random.hpp"
#include "tremula/structure/structure.hpp"

#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include "frames.hpp"
#include "trees.hpp"

namespace tremula {
namespace {

const Material wood{"wood", 9e9, 7e8, 950, ""};

Eigen::MatrixXd random_matrix(Eigen::Index rows, Eigen::Index columns, std::uint64_t seed) {
  Eigen::MatrixXd matrix(rows, columns);
  for (Eigen::Index i = 0; i < matrix.size(); ++i) {
    matrix.data()[i] = complex_gaussian({seed, RandomStream::test, 1, static_cast<std::uint64_t>(i)}).real();
  }
  return matrix;
}

// Leaves of several sizes, two of them on one branch.
Skeleton leafy_tree() {
  Skeleton skeleton = test::awkward_tree();
  skeleton.leaves.push_back(skeleton.leaves[1]);
  double area = 0.01;
  for (Leaf& leaf : skeleton.leaves) {
    leaf.area = area *= 1.3;
    leaf.normal = Vec3(0, 1, area).normalized();
  }
  return skeleton;
}

// Elements with both ends free, with the start held, with the end held and with both.
Frame held_every_way() {
  Frame frame = test::table(2, wood);
  for (std::size_t i = 0; i < frame.elements.size(); i += 3) {
    FrameElement& element = frame.elements[i];
    element.end_radius *= 0.6;
    std::swap(element.start_node, element.end_node);
  }
  frame.elements.push_back(test::make_element(0, 2, 0.01, 0.02, wood));
  int held[4] = {};
  const Structure structure = assemble(frame);
  for (const Member& member : structure.members)
    ++held[(member.start_row < 0 ? 1 : 0) + (member.end_row < 0 ? 2 : 0)];
  for (const int count : held) EXPECT_GT(count, 0);
  return frame;
}

struct Named {
  std::string name;
  Structure structure;
};
std::vector<Named> several() {
  return {{"tree", assemble(leafy_tree(), test::weightless({.material = wood}))},
          {"tree on springs",
           assemble(leafy_tree(),
                    test::weightless({.material = wood, .root = {.translation = 1e5, .rotation = 2e3}}))},
          {"frame", assemble(held_every_way())}};
}

TEST(FindSites, TheirAreasAddUpToThoseOfTheCylinders) {
  for (const auto& [name, structure] : several()) {
    const Sites sites = structure.find_sites();
    std::vector<double> area(structure.members.size()), mean_area = area;
    std::vector<int> count(structure.members.size());
    for (const Site& site : sites.sites) {
      if (site.kind != SiteKind::cylinder) continue;
      const auto member = static_cast<std::size_t>(site.point);
      area[member] += site.area;
      mean_area[member] += site.mean_area;
      ++count[member];
      EXPECT_EQ(site.axis, structure.members[member].direction);
    }
    for (std::size_t k = 0; k < structure.members.size(); ++k) {
      const Beam& beam = structure.members[k].beam;
      const double wanted = (beam.start_radius + beam.end_radius) * beam.length;
      EXPECT_NEAR(area[k] / wanted, 1, 1e-14) << name << ", member " << k;
      EXPECT_NEAR(mean_area[k] / wanted, 1, 1e-14) << name << ", member " << k;
      EXPECT_EQ(count[k], 4) << name << ", member " << k;
    }
  }
}

TEST(FindSites, FeelTheWindInTheMiddleOfTheirMember) {
  for (const auto& [name, structure] : several()) {
    const Sites sites = structure.find_sites();
    ASSERT_EQ(sites.point_count(), static_cast<Eigen::Index>(structure.members.size()));
    for (std::size_t k = 0; k < structure.members.size(); ++k) {
      const Member& member = structure.members[k];
      const Vec3 middle = 0.5 * (member.point(0) + member.point(1));
      EXPECT_LT((sites.points.col(static_cast<Eigen::Index>(k)) - middle).norm(), 1e-14) << name;
    }
    for (std::size_t s = 1; s < sites.sites.size(); ++s)
      EXPECT_LE(sites.sites[s - 1].point, sites.sites[s].point) << name;
  }
}

TEST(FindSites, HaveOneBladeForEveryLeafWhereItsBranchCarriesIt) {
  const Skeleton skeleton = leafy_tree();
  const Structure structure = assemble(skeleton, test::weightless({.material = wood}));
  const Sites sites = structure.find_sites();
  const Eigen::VectorXd u = random_matrix(structure.size(), 1, 5);
  std::vector<int> times(skeleton.leaves.size());
  for (std::size_t s = 0; s < sites.sites.size(); ++s) {
    const Site& site = sites.sites[s];
    if (site.kind != SiteKind::blade) continue;
    for (std::size_t i = 0; i < skeleton.leaves.size(); ++i) {
      const Leaf& leaf = skeleton.leaves[i];
      if (leaf.area != site.area) continue;
      ++times[i];
      EXPECT_EQ(site.point, leaf.branch);
      EXPECT_EQ(site.axis, leaf.normal);
      const Member& member = structure.members[static_cast<std::size_t>(leaf.branch)];
      const EndDisplacements ends = end_displacements(member, u);
      Eigen::Matrix<double, 12, 1> stacked;
      stacked << ends.start_translation, ends.start_rotation, ends.end_translation, ends.end_rotation;
      const Vec3 wanted = point_shape(member, leaf.position).transpose() * stacked;
      EXPECT_LT((Vec3(sites.motion(s, s + 1, u)) - wanted).norm(), 1e-14 * u.norm());
    }
  }
  EXPECT_EQ(times, std::vector<int>(skeleton.leaves.size(), 1));
}

TEST(SiteMotion, IsRigidWhereTheWholeStructureIsMovedRigidly) {
  const Vec3 shift(0.3, -0.2, 0.5), turn(0.2, 0.7, -0.4);
  const std::vector<QuadraturePoint> places = gauss_legendre(4);
  for (const auto& [name, structure] : several()) {
    const Sites sites = structure.find_sites();
    Eigen::VectorXd u(structure.size());
    for (const Node& node : structure.nodes) {
      if (node.row >= 0) u.segment<6>(node.row) << shift + turn.cross(node.position), turn;
    }
    const Eigen::MatrixXd motion = sites.motion(0, sites.sites.size(), u);
    std::size_t of_member = 0;
    for (std::size_t s = 0; s < sites.sites.size(); ++s) {
      const Site& site = sites.sites[s];
      of_member = s > 0 && sites.sites[s - 1].point == site.point ? of_member + 1 : 0;
      const Member& member = structure.members[static_cast<std::size_t>(site.point)];
      if (site.kind != SiteKind::cylinder || member.start_row < 0 || member.end_row < 0) continue;
      ASSERT_LT(of_member, places.size());
      const Vec3 wanted = shift + turn.cross(member.point(places[of_member].position));
      EXPECT_LT((motion.block<3, 1>(static_cast<Eigen::Index>(3 * s), 0) - wanted).norm(), 1e-13)
          << name << ", site " << s;
    }
  }
}

TEST(Sites, GatherForcesByTheTransposeOfTheirMotion) {
  for (const auto& [name, structure] : several()) {
    const Sites sites = structure.find_sites();
    const auto count = static_cast<Eigen::Index>(sites.sites.size());
    const Eigen::MatrixXd u = random_matrix(structure.size(), 3, 6);
    const Eigen::Matrix3Xd forces = random_matrix(3, count, 7);
    const Eigen::VectorXd gathered = sites.gather(forces);
    ASSERT_EQ(gathered.size(), structure.size());
    const Eigen::MatrixXd motion = sites.motion(0, sites.sites.size(), u);
    ASSERT_EQ(motion.rows(), 3 * count);
    for (Eigen::Index c = 0; c < u.cols(); ++c) {
      const double work = motion.col(c).dot(forces.reshaped());
      EXPECT_NEAR(gathered.dot(u.col(c)), work, 1e-13 * motion.col(c).norm() * forces.norm()) << name;
    }
    // Row by row: every entry of the transpose.
    const Eigen::MatrixXd matrix =
        sites.motion(0, sites.sites.size(), Eigen::MatrixXd::Identity(structure.size(), structure.size()));
    const Eigen::VectorXd wanted = matrix.transpose() * forces.reshaped();
    EXPECT_LT((gathered - wanted).norm(), 1e-13 * wanted.norm()) << name;
    EXPECT_LT((matrix * u - motion).norm(), 1e-13 * motion.norm()) << name;
  }
}

TEST(SiteTurning, IsThatOfTheBodyWhereItMovesAsOne) {
  for (const auto& [name, structure] : several()) {
    const Sites sites = structure.find_sites();
    Eigen::VectorXd u(structure.size());
    const Vec3 turn(0.3, -0.2, 0.5);
    for (const Node& node : structure.nodes) {
      if (node.row >= 0) u.segment<6>(node.row) << turn.cross(node.position), turn;
    }
    const Eigen::MatrixXd turning = sites.turning(0, sites.sites.size(), u);
    for (std::size_t s = 0; s < sites.sites.size(); ++s) {
      const Member& member = structure.members[index_of(sites.sites[s].point)];
      if (member.start_row < 0 || member.end_row < 0) continue;
      EXPECT_LT((turning.block<3, 1>(static_cast<Eigen::Index>(3 * s), 0) - turn).norm(), 1e-12) << name;
    }
  }
}

TEST(SiteTurning, AcrossTheAxisIsTheSlopeOfTheMotion) {
  const Structure structure = assemble(test::random_tree(12, 7), {.material = wood});
  const Eigen::VectorXd u = random_matrix(structure.size(), 1, 4);
  for (const Member& member : structure.members) {
    const EndDisplacements moved = end_displacements(member, u);
    Eigen::Matrix<double, 12, 1> ends;
    ends << moved.start_translation, moved.start_rotation, moved.end_translation, moved.end_rotation;
    const double h = 1e-5, s = 0.37;
    const Vec3 slope = (point_shape(member, s + h) - point_shape(member, s - h)).transpose() * ends /
                       (2 * h * member.beam.length);
    const Vec3 turned = turn_shape(member, s).transpose() * ends;
    const Vec3 across = slope - slope.dot(member.direction) * member.direction;
    EXPECT_LT((turned.cross(member.direction) - across).norm(), 1e-6 * across.norm());
  }
}

TEST(Sites, OfAMemberHeldAtBothEndsNeitherMoveNorBear) {
  const Structure structure = assemble(held_every_way());
  const Sites sites = structure.find_sites();
  const Eigen::VectorXd u = random_matrix(structure.size(), 1, 8);
  Eigen::Matrix3Xd forces = Eigen::Matrix3Xd::Zero(3, static_cast<Eigen::Index>(sites.sites.size()));
  int held = 0;
  for (std::size_t s = 0; s < sites.sites.size(); ++s) {
    const auto point = static_cast<std::size_t>(sites.sites[s].point);
    const Member& member = structure.members[point];
    if (member.start_row >= 0 || member.end_row >= 0) continue;
    ++held;
    EXPECT_EQ(sites.turning(s, s + 1, u).norm(), 0);
    EXPECT_EQ(sites.motion(s, s + 1, u).norm(), 0);
    forces.col(static_cast<Eigen::Index>(s)) = Vec3(1, 2, 3);
  }
  EXPECT_EQ(held, 4);
  EXPECT_EQ(sites.gather(forces).norm(), 0);
}

TEST(SiteMotion, OfABlockIsThatPartOfTheWhole) {
  const Structure structure = assemble(test::random_tree(1500, 3), test::weightless({.material = wood}));
  const Sites sites = structure.find_sites();
  const Eigen::MatrixXd u = random_matrix(structure.size(), 2, 9);
  const Eigen::MatrixXd whole = sites.motion(0, sites.sites.size(), u);
  const std::vector<SiteBlock> blocks = cut_between_points(sites);
  EXPECT_GT(blocks.size(), 1U);
  std::size_t next = 0;
  for (const auto& [first, last] : blocks) {
    EXPECT_EQ(first, next);
    ASSERT_LT(first, last);
    EXPECT_TRUE(first == 0 || sites.sites[first].point != sites.sites[first - 1].point);
    EXPECT_EQ(sites.motion(first, last, u), whole.middleRows(static_cast<Eigen::Index>(3 * first),
                                                             static_cast<Eigen::Index>(3 * (last - first))));
    next = last;
  }
  EXPECT_EQ(next, sites.sites.size());
}

TEST(Sites, WorkAfterTheStructureIsGone) {
  const auto sites_of = [](const Structure& structure) { return structure.find_sites(); };
  const Sites of_tree = sites_of(assemble(leafy_tree(), test::weightless({.material = wood})));
  const Sites of_frame = sites_of(assemble(held_every_way()));
  for (const Sites& sites : {of_tree, of_frame}) {
    const Eigen::Matrix3Xd forces = Eigen::Matrix3Xd::Ones(3, static_cast<Eigen::Index>(sites.sites.size()));
    const Eigen::VectorXd gathered = sites.gather(forces);
    EXPECT_GT(gathered.norm(), 0);
    EXPECT_TRUE(sites.motion(0, sites.sites.size(), gathered).allFinite());
  }
}

TEST(Sites, RefuseSizesOfAnotherStructure) {
  for (const auto& [name, structure] : several()) {
    const Sites sites = structure.find_sites();
    const auto count = static_cast<Eigen::Index>(sites.sites.size());
    EXPECT_THROW(sites.motion(0, 1, Eigen::VectorXd::Zero(structure.size() - 6)), InputError) << name;
    EXPECT_THROW(sites.motion(0, 1, Eigen::VectorXd::Zero(structure.size() + 6)), InputError) << name;
    EXPECT_THROW(sites.gather(Eigen::Matrix3Xd::Zero(3, count - 1)), InputError) << name;
    EXPECT_THROW(sites.gather(Eigen::Matrix3Xd::Zero(3, count + 1)), InputError) << name;
  }
}

}  // namespace
}  // namespace tremula
