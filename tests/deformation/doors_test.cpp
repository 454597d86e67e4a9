// What a program may hand over by mistake: an error that says what is wrong, and no crash.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "trees.hpp"
#include "tremula/base/error.hpp"
#include "tremula/deformation/morph_targets.hpp"
#include "tremula/deformation/pose.hpp"
#include "tremula/modes/solve_modes.hpp"

namespace tremula {
namespace {

Basis basis_of(const Structure& structure, int mode_count) {
  return join(Eigen::VectorXd::Zero(structure.size()), solve_modes(structure, {.count = mode_count}), {});
}

struct Scene {
  Skeleton skeleton = test::random_tree(6, 2);
  Structure structure = assemble(skeleton, test::weightless());
  Motion motion{.period = 2, .basis = basis_of(structure, 3), .coordinates = Eigen::MatrixXd::Ones(8, 4)};
};

TEST(DisplacementAt, RefusesMotionsThatAreNotOfTheirBasisAndTimesThatAreNone) {
  const Scene scene;
  EXPECT_EQ(displacement_at(scene.motion, 0.3).size(), 36);
  EXPECT_NO_THROW(check_motion(scene.motion));
  EXPECT_THROW(displacement_at(Motion{}, 0), InputError);
  EXPECT_THROW(check_motion(Motion{}), InputError);
  Motion bad = scene.motion;
  bad.basis = {};
  EXPECT_THROW(displacement_at(bad, 0), InputError);
  EXPECT_THROW(check_motion(bad), InputError);
  bad.basis = basis_of(scene.structure, 2);
  EXPECT_THROW(displacement_at(bad, 0), InputError);
  EXPECT_THROW(check_motion(bad), InputError);
  for (const double time : {double{NAN}, HUGE_VAL, -HUGE_VAL}) {
    EXPECT_THROW(displacement_at(scene.motion, time), InputError);
    EXPECT_THROW(coordinates_at(scene.motion, time, Interpolation::cubic), InputError);
  }
  for (const double period : {0.0, -1.0, double{NAN}, HUGE_VAL}) {
    bad = scene.motion;
    bad.period = period;
    EXPECT_THROW(displacement_at(bad, 0), InputError);
    EXPECT_THROW(check_motion(bad), InputError);
  }
  bad = scene.motion;
  bad.basis.kind.push_back(ShapeKind::static_shape);
  bad.basis.frequency.conservativeResize(5);
  bad.basis.frequency[4] = 1;  // and no shape to it
  EXPECT_THROW(check_motion(bad), InputError);
  bad.coordinates = Eigen::MatrixXd::Ones(8, 5);
  EXPECT_THROW(displacement_at(bad, 0), InputError);
  EXPECT_THROW(check_motion(bad), InputError);
}

TEST(MemberPoint, RefusesPlacesThatThereAreNot) {
  const Scene scene;
  const Eigen::VectorXd still = Eigen::VectorXd::Zero(36);
  EXPECT_EQ(member_point(scene.structure.members[5], still, 1).displacement, Vec3::Zero());
  for (const double s : {-0.1, 1.1, static_cast<double>(NAN)})
    EXPECT_THROW(member_point(scene.structure.members[5], still, s), InputError);
}

TEST(MemberPoint, RefusesDisplacementsWithoutTheRowsOfTheMember) {
  const Scene scene;
  const Member& member = scene.structure.members[5];
  for (const Eigen::Index rows : {0, 6, 30, 35})
    EXPECT_THROW(member_point(member, Eigen::VectorXd::Zero(rows), 1), InputError) << rows;
}

TEST(DeformSurface, RefusesSurfacesOfOtherPlants) {
  const Scene scene;
  const Surface surface = mesh_surface(scene.skeleton);
  const Eigen::VectorXd still = Eigen::VectorXd::Zero(36);
  EXPECT_NO_THROW(deform_surface(scene.structure, surface, still));
  Surface bad = surface;
  for (const int branch : {-1, 6, 77, 99}) {
    bad.branch.back() = branch;
    EXPECT_THROW(deform_surface(scene.structure, bad, still), InputError) << branch;
  }
  bad = surface;
  bad.normal.pop_back();
  EXPECT_THROW(deform_surface(scene.structure, bad, still), InputError);
  bad = surface;
  bad.along.clear();
  EXPECT_THROW(deform_surface(scene.structure, bad, still), InputError);
  bad = surface;
  bad.along.back() = 1.1F;
  EXPECT_THROW(deform_surface(scene.structure, bad, still), InputError);
  for (const Eigen::Index rows : {0, 12, 42})
    EXPECT_THROW(deform_surface(scene.structure, surface, Eigen::VectorXd::Zero(rows)), InputError) << rows;
  const Structure other = assemble(test::random_tree(9, 2), test::weightless());
  EXPECT_THROW(deform_surface(other, surface, still), InputError);
  const Loop nothing;
  EXPECT_THROW(make_morph_targets(nothing, MorphForm::paired), Error);
  EXPECT_THROW(mesh_surface(Skeleton{}), InputError);
}

}  // namespace
}  // namespace tremula
