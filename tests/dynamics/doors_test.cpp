// What a program may hand over by mistake: an error that says what is wrong, and no crash.
#include <gtest/gtest.h>

#include <cmath>

#include "trees.hpp"
#include "tremula/base/error.hpp"
#include "tremula/dynamics/damping.hpp"
#include "tremula/dynamics/motion_statistics.hpp"
#include "tremula/dynamics/response.hpp"
#include "tremula/dynamics/static_correction.hpp"
#include "tremula/modes/solve_modes.hpp"
#include "tremula/reference/modal_load_spectrum.hpp"
#include "tremula/reference/response_as_printed.hpp"

namespace tremula {
namespace {

struct Scene {
  Skeleton skeleton = test::random_tree(6, 2);
  Structure structure = assemble(skeleton, test::weightless());
  Modes modes = solve_modes(structure, {.count = 3});
  Sites sites = structure.find_sites();
  Loads loads = linearise_loads(sites, Eigen::Matrix3Xd::Ones(3, 6));
};

TEST(Dynamics, RefusesLoadsOfAnotherPlant) {
  const Scene own;
  const Structure structure = assemble(test::random_tree(9, 2), test::weightless());
  const Sites sites = structure.find_sites();
  const Loads& loads = own.loads;
  EXPECT_THROW(linearise_loads(own.sites, Eigen::Matrix3Xd::Ones(3, 5)), InputError);
  EXPECT_THROW(linearise_loads(sites, Eigen::Matrix3Xd::Ones(3, 6)), InputError);
  EXPECT_THROW(mean_force(sites, loads), InputError);
  EXPECT_THROW(fluctuating_force(own.sites, loads, Eigen::Matrix3Xd::Ones(3, 5)), InputError);
  EXPECT_THROW(modal_participation(sites, loads, own.modes.shapes), InputError);
  EXPECT_THROW(modal_participation(own.sites, loads, Eigen::MatrixXd::Ones(7, 3)), InputError);
  EXPECT_THROW(aerodynamic_damping(sites, loads, own.modes.shapes), InputError);
  EXPECT_THROW(aerodynamic_damping(own.sites, loads, Eigen::MatrixXd::Ones(7, 3)), InputError);
  EXPECT_THROW(aerodynamic_stiffness(sites, loads, own.modes.shapes), InputError);
  EXPECT_THROW(aerodynamic_stiffness(own.sites, loads, Eigen::MatrixXd::Ones(7, 3)), InputError);
  EXPECT_THROW(static_shapes(structure, sites, loads, own.modes), InputError);
  Loads fewer = loads;
  fewer.sites.pop_back();
  EXPECT_THROW(mean_force(own.sites, fewer), InputError);
  EXPECT_THROW(own.sites.gather(Eigen::Matrix3Xd::Ones(3, 5)), InputError);
}

TEST(Dynamics, RefusesSizesThatDoNotAgree) {
  const Scene scene;
  const TimeAxis axis{.period = 2, .sample_count = 16};
  EXPECT_THROW(respond_as_printed(scene.modes, Eigen::MatrixXcd::Zero(5, 3), axis, {}), InputError);
  EXPECT_THROW(respond_as_printed(scene.modes, Eigen::MatrixXcd::Zero(9, 4), axis, {}), InputError);
  const auto wind = [](int) { return Eigen::Matrix3Xcd::Zero(3, 5).eval(); };
  EXPECT_THROW(project_loads(Eigen::MatrixXd::Zero(18, 3), axis, wind), InputError);
  EXPECT_THROW(project_loads(Eigen::MatrixXd::Zero(15, 3), {.period = 2, .sample_count = 0}, wind),
               InputError);
  EXPECT_THROW(motion_statistics(scene.structure, Motion{}), InputError);
  EXPECT_THROW(modal_load_spectrum({}, Eigen::Matrix3Xd::Ones(3, 6), Eigen::MatrixXd::Ones(17, 3), 1),
               InputError);
  EXPECT_THROW(modal_load_spectrum({}, Eigen::Matrix3Xd::Ones(3, 6), Eigen::MatrixXd::Ones(18, 3), 0),
               InputError);
  EXPECT_THROW(draw_modal_forces(Eigen::MatrixXcd::Zero(3, 2), 2, 1, 1), InputError);
  EXPECT_THROW(draw_modal_forces(Eigen::MatrixXcd::Zero(3, 3), 2, 1, 1, 0), InputError);
}

TEST(Dynamics, RefusesSystemsThatAreNone) {
  const TimeAxis axis{.period = 2, .sample_count = 16};
  ModalSystem system{.omega = Eigen::VectorXd::Ones(3), .damping = Eigen::MatrixXd::Identity(3, 3)};
  EXPECT_NO_THROW(BinTransfer(system, axis, Transfer::sampled));
  system.omega[1] = 0;
  EXPECT_THROW(BinTransfer(system, axis, Transfer::sampled), InputError);
  system.omega = Eigen::VectorXd::Ones(2);
  EXPECT_THROW(find_poles(system), InputError);
  system.omega = Eigen::VectorXd::Ones(3);
  system.damping(0, 0) = NAN;
  EXPECT_THROW(find_poles(system), InputError);
  system.damping = Eigen::MatrixXd::Identity(3, 2);
  EXPECT_THROW(find_poles(system), InputError);
}

}  // namespace
}  // namespace tremula
