#include "tremula/deformation/pose.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "trees.hpp"
#include "tremula/dynamics/motion.hpp"

namespace tremula {
namespace {

// Przemieniecki's interpolation for a beam along local x, 3 x 12: the A(s) of S eq. 1, written out (errata
// S5).
Eigen::Matrix<double, 3, 12> interpolation(double s, double l) {
  Eigen::Matrix<double, 3, 12> a = Eigen::Matrix<double, 3, 12>::Zero();
  const double s2 = s * s, s3 = s2 * s;
  a(0, 0) = 1 - s;
  a(0, 6) = s;
  a(1, 1) = a(2, 2) = 1 - 3 * s2 + 2 * s3;
  a(1, 5) = l * (s - 2 * s2 + s3);
  a(2, 4) = -l * (s - 2 * s2 + s3);
  a(1, 7) = a(2, 8) = 3 * s2 - 2 * s3;
  a(1, 11) = l * (s3 - s2);
  a(2, 10) = -l * (s3 - s2);
  return a;
}

TEST(MemberPoint, IsEquation1) {
  const Skeleton skeleton = test::random_tree(9, 3);
  const Structure clamped = assemble(skeleton, test::weightless());
  const Eigen::VectorXd u = 0.01 * Eigen::VectorXd::Random(6 * 9);
  for (int k = 1; k < 9; ++k) {
    const Branch& branch = skeleton.branches[static_cast<std::size_t>(k)];
    const double l = branch.length();
    const Vec3 x = (branch.end - branch.start) / l, y = x.unitOrthogonal();
    Mat3 r;
    r << x, y, x.cross(y);
    Eigen::Matrix<double, 12, 1> ends;
    ends << u.segment<6>(6 * skeleton.parent(k)), u.segment<6>(6 * k);
    for (int block = 0; block < 4; ++block) {
      ends.segment<3>(3 * block) = (r.transpose() * ends.segment<3>(3 * block)).eval();
    }
    for (const double s : {0.0, 0.2, 0.5, 0.9, 1.0}) {
      const Vec3 wanted = r * interpolation(s, l) * ends;
      EXPECT_LT(
          (member_point(clamped.members[static_cast<std::size_t>(k)], u, s).displacement - wanted).norm(),
          1e-15)
          << k << ", " << s;
    }
  }
}

TEST(MemberPoint, PassesThroughItsNodesWithTheirRotations) {
  const Skeleton skeleton = test::random_tree(9, 3);
  const Structure clamped = assemble(skeleton, test::weightless());
  const Eigen::VectorXd u = Eigen::VectorXd::Random(6 * 9);
  for (int k = 1; k < 9; ++k) {
    const MemberPoint start = member_point(clamped.members[static_cast<std::size_t>(k)], u, 0),
                      end = member_point(clamped.members[static_cast<std::size_t>(k)], u, 1);
    EXPECT_LT((start.displacement - u.segment<3>(6 * skeleton.parent(k))).norm(), 1e-13);
    EXPECT_LT((start.rotation - u.segment<3>(6 * skeleton.parent(k) + 3)).norm(), 1e-13);
    EXPECT_LT((end.displacement - u.segment<3>(6 * k)).norm(), 1e-13);
    EXPECT_LT((end.rotation - u.segment<3>(6 * k + 3)).norm(), 1e-13);
  }
}

TEST(MemberPoint, RotationIsTheSlopeOfTheCurve) {
  const Skeleton skeleton = test::random_tree(4, 3);
  const Structure clamped = assemble(skeleton, test::weightless());
  const Eigen::VectorXd u = Eigen::VectorXd::Random(24);
  const Branch& branch = skeleton.branches[2];
  const Vec3 direction = (branch.end - branch.start).normalized();
  const double s = 0.3, h = 1e-5;
  const Vec3 slope = (member_point(clamped.members[2], u, s + h).displacement -
                      member_point(clamped.members[2], u, s - h).displacement) /
                     (2 * h * branch.length());
  const Vec3 across = slope - slope.dot(direction) * direction;
  EXPECT_LT((member_point(clamped.members[2], u, s).rotation.cross(direction) - across).norm(), 1e-8);
}

TEST(MemberPoint, RigidMotionOfAllNodesIsARigidMotionOfAllPoints) {
  Skeleton skeleton = test::random_tree(9, 3);
  for (Branch& branch : skeleton.branches) {  // starts beside their nodes are carried too
    if (branch.start_node > 0) branch.start += Vec3(0.02, 0, 0.01);
  }
  const Structure clamped = assemble(skeleton, test::weightless());
  const Vec3 translation(0.1, -0.2, 0.3), rotation(0.01, 0.02, -0.03);
  Eigen::VectorXd u(6 * 9);
  for (int k = 0; k < 9; ++k) {
    u.segment<3>(6 * k) = translation + rotation.cross(skeleton.node_position(k + 1));
    u.segment<3>(6 * k + 3) = rotation;
  }
  for (int k = 1; k < 9; ++k) {
    const Branch& branch = skeleton.branches[static_cast<std::size_t>(k)];
    const MemberPoint point = member_point(clamped.members[static_cast<std::size_t>(k)], u, 0.37);
    const Vec3 at = branch.start + 0.37 * (branch.end - branch.start);
    EXPECT_LT((point.displacement - translation - rotation.cross(at)).norm(), 1e-14);
    EXPECT_LT((point.rotation - rotation).norm(), 1e-14);
  }
}

// On springs far softer than the wood, a plant that turns and shifts as one takes its foot along.
TEST(MemberPoint, OnASoftRootTheFirstBranchMovesRigidlyWithTheRest) {
  const Skeleton skeleton = test::random_tree(9, 3);
  const Structure structure =
      assemble(skeleton, test::weightless({.root = {.translation = 1e-6, .rotation = 1e-6}}));
  const Structure clamped = assemble(skeleton, test::weightless());
  const Vec3 translation(0.1, -0.2, 0.3), rotation(0.01, 0.02, -0.03);
  Eigen::VectorXd u(6 * 9);
  for (int k = 0; k < 9; ++k) {
    u.segment<3>(6 * k) = translation + rotation.cross(skeleton.node_position(k + 1));
    u.segment<3>(6 * k + 3) = rotation;
  }
  const Branch& stem = skeleton.branches[0];
  ASSERT_EQ(skeleton.parent(0), -1);
  for (const double s : {0.0, 0.4, 1.0}) {
    const MemberPoint point = member_point(structure.members[0], u, s);
    const Vec3 at = stem.start + s * (stem.end - stem.start);
    EXPECT_LT((point.displacement - translation - rotation.cross(at)).norm(), 1e-8) << s;
    EXPECT_LT((point.rotation - rotation).norm(), 1e-8) << s;
  }
  const MemberPoint foot = member_point(clamped.members[0], u, 0);
  EXPECT_EQ(foot.displacement, Vec3::Zero());
  EXPECT_EQ(foot.rotation, Vec3::Zero());
}

Surface points_on(const Skeleton& skeleton) {
  Surface surface;
  for (int k = 0; k < skeleton.branch_count(); ++k) {
    const Branch& branch = skeleton.branches[static_cast<std::size_t>(k)];
    for (const float along : {0.0F, 0.5F, 1.0F}) {
      const Vec3 out = (branch.end - branch.start).unitOrthogonal();
      const Vec3 at = branch.start + static_cast<double>(along) * (branch.end - branch.start) + 0.05 * out;
      surface.position.push_back(at.cast<float>());
      surface.normal.push_back(out.cast<float>());
      surface.branch.push_back(k);
      surface.along.push_back(along);
    }
  }
  return surface;
}

TEST(DeformSurface, IsLinearInTheDisplacement) {
  const Skeleton skeleton = test::random_tree(9, 3);
  const Surface surface = points_on(skeleton);
  const Eigen::VectorXd a = Eigen::VectorXd::Random(54), b = Eigen::VectorXd::Random(54);
  const Structure clamped = assemble(skeleton, test::weightless());
  const SurfaceDelta of_a = deform_surface(clamped, surface, a), of_b = deform_surface(clamped, surface, b);
  const SurfaceDelta of_sum = deform_surface(clamped, surface, 2 * a - b);
  for (std::size_t i = 0; i < surface.vertex_count(); ++i) {
    EXPECT_LT((of_sum.position[i] - (2 * of_a.position[i] - of_b.position[i])).norm(), 1e-5F);
    EXPECT_LT((of_sum.normal[i] - (2 * of_a.normal[i] - of_b.normal[i])).norm(), 1e-5F);
  }
}

TEST(DeformSurface, CarriesRingsAroundTheirAxis) {
  const Skeleton skeleton = test::random_tree(3, 3);
  const Surface surface = points_on(skeleton);
  const Eigen::VectorXd u = 0.1 * Eigen::VectorXd::Random(18);
  for (const Structure& structure : {assemble(skeleton, test::weightless()),
                                     assemble(skeleton, test::weightless({.root = {.rotation = 1e4}}))}) {
    const SurfaceDelta delta = deform_surface(structure, surface, u);
    for (std::size_t i = 0; i < surface.vertex_count(); ++i) {
      const MemberPoint point = member_point(structure.members[static_cast<std::size_t>(surface.branch[i])],
                                             u, static_cast<double>(surface.along[i]));
      const Vec3 arm = 0.05 * surface.normal[i].cast<double>();
      const Vec3 wanted = point.displacement + point.rotation.cross(arm);
      EXPECT_LT((delta.position[i].cast<double>() - wanted).norm(), 1e-6);
      EXPECT_LT((delta.normal[i] - point.rotation.cast<float>().cross(surface.normal[i])).norm(), 1e-6F);
    }
  }
}

TEST(DeformSurface, ARigidMotionTurnsNormalsAndCarriesPositionsAsOne) {
  const Skeleton skeleton = test::awkward_tree();
  // On springs far softer than the wood, so that the feet come along.
  const Structure soft =
      assemble(skeleton, test::weightless({.root = {.translation = 1e-6, .rotation = 1e-6}}));
  const Surface surface = mesh_surface(skeleton);
  const Vec3 translation(0.1, -0.2, 0.3), rotation(0.01, 0.02, -0.03);
  Eigen::VectorXd u(6 * skeleton.branch_count());
  for (int k = 0; k < skeleton.branch_count(); ++k) {
    u.segment<3>(6 * k) = translation + rotation.cross(skeleton.branches[static_cast<std::size_t>(k)].end);
    u.segment<3>(6 * k + 3) = rotation;
  }
  const SurfaceDelta delta = deform_surface(soft, surface, u);
  for (std::size_t i = 0; i < surface.vertex_count(); ++i) {
    const Vec3 at = surface.position[i].cast<double>(), normal = surface.normal[i].cast<double>();
    EXPECT_LT((delta.position[i].cast<double>() - translation - rotation.cross(at)).norm(), 1e-6);
    EXPECT_LT((delta.normal[i].cast<double>() - rotation.cross(normal)).norm(), 1e-6);
  }
}

// Normals of the triangles around each vertex, each counted by its area, as the mesh itself has them.
std::vector<Vec3> mesh_normals(const Surface& surface, const SurfaceDelta& delta, double factor) {
  std::vector<Vec3> normals(surface.vertex_count(), Vec3::Zero());
  const auto at = [&](std::uint32_t i) -> Vec3 {
    return surface.position[i].cast<double>() + factor * delta.position[i].cast<double>();
  };
  for (const SurfacePart& part : surface.parts) {
    for (std::size_t i = 0; i < part.triangles.size(); i += 3) {
      const std::uint32_t a = part.triangles[i], b = part.triangles[i + 1], c = part.triangles[i + 2];
      const Vec3 area = (at(b) - at(a)).cross(at(c) - at(a));
      for (const std::uint32_t corner : {a, b, c}) normals[corner] += area;
    }
  }
  for (Vec3& normal : normals) normal.normalize();
  return normals;
}

// How far the change of normals is from the derivative of those of the moving mesh, as a part of the largest.
double normal_error(const Skeleton& skeleton, const Surface& surface, const Eigen::VectorXd& u,
                    const std::function<bool(std::size_t)>& counts) {
  const SurfaceDelta delta = deform_surface(assemble(skeleton, test::weightless()), surface, u);
  const double h = 1e-2;  // positions are floats
  const std::vector<Vec3> before = mesh_normals(surface, delta, -h), after = mesh_normals(surface, delta, h);
  double worst = 0, largest = 0;
  for (std::size_t i = 0; i < surface.vertex_count(); ++i) {
    if (!counts(i)) continue;
    const Vec3 derivative = (after[i] - before[i]) / (2 * h);
    worst = std::max(worst, (delta.normal[i].cast<double>() - derivative).norm());
    largest = std::max(largest, derivative.norm());
  }
  return worst / largest;
}

TEST(DeformSurface, NormalsTurnAsThoseOfTheMeshDo) {
  const Skeleton stem = test::straight_stem(6, 3, 0.1, 0.1, Vec3(0.3, -0.2, 1).normalized());
  Eigen::VectorXd u(36);
  for (int k = 0; k < 36; ++k) u[k] = 0.05 * std::sin(1.7 * k);
  // The seam of the texture, the two ends and the triangles' slant keep a mesh from the smooth surface.
  const Surface fine = mesh_surface(stem, {.max_sides = 96, .min_sides = 96, .bend_subdivisions = 24});
  const auto inside = [&](std::size_t i) {
    return fine.texture[i].x() > 0 && fine.texture[i].x() < 1 && fine.along[i] > 0.1F &&
           fine.along[i] < 0.9F && fine.branch[i] < 5;
  };
  EXPECT_LT(normal_error(stem, fine, u, inside), 0.05);

  // A leaf is carried as one piece: there the two agree to rounding.
  Skeleton tree = test::awkward_tree();
  for (Leaf& leaf : tree.leaves) {
    leaf.length = 0.2;
    leaf.width = 0.1;
    leaf.base = tree.branches[static_cast<std::size_t>(leaf.branch)].end;
  }
  const Surface leafy = mesh_surface(tree);
  ASSERT_EQ(leafy.parts.size(), 2U);
  Eigen::VectorXd v(6 * tree.branch_count());
  for (Eigen::Index k = 0; k < v.size(); ++k) v[k] = 0.1 * std::sin(0.9 * static_cast<double>(k));
  EXPECT_LT(
      normal_error(tree, leafy, v, [&](std::size_t i) { return i >= leafy.parts[1].pieces.first_vertex; }),
      0.01);
}

TEST(DisplacementAt, IsTheLeanAndTheSumOfTheModes) {
  Modes modes;
  modes.frequency = Eigen::Vector3d(1, 2, 3);
  modes.shapes = Eigen::MatrixXd::Random(12, 3);
  const Eigen::VectorXd lean = Eigen::VectorXd::Random(12);
  Motion motion{5, join(lean, modes, {}), Eigen::MatrixXd::Ones(10, 4)};
  motion.coordinates.rightCols(3).setRandom();
  const Eigen::VectorXd wanted = lean + modes.shapes * motion.coordinates.row(4).tail(3).transpose();
  EXPECT_LT((displacement_at(motion, 2) - wanted).norm(), 1e-14);
}

}  // namespace
}  // namespace tremula
