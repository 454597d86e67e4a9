#include "tremula/geometry/surface.hpp"

#include "tremula/base/error.hpp"
#include "tremula/geometry/axes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <set>

#include <gtest/gtest.h>
#include <Eigen/Geometry>
#include "trees.hpp"

namespace tremula {
namespace {

using test::make_branch;
using test::random_tree;
using test::straight_stem;

constexpr double pi = std::numbers::pi;

struct Solid {
  double volume = 0;
  double area = 0;
};

Vec3 corner(const Surface& surface, std::uint32_t index) { return surface.position[index].cast<double>(); }

// Of each axis' tube by the divergence theorem, about its own base (float positions far out lose digits).
std::vector<Solid> measure_axes(const Skeleton& skeleton, const Surface& surface) {
  const auto axes = split_into_axes(skeleton);
  std::vector<std::size_t> axis_of(skeleton.branches.size());
  for (std::size_t a = 0; a < axes.size(); ++a) {
    for (const int k : axes[a]) axis_of[std::size_t(k)] = a;
  }
  std::vector<Solid> solids(axes.size());
  for (std::size_t t = 0; t < surface.parts[0].triangles.size(); t += 3) {
    const auto* corners = &surface.parts[0].triangles[t];
    const std::size_t axis = axis_of[std::size_t(surface.branch[corners[0]])];
    const Vec3 base = skeleton.branches[std::size_t(axes[axis][0])].start;
    const Vec3 a = corner(surface, corners[0]) - base;
    const Vec3 b = corner(surface, corners[1]) - base;
    const Vec3 c = corner(surface, corners[2]) - base;
    solids[axis].volume += a.dot(b.cross(c)) / 6;
    solids[axis].area += (b - a).cross(c - a).norm() / 2;
  }
  return solids;
}

Skeleton polyline(const std::vector<Vec3>& points, double radius) {
  Skeleton skeleton;
  skeleton.roots.push_back(points[0]);
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    skeleton.branches.push_back(make_branch(int(i), points[i], points[i + 1], radius, radius));
  }
  return skeleton;
}

double polygon_area(int sides, double radius) {
  return sides / 2.0 * std::sin(2 * pi / sides) * radius * radius;
}

// A vertical trunk of two branches, with a side branch at the node between them.
Skeleton trunk_with_side_branch(double trunk_radius, double side_radius, const Vec3& side_end) {
  Skeleton skeleton = polyline({{0, 0, 0}, {0, 0, 1}, {0, 0, 2}}, trunk_radius);
  skeleton.branches.push_back(make_branch(1, {0, 0, 1}, side_end, side_radius, side_radius));
  return skeleton;
}

// What every surface owes its users, whatever the skeleton.
void expect_sound(const Skeleton& skeleton, const Surface& surface) {
  const std::size_t count = surface.vertex_count();
  ASSERT_EQ(surface.normal.size(), count);
  ASSERT_EQ(surface.texture.size(), count);
  ASSERT_EQ(surface.branch.size(), count);
  ASSERT_EQ(surface.along.size(), count);
  ASSERT_EQ(surface.parts[0].triangles.size() % 3, 0U);
  for (std::size_t v = 0; v < count; ++v) {
    ASSERT_TRUE(surface.position[v].allFinite()) << v;
    ASSERT_NEAR(surface.normal[v].norm(), 1, 1e-5) << v;
    ASSERT_TRUE(surface.branch[v] >= 0 && surface.branch[v] < skeleton.branch_count()) << v;
    ASSERT_TRUE(surface.along[v] >= 0 && surface.along[v] <= 1) << v;
    ASSERT_TRUE(surface.texture[v].x() >= 0 && surface.texture[v].x() <= 1) << v;
    ASSERT_TRUE(surface.texture[v].y() >= 0 && std::isfinite(surface.texture[v].y())) << v;
  }
  ASSERT_EQ(surface.parts.size(), skeleton.leaves.empty() ? 1U : 2U);
  for (const SurfacePart& part : surface.parts) {
    const bool of_leaves = &part == &surface.parts.back() && !skeleton.leaves.empty();
    EXPECT_EQ(part.material.two_sided, of_leaves);
    EXPECT_EQ(part.pieces.count, of_leaves ? skeleton.leaves.size() : 0U);
    for (const std::uint32_t index : part.triangles) {
      ASSERT_LT(index, count);
      for (const SurfacePart& any : surface.parts) {
        if (any.pieces.count > 0) {
          ASSERT_EQ(any.pieces.owns(index), of_leaves);
        }
      }
    }
  }
}

TEST(SplitIntoAxes, EveryBranchBelongsToExactlyOneAxisBelowItsContinuation) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Skeleton skeleton = random_tree(1 + int(seed) * 37, seed);
    std::vector<int> seen(skeleton.branches.size(), 0);
    for (const auto& axis : split_into_axes(skeleton)) {
      ASSERT_FALSE(axis.empty());
      for (const int k : axis) ++seen[std::size_t(k)];
      for (std::size_t i = 1; i < axis.size(); ++i) EXPECT_EQ(skeleton.parent(axis[i]), axis[i - 1]);
    }
    EXPECT_TRUE(std::all_of(seen.begin(), seen.end(), [](int n) { return n == 1; }));
  }
}

TEST(SplitIntoAxes, OfTwoEquallyThickChildrenTheStraightOneContinues) {
  Skeleton skeleton = polyline({{0, 0, 0}, {0, 0, 1}}, 0.1);
  skeleton.branches.push_back(make_branch(1, {0, 0, 1}, {1, 0, 1}, 0.1, 0.1));
  skeleton.branches.push_back(make_branch(1, {0, 0, 1}, {0, 0, 2}, 0.1, 0.1));
  EXPECT_EQ(split_into_axes(skeleton), (std::vector<std::vector<int>>{{0, 2}, {1}}));
}

TEST(SplitIntoAxes, OfTwoEquallyStraightChildrenTheThickOneContinues) {
  Skeleton skeleton = polyline({{0, 0, 0}, {0, 0, 1}}, 0.1);
  skeleton.branches.push_back(make_branch(1, {0, 0, 1}, {0.5, 0, 1.5}, 0.05, 0.05));
  skeleton.branches.push_back(make_branch(1, {0, 0, 1}, {-0.5, 0, 1.5}, 0.09, 0.09));
  EXPECT_EQ(split_into_axes(skeleton), (std::vector<std::vector<int>>{{0, 2}, {1}}));
}

TEST(SplitIntoAxes, OfTwoEqualChildrenTheOneThatCarriesMoreContinues) {
  Skeleton skeleton = polyline({{0, 0, 0}, {0, 0, 1}}, 0.1);
  skeleton.branches.push_back(make_branch(1, {0, 0, 1}, {0.5, 0, 1.5}, 0.09, 0.09));
  skeleton.branches.push_back(make_branch(1, {0, 0, 1}, {-0.5, 0, 1.5}, 0.09, 0.09));
  skeleton.branches.push_back(make_branch(3, {-0.5, 0, 1.5}, {-0.5, 0, 2.5}, 0.09, 0.09));
  EXPECT_EQ(split_into_axes(skeleton), (std::vector<std::vector<int>>{{0, 2, 3}, {1}}));
}

TEST(SplitIntoAxes, NoAxisTurnsBackOnItself) {
  const Skeleton skeleton = polyline({{0, 0, 0}, {0, 0, 1}, {0, 0, 0.5}}, 0.1);
  EXPECT_EQ(split_into_axes(skeleton), (std::vector<std::vector<int>>{{0}, {1}}));
}

TEST(SplitIntoAxes, CylindersThatMissEachOtherBesideTheStemAreOneAxis) {
  Skeleton skeleton = polyline({{0, 0, 0}, {0, 0, 1}}, 0.1);
  skeleton.branches.push_back(make_branch(1, {0, 0.2, 1}, {0, 0.3, 2}, 0.1, 0.1));
  EXPECT_EQ(split_into_axes(skeleton), (std::vector<std::vector<int>>{{0, 1}}));
}

TEST(SplitIntoAxes, OnARigidArmOneThatTurnsAwayOrStartsFarOffIsAnAxisOfItsOwn) {
  Skeleton turns = polyline({{0, 0, 0}, {0, 0, 1}}, 0.1);
  turns.branches.push_back(make_branch(1, {0, 0.2, 1}, {0, 1.2, 1}, 0.1, 0.1));
  EXPECT_EQ(split_into_axes(turns), (std::vector<std::vector<int>>{{0}, {1}}));
  Skeleton far = polyline({{0, 0, 0}, {0, 0, 1}}, 0.1);
  far.branches.push_back(make_branch(1, {0, 1, 1}, {0, 1, 2}, 0.1, 0.1));
  EXPECT_EQ(split_into_axes(far), (std::vector<std::vector<int>>{{0}, {1}}));
}

TEST(SplitIntoAxes, OfTwoEqualChildrenTheOneWithoutAGapContinues) {
  Skeleton skeleton = polyline({{0, 0, 0}, {0, 0, 1}}, 0.1);
  skeleton.branches.push_back(make_branch(1, {0, 0.15, 1}, {0, 0.15, 2}, 0.1, 0.1));
  skeleton.branches.push_back(make_branch(1, {0, 0, 1}, {0, 0, 2}, 0.1, 0.1));
  EXPECT_EQ(split_into_axes(skeleton), (std::vector<std::vector<int>>{{0, 2}, {1}}));
}

TEST(MeshSurface, VolumeAndAreaOfAStemAreThoseOfAPrismWithAPyramid) {
  const double radius = 0.1, length = 2;
  for (const int sides : {3, 4, 7, 16, 64}) {
    const Skeleton skeleton = straight_stem(5, length, radius, radius, Vec3(1, 2, 3).normalized());
    const Surface surface = mesh_surface(skeleton, {.max_sides = sides});
    const Solid solid = measure_axes(skeleton, surface).at(0);
    const double cap = std::min(radius, 0.25 * length / 5);
    const double base = polygon_area(sides, radius);
    const double edge = 2 * radius * std::sin(pi / sides);
    const double slant = std::hypot(cap, radius * std::cos(pi / sides));
    EXPECT_NEAR(solid.volume, base * (length - cap + cap / 3), 1e-6 * solid.volume);
    EXPECT_NEAR(solid.area, base + sides * edge * (length - cap + slant / 2), 1e-6 * solid.area);
  }
}

TEST(MeshSurface, VolumeConvergesToTheConeFrustumWithTheSquareOfTheSides) {
  const double base = 0.2, tip = 0.05, length = 3;
  const Skeleton skeleton = straight_stem(4, length, base, tip);
  const double cap = tip;  // shorter than a quarter of the last branch
  const double ring = tip + (base - tip) * cap / length;
  const double exact =
      pi / 3 * ((length - cap) * (base * base + base * ring + ring * ring) + cap * ring * ring);
  const auto error = [&](int sides) {
    const Surface surface = mesh_surface(skeleton, {.max_sides = sides, .min_sides = sides});
    return exact - measure_axes(skeleton, surface).at(0).volume;
  };
  EXPECT_NEAR(error(8) / error(16), 4, 0.1);
  EXPECT_NEAR(error(16) / error(32), 4, 0.1);
  EXPECT_LT(std::abs(error(256)), 2e-4 * exact);
}

TEST(MeshSurface, MitredBendsKeepTheTubeAsThickAsItsStraightParts) {
  // A prism cut at a slant has the volume of its cross section times its axis, however it is turned.
  const std::vector<Vec3> points = {{0, 0, 0}, {0, 0, 1}, {0.8, 0, 1.6}, {1, 0.9, 2}, {1.5, 1, 3.2}};
  const Skeleton skeleton = polyline(points, 0.07);
  double length = 0;
  for (const Branch& branch : skeleton.branches) length += branch.length();
  for (const int subdivisions : {0, 1, 3}) {
    const Surface surface = mesh_surface(skeleton, {.max_sides = 9, .bend_subdivisions = subdivisions});
    const double expected = polygon_area(9, 0.07) * (length - 0.07 * 2 / 3);
    EXPECT_NEAR(measure_axes(skeleton, surface).at(0).volume, expected, 1e-6 * expected);
  }
}

TEST(MeshSurface, EveryTubeIsAClosedSkinWithItsOutsideOut) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const Skeleton skeleton = random_tree(150, seed);
    const Surface surface = mesh_surface(skeleton);
    // Welded over the seam of the texture, each edge is walked once in either direction.
    std::map<std::array<float, 3>, std::uint32_t> welded;
    std::vector<std::uint32_t> weld(surface.vertex_count());
    for (std::uint32_t v = 0; v < weld.size(); ++v) {
      const Eigen::Vector3f& p = surface.position[v];
      weld[v] = welded.emplace(std::array{p.x(), p.y(), p.z()}, v).first->second;
    }
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    for (std::size_t t = 0; t < surface.parts[0].triangles.size(); t += 3) {
      for (std::size_t e = 0; e < 3; ++e) {
        ++edges[{weld[surface.parts[0].triangles[t + e]], weld[surface.parts[0].triangles[t + (e + 1) % 3]]}];
      }
    }
    for (const auto& [edge, uses] : edges) {
      ASSERT_EQ(uses, 1);
      ASSERT_TRUE(edges.contains({edge.second, edge.first}));
    }
    for (const Solid& solid : measure_axes(skeleton, surface)) EXPECT_GT(solid.volume, 0);
  }
}

TEST(MeshSurface, TheSkinHoldsTheWoodOfTheSkeleton) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const Skeleton skeleton = random_tree(300, seed);
    const Surface surface = mesh_surface(skeleton, {.max_sides = 24, .min_sides = 24});
    double wood = 0;
    for (const Branch& b : skeleton.branches) {
      wood += pi / 3 * b.length() *
              (b.start_radius * b.start_radius + b.start_radius * b.end_radius + b.end_radius * b.end_radius);
    }
    double skin = 0;
    for (const Solid& solid : measure_axes(skeleton, surface)) skin += solid.volume;
    EXPECT_NEAR(skin, wood, 0.12 * wood);
  }
}

TEST(MeshSurface, TheTipVertexLiesExactlyOnTheEndNodeOfEveryAxis) {
  const Skeleton skeleton = random_tree(200, 3);
  const Surface surface = mesh_surface(skeleton);
  for (const auto& axis : split_into_axes(skeleton)) {
    const Branch& last = skeleton.branches[std::size_t(axis.back())];
    int found = 0;
    for (std::size_t v = 0; v < surface.vertex_count(); ++v) {
      if (surface.branch[v] == axis.back() && surface.position[v] == last.end.cast<float>()) {
        EXPECT_EQ(surface.along[v], 1);
        ++found;
      }
    }
    EXPECT_EQ(found, 1);
  }
}

TEST(MeshSurface, EveryVertexStandsOnTheCrossSectionThatCarriesIt) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const Skeleton skeleton = random_tree(200, seed);
    const Surface surface = mesh_surface(skeleton);
    const auto directions = branch_directions(skeleton);
    const auto axes = split_into_axes(skeleton);
    std::vector<std::pair<double, double>> radii(skeleton.branches.size());  // smoothed over the joints
    for (const auto& axis : axes) {
      for (std::size_t i = 0; i < axis.size(); ++i) {
        const Branch& b = skeleton.branches[std::size_t(axis[i])];
        auto& [start, end] = radii[std::size_t(axis[i])];
        start = i == 0 ? b.start_radius
                       : std::sqrt(b.start_radius * skeleton.branches[std::size_t(axis[i - 1])].end_radius);
        end = i + 1 == axis.size()
                  ? b.end_radius
                  : std::sqrt(b.end_radius * skeleton.branches[std::size_t(axis[i + 1])].start_radius);
      }
    }
    for (std::size_t v = 0; v < surface.vertex_count(); ++v) {
      const auto k = std::size_t(surface.branch[v]);
      const double along = surface.along[v];
      const Branch& branch = skeleton.branches[k];
      const double radius = radii[k].first + along * (radii[k].second - radii[k].first);
      const Vec3 offset =
          surface.position[v].cast<double>() - (branch.start + along * (branch.end - branch.start));
      if (offset.norm() < 1e-6) continue;  // a tip
      EXPECT_GT(offset.norm(), radius * 0.999);
      EXPECT_LT(offset.norm(), radius * 1.501);  // mitre or collar
      // Only the rings that two branches share lean out of the cross section.
      if (along < 0.999) {
        EXPECT_NEAR(offset.dot(directions[k]), 0, 1e-4 * branch.length());
      }
    }
  }
}

TEST(MeshSurface, IsSoundOnRandomTrees) {
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    const Skeleton skeleton = random_tree(1 + int(seed) * 20, seed);
    expect_sound(skeleton, mesh_surface(skeleton));
  }
}

// Lengths from nothing to kilometres, radii from hairs to far more than the length, turns back, jumps.
Skeleton hostile_tree(int count, std::uint64_t seed) {
  Skeleton skeleton;
  skeleton.roots = {Vec3(1000, -2000, 3), Vec3::Zero()};
  for (int k = 0; k < count; ++k) {
    const auto draw = [&](std::uint32_t what) {
      return uniform({seed, RandomStream::test, what, std::uint64_t(k)});
    };
    const int node = std::min(int(draw(0) * (k + 2)), k + 1);
    Vec3 start = skeleton.node_position(node);
    if (draw(1) < 0.1) start += Vec3(draw(2), draw(3), draw(4));
    Vec3 direction = Vec3(draw(5) - 0.5, draw(6) - 0.5, draw(7) - 0.5).normalized();
    if (node >= 2 && draw(8) < 0.3) {
      const Branch& below = skeleton.branches[std::size_t(node - 2)];
      if (below.length() > 0) direction = (draw(8) < 0.15 ? -1 : 1) * (below.end - below.start).normalized();
    }
    const double length = draw(9) < 0.2 ? 0 : std::pow(10, 7 * draw(10) - 4);
    const double radius = std::pow(10, 6 * draw(11) - 4);
    skeleton.branches.push_back(make_branch(node, start, start + length * direction, radius,
                                            draw(12) < 0.5 ? radius : std::pow(10, 6 * draw(13) - 4)));
  }
  for (int i = 0; i < count; ++i) {
    Leaf leaf;
    leaf.branch = i;
    leaf.length = i % 2 == 0 ? 1e-6 : 10;
    leaf.width = i % 3 == 0 ? 1e-6 : 10;
    leaf.axis = Vec3(i % 5 == 0 ? 0 : 1, 0, 0);
    leaf.normal = i % 7 == 0 ? leaf.axis : Vec3(0, 0, 1);
    skeleton.leaves.push_back(leaf);
  }
  return skeleton;
}

TEST(MeshSurface, IsSoundOnHostileTrees) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const Skeleton skeleton = hostile_tree(1 + int(seed % 60), seed);
    const Surface surface =
        mesh_surface(skeleton, {.max_sides = 3 + int(seed % 9), .bend_subdivisions = int(seed % 4)});
    expect_sound(skeleton, surface);
    if (HasFatalFailure()) FAIL() << "seed " << seed;
  }
}

TEST(MeshSurface, ManyBranchesOnOneNodeAreSound) {
  Skeleton skeleton = polyline({{0, 0, 0}, {0, 0, 1}}, 0.1);
  for (int i = 0; i < 2000; ++i) {
    const double turn = 0.1 * i;
    skeleton.branches.push_back(
        make_branch(1, {0, 0, 1}, Vec3(std::cos(turn), std::sin(turn), 1 + 0.001 * i), 0.2, 0.01));
  }
  expect_sound(skeleton, mesh_surface(skeleton));
}

TEST(MeshSurface, StairsOfRadiiBecomeATaper) {
  Skeleton skeleton = straight_stem(6, 3, 0.3, 0.3);
  for (std::size_t k = 0; k < 6; ++k) {
    skeleton.branches[k].start_radius = skeleton.branches[k].end_radius = 0.3 * std::pow(0.8, double(k));
  }
  const Surface surface = mesh_surface(skeleton, {.bend_subdivisions = 3});
  std::map<float, float> radius_at_height;
  for (std::size_t v = 0; v + 1 < surface.vertex_count(); ++v) {
    radius_at_height[std::round(surface.position[v].z() * 1e4F)] = surface.position[v].head<2>().norm();
  }
  ASSERT_GT(radius_at_height.size(), 15U);
  float last = std::numeric_limits<float>::max();
  for (auto ring = std::next(radius_at_height.begin()); ring != radius_at_height.end(); ++ring) {
    const float slope =
        (std::prev(ring)->second - ring->second) / (ring->first - std::prev(ring)->first) * 1e4F;
    EXPECT_GE(slope, 0);
    EXPECT_LT(slope, 0.16F);  // the steps are 0.06 over 0.5 at most: nowhere steeper than the mean by a third
    EXPECT_LT(ring->second, last);
    last = ring->second;
  }
}

TEST(MeshSurface, ASideAxisGrowsOutOfTheSkinOfTheOneBelow) {
  for (const Vec3& end : {Vec3(1, 0, 1), Vec3(0.7, 0.3, 1.8), Vec3(-0.5, 0.4, 0.6)}) {
    const Skeleton skeleton = trunk_with_side_branch(0.2, 0.05, end);
    const Surface surface = mesh_surface(skeleton, {.max_sides = 16});
    const Vec3 direction = (end - Vec3(0, 0, 1)).normalized();
    double widest = 0;
    int ring = 0;
    for (std::size_t v = 0; v < surface.vertex_count(); ++v) {
      if (surface.branch[v] != 2) continue;
      const Vec3 p = surface.position[v].cast<double>();
      const double from_trunk = p.head<2>().norm();
      // Nothing shows before the skin of the trunk (whose flat sides lie within its radius).
      EXPECT_GT(from_trunk, 0.95 * 0.2 * std::cos(pi / 16));
      if (from_trunk > 0.2) continue;
      ++ring;
      // There it faces as the trunk does, so that the shading runs over from one to the other.
      EXPECT_NEAR(surface.normal[v].cast<double>().dot(Vec3(p.x(), p.y(), 0).normalized()), 1, 1e-5);
      const Vec3 offset = p - Vec3(0, 0, 1);
      widest = std::max(widest, (offset - direction * offset.dot(direction)).norm());
    }
    EXPECT_GE(ring, 4);
    EXPECT_NEAR(widest, 1.5 * 0.05, 1e-6);
  }
}

TEST(MeshSurface, ABranchOnARigidArmBeginsAtItsOwnStart) {
  Skeleton skeleton = polyline({{0, 0, 0}, {0, 0, 1}, {0, 0, 2}}, 0.1);
  skeleton.branches.push_back(make_branch(1, {0.5, 0, 0.8}, {1.5, 0, 0.8}, 0.05, 0.05));
  const Surface surface = mesh_surface(skeleton);
  float nearest = 10;
  for (std::size_t v = 0; v < surface.vertex_count(); ++v) {
    if (surface.branch[v] == 2) nearest = std::min(nearest, surface.position[v].x());
  }
  EXPECT_FLOAT_EQ(nearest, 0.5F);
}

TEST(MeshSurface, ARigidArmShowsWhereNothingElseReachesTheBranch) {
  for (const double away : {0.14, 0.5}) {  // within the radii of both, 0.15, and clear of them
    Skeleton skeleton = polyline({{0, 0, 0}, {0, 0, 1}, {0, 0, 2}}, 0.1);
    skeleton.branches.push_back(make_branch(1, {away, 0, 0.8}, {away + 1, 0, 0.8}, 0.05, 0.05));
    const Surface surface = mesh_surface(skeleton);
    // The spike's triangles go from the first branch, at whose end the node is, to the start of the third.
    int spikes = 0;
    for (std::size_t t = 0; t < surface.parts[0].triangles.size(); t += 3) {
      std::set<int> branches;
      for (std::size_t c = 0; c < 3; ++c) branches.insert(surface.branch[surface.parts[0].triangles[t + c]]);
      if (branches != std::set<int>{0, 2}) continue;
      ++spikes;
      for (std::size_t c = 0; c < 3; ++c) {
        const std::uint32_t v = surface.parts[0].triangles[t + c];
        EXPECT_EQ(surface.along[v], surface.branch[v] == 0 ? 1 : 0);
        const Vec3 point = corner(surface, v);
        if (surface.branch[v] == 2) {
          EXPECT_LE((point - skeleton.branches[2].start).norm(), 1e-6);
        } else {
          EXPECT_NEAR((point - Vec3(0, 0, 1)).norm(), 0.05, 1e-6);
        }
      }
    }
    EXPECT_EQ(spikes, away > 0.15 ? 3 : 0);  // a triangle for every side
  }
}

TEST(MeshSurface, AForkOfTwoEqualStemsShowsBoth) {
  Skeleton skeleton = polyline({{0, 0, 0}, {0, 0, 1}}, 0.1);
  skeleton.branches.push_back(make_branch(1, {0, 0, 1}, {0.5, 0, 2}, 0.1, 0.1));
  skeleton.branches.push_back(make_branch(1, {0, 0, 1}, {-0.5, 0, 2}, 0.1, 0.1));
  const auto solids = measure_axes(skeleton, mesh_surface(skeleton, {.max_sides = 32}));
  ASSERT_EQ(solids.size(), 2U);
  const double stem = pi * 0.01 * std::sqrt(1.25);
  EXPECT_GT(solids[1].volume, 0.6 * stem);  // what is not inside the other one
  EXPECT_LT(solids[1].volume, stem);
}

TEST(MeshSurface, ThinAxesGetFewerSidesButOneAxisKeepsItsNumber) {
  const Skeleton skeleton = trunk_with_side_branch(0.2, 0.002, {1, 0, 1});
  const Surface surface = mesh_surface(skeleton, {.max_sides = 12, .min_sides = 4});
  // Trunk: base, two rings inside branches, the node, the cap; side axis: two collar rings, one inside, the
  // cap.
  EXPECT_EQ(surface.vertex_count(), 5U * 13 + 1 + 4 * 5 + 1);
  EXPECT_EQ(surface.parts[0].triangles.size() / 3, (12U - 2) + 4 * 2 * 12 + 12 + (4 - 2) + 3 * 2 * 4 + 4);
}

TEST(MeshSurface, AStubbyBranchGetsNoRingInside) {
  const Surface stubby = mesh_surface(straight_stem(1, 0.1, 0.06, 0.06), {.max_sides = 5});
  EXPECT_EQ(stubby.vertex_count(), 2U * 6 + 1);
  const Surface slender = mesh_surface(straight_stem(1, 0.1, 0.01, 0.01), {.max_sides = 5});
  EXPECT_EQ(slender.vertex_count(), 3U * 6 + 1);
}

TEST(MeshSurface, TextureRunsInCircumferencesAlongTheStem) {
  const Surface surface = mesh_surface(straight_stem(4, 2, 0.1, 0.1), {.max_sides = 6});
  for (std::size_t v = 0; v < surface.vertex_count(); ++v) {
    EXPECT_NEAR(surface.texture[v].y(), surface.position[v].z() / (2 * pi * 0.1), 1e-5);
  }
  for (std::size_t i = 0; i <= 6; ++i) EXPECT_FLOAT_EQ(surface.texture[i].x(), float(i) / 6);
  EXPECT_EQ(surface.position[0], surface.position[6]);
}

TEST(MeshSurface, ALeafIsAFoldedBladeFromBaseToTipAsWideAsSaid) {
  Skeleton skeleton = straight_stem(1, 1, 0.01, 0.01);
  Leaf leaf;
  leaf.position = 0.25;
  leaf.base = Vec3(0.1, 0.2, 0.3);
  leaf.axis = Vec3(1, 1, 0).normalized();
  leaf.normal = Vec3(-1, 1, 1).normalized();
  leaf.length = 0.08;
  leaf.width = 0.05;
  skeleton.leaves = {leaf, leaf};
  const Surface surface = mesh_surface(skeleton);
  expect_sound(skeleton, surface);
  ASSERT_EQ(surface.parts.size(), 2U);
  const Pieces& leaves = surface.parts[1].pieces;
  EXPECT_EQ(leaves.count, 2U);
  EXPECT_EQ(leaves.size, leaf_vertices);
  ASSERT_EQ(surface.vertex_count() - leaves.first_vertex, 2 * leaf_vertices);
  ASSERT_EQ(surface.parts[1].triangles.size(), 2 * 3 * leaf_triangle_count);

  const Vec3 across = leaf.axis.cross(leaf.normal);
  double left = 0, right = 0, bottom = 1, top = 0, near = 1, far = 0, area = 0;
  for (std::uint32_t v = leaves.first_vertex; v < leaves.first_vertex + leaf_vertices; ++v) {
    EXPECT_EQ(surface.branch[v], 0);
    EXPECT_FLOAT_EQ(surface.along[v], 0.25F);
    const Vec3 offset = corner(surface, v) - leaf.base;
    EXPECT_NEAR(surface.texture[v].x(), offset.dot(across) / leaf.width + 0.5, 1e-5);
    EXPECT_NEAR(surface.texture[v].y(), offset.dot(leaf.axis) / leaf.length, 1e-5);
    left = std::min(left, offset.dot(across));
    right = std::max(right, offset.dot(across));
    near = std::min(near, offset.dot(leaf.axis));
    far = std::max(far, offset.dot(leaf.axis));
    bottom = std::min(bottom, offset.dot(leaf.normal));
    top = std::max(top, offset.dot(leaf.normal));
    EXPECT_GT(surface.normal[v].cast<double>().dot(leaf.normal), 0.8);
  }
  EXPECT_NEAR(right - left, leaf.width, 1e-7);
  EXPECT_NEAR(near, 0, 1e-7);
  EXPECT_NEAR(far, leaf.length, 1e-7);
  EXPECT_GT(top - bottom, 0.05 * leaf.width);
  for (std::size_t t = 0; t < 3 * leaf_triangle_count; t += 3) {
    const auto* c = &surface.parts[1].triangles[t];
    const Vec3 face =
        (corner(surface, c[1]) - corner(surface, c[0])).cross(corner(surface, c[2]) - corner(surface, c[0]));
    EXPECT_GT(face.dot(leaf.normal), 0);
    area += face.norm() / 2;
  }
  EXPECT_GT(area, 0.6 * leaf.length * leaf.width);
  EXPECT_LT(area, 0.8 * leaf.length * leaf.width);
}

TEST(MeshSurface, LeavesCanBeLeftOut) {
  Skeleton skeleton = straight_stem(1, 1, 0.01, 0.01);
  skeleton.leaves.emplace_back();
  skeleton.leaves[0].length = skeleton.leaves[0].width = 0.1;
  const Surface surface = mesh_surface(skeleton, {.leaves = false});
  EXPECT_EQ(surface.parts.size(), 1U);
}

TEST(MeshSurface, TheSameSkeletonGivesTheSameSkinWhereverItStands) {
  const Skeleton skeleton = random_tree(80, 5);
  Skeleton moved = skeleton;
  const Vec3 shift(3, -4, 5);
  moved.roots[0] += shift;
  for (Branch& branch : moved.branches) {
    branch.start += shift;
    branch.end += shift;
  }
  const Surface here = mesh_surface(skeleton), there = mesh_surface(moved);
  ASSERT_EQ(here.vertex_count(), there.vertex_count());
  EXPECT_EQ(here.parts[0].triangles, there.parts[0].triangles);
  for (std::size_t v = 0; v < here.vertex_count(); ++v) {
    EXPECT_LT((there.position[v] - here.position[v] - shift.cast<float>()).norm(), 1e-5F);
    EXPECT_LT((there.normal[v] - here.normal[v]).norm(), 1e-4F);
  }
}

TEST(MeshSurface, RejectsOptionsOutOfRange) {
  const Skeleton skeleton = straight_stem(1, 1, 0.1, 0.1);
  EXPECT_THROW(mesh_surface(skeleton, {.min_sides = 2}), InputError);
  EXPECT_THROW(mesh_surface(skeleton, {.max_sides = 4, .min_sides = 5}), InputError);
  EXPECT_THROW(mesh_surface(skeleton, {.max_sides = 1000}), InputError);
  EXPECT_THROW(mesh_surface(skeleton, {.bend_subdivisions = -1}), InputError);
}

// Pieces on branches that follow each other make one strip, as wide as they are, that bends with them.
TEST(MeshSurface, MakesOneStripOfARibbonOnSeveralBranches) {
  Skeleton skeleton;
  skeleton.roots.push_back(Vec3::Zero());
  Vec3 at = Vec3::Zero();
  for (int k = 0; k < 4; ++k) {
    const Vec3 next = at + Vec3(0.02 * k, 0, 0.2);
    skeleton.branches.push_back(test::make_branch(k, at, next, 0.001, 0.001));
    const Vec3 axis = (next - at).normalized();
    skeleton.leaves.push_back({.branch = k,
                               .position = 0.5,
                               .base = at,
                               .axis = axis,
                               .normal = axis.cross(Vec3::UnitY()).normalized(),
                               .length = (next - at).norm(),
                               .width = 0.05 - 0.01 * k,
                               .area = 0.2 * 0.045,
                               .mass = 0.001,
                               .is_ribbon = true,
                               .end_width = 0.04 - 0.01 * k});
    at = next;
  }
  const Surface surface = mesh_surface(skeleton);
  ASSERT_EQ(surface.parts.size(), 2U);
  const SurfacePart& ribbon = surface.parts[1];
  EXPECT_EQ(ribbon.material.name, "ribbon");
  EXPECT_TRUE(ribbon.material.two_sided);
  EXPECT_EQ(ribbon.pieces.count, 0U);
  EXPECT_EQ(ribbon.triangles.size(), 3U * 4 * 8);  // two sections a piece and one more
  double area = 0, low = 1, high = 0;
  for (std::size_t f = 0; f < ribbon.triangles.size(); f += 3) {
    const auto place = [&](std::size_t corner) {
      return Vec3(surface.position[ribbon.triangles[f + corner]].cast<double>());
    };
    const Vec3 face = (place(1) - place(0)).cross(place(2) - place(0)) / 2;
    area += face.norm();
    low = std::min({low, place(0).z(), place(1).z()});
    high = std::max({high, place(0).z(), place(2).z()});
    // Its upper side is that of the pieces.
    EXPECT_GT(face.dot(surface.normal[ribbon.triangles[f]].cast<double>()), 0);
  }
  double wanted = 0;
  for (const Leaf& leaf : skeleton.leaves) wanted += 0.5 * (leaf.width + leaf.end_width) * leaf.length;
  EXPECT_NEAR(area, wanted, 0.04 * wanted);  // it is a little deeper along its midrib
  EXPECT_NEAR(low, 0, 0.01);
  EXPECT_NEAR(high, 0.8, 0.01);
}

}  // namespace
}  // namespace tremula
