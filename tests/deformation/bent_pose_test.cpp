#include "tremula/deformation/bent_pose.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "structure/random_vector.hpp"
#include "trees.hpp"
#include "tremula/base/error.hpp"
#include "tremula/deformation/loop.hpp"
#include "tremula/numerics/rotation.hpp"

namespace tremula {
namespace {

constexpr RootSpring soft{.translation = 1e3, .rotation = 1e2};
constexpr double times[] = {0, 0.9, 1.234, 2.95, 3, -4.5, 30.1};

// A slender plant with two stems and leaves that stands bent, and moves about that as five loads bend it.
struct Case {
  Skeleton skeleton = test::awkward_tree();
  Structure structure;
  Surface surface;
  Motion motion{.period = 3, .basis = {}, .coordinates = 0.5 * test::random_vector(60, 9).reshaped(10, 6)};

  // lean: of what size its strains are; sway: by how many radians each shape turns the end that it turns
  // most.
  Case(double lean, double sway, const RootSpring& root = {}) {
    for (Branch& branch : skeleton.branches) {
      branch.start_radius *= 0.1;
      branch.end_radius *= 0.1;
    }
    for (Leaf& leaf : skeleton.leaves) {
      leaf.length = 0.2;
      leaf.width = 0.1;
      leaf.base = skeleton.branches[index_of(leaf.branch)].end;
    }
    surface = mesh_surface(skeleton);
    structure = assemble(skeleton, test::weightless({.root = root}));
    motion.lean_strains = lean * test::random_vector(structure.size(), 8);
    without_stretch(motion.lean_strains);
    const std::vector<BentBranch> bent = bend(*structure.tree, motion.lean_strains);
    const BeamTree standing = tree_at(*structure.tree, bent);
    Modes shapes;
    shapes.frequency = Eigen::VectorXd::LinSpaced(5, 1, 5);
    shapes.shapes.resize(structure.size(), 5);
    for (Eigen::Index r = 0; r < 5; ++r) {
      const auto seed = static_cast<std::uint64_t>(40 + r);
      const Eigen::VectorXd shape = solve_static(standing, test::random_vector(structure.size(), seed));
      const double turned = shape.reshaped(6, shape.size() / 6).bottomRows(3).colwise().norm().maxCoeff();
      shapes.shapes.col(r) = sway / turned * shape;
    }
    motion.basis = join(displacement_of(*structure.tree, bent), shapes, {});
    motion.coordinates.col(0).setOnes();
  }

  void without_stretch(Eigen::VectorXd& strains) const {
    for (const Member& member : structure.members) {
      const Vec3 d = member.direction, v = strains.segment<3>(member.end_row);
      strains.segment<3>(member.end_row) = member.beam.length * (v - v.dot(d) * d);
    }
  }

  Loop loop(Poses poses = Poses::bent) const { return make_loop(structure, surface, motion, {}, poses); }
};

double largest_difference(const SurfaceDelta& a, const SurfaceDelta& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.position.size(); ++i) {
    largest = std::max(largest, static_cast<double>((a.position[i] - b.position[i]).norm()));
    largest = std::max(largest, static_cast<double>((a.normal[i] - b.normal[i]).norm()));
  }
  return largest;
}

SurfaceDelta sum_of_shapes(const Loop& loop, Eigen::Index sample) {
  SurfaceDelta sum = loop.shape_of_skin(0, 1);
  for (Eigen::Index c = 1; c < loop.coordinates.cols(); ++c) {
    const SurfaceDelta one = loop.shape_of_skin(c, loop.coordinates(sample, c));
    for (std::size_t i = 0; i < sum.position.size(); ++i) {
      sum.position[i] += one.position[i];
      sum.normal[i] += one.normal[i];
    }
  }
  return sum;
}

TEST(BentAt, KeepsTheLengthOfEveryBranchThroughLargeSway) {
  for (const RootSpring& root : {RootSpring{}, soft}) {
    const Case c(0.5, 1.5, root);
    for (int p = 0; p < c.motion.sample_count(); ++p) {
      const double time = p * c.motion.period / c.motion.sample_count();
      const std::vector<BentBranch> bent = bent_at(c.structure, c.motion, time);
      for (std::size_t k = 0; k < bent.size(); ++k) {
        const double length = c.structure.members[k].beam.length;
        EXPECT_NEAR((bent[k].end - bent[k].start).norm() / length, 1, 1e-3) << p << ", " << k;
      }
    }
  }
}

TEST(BentAt, KeepsTheLengthOfBranchesThatDoNotStretchToRounding) {
  Case c(0.5, 1.5);
  const BentLean lean = bend_lean(c.structure, c.motion);
  // Every end moves across its branch as it stands, on top of what carries it.
  for (Eigen::Index r = 1; r < 6; ++r) {
    const Eigen::VectorXd more = test::random_vector(c.structure.size(), static_cast<std::uint64_t>(r));
    auto u = c.motion.basis.columns.col(r);
    for (int k = 0; k < lean.tree->branch_count(); ++k) {
      const BentBranch& branch = lean.bent[index_of(k)];
      const Vec3 chord = branch.end - branch.start, across = chord.cross(more.segment<3>(6 * k));
      u.segment<3>(6 * k) = across;
      u.segment<3>(6 * k + 3) = more.segment<3>(6 * k + 3);
      const int parent = lean.tree->parent[index_of(k)];
      if (parent < 0) continue;
      const Vec3 carried = u.segment<3>(6 * parent + 3);
      const Vec3 reach = branch.end - lean.bent[index_of(parent)].end;
      u.segment<3>(6 * k) += u.segment<3>(6 * parent) + carried.cross(reach);
      u.segment<3>(6 * k + 3) += carried;
    }
  }
  for (int p = 0; p < c.motion.sample_count(); ++p) {
    const std::vector<BentBranch> bent = bent_at(lean, c.motion, p * 0.3);
    for (std::size_t k = 0; k < bent.size(); ++k) {
      const double length = c.structure.members[k].beam.length;
      EXPECT_NEAR((bent[k].end - bent[k].start).norm() / length, 1, 1e-12) << p << ", " << k;
    }
  }
}

TEST(BentAt, IsTheLeanWhereNothingMovesAboutIt) {
  Case c(0.5, 1);
  c.motion.coordinates.rightCols(5).setZero();
  const std::vector<BentBranch> bent = bent_at(c.structure, c.motion, 1.3);
  EXPECT_LT((displacement_of(*c.structure.tree, bent) - c.motion.basis.columns.col(0)).norm(), 1e-13);
}

TEST(BentAt, SuperposesDisplacementsToFirstOrder) {
  const auto error = [](double sway) {
    const Case c(0.5, sway);
    const BentLean lean = bend_lean(c.structure, c.motion);
    const std::vector<BentBranch> bent = bent_at(lean, c.motion, 1.234);
    const Eigen::VectorXd moved = displacement_about_lean(c.motion, 1.234);
    double worst = 0;
    for (std::size_t k = 0; k < bent.size(); ++k) {
      const auto row = 6 * static_cast<Eigen::Index>(k);
      worst = std::max(worst, (bent[k].end - lean.bent[k].end - moved.segment<3>(row)).norm());
      const Vec3 turned = rotation_vector(bent[k].end_frame * lean.bent[k].end_frame.transpose());
      worst = std::max(worst, (turned - moved.segment<3>(row + 3)).norm());
    }
    return worst;
  };
  EXPECT_NEAR(error(1e-2) / error(1e-3), 100, 5);
  EXPECT_LT(error(1e-4), 1e-7);
}

TEST(BendSurface, LeavesATreeThatDoesNotBendWhereItIs) {
  const Case c(0, 0);
  const SurfaceDelta delta =
      bend_surface(c.structure, c.surface, bend(*c.structure.tree, c.motion.lean_strains));
  for (std::size_t i = 0; i < c.surface.vertex_count(); ++i) {
    EXPECT_LT(delta.position[i].norm(), 1e-14F);
    EXPECT_LT(delta.normal[i].norm(), 1e-14F);
  }
}

TEST(BendSurface, AboutRestIsTheLinearSkinToFirstOrder) {
  for (const RootSpring& root : {RootSpring{}, soft}) {
    const auto error = [&](double sway) {
      const Case c(0, sway, root);
      const Eigen::VectorXd moved = displacement_about_lean(c.motion, 0.6);
      return largest_difference(bend_surface(c.structure, c.surface, bent_at(c.structure, c.motion, 0.6)),
                                deform_surface(c.structure, c.surface, moved));
    };
    EXPECT_NEAR(error(0.3) / error(0.03), 100, 15);
    EXPECT_LT(error(1e-3), 2e-5);
  }
}

TEST(BendSurface, CarriesRingsAndLeavesWithoutChangingTheirShape) {
  const Case c(0.6, 1.5, soft);
  const SurfaceDelta delta = c.loop().skin_at(0.9);
  const auto moved = [&](std::size_t i) -> Vec3 {
    return (c.surface.position[i] + delta.position[i]).cast<double>();
  };
  for (std::size_t i = 1; i < c.surface.vertex_count(); ++i) {
    if (c.surface.branch[i] != c.surface.branch[i - 1] || c.surface.along[i] != c.surface.along[i - 1])
      continue;
    const double before = static_cast<double>((c.surface.position[i] - c.surface.position[i - 1]).norm());
    EXPECT_NEAR((moved(i) - moved(i - 1)).norm(), before, 1e-6) << i;
  }
}

// Of a triangle: twice its area, along its normal.
Vec3 area_of(const Surface& surface, const SurfaceDelta& delta, const std::uint32_t* corner) {
  const auto at = [&](std::uint32_t i) -> Vec3 {
    return (surface.position[i] + delta.position[i]).cast<double>();
  };
  return (at(corner[1]) - at(corner[0])).cross(at(corner[2]) - at(corner[0]));
}

TEST(BendSurface, KeepsTheAreaOfEveryLeafAndItsNormalsOnIt) {
  const Case c(0.6, 1.5);
  const Loop loop = c.loop();
  ASSERT_EQ(c.surface.parts.size(), 2U);
  const std::vector<std::uint32_t>& leaves = c.surface.parts[1].triangles;
  SurfaceDelta rest = loop.skin_at(0);
  for (Eigen::Vector3f& p : rest.position) p.setZero();
  for (int p = 0; p < loop.sample_count(); ++p) {
    const SurfaceDelta delta = loop.skin_at(p * 0.3);
    for (std::size_t i = 0; i < leaves.size(); i += 3) {
      const Vec3 before = area_of(c.surface, rest, &leaves[i]), after = area_of(c.surface, delta, &leaves[i]);
      EXPECT_NEAR(after.norm() / before.norm(), 1, 2e-5);
      for (std::size_t j = i; j < i + 3; ++j) {
        const Vec3 normal = c.surface.normal[leaves[j]].cast<double>();
        const Vec3 turned = (c.surface.normal[leaves[j]] + delta.normal[leaves[j]]).cast<double>();
        EXPECT_NEAR(turned.dot(after) / after.norm(), normal.dot(before) / before.norm(), 2e-5);
      }
    }
  }
}

TEST(BendSurface, KeepsNormalsUnitAndOutOfTheTube) {
  // A stem bent to a quarter of a circle: normals of its mesh against those that it carries.
  const Skeleton stem = test::straight_stem(8, 4, 0.1, 0.1);
  const Structure structure = assemble(stem, test::weightless());
  const Surface surface = mesh_surface(stem, {.max_sides = 48, .min_sides = 48, .bend_subdivisions = 8});
  Eigen::VectorXd strains = Eigen::VectorXd::Zero(structure.size());
  for (int k = 0; k < 8; ++k) {
    strains[6 * k + 4] = 0.2;
    strains[6 * k] = 0.5 * 0.1;
  }
  const SurfaceDelta delta = bend_surface(structure, surface, bend(*structure.tree, strains));
  std::vector<Vec3> faces(surface.vertex_count(), Vec3::Zero());
  const std::vector<std::uint32_t>& triangles = surface.parts[0].triangles;
  for (std::size_t i = 0; i < triangles.size(); i += 3) {
    for (std::size_t j = i; j < i + 3; ++j) faces[triangles[j]] += area_of(surface, delta, &triangles[i]);
  }
  for (std::size_t i = 0; i < surface.vertex_count(); ++i) {
    const Vec3 normal = (surface.normal[i] + delta.normal[i]).cast<double>();
    EXPECT_NEAR(normal.norm(), 1, 1e-6);
    const bool inside = surface.texture[i].x() > 0 && surface.texture[i].x() < 1 &&
                        (surface.branch[i] > 0 || surface.along[i] > 0.1F) &&
                        (surface.branch[i] < 7 || surface.along[i] < 0.8F);
    if (!inside) continue;
    EXPECT_GT(normal.dot(faces[i].normalized()), std::cos(0.08)) << i;
  }
}

TEST(ShapeOfSkin, OfTheLeanIsTheBentSkin) {
  const Case c(0.6, 1);
  const SurfaceDelta wanted =
      bend_surface(c.structure, c.surface, bend(*c.structure.tree, c.motion.lean_strains));
  EXPECT_EQ(c.loop().shape_of_skin(0, 1).position, wanted.position);
  EXPECT_EQ(c.loop().shape_of_skin(0, 1).normal, wanted.normal);
}

TEST(ShapeOfSkin, SumsUpToThePosesToFirstOrderInTheCoordinates) {
  for (const RootSpring& root : {RootSpring{}, soft}) {
    const auto error = [&](double sway) {
      const Loop loop = Case(0.5, sway, root).loop();
      return largest_difference(sum_of_shapes(loop, 3), loop.skin_at(0.9));
    };
    EXPECT_NEAR(error(0.1) / error(0.01), 100, 10);
    EXPECT_LT(error(1e-3), 1e-5);
  }
}

TEST(ShapeOfSkin, SumsUpToLinearPosesToRounding) {
  for (const RootSpring& root : {RootSpring{}, soft}) {
    const Loop loop = Case(0.5, 1, root).loop(Poses::linear);
    for (Eigen::Index p = 0; p < 10; ++p)
      EXPECT_LT(largest_difference(sum_of_shapes(loop, p), loop.skin_at(0.3 * static_cast<double>(p))), 3e-6);
  }
}

TEST(NodesAt, OfPosesByStrainAreWhereTheSkinIs) {
  for (const RootSpring& root : {RootSpring{}, soft}) {
    for (const Poses poses : {Poses::bent, Poses::linear}) {
      const Case c(0.5, 0.8, root);
      const Loop loop = c.loop(poses);
      const SurfaceDelta skin = loop.skin_at(0.9);
      const NodePoses nodes = loop.nodes_at(0.9);
      int feet = 0, tips = 0;
      for (std::size_t i = 0; i < c.surface.vertex_count(); ++i) {
        const int branch = c.surface.branch[i];
        const bool is_end = c.surface.along[i] == 1;
        const int node =
            is_end ? c.skeleton.end_node(branch) : c.skeleton.branches[index_of(branch)].start_node;
        if (!is_end && (c.surface.along[i] != 0 || node > 1)) continue;
        // In linear poses what hangs on a section is sheared by its turn: compare on the axis.
        const Vec3 arm = c.surface.position[i].cast<double>() - loop.nodes.col(node);
        if (poses == Poses::linear && arm.norm() > 1e-6) continue;
        const Vec3 wanted =
            nodes.col(node).head<3>() + rotation_matrix(nodes.col(node).tail<3>()) * arm - arm;
        EXPECT_LT((skin.position[i].cast<double>() - wanted).norm(), 2e-6) << i;
        ++(is_end ? tips : feet);
      }
      EXPECT_GT(tips, 3);
      if (poses == Poses::bent) {
        EXPECT_GT(feet, 5);
      }
      const double moved = nodes.leftCols(2).norm();
      EXPECT_EQ(moved > 1e-3, root.rotation < 1e6);
    }
  }
}

TEST(NodesAt, OfLinearPosesAreTheDisplacementOfTheMotion) {
  const Case c(0.5, 0.8);
  const NodePoses poses = c.loop(Poses::linear).nodes_at(0.9);
  const Eigen::VectorXd displacement = displacement_at(c.motion, 0.9);
  for (int k = 0; k < c.skeleton.branch_count(); ++k)
    EXPECT_LT((poses.col(2 + k).head<3>() - displacement.segment<3>(6 * k)).norm(), 1e-6);
}

TEST(PosesByStrain, CloseAndAreTheSameBytesAloneAndInASequence) {
  const Case c(0.5, 1);
  for (const Poses poses : {Poses::bent, Poses::linear}) {
    const Loop loop = c.loop(poses);
    EXPECT_EQ(loop.skin_at(0).position, loop.skin_at(loop.period).position);
    EXPECT_EQ(loop.nodes_at(0), loop.nodes_at(loop.period));
    std::vector<SurfaceDelta> sequence;
    for (const double time : times) sequence.push_back(loop.skin_at(time));
    for (std::size_t i = std::size(times); i-- > 0;) {
      const SurfaceDelta alone = c.loop(poses).skin_at(times[i]);
      EXPECT_EQ(alone.position, sequence[i].position);
      EXPECT_EQ(alone.normal, sequence[i].normal);
    }
  }
}

TEST(PosesByStrain, AreThoseOfTheDisplacementWhereTheMotionHasNoStrains) {
  Case c(0.2, 0.5, soft);
  c.motion.lean_strains.resize(0);
  for (const Poses poses : {Poses::bent, Poses::linear}) {
    for (const double time : times) {
      const SurfaceDelta wanted = deform_surface(c.structure, c.surface, displacement_at(c.motion, time));
      EXPECT_EQ(c.loop(poses).skin_at(time).position, wanted.position);
      EXPECT_EQ(c.loop(poses).skin_at(time).normal, wanted.normal);
    }
  }
}

TEST(PosesByStrain, RefuseStrainsOfAnotherPlantAndWhatIsNoTree) {
  const auto make = [](const std::function<void(Case&)>& spoil) {
    Case c(0.2, 0.5);
    spoil(c);
    return c.loop();
  };
  EXPECT_NO_THROW(make([](Case&) {}));
  EXPECT_THROW(make([](Case& c) { c.motion.lean_strains.conservativeResize(6); }), InputError);
  EXPECT_THROW(make([](Case& c) { c.motion.lean_strains[3] = std::nan(""); }), InputError);
  EXPECT_THROW(make([](Case& c) { c.structure.tree = nullptr; }), InputError);
  const Case c(0.2, 0.5);
  EXPECT_THROW(bend_surface(c.structure, c.surface, {}), InputError);
}

}  // namespace
}  // namespace tremula
