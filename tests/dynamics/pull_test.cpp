#include "tremula/dynamics/pull.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "complaint.hpp"
#include "trees.hpp"
#include "tremula/dynamics/static_correction.hpp"
#include "tremula/modes/solve_modes.hpp"

namespace tremula {
namespace {

using std::numbers::pi;

struct Cantilever {
  double length = 3, radius = 0.02;
  Skeleton skeleton = test::straight_stem(12, length, radius, radius);
  StructureOptions options = test::weightless();
  Structure structure = assemble(skeleton, options);
  Modes modes = solve_modes(structure, {.count = 6});
  double bending_stiffness = options.material.youngs_modulus * pi / 4 * std::pow(radius, 4);
};

TEST(PlacePull, ReadsHeightsPlacesAndUnits) {
  const Skeleton stem = test::straight_stem(4, 2, 0.02, 0.02, Vec3(0, 0.6, 0.8));
  const Pull by_height = place_pull(stem, "1.3m:200N", 90);
  EXPECT_EQ(by_height.place.name, "1.3m");
  const Branch& branch = stem.branches[static_cast<std::size_t>(by_height.place.branch)];
  EXPECT_NEAR((branch.start + by_height.place.place * (branch.end - branch.start)).z(), 1.3, 1e-5);
  EXPECT_NEAR((by_height.force - Vec3(0, 200, 0)).norm(), 0, 1e-12);
  const Pull by_path = place_pull(stem, "stem:1.25:1.5kN", 0);
  EXPECT_EQ(by_path.place.branch, 2);
  EXPECT_NEAR(by_path.place.place, 0.5, 1e-12);
  EXPECT_NEAR((by_path.force - Vec3(1500, 0, 0)).norm(), 0, 1e-12);
  EXPECT_EQ(place_pull(stem, "branch:3:1:2N", 0).place.branch, 3);
}

TEST(PlacePull, RefusesWhatIsNoPullInOneLine) {
  const Skeleton stem = test::straight_stem(4, 2, 0.02, 0.02);
  const auto complaint = [&](const std::string& text) {
    return test::complaint_of([&] { place_pull(stem, text, 0); });
  };
  const std::string forms = ", wanted PLACE:FORCE such as 1.3m:200N, stem:1.3:200N or branch:12:0.5:2kN";
  for (const std::string text : {"", "1.3m", "1.3:200N", "1.3m:200", "1.3m:N", "base:200N", "1.3m:2MN"})
    EXPECT_EQ(complaint(text), "pull: '" + text + "'" + forms);
  EXPECT_EQ(complaint("1.3m:0N"), "pull: '1.3m:0N', wanted a force above 0 N");
  EXPECT_EQ(complaint("9m:1N"),
            "pull: '9m:1N', wanted a height above 0 m and up to 2 m, where the main stem ends");
  EXPECT_EQ(complaint("stem:0:1N"),
            "pull: 'stem:0:1N', wanted a place above the ground, which holds the stem");
  EXPECT_FALSE(complaint("stem:3:1N").empty());
  EXPECT_FALSE(complaint("branch:9:0:1N").empty());
}

TEST(PlaceShape, IsTheClosedFormOfACantileverUnderAForceAnywhere) {
  const Cantilever c;
  for (const std::string place : {"3m", "1.3m", "2m"}) {
    const Pull pull = place_pull(c.skeleton, place + ":10N", 30);
    const Eigen::MatrixX3d shape = place_shape(c.structure, pull.place);
    const Vec3 moved = shape.transpose() * c.structure.flexibility(shape * pull.force);
    const double a = std::stod(place), wanted = 10 * std::pow(a, 3) / (3 * c.bending_stiffness);
    // Shear adds a little to the slender beam of the closed form.
    EXPECT_NEAR(moved.norm(), wanted, 2e-3 * wanted) << place;
    EXPECT_NEAR(moved.normalized().dot(pull.force.normalized()), 1, 1e-9) << place;
  }
}

struct Let {
  ModalSystem system;
  Eigen::MatrixXd moving;
  Eigen::VectorXd structural;

  Let(const Cantilever& c, const Pull& pull, double ratio) {
    const Eigen::VectorXd force = place_shape(c.structure, pull.place) * pull.force;
    const StaticShapes more = static_shape(c.structure, force, c.modes);
    moving.resize(c.structure.size(), c.modes.count() + more.count());
    moving << c.modes.shapes, more.shapes;
    Eigen::VectorXd frequency(moving.cols());
    frequency << c.modes.frequency, more.frequency;
    system.omega = 2 * pi * frequency;
    structural = 2 * ratio * system.omega;
    system.damping = structural.asDiagonal();
  }
};

TEST(LetGo, BeginsAtTheExactStaticDeflectionHoweverFewTheModes) {
  const Cantilever c;
  const Pull pull = place_pull(c.skeleton, "1.3m:10N", 0);
  const Let let(c, pull, 0.03);
  const Eigen::VectorXd force = place_shape(c.structure, pull.place) * pull.force;
  const Eigen::MatrixXd coordinates =
      let_go(let.system, {.period = 2, .sample_count = 50}, let.moving.transpose() * force);
  const Eigen::VectorXd first = let.moving * coordinates.row(0).transpose();
  const Eigen::VectorXd exact = c.structure.flexibility(force);
  EXPECT_LT((first - exact).norm(), 1e-8 * exact.norm());
}

TEST(LetGo, IsTheSameWhateverTheStep) {
  const Cantilever c;
  const Pull pull = place_pull(c.skeleton, "3m:10N", 0);
  const Let let(c, pull, 0.03);
  const Eigen::VectorXd forces = let.moving.transpose() * (place_shape(c.structure, pull.place) * pull.force);
  const Eigen::MatrixXd coarse = let_go(let.system, {.period = 3, .sample_count = 10}, forces);
  const Eigen::MatrixXd fine = let_go(let.system, {.period = 3, .sample_count = 640}, forces);
  for (Eigen::Index p = 0; p < coarse.rows(); ++p)
    EXPECT_LT((coarse.row(p) - fine.row(64 * p)).norm(), 1e-9 * coarse.row(0).norm()) << p;
}

TEST(TestPull, FindsAgainWhatTheModeIs) {
  const Cantilever c;
  for (const double heading : {0.0, 30.0, 45.0, 100.0}) {  // both bending modes have one frequency
    const Pull pull = place_pull(c.skeleton, "2m:10N", heading);
    const double ratio = 0.02;
    const Let let(c, pull, ratio);
    const PullTest test = test_pull(pull, c.structure, let.moving, c.modes.count(), let.system,
                                    let.structural, {.period = 30, .sample_count = 900});
    EXPECT_NEAR(test.frequency, c.modes.frequency[0], 1e-6);
    EXPECT_NEAR(test.of_structure, ratio, 1e-12);
    EXPECT_EQ(test.of_medium, 0);
    ASSERT_TRUE(test.of_mode && test.of_place);
    for (const FreeDecay& decay : {*test.of_mode, *test.of_place}) {
      EXPECT_NEAR(decay.frequency, c.modes.frequency[0], 0.01 * c.modes.frequency[0]) << heading;
      EXPECT_NEAR(decay.damping_ratio, ratio, 0.05 * ratio) << heading;
    }
    const double wanted = 10 * 8 / (3 * c.bending_stiffness);
    EXPECT_NEAR(test.released_from.norm(), wanted, 2e-3 * wanted);
  }
}

TEST(TestPull, SaysNothingWhereTheRecordIsTooShort) {
  const Cantilever c;
  const Pull pull = place_pull(c.skeleton, "2m:10N", 0);
  const Let let(c, pull, 0.02);
  const PullTest test = test_pull(pull, c.structure, let.moving, c.modes.count(), let.system, let.structural,
                                  {.period = 0.5 / c.modes.frequency[0], .sample_count = 20});
  EXPECT_FALSE(test.of_mode);
  EXPECT_FALSE(test.of_place);
}

}  // namespace
}  // namespace tremula
