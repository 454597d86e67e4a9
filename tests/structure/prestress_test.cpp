#include "tremula/structure/prestress.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>

#include "random_vector.hpp"
#include "support.hpp"
#include "trees.hpp"
#include "tremula/base/error.hpp"
#include "tremula/reference/sparse_matrices.hpp"
#include "tremula/structure/compliance_operator.hpp"
#include "tremula/structure/independent_parts.hpp"
#include "tremula/structure/mode_count.hpp"

namespace tremula {
namespace {

const Material wood{"wood", 9e9, 7e8, 950, ""};

// Thin, with leaves and starts beside their nodes: far from its own weight's worst.
struct Laden {
  Skeleton skeleton = test::awkward_tree();
  StructureOptions options{.material = wood};
  BeamTree bare, tree;

  explicit Laden(const RootSpring& root = {}) {
    skeleton.leaves.front().mass = 0.5;
    options.root = root;
    bare = assemble_tree(skeleton, options);
    tree = under_load(bare, weight(skeleton, options));
  }
};

// --- The exact potential: every branch a rod whose strains are those of its shape functions, followed along
// --- its axis with finite rotations.

using Long = long double;
using Long3 = Eigen::Matrix<Long, 3, 1>;
using LongMat3 = Eigen::Matrix<Long, 3, 3>;

LongMat3 turned_by(const Long3& rotation) {
  const Long angle = rotation.norm();
  if (angle == 0) return LongMat3::Identity();
  return Eigen::AngleAxis<Long>(angle, rotation / angle).toRotationMatrix();
}

class ExactPotential {
 public:
  ExactPotential(const BeamTree& tree, const DeadLoads& loads) : tree_(tree), loads_(loads) {}

  // Of all loads, where the relative displacements (6N) are t times `relative`.
  Long at(const Eigen::VectorXd& relative, Long t) const {
    std::vector<Long3> place(tree_.parent.size());
    std::vector<LongMat3> turn(tree_.parent.size());
    Long potential = 0;
    for (int k = 0; k < tree_.branch_count(); ++k) {
      const int parent = tree_.parent[index_of(k)];
      const Member& member = tree_.members[index_of(k)];
      Path path;
      path.rotation = parent < 0 ? LongMat3(LongMat3::Identity()) : turn[index_of(parent)];
      path.place =
          parent < 0 ? Long3((member.start - member.start_arm).cast<Long>()) : place[index_of(parent)];
      path.place += path.rotation * member.start_arm.cast<Long>();
      potential += follow(k, relative.segment<6>(6 * k), t, path);
      place[index_of(k)] = path.place, turn[index_of(k)] = path.rotation;
    }
    return potential;
  }

 private:
  static constexpr int steps = 200;
  struct Path {
    Long3 place;
    LongMat3 rotation;
  };
  struct Fields {
    Long3 rotation_rate;  // theta'
    Long stretch;
  };

  Fields fields(const Member& member, const Compliance& c, const Vec6& e, double s) const {
    const Strain strain = strain_at(member.beam, c, s);
    const Split end(e.head<3>(), e.tail<3>(), member.direction);
    const Split rate(0, strain.torsion * end.twist, Vec3::Zero(),
                     strain.curvature[0] * end.across + strain.curvature[1] * end.bend);
    return {rate.rotation(member.direction).cast<Long>(), strain.axial * end.along};
  }

  // Magnus's method of fourth order from one place of a branch to the next, Simpson's rule for what it has
  // passed.
  void advance(int k, const Vec6& e, Long t, double from, double to, Path& path) const {
    const Member& member = tree_.members[index_of(k)];
    const Compliance& c = tree_.compliances[index_of(k)];
    const Long3 d = member.direction.cast<Long>();
    const Long h = static_cast<Long>(to - from) * member.beam.length;
    const auto heading = [&](const LongMat3& rotation, double s) -> Long3 {
      return rotation * d * (1 + t * fields(member, c, e, s).stretch);
    };
    const auto rotated = [&](const LongMat3& rotation, double a, double b) -> LongMat3 {
      const double middle = 0.5 * (a + b), offset = (b - a) * std::sqrt(3.0) / 6;
      const Long length = static_cast<Long>(b - a) * member.beam.length;
      const Long3 one = t * fields(member, c, e, middle - offset).rotation_rate;
      const Long3 two = t * fields(member, c, e, middle + offset).rotation_rate;
      return rotation *
             turned_by(length / 2 * (one + two) + std::sqrt(Long(3)) / 12 * length * length * one.cross(two));
    };
    const double half = 0.5 * (from + to);
    const LongMat3 at_half = rotated(path.rotation, from, half), at_end = rotated(at_half, half, to);
    path.place += h / 6 * (heading(path.rotation, from) + 4 * heading(at_half, half) + heading(at_end, to));
    path.rotation = at_end;
  }

  Long follow(int k, const Vec6& e, Long t, Path& path) const {
    const Member& member = tree_.members[index_of(k)];
    Eigen::VectorXd row = Eigen::VectorXd::Zero(6);
    row = e;
    Member alone = member;
    alone.end_row = 0;
    const Vec6 foot = foot_displacement(alone, row);
    path.place += t * foot.head<3>().cast<Long>();
    path.rotation = path.rotation * turned_by(t * foot.tail<3>().cast<Long>());
    std::vector<PointForce> points;
    for (const PointForce& point : loads_.points) {
      if (point.branch == k) points.push_back(point);
    }
    std::ranges::sort(points, {}, &PointForce::position);
    const Long3 by_volume = loads_.per_volume[index_of(k)].cast<Long>();
    const auto area = [&](double s) {
      const Beam& beam = member.beam;
      const Long r = beam.start_radius + s * (beam.end_radius - beam.start_radius);
      return std::numbers::pi_v<Long> * r * r;
    };
    Long potential = 0;
    const Path start = path;
    for (int i = 0; i <= steps; ++i) {
      const double s = static_cast<double>(i) / steps;
      const Long simpson = (i == 0 || i == steps ? 1
                            : i % 2 == 1         ? 4
                                                 : 2) *
                           Long(member.beam.length) / (3 * steps);
      potential -= simpson * area(s) * by_volume.dot(path.place);
      if (i < steps) advance(k, e, t, s, static_cast<double>(i + 1) / steps, path);
    }
    for (const PointForce& point : points) {
      Path part = start;
      for (int i = 0; i < steps; ++i)
        advance(k, e, t, point.position * i / steps, point.position * (i + 1) / steps, part);
      potential -= part.place.dot(point.force.cast<Long>());
    }
    return potential;
  }

  const BeamTree& tree_;
  const DeadLoads& loads_;
};

// The sum of the branches' quadratic forms, of the same relative displacements.
double second_derivative(const BeamTree& tree, const std::vector<GeometricStiffness>& geometric,
                         const Eigen::VectorXd& relative) {
  std::vector<Vec3> rotation(tree.parent.size());
  double sum = 0;
  for (int k = 0; k < tree.branch_count(); ++k) {
    const int parent = tree.parent[index_of(k)];
    const Vec3 carrier = parent < 0 ? Vec3(Vec3::Zero()) : rotation[index_of(parent)];
    const Vec6 e = relative.segment<6>(6 * k);
    sum += e.dot(geometric[index_of(k)].relative * e) + 2 * carrier.dot(geometric[index_of(k)].carried * e);
    rotation[index_of(k)] = carrier + e.tail<3>();
  }
  return sum;
}

// Loads in all directions, along the branches and on their ends.
DeadLoads odd_loads(const Skeleton& skeleton) {
  DeadLoads loads;
  const Eigen::VectorXd numbers = test::random_vector(6 * skeleton.branch_count(), 77);
  for (int k = 0; k < skeleton.branch_count(); ++k) {
    loads.per_volume.emplace_back(1e4 * numbers.segment<3>(6 * k));
    loads.points.push_back({k, k % 3 == 0 ? 1.0 : 0.37, 5 * numbers.segment<3>(6 * k + 3)});
  }
  const int last = skeleton.branch_count() - 1;
  loads.points.push_back({last / 2, 0, Vec3(3, -2, 1)});
  loads.points.push_back({last / 2, 0.8, Vec3(-1, 2, 4)});
  return loads;
}

void expect_the_exact_potential(const Skeleton& skeleton, const RootSpring& root) {
  const BeamTree tree = assemble_tree(skeleton, {.material = wood, .root = root});
  const DeadLoads loads = odd_loads(skeleton);
  const std::vector<GeometricStiffness> geometric = geometric_stiffness(tree, loads);
  const ExactPotential potential(tree, loads);
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    // Each branch bends, twists and stretches as much as it turns.
    const Eigen::VectorXd relative = test::random_vector(tree.size(), seed);
    constexpr Long h = 2e-5L;
    const Long found =
        (potential.at(relative, h) - 2 * potential.at(relative, 0) + potential.at(relative, -h)) / (h * h);
    const double wanted = second_derivative(tree, geometric, relative);
    EXPECT_NEAR(static_cast<double>(found) / wanted, 1, 5e-7) << "direction " << seed;
  }
}

TEST(GeometricStiffnessOf, LoadsIsTheSecondDerivativeOfTheirExactPotential) {
  expect_the_exact_potential(test::random_tree(5, 3), {});
  const Skeleton tapered = test::straight_stem(1, 2, 0.05, 0.01, Vec3(0.3, 0.4, 1).normalized());
  expect_the_exact_potential(tapered, {});
}

TEST(GeometricStiffnessOf, LoadsHoldsForStartsBesideTheirNodesAndForSprings) {
  expect_the_exact_potential(test::awkward_tree(), {});
  expect_the_exact_potential(test::awkward_tree(), {.translation = 2e5, .rotation = 3e3});
}

TEST(GeometricStiffnessOf, LoadsRefusesThoseThatAreOnNoBranch) {
  const BeamTree tree = assemble_tree(test::straight_stem(2, 1, 0.1, 0.1), {});
  const std::vector<Vec3> none(2, Vec3::Zero());
  EXPECT_THROW(geometric_stiffness(tree, {{Vec3::Zero()}, {}}), InputError);
  EXPECT_THROW(geometric_stiffness(tree, {none, {{2, 0.5, Vec3::UnitX()}}}), InputError);
  EXPECT_THROW(geometric_stiffness(tree, {none, {{-1, 0.5, Vec3::UnitX()}}}), InputError);
  EXPECT_THROW(geometric_stiffness(tree, {none, {{1, 1.5, Vec3::UnitX()}}}), InputError);
}

TEST(Weight, IsThatOfTheMasses) {
  const Laden laden;
  const DeadLoads loads = weight(laden.skeleton, laden.options);
  Vec3 sum = Vec3::Zero();
  double mass = 0;
  for (int k = 0; k < laden.bare.branch_count(); ++k) {
    sum += volume_beyond(laden.bare.members[index_of(k)].beam, 0).volume * loads.per_volume[index_of(k)];
    mass += laden.bare.masses[index_of(k)].axial.sum();
  }
  for (const PointForce& point : loads.points) sum += point.force;
  EXPECT_NEAR(sum.z(), -9.81 * mass, 1e-12 * 9.81 * mass);
  EXPECT_EQ(sum.head<2>().norm(), 0);
}

TEST(Weight, UnderWaterIsThatOfWhatTheWoodIsHeavierThanTheWater) {
  Skeleton skeleton = test::straight_stem(1, 1, 0.1, 0.1);
  skeleton.leaves.push_back({.branch = 0, .mass = 2});
  const DeadLoads wet =
      weight(skeleton, {.material = {"wood", 9e9, 7e8, 950, ""}, .added_mass_density = 1000, .gravity = 10});
  EXPECT_NEAR(wet.per_volume[0].z(), 500, 1e-9);
  EXPECT_EQ(wet.points[0].force.norm(), 0);
}

TEST(Weight, OfASealedTubeUnderWaterIsLessByAllThatItDisplaces) {
  Skeleton skeleton = test::straight_stem(1, 2, 0.1, 0.1);
  skeleton.branches[0].wall = 0.25;
  const StructureOptions options{
      .material = {"wood", 9e9, 7e8, 950, ""}, .added_mass_density = 1000, .gravity = 10};
  const double outer = std::numbers::pi * 0.1 * 0.1 * 2, bore = 0.75 * 0.75 * outer;
  const BeamTree tree = assemble_tree(skeleton, options);
  const double force =
      volume_beyond(tree.members[0].beam, 0).volume * weight(skeleton, options).per_volume[0].z();
  EXPECT_NEAR(force, 10 * (1000 * outer - 950 * (outer - bore)), 1e-9 * 1e4 * outer);
  EXPECT_GT(force, 0);
}

TEST(UnderLoad, TheStaticSolveUndoesTheStiffness) {
  for (const RootSpring& root : {RootSpring{}, RootSpring{.translation = 1e5, .rotation = 5e3}}) {
    const Laden laden(root);
    const Eigen::VectorXd force = test::random_vector(laden.tree.size(), 5);
    EXPECT_LT((apply_stiffness(laden.tree, solve_static(laden.tree, force)) - force).norm(),
              1e-9 * force.norm());
    const Eigen::MatrixXd stiffness = assemble_sparse(laden.tree).stiffness;
    const Eigen::VectorXd u = test::random_vector(laden.tree.size(), 6);
    EXPECT_LT((stiffness * u - apply_stiffness(laden.tree, u)).norm(), 1e-12 * (stiffness * u).norm());
    EXPECT_GT((stiffness - Eigen::MatrixXd(assemble_sparse(laden.bare).stiffness)).norm(), 1);
  }
}

TEST(UnderLoad, ThePackedOperatorIsThePlainForm) {
  const StructureOptions options{.material = wood, .gravity = 1e-3};
  for (const int branches : {1, 7, 62, 700}) {
    for (const Skeleton& skeleton :
         {test::random_tree(branches, 4), test::straight_stem(branches, 3, 0.1, 0.02)}) {
      const BeamTree tree = under_load(assemble_tree(skeleton, options), weight(skeleton, options));
      ComplianceOperator packed(tree);
      const Eigen::VectorXd s = test::random_vector(tree.size(), 9), wanted = apply_compliance_form(tree, s);
      Eigen::VectorXd out(packed.size());
      const double product = packed.apply(packed.packed(s), out);
      EXPECT_LT((packed.unpacked(out) - wanted).norm(), 1e-13 * wanted.norm()) << branches;
      EXPECT_NEAR(product, s.dot(wanted), 1e-13 * s.norm() * wanted.norm());
    }
  }
}

TEST(UnderLoad, ThePackedOperatorIsThePlainFormWhereTheTreeIsCutIntoBlocks) {
  const Skeleton skeleton = test::random_tree(20000, 9);
  const StructureOptions options{.material = wood, .gravity = 1e-3};
  const BeamTree tree = under_load(assemble_tree(skeleton, options), weight(skeleton, options));
  ComplianceOperator packed(tree);
  const Eigen::VectorXd s = test::random_vector(tree.size(), 9), wanted = apply_compliance_form(tree, s);
  Eigen::VectorXd out(packed.size());
  packed.apply(packed.packed(s), out);
  EXPECT_LT((packed.unpacked(out) - wanted).norm(), 1e-13 * wanted.norm());
}

TEST(UnderLoad, APartIsUnderItsOwnLoad) {
  const Laden laden;
  for (const std::vector<int>& branches : independent_parts(laden.tree)) {
    const BeamTree part = part_of(laden.tree, branches);
    const Eigen::VectorXd force = test::random_vector(part.size(), 3);
    Eigen::VectorXd whole = Eigen::VectorXd::Zero(laden.tree.size());
    for (std::size_t i = 0; i < branches.size(); ++i)
      whole.segment<6>(6 * branches[i]) = force.segment<6>(6 * static_cast<Eigen::Index>(i));
    const Eigen::VectorXd wanted = solve_static(laden.tree, whole), found = solve_static(part, force);
    for (std::size_t i = 0; i < branches.size(); ++i) {
      EXPECT_EQ(found.segment<6>(6 * static_cast<Eigen::Index>(i)), wanted.segment<6>(6 * branches[i]));
    }
  }
}

TEST(UnderLoad, MoreThanAPlantCanStandUnderIsRefused) {
  const Skeleton stem = test::straight_stem(8, 1, 0.001, 0.001);
  const BeamTree tree = assemble_tree(stem, {.material = wood});
  const StructureOptions heavy{.material = wood, .gravity = 1000};
  EXPECT_THROW(under_load(tree, weight(stem, heavy)), InputError);
}

// A twig that cannot bear its load is freed of it, and the rest stands as if it had none.
TEST(TakeLoad, FreesATwigThatGivesWayWhereThatIsAllowed) {
  Skeleton skeleton = test::straight_stem(10, 3, 0.1, 0.08);
  skeleton.branches.push_back(test::make_branch(10, {0, 0, 3}, {0, 0, 3.4}, 0.001, 0.001));
  skeleton.branches.push_back(test::make_branch(11, {0, 0, 3.4}, {0, 0, 3.8}, 0.001, 0.001));
  const BeamTree tree = assemble_tree(skeleton, {});
  DeadLoads loads{std::vector<Vec3>(tree.parent.size(), Vec3(0, 0, -8000)), {{11, 1.0, Vec3(0, 0, -20)}}};
  BeamTree stands = tree;
  EXPECT_FALSE(take_load(geometric_stiffness(tree, loads), stands));
  ASSERT_TRUE(take_load(geometric_stiffness(tree, loads), stands, 0.3));
  const Eigen::VectorXd force = test::random_vector(tree.size(), 3);
  const Eigen::VectorXd moved = solve_static(stands, force);
  EXPECT_LT((apply_stiffness(stands, moved) - force).norm(), 1e-6 * force.norm());
  EXPECT_TRUE(stands.geometric.back().relative.isZero(0));
  EXPECT_FALSE(stands.geometric.front().relative.isZero(0));
}

}  // namespace
}  // namespace tremula
