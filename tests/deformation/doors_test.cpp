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

struct Scene {
  Skeleton skeleton = test::random_tree(6, 2);
  Structure structure = assemble(skeleton, {});
  Modes modes = solve_modes(structure, {.count = 3});
  Motion motion{.period = 2, .coordinates = Eigen::MatrixXd::Ones(8, 3), .lean = Eigen::VectorXd::Zero(36)};
};

TEST(DisplacementAt, RefusesMotionsOfOtherModesAndTimesThatAreNone) {
  const Scene scene;
  EXPECT_EQ(displacement_at(scene.modes, scene.motion, 0.3).size(), 36);
  EXPECT_THROW(displacement_at(scene.modes, Motion{}, 0), InputError);
  EXPECT_THROW(displacement_at(Modes{}, scene.motion, 0), InputError);
  const Modes others = solve_modes(assemble(test::random_tree(9, 2), {}), {.count = 3});
  EXPECT_THROW(displacement_at(others, scene.motion, 0), InputError);
  const Modes fewer = solve_modes(scene.structure, {.count = 2});
  EXPECT_THROW(displacement_at(fewer, scene.motion, 0), InputError);
  for (const double time : {double{NAN}, HUGE_VAL, -HUGE_VAL}) {
    EXPECT_THROW(displacement_at(scene.modes, scene.motion, time), InputError);
    EXPECT_THROW(coordinates_at(scene.motion, time, Interpolation::cubic), InputError);
  }
  Motion no_period = scene.motion;
  no_period.period = 0;
  EXPECT_THROW(displacement_at(scene.modes, no_period, 0), InputError);
  Motion half = scene.motion;
  half.static_shapes.frequency = Eigen::VectorXd::Ones(1);  // and no shape to it
  EXPECT_THROW(displacement_at(scene.modes, half, 0), InputError);
}

TEST(BranchPoint, RefusesBranchesAndPlacesThatThereAreNot) {
  const Scene scene;
  const Displacement still = Displacement::Zero(36);
  EXPECT_EQ(branch_point(scene.skeleton, scene.structure, still, 5, 1).displacement, Vec3::Zero());
  for (const int branch : {-1, 6, 99})
    EXPECT_THROW(branch_point(scene.skeleton, scene.structure, still, branch, 1), InputError);
  for (const double s : {-0.1, 1.1, static_cast<double>(NAN)})
    EXPECT_THROW(branch_point(scene.skeleton, scene.structure, still, 5, s), InputError);
  EXPECT_THROW(branch_point(scene.skeleton, scene.structure, Displacement(), 5, 1), InputError);
  EXPECT_THROW(branch_point(scene.skeleton, scene.structure, Displacement::Zero(42), 5, 1), InputError);
}

TEST(DeformSurface, RefusesSurfacesOfOtherPlants) {
  const Scene scene;
  const Surface surface = mesh_surface(scene.skeleton);
  const Displacement still = Displacement::Zero(36);
  Surface bad = surface;
  bad.branch.back() = 77;
  EXPECT_THROW(deform_surface(scene.skeleton, scene.structure, bad, still), InputError);
  bad = surface;
  bad.normal.pop_back();
  EXPECT_THROW(deform_surface(scene.skeleton, scene.structure, bad, still), InputError);
  bad = surface;
  bad.along.clear();
  EXPECT_THROW(deform_surface(scene.skeleton, scene.structure, bad, still), InputError);
  EXPECT_THROW(deform_surface(scene.skeleton, scene.structure, surface, Displacement::Zero(12)), InputError);
  const Structure other = assemble(test::random_tree(9, 2), {});
  EXPECT_THROW(deform_surface(scene.skeleton, other, surface, still), InputError);
  EXPECT_THROW(
      make_morph_targets(scene.skeleton, scene.structure, surface, scene.modes, Motion{}, MorphForm::paired),
      Error);
  EXPECT_THROW(mesh_surface(Skeleton{}), InputError);
}

}  // namespace
}  // namespace tremula
